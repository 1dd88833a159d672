//! Any elements behind the header of a MATLAB level 5 file, of either byte order.
#![no_main]

use libfuzzer_sys::fuzz_target;
use veloid_engine::bicycle::Bike;
use veloid_engine::ride::{ReadOptions, read};

fuzz_target!(|data: (bool, &[u8])| {
    let (big_endian, bytes) = data;
    let mut file = b"MATLAB 5.0 MAT-file".to_vec();
    file.resize(124, b' ');
    file.extend(if big_endian {
        b"\x01\x00MI"
    } else {
        b"\x00\x01IM"
    });
    file.extend(bytes);
    let _ = read(&file, "ride", &Bike::default(), &ReadOptions::default());
});
