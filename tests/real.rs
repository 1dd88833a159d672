//! Recordings of other people, which lie outside the repository.

use crate::harness::{Folder, identify, veloid};
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

/// What an expert says of a recording: the verdict that is right, and the effects of which some must be affirmed and no other.
struct Expert {
    file: &'static str,
    columns: &'static [&'static str],
    mass: &'static str,
    verdict: &'static str,
    effects: &'static [&'static str],
}

/// As ../shared/real/README.md has them. Those of which veloid is not as sure as the expert stand in docs/real.md.
const EXPERTS: [Expert; 9] = [
    Expert {
        file: "pendulums/bicycle_fork_compound.csv",
        columns: &["z_f=gyro_V"],
        mass: "1",
        verdict: "named_in_part",
        effects: &["coulomb_friction", "cubic_stiffness"],
    },
    Expert {
        file: "pendulums/encoder_swing.csv",
        columns: &["z_f=angle_rad"],
        mass: "1",
        verdict: "named_in_part",
        effects: &["cubic_stiffness", "coulomb_friction", "quadratic_damping"],
    },
    Expert {
        file: "pendulums/bicycle_fork_torsional.csv",
        columns: &["z_f=gyro_V"],
        mass: "1",
        verdict: "nothing_missing",
        effects: &[],
    },
    Expert {
        file: "spring_mass/real_linear_h_1.txt",
        columns: &["t=2", "z_f=3"],
        mass: "1",
        verdict: "nothing_missing",
        effects: &[],
    },
    Expert {
        file: "dampers/mr_sine.csv",
        columns: &["z_f=displacement_m", "force_f=force_N"],
        mass: "1",
        verdict: "named_in_part",
        effects: &["coulomb_friction", "hysteresis"],
    },
    Expert {
        file: "dampers/friction_band_1hz.csv",
        columns: &["z_f=x_m", "force_f=force_N"],
        mass: "null",
        verdict: "named_in_part",
        effects: &["hysteresis", "free_play"],
    },
    Expert {
        file: "magnet_beam/free_decay.csv",
        columns: &["z_f=2"],
        mass: "1",
        verdict: "named_in_part",
        effects: &["cubic_stiffness", "quadratic_damping"],
    },
    Expert {
        file: "double_beam/decay.csv",
        columns: &["z_f=tip_velocity_m_s"],
        mass: "1",
        verdict: "named_in_part",
        effects: &["sprung_mass", "unsprung_mass"],
    },
    Expert {
        file: "sled/chirp.csv",
        columns: &["z_f=position_x100th", "force_f=motor_u"],
        mass: "null",
        verdict: "named_in_part",
        effects: &["coulomb_friction"],
    },
];

#[test]
fn val_recordings_of_others_are_answered_as_experts_do() {
    for expert in EXPERTS {
        let Some(ride) = recording(expert.file) else {
            return;
        };
        let folder = Folder::new();
        let bike = format!(r#"{{"bike": "bench", "mass_front_kg": {}}}"#, expert.mass);
        let bike = folder.write("bike.json", bike);
        let columns = expert.columns.iter().flat_map(|c| ["--map", c]);
        let quick = ["--trials", "1", "--iterations", "5"];
        let args: Vec<&str> = columns.chain(quick).collect();
        let (report, _) = identify(&ride, &bike, &args);
        let diagnosis = &report["diagnosis"];
        let told = format!("{}: {}", expert.file, diagnosis["sentence"]);
        assert_eq!(diagnosis["verdict"], expert.verdict, "{told}");
        let effects = diagnosis["effects"].as_array().unwrap();
        let affirmed: Vec<&str> = (effects.iter().filter(|e| e["affirmed"] == true))
            .map(|e| e["id"].as_str().unwrap())
            .collect();
        assert!(
            affirmed.iter().all(|id| expert.effects.contains(id)),
            "{told}"
        );
        assert_eq!(
            affirmed.is_empty(),
            expert.verdict != "named_in_part",
            "{told}"
        );
    }
}

/// The travel of a suspension without the road that it rides on is no free decay, and the message says what is lacking.
#[test]
fn a_travel_without_a_road_is_refused_with_what_is_missing() {
    let Some(ride) = recording("mtb_travel/run_00648.csv") else {
        return;
    };
    let folder = Folder::new();
    let bike = folder.write("bike.json", r#"{"mass_front_kg": 40, "mass_rear_kg": 50}"#);
    let columns = ["--map", "z_f=front_travel_m", "--map", "z_r=rear_travel_m"];
    let files = [ride.to_str().unwrap(), "--bike", bike.to_str().unwrap()];
    let output = veloid(&[&["identify"], &files[..], &columns[..]].concat());
    assert_eq!(output.status.code(), Some(2));
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(message.contains("record the road, the force"), "{message}");
}
