//! The report for a person at a terminal.

use std::fmt::Write;

use super::{Estimate, LatentRoad, Report, ResultQuantity};
use crate::bicycle::{Axle, PerAxle};
use crate::document::format_number::{Number, powers, significant};

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
    let ride = &report.ride;
    writeln!(
        out,
        "\n{} samples, {} s at {} Hz",
        ride.samples,
        significant(ride.duration_s, 4),
        significant(ride.rate_hz, 5)
    )?;
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
    measured(out, "least squares", &report.least_squares)?;
    measured(out, "instrumental", &report.instrumental)?;
    for (axle, e) in [
        (Axle::Front, &report.swarm.front),
        (Axle::Rear, &report.swarm.rear),
    ] {
        if let Some(e) = e {
            let k = Number::scattered(e.k_n_m, e.k_scatter_n_m);
            row(
                out,
                "swarm",
                axle,
                k,
                Number::scattered(e.b_n_s_m, e.b_scatter_n_s_m),
            )?;
        }
    }
    measured(out, "output error", &report.output_error)?;
    if let Some(latent) = &report.latent_road {
        measured(out, "latent road", &latent.axles())?;
    }
    if let Some(diagnosis) = &report.diagnosis {
        measured(out, "extended", &diagnosis.extended)?;
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
    let more = diagnosis.warnings.iter();
    for warning in more.filter(|w| !ride.warnings.contains(w)) {
        writeln!(out, "warning: {warning}")?;
    }
    Ok(())
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
    match (quantity.quantity(), quantity.std_error, &quantity.why) {
        (None, ..) => format!("{name} withheld"),
        (Some(value), None, Some(why)) => format!("{name} = {value} ({why})"),
        (Some(value), ..) => format!("{name} = {value}"),
    }
}

fn measured(out: &mut String, method: &str, estimates: &PerAxle<Estimate>) -> std::fmt::Result {
    estimates.iter().try_for_each(|(axle, e)| {
        let k = Number::measured(e.k_n_m, e.k_std_n_m);
        row(
            out,
            method,
            axle,
            k,
            Number::measured(e.b_n_s_m, e.b_std_n_s_m),
        )
    })
}

fn row(out: &mut String, method: &str, axle: Axle, k: Number, b: Number) -> std::fmt::Result {
    writeln!(out, "{method:<16}{:<7}{k:>28}{b:>28}", axle.name())
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
        let noise = significant(sensor.noise, 2);
        write!(out, "{}: noise {noise} {}", sensor.channel, sensor.unit)?;
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

/// Why parameters have no interval.
fn not_identifiable(out: &mut String, report: &Report) -> std::fmt::Result {
    let extended = report.diagnosis.as_ref().map(|d| ("extended", &d.extended));
    let latent = report.latent_road.as_ref().map(LatentRoad::axles);
    let latent = latent.as_ref().map(|axles| ("latent road", axles));
    let plain = [
        ("least squares", &report.least_squares),
        ("instrumental", &report.instrumental),
        ("output error", &report.output_error),
    ];
    for (method, estimates) in plain.into_iter().chain(extended).chain(latent) {
        for (axle, e) in estimates.iter() {
            for (name, why) in [("k", &e.k_not_identifiable), ("B", &e.b_not_identifiable)] {
                if let Some(why) = why {
                    writeln!(out, "{method}, {axle}: {name} is not identifiable: {why}")?;
                }
            }
        }
    }
    Ok(())
}
