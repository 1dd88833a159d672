//! Recordings of other people, which lie outside the repository.

use crate::harness::{Folder, identify};
use crate::skips::recording;

/// An unknown mass on a cubic spring, driven by a force.
#[test]
fn regress_the_silverbox_is_identified_with_its_mass() {
    let Some(ride) = recording("silverbox/SNLS80mV.csv") else {
        return;
    };
    let folder = Folder::new();
    let bike = folder.write(
        "bike.json",
        r#"{"bike": "silverbox", "mass_front_kg": null}"#,
    );
    let columns = ["--map", "force_f=V1", "--map", "z_f=V2", "--rate", "610.35"];
    let quick = ["--trials", "1", "--iterations", "5", "--no-diagnosis"];
    let args = [&columns[..], &["--rows", "40650:127400"], &quick].concat();
    let (report, _) = identify(&ride, &bike, &args);
    assert_eq!(report["ride"]["samples"], 86_750);
    let fit = &report["output_error"]["front"];
    // Our own figure; the recording comes with no resonance to compare with.
    let (k, m) = (&fit["k_n_m"], &fit["mass_kg"]);
    let resonance = (k.as_f64().unwrap() / m.as_f64().unwrap()).sqrt() / std::f64::consts::TAU;
    assert!((resonance - 69.5).abs() < 1.0, "{resonance} Hz");
    assert!(fit["mass_std_kg"].is_f64());
}
