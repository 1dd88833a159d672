//! Any bytes behind the magic of gzip or zstd.
#![no_main]

use libfuzzer_sys::fuzz_target;
use veloid_engine::bicycle::Bike;
use veloid_engine::ride::{ReadOptions, read};

const GZIP: &[u8] = b"\x1f\x8b\x08";
const ZSTD: &[u8] = b"\x28\xb5\x2f\xfd";

fuzz_target!(|data: (bool, &[u8])| {
    let (gzip, bytes) = data;
    let file = [if gzip { GZIP } else { ZSTD }, bytes].concat();
    let _ = read(&file, "ride", &Bike::default(), &ReadOptions::default());
});
