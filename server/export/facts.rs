//! What scripts in any language know of the ride.

use veloid_engine::report::simulation::{Simulation, names};

use super::content::{Content, Kind};

/// Channel, header and factor of each column of the ride's own file. Of a ride of several files none, and channels are then
/// called by their names.
pub fn channels<'a>(content: &Content<'a>) -> Vec<(String, &'a str, f64)> {
    let ride = &content.report.ride;
    if !ride.files.is_empty() || content.kind == Kind::Roadless {
        return Vec::new();
    }
    let columns = ride.columns.iter();
    let mut found: Vec<(String, &str, f64)> = columns
        .map(|c| (c.channel.clone(), c.header.trim(), c.scale))
        .collect();
    for (z, other) in prescribed(content) {
        let of = found.iter().find(|(channel, ..)| *channel == other);
        let of = of.map(|(_, header, scale)| (z, *header, *scale));
        found.extend(of);
    }
    found
}

/// Displacements for which a rig's deflection stands: veloid takes its mean off.
pub fn centred(content: &Content) -> Vec<String> {
    let deflections = prescribed(content).filter(|(_, other)| other.starts_with('d'));
    deflections.map(|(z, _)| z).collect()
}

/// Displacements that a rig prescribes, and the channels that stand for them where they are not recorded.
fn prescribed(content: &Content) -> impl Iterator<Item = (String, String)> {
    let columns = &content.report.ride.columns;
    let has = |name: &String| columns.iter().any(|c| c.channel == *name);
    let axles = content.simulation.axles.iter();
    let axles = axles.filter(|(_, model)| model.prescribed);
    axles.filter_map(move |(axle, _)| {
        let named = |kind: &str| format!("{kind}_{}", &axle.name()[..1]);
        let z = named("z");
        let other = ["d", "u"].map(named).into_iter().find(has)?;
        (!has(&z)).then_some((z, other))
    })
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
