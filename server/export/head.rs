//! The lines at a script's head: what it is, what it needs, and what is in the model.

use veloid_engine::report::Report;
use veloid_engine::report::diagnosis::{Diagnosis, EffectReport, ParameterReport};
use veloid_engine::report::model::left_out;

use super::facts::AS_READ;

/// Lines of a script that simulates the model with its effects, `call` being how it is run.
pub fn lines(report: &Report, call: &str) -> Vec<String> {
    let mut lines = vec![
        "The identified model with its effects, simulated along the ride.".to_owned(),
        format!("veloid {}, bike {}.", report.veloid, plain(&report.bike.bike)),
        format!("  {call}"),
        "prints the RMS error on the held-out part of the ride for each axle, and the report's beside it.".to_owned(),
    ];
    lines.extend(what_it_needs(report));
    if let Some(diagnosis) = &report.diagnosis {
        lines.extend(effects(diagnosis));
    }
    lines
}

/// Lines of a script that simulates what was identified without a road.
pub fn roadless_lines(report: &Report, call: &str, input: &str) -> Vec<String> {
    vec![
        "Stiffness and damping that were identified without a road, simulated on a road."
            .to_owned(),
        format!(
            "veloid {}, bike {}.",
            report.veloid,
            plain(&report.bike.bike)
        ),
        format!("  {call}"),
        format!("It reads {input}."),
    ]
}

/// Lines of a script that simulates the plain model.
pub fn plain_lines(report: &Report, call: &str) -> Vec<String> {
    let mut lines = vec![
        "The identified plain model (output error), simulated along the ride.".to_owned(),
        format!(
            "veloid {}, bike {}.",
            report.veloid,
            plain(&report.bike.bike)
        ),
        format!("  {call}"),
    ];
    lines.extend(what_it_needs(report));
    if let Some(diagnosis) = &report.diagnosis {
        lines.extend(effects(diagnosis));
    }
    lines
}

/// Which table a script reads.
fn what_it_needs(report: &Report) -> Vec<String> {
    let mut lines = match report.ride.files.len() {
        0 | 1 => vec!["It reads the ride's own CSV where that is evenly sampled and every channel is logged in it, else".to_owned()],
        _ => vec!["The ride has several files. This needs it as one table:".to_owned()],
    };
    lines.push(format!("{AS_READ}."));
    lines
}

fn effects(diagnosis: &Diagnosis) -> Vec<String> {
    let mut lines = Vec::new();
    if diagnosis.effects.is_empty() {
        lines.push("The diagnosis found no effects.".to_owned());
    } else {
        lines.push("Effects that the diagnosis found:".to_owned());
        lines.extend(diagnosis.effects.iter().map(line));
    }
    let left_out = left_out(diagnosis);
    if !left_out.is_empty() {
        lines.push("NOT in the script:".to_owned());
        lines.extend((left_out.iter()).map(|e| format!("  {} ({})", e.id, e.axle.name())));
    }
    lines
}

/// An effect with its numbers.
pub fn line(effect: &EffectReport) -> String {
    let value = |(name, p): (&String, &ParameterReport)| match p.unit.as_str() {
        "-" => format!("{name} = {}", p.value),
        unit => format!("{name} = {} {unit}", p.value),
    };
    let values: Vec<String> = effect.parameters.iter().map(value).collect();
    format!(
        "  {} ({}): {}",
        effect.id,
        effect.axle.name(),
        values.join(", ")
    )
}

/// A text on one line.
fn plain(text: &str) -> String {
    text.chars().filter(|c| !c.is_control()).collect()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use veloid_engine::report::diagnosis::Place;

    use super::*;

    #[test]
    fn effects_without_a_law_are_said_not_to_be_in_the_script() {
        let effect = EffectReport {
            id: "cubic_stiffness".to_owned(),
            axle: Place::Front,
            parameters: BTreeMap::new(),
            p_value: None,
            separation: None,
            affirmed: true,
            support: None,
            adequate: true,
            material: true,
            sentence: String::new(),
        };
        let mut diagnosis = Diagnosis::without_verdict(String::new());
        assert!(left_out(&diagnosis).is_empty());
        diagnosis.effects.push(effect.clone());
        assert_eq!(left_out(&diagnosis), [effect.name()]);
        let said = effects(&diagnosis);
        assert!(said.iter().any(|line| line.contains("NOT in the script")));
        assert!(
            said.iter()
                .any(|line| line.trim() == "cubic_stiffness (front)")
        );
    }
}
