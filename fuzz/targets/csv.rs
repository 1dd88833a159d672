//! Any text as a ride; the first byte says how to read it.
#![no_main]

use libfuzzer_sys::fuzz_target;
use veloid_engine::bicycle::Bike;
use veloid_engine::ride::{ReadOptions, RideFile, preview, read};

fuzz_target!(|data: (u8, &[u8])| {
    let (how, bytes) = data;
    let set = |bit: u8| how & (1 << bit) != 0;
    let mut options = ReadOptions {
        rate_hz: set(0).then_some(200.0),
        rows: set(1).then_some((3, 90)),
        ..ReadOptions::default()
    };
    if set(2) {
        options.map.insert("z_f".to_owned(), "2".to_owned());
    }
    let bike = Bike {
        l_front_m: set(3).then_some(0.8),
        l_rear_m: set(3).then_some(0.3),
        ..Bike::default()
    };
    let _ = read(bytes, "ride", &bike, &options);
    let _ = preview(&[RideFile::new("ride", bytes)], &options);
});
