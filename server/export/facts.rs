//! What scripts in any language know of the ride.

use veloid_engine::bicycle::Axle;
use veloid_engine::report::Report;
use veloid_engine::report::simulation::{Simulation, names};

/// Where the ride comes from that every script can read.
pub const AS_READ: &str = "the ride as veloid read it: /v1/jobs/ID/model?format=csv of the server, or veloid identify with --model ride.csv";

/// Channel, header and factor of each column that a script may read from the ride's own file: none of a ride of several.
pub fn channels(report: &Report) -> Vec<(String, &str, f64)> {
    if !report.ride.files.is_empty() {
        return Vec::new();
    }
    let columns = report.ride.columns.iter();
    let mut found: Vec<(String, &str, f64)> = columns
        .map(|c| (c.channel.clone(), c.header.trim(), c.scale))
        .collect();
    for (z, d) in deflections(report) {
        let of = found.iter().find(|(channel, ..)| channel == d).cloned();
        found.extend(of.map(|(_, header, scale)| (z.to_owned(), header, scale)));
    }
    found
}

/// On a rig the deflection is what is prescribed: the displacements for which it stands, and its channels. veloid takes their mean off.
pub fn deflections(report: &Report) -> impl Iterator<Item = (&'static str, &'static str)> {
    let has = |name| report.ride.columns.iter().any(|c| c.channel == name);
    let both = [("z_f", "d_f"), ("z_r", "d_r")].into_iter();
    both.filter(move |(z, d)| !has(*z) && has(*d))
}

/// Channels of the bicycle that the laws ask for.
pub fn needed(simulation: &Simulation) -> Vec<&'static str> {
    let effects = simulation.axles.iter().flat_map(|(_, axle)| &axle.effects);
    let words: Vec<&str> = effects
        .flat_map(|effect| effect.law.expressions())
        .flat_map(names)
        .collect();
    let asked = [
        ("v", &["speed", "distance", "wheel"][..]),
        ("speed_rate", &["speed_rate"]),
        ("cadence", &["crank"]),
    ];
    let is_spoken = |spoken: &[&str]| words.iter().any(|word| spoken.contains(word));
    asked
        .into_iter()
        .filter(|(_, spoken)| is_spoken(spoken))
        .map(|(channel, _)| channel)
        .collect()
}

/// What the report says of an axle's held-out error, in words.
pub fn reported(report: &Report, axle: Axle) -> String {
    let held = report.diagnosis.as_ref().and_then(|d| d.held_out.get(axle));
    let Some(held) = held else {
        return "the report has none".to_owned();
    };
    let unit = held.predicted.unit();
    match (held.extended_rms_m, held.horizon_s) {
        (None, _) => "the report has none: the model runs away".to_owned(),
        (Some(error), None) => format!("in the report {error:?} {unit}"),
        (Some(error), Some(horizon)) => format!(
            "in the report {error:?} {unit}, of predictions over {horizon:?} s each from a start of its own, which this is not"
        ),
    }
}
