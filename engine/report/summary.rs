//! The report for a person at a terminal.

use std::fmt::Write;

use super::diagnosis::Diagnosis;
use super::{LatentRoad, Method, Report, ResultQuantity};
use veloid_core::bicycle::Axle;
use veloid_core::document::format_number::{Number, powers, significant};

/// The methods in the order in which they run, with names that fit their column.
const METHODS: [(&str, Method); 6] = [
    ("least squares", Method::LeastSquares),
    ("instrumental", Method::Instrumental),
    ("swarm", Method::Swarm),
    ("output error", Method::OutputError),
    ("latent road", Method::LatentRoad),
    ("extended", Method::Extended),
];

/// Explanations that are listed, the answer and those next to it.
const TRIED: usize = 6;

/// What was understood, every method's parameters, and the verdict.
pub fn summary(report: &Report) -> String {
    let mut text = String::new();
    // Writing to a String cannot fail.
    let _ = write(&mut text, report);
    text
}

fn write(out: &mut String, report: &Report) -> std::fmt::Result {
    result(out, report)?;
    if let Some(diagnosis) = &report.diagnosis {
        writeln!(out, "\n{}", powers(&diagnosis.sentence))?;
    }
    for next in &report.what_next {
        writeln!(out, "next: {next}")?;
    }
    let ride = &report.ride;
    writeln!(
        out,
        "\n{} samples, {} s at {} Hz",
        ride.samples,
        significant(ride.duration_s, 4),
        significant(ride.rate_hz, 5)
    )?;
    for assumed in &ride.reading {
        writeln!(out, "read: {assumed}")?;
    }
    for warning in &ride.warnings {
        writeln!(out, "warning: {warning}")?;
    }
    for mistake in report.other_mistakes() {
        writeln!(out, "warning: {}", mistake.sentence)?;
    }
    writeln!(
        out,
        "\nAll methods; the swarm's scatter is the standard deviation over its trials:"
    )?;
    writeln!(
        out,
        "{:<16}{:<7}{:>28}{:>28}",
        "method", "axle", "k (N/m)", "B (N s/m)"
    )?;
    for (name, method) in METHODS {
        rows(out, report, name, method)?;
    }
    not_identifiable(out, report)?;
    if let Some(latent) = &report.latent_road {
        without_road(out, latent)?;
    }
    let Some(diagnosis) = &report.diagnosis else {
        return Ok(());
    };
    for effect in &diagnosis.effects {
        for (name, parameter) in &effect.parameters {
            let rank = if effect.adequate {
                ""
            } else {
                ", not affirmed"
            };
            writeln!(
                out,
                "  {} ({name}{rank}): {}",
                effect.id,
                parameter.quantity(name)
            )?;
        }
    }
    // Of a law of the user's own all is of interest.
    let most = match report.settings.law {
        Some(_) => usize::MAX,
        None => TRIED,
    };
    tried(out, diagnosis, most)?;
    let more = diagnosis.warnings.iter();
    for warning in more.filter(|w| !ride.warnings.contains(w)) {
        writeln!(out, "warning: {warning}")?;
    }
    Ok(())
}

/// What was fitted to the end, a line for each set of effects.
fn tried(out: &mut String, diagnosis: &Diagnosis, most: usize) -> std::fmt::Result {
    if !diagnosis.tried.is_empty() {
        writeln!(out, "\nTried:")?;
    }
    let unit = diagnosis.held_out_unit();
    for tried in diagnosis.tried.iter().take(most) {
        let [values, parameters, gain, held_out, why] = tried.columns(unit);
        let plural = if parameters == "1" { "" } else { "s" };
        writeln!(
            out,
            "  {}: {why}; {values}; {parameters} parameter{plural}, gain {gain}, held out {held_out}",
            tried.name()
        )?;
    }
    match diagnosis.tried.len().saturating_sub(most) {
        0 => Ok(()),
        more => writeln!(out, "  {more} more in the report"),
    }
}

/// The answer, one line for each axle.
fn result(out: &mut String, report: &Report) -> std::fmt::Result {
    for (axle, result) in report.result.iter() {
        let quantities: Vec<String> = result.iter().map(quantity).collect();
        writeln!(out, "{:<7}{}", axle.name(), quantities.join("   "))?;
    }
    let mut reasons: Vec<&str> = (report.result.iter())
        .flat_map(|(_, result)| result.iter())
        .filter(|(_, quantity)| quantity.value.is_none())
        .filter_map(|(_, quantity)| quantity.why.as_deref())
        .collect();
    reasons.dedup();
    for why in reasons {
        writeln!(out, "withheld: {why}")?;
    }
    writeln!(out, "(± is the 95 % interval)")
}

fn quantity((name, quantity): (&str, &ResultQuantity)) -> String {
    let name = name.replace('_', " ");
    match (quantity.quantity(), quantity.std_error, &quantity.why) {
        (None, ..) => format!("{name} withheld"),
        (Some(value), None, Some(why)) => format!("{name} = {value} ({why})"),
        (Some(value), ..) => format!("{name} = {value}"),
    }
}

fn rows(out: &mut String, report: &Report, name: &str, method: Method) -> std::fmt::Result {
    let number = match method {
        Method::Swarm => Number::scattered,
        _ => Number::measured,
    };
    let estimates = report.estimates(method);
    estimates.iter().try_for_each(|(axle, e)| {
        let [k_error, b_error] = match method {
            Method::Swarm => [e.k_scatter_n_m, e.b_scatter_n_s_m],
            _ => [e.k_std_n_m, e.b_std_n_s_m],
        };
        let shown = |quantity, number: Number| match withheld(report, axle, quantity) {
            Some(_) => "withheld".to_owned(),
            None => number.to_string(),
        };
        let k = shown("k", number(e.k_n_m, k_error));
        let b = shown("B", number(e.b_n_s_m, b_error));
        writeln!(out, "{name:<16}{:<7}{k:>28}{b:>28}", axle.name())
    })
}

/// Why the result withholds a quantity.
fn withheld<'r>(report: &'r Report, axle: Axle, quantity: &str) -> Option<&'r str> {
    report.result.get(axle)?.withheld(quantity)
}

/// What else was found out without a road.
fn without_road(out: &mut String, latent: &LatentRoad) -> std::fmt::Result {
    if let Some(reason) = &latent.reason {
        writeln!(out, "not identified: {reason}")?;
    }
    if let Some(road) = &latent.road {
        writeln!(out, "road: ISO 8608 class {}", road.class)?;
    }
    if let Some(speed) = &latent.speed {
        let share = Number::measured(100.0 * speed.value, Some(100.0 * speed.std_error));
        writeln!(out, "speed reads low by {share} %")?;
    }
    for sensor in &latent.sensors {
        write!(out, "{}: {}", sensor.channel, sensor.noise_in_words())?;
        if let Some(gain) = &sensor.gain {
            let gain = Number::measured(gain.value, Some(gain.std_error));
            write!(out, ", gain {gain}")?;
        }
        if let Some(delay) = &sensor.delay_s {
            let late = Number::measured(1e3 * delay.value, Some(1e3 * delay.std_error));
            write!(out, ", late by {late} ms")?;
        }
        if let Some(drift) = &sensor.drift_ppm {
            let fast = Number::measured(drift.value, Some(drift.std_error));
            write!(out, ", fast by {fast} ppm")?;
        }
        writeln!(out)?;
    }
    latent
        .notes
        .iter()
        .try_for_each(|note| writeln!(out, "{note}"))
}

/// Why parameters that the result states have no interval by other methods.
fn not_identifiable(out: &mut String, report: &Report) -> std::fmt::Result {
    for (name, method) in METHODS {
        for (axle, e) in report.estimates(method).iter() {
            for (quantity, why) in [("k", &e.k_not_identifiable), ("B", &e.b_not_identifiable)] {
                let Some(why) = why else { continue };
                if withheld(report, axle, quantity).is_none() {
                    writeln!(out, "{name}, {axle}: {quantity} is not identifiable: {why}")?;
                }
            }
        }
    }
    Ok(())
}
