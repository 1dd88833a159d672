//! The lines at a script's head: what it is, what it needs, and what is in the model.

use veloid_engine::report::diagnosis::{Diagnosis, EffectReport, ParameterReport};
use veloid_engine::report::model::left_out;

use super::content::{Content, Kind};

/// Lines of a script, `call` being how it is run.
pub fn lines(content: &Content, call: &str) -> Vec<String> {
    let report = content.report;
    let [what, prints] = match content.kind {
        Kind::Diagnosed => [
            "The identified model with its effects, simulated along a ride.",
            "prints for each axle the RMS error on the held-out part of the model's own ride, and the report's beside it.",
        ],
        Kind::Plain => [
            "The identified plain model (output error), simulated along a ride.",
            "prints for each axle the RMS error on the model's own ride, and the report's beside it.",
        ],
        Kind::Roadless => [
            "Stiffness and damping that were identified without a road, simulated on a road.",
            "prints for each axle the displacement (RMS).",
        ],
    };
    let bike = report.bike.bike.chars().filter(|c| !c.is_control());
    let bike: String = bike.collect();
    let mut lines = vec![
        what.to_owned(),
        format!("veloid {}, bike {bike}.", report.veloid),
        format!("  {call}"),
        prints.to_owned(),
        "Of another ride it prints the RMS error behind the part that the start is fitted to, as a rule a second, and the fit".to_owned(),
        "100 (1 - |y - y_model| / |y - mean(y)|) as MATLAB's compare.".to_owned(),
        format!("It reads {}.", content.takes()),
    ];
    if let Some(diagnosis) = &report.diagnosis {
        lines.extend(effects(diagnosis));
    }
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
fn line(effect: &EffectReport) -> String {
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
