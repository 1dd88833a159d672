//! Any text as a bike file. What is taken is written, and read again, as the same.
#![no_main]

use libfuzzer_sys::fuzz_target;
use veloid_engine::bicycle::Bike;

fuzz_target!(|text: &str| {
    if let Ok(bike) = Bike::from_json(text) {
        let written = serde_json::to_string(&bike).expect("a bike can be written");
        assert_eq!(Bike::from_json(&written).expect("and read again"), bike);
    }
});
