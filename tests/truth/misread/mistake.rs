//! What people get wrong, each as they do it.

use serde_json::json;

use super::record::{Kind, Recorded};
use crate::chance::Chance;

/// How a mistake is noticed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Noticed {
    /// As one of these kinds of the report's `mistakes`.
    Named(&'static [&'static str]),
    /// By a warning that holds these words, with k and B right all the same.
    Used(&'static str),
}

/// One mistake, on the kinds of bench on which a ride can show it.
pub struct Mistake {
    pub name: &'static str,
    pub kinds: &'static [Kind],
    pub noticed: Noticed,
    pub make: fn(&mut Recorded, &mut Chance),
}

const EVERY: &[Kind] = &Kind::ALL;
const SENSED: &[Kind] = &[Kind::Accelerometers, Kind::Laser];
const ROAD: &[Kind] = &[Kind::Road];
const LASER: &[Kind] = &[Kind::Laser];
const BOTH_ROADS: &[Kind] = &[Kind::Road, Kind::Laser];

/// Standard gravity, m/s^2.
const G: f64 = 9.806_65;

pub const MISTAKES: [Mistake; 20] = [
    Mistake {
        name: "one axle's sensor counts downwards",
        kinds: EVERY,
        noticed: Noticed::Named(&["turned_channel"]),
        make: |ride, chance| {
            let name = motion(ride, chance);
            ride.scale(&name, -1.0);
        },
    },
    Mistake {
        name: "one displacement or road in mm, cm or inches",
        kinds: ROAD,
        noticed: Noticed::Named(&["wrong_unit"]),
        make: |ride, chance| {
            let name = chance.pick(&["u_f", "u_r", "z_f", "z_r"]);
            ride.scale(name, chance.pick(&[1e3, 1e2, 39.37]));
        },
    },
    Mistake {
        name: "one accelerometer in g",
        kinds: SENSED,
        noticed: Noticed::Named(&["wrong_unit"]),
        make: |ride, chance| {
            let name = motion(ride, chance);
            ride.scale(&name, 1.0 / G);
        },
    },
    Mistake {
        name: "both accelerometers in g",
        kinds: LASER,
        noticed: Noticed::Named(&["wrong_unit"]),
        make: |ride, _| {
            ["a_f", "a_r"]
                .into_iter()
                .for_each(|a| ride.scale(a, 1.0 / G))
        },
    },
    Mistake {
        name: "laser in mm or cm",
        kinds: LASER,
        noticed: Noticed::Named(&["wrong_unit"]),
        make: |ride, chance| {
            let by = chance.pick(&[1e3, 1e2]);
            ride.laser().into_iter().for_each(|d| ride.scale(&d, by));
        },
    },
    Mistake {
        name: "laser reports the distance to the road",
        kinds: LASER,
        noticed: Noticed::Used("distance to the road"),
        make: |ride, _| ride.laser().into_iter().for_each(|d| ride.scale(&d, -1.0)),
    },
    Mistake {
        name: "front and rear sensor exchanged",
        kinds: EVERY,
        noticed: Noticed::Named(&[
            "swapped_displacements",
            "swapped_axles",
            "swapped_accelerometers",
        ]),
        make: |ride, _| {
            ride.swap("z_f", "z_r");
            ride.swap("a_f", "a_r");
        },
    },
    Mistake {
        name: "all of front and rear exchanged",
        kinds: BOTH_ROADS,
        noticed: Noticed::Named(&["swapped_axles"]),
        make: |ride, _| {
            for what in ["u", "z", "a", "d"] {
                ride.swap(&format!("{what}_f"), &format!("{what}_r"));
            }
        },
    },
    Mistake {
        name: "u and z of one axle exchanged",
        kinds: ROAD,
        noticed: Noticed::Named(&["swapped_road"]),
        make: |ride, chance| match chance.happens(0.5) {
            true => ride.swap("u_f", "z_f"),
            false => ride.swap("u_r", "z_r"),
        },
    },
    Mistake {
        name: "speed in km/h",
        kinds: EVERY,
        noticed: Noticed::Named(&["speed_unit"]),
        make: |ride, _| ride.scale("v", 3.6),
    },
    Mistake {
        name: "speed in miles per hour",
        kinds: EVERY,
        noticed: Noticed::Named(&["speed_unit"]),
        make: |ride, _| ride.scale("v", 2.236_936),
    },
    Mistake {
        name: "times in s under t [ms]",
        kinds: EVERY,
        noticed: Noticed::Named(&["wrong_unit"]),
        make: |ride, _| rename_time(ride, "t [ms]", 1.0),
    },
    Mistake {
        name: "times in ms under t [us]",
        kinds: EVERY,
        noticed: Noticed::Named(&["wrong_unit"]),
        make: |ride, _| rename_time(ride, "t [us]", 1e3),
    },
    Mistake {
        name: "times in ms under t",
        kinds: EVERY,
        noticed: Noticed::Named(&["wrong_unit"]),
        make: |ride, _| rename_time(ride, "t", 1e3),
    },
    Mistake {
        name: "one accelerometer 30 ms late",
        kinds: SENSED,
        noticed: Noticed::Named(&["late_channel"]),
        make: |ride, chance| {
            let name = motion(ride, chance);
            if let Some(values) = ride.column(&name) {
                values.rotate_right(3);
            }
        },
    },
    Mistake {
        name: "a mass doubled",
        kinds: EVERY,
        noticed: Noticed::Named(&["bicycle"]),
        make: |ride, chance| {
            let key = chance.pick(&["mass_front_kg", "mass_rear_kg"]);
            let mass = ride.bike[key].as_f64().unwrap_or(0.0);
            ride.bike[key] = json!(2.0 * mass);
        },
    },
    Mistake {
        name: "l_F and l_R exchanged",
        kinds: EVERY,
        noticed: Noticed::Named(&["bicycle"]),
        make: |ride, _| {
            let lengths = ["l_front_m", "l_rear_m"].map(|key| ride.bike[key].clone());
            let [front, rear] = lengths;
            ride.bike["l_front_m"] = rear;
            ride.bike["l_rear_m"] = front;
        },
    },
    Mistake {
        name: "a sensor freezes for 3 s",
        kinds: EVERY,
        noticed: Noticed::Used("the same value"),
        make: |ride, chance| {
            let (name, from) = (motion(ride, chance), 1000 + chance.index(4000));
            if let Some(values) = ride.column(&name) {
                let frozen = values[from];
                values[from..from + 300].fill(frozen);
            }
        },
    },
    Mistake {
        name: "zeros for one sample in 100",
        kinds: EVERY,
        noticed: Noticed::Used("zeros"),
        make: |ride, chance| {
            let name = motion(ride, chance);
            for value in ride.column(&name).into_iter().flatten() {
                if chance.happens(0.01) {
                    *value = Some(0.0);
                }
            }
        },
    },
    Mistake {
        name: "one sample in 100 missing",
        kinds: EVERY,
        noticed: Noticed::Used("missing"),
        make: |ride, chance| {
            let name = ride.laser().unwrap_or_else(|| motion(ride, chance));
            for value in ride.column(&name).into_iter().flatten() {
                if chance.happens(0.01) {
                    *value = None;
                }
            }
        },
    },
];

/// The channel of one axle's motion.
fn motion(ride: &Recorded, chance: &mut Chance) -> String {
    let what = match ride.columns.iter().any(|(name, _)| name == "z_f") {
        true => ["z_f", "z_r"],
        false => ["a_f", "a_r"],
    };
    chance.pick(&what).to_owned()
}

/// Times `by` what they were in seconds, under another header.
fn rename_time(ride: &mut Recorded, header: &str, by: f64) {
    ride.scale("t", by);
    header.clone_into(&mut ride.columns[0].0);
}
