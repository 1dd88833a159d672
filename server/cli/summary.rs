//! The report for a person at a terminal.

use std::fmt::Write;

use veloid_engine::bicycle::{Axle, PerAxle};
use veloid_engine::number::{Number, significant};
use veloid_engine::report::{Estimate, Report};

/// What was understood, every method's parameters, and the verdict.
pub fn summary(report: &Report) -> String {
    let mut text = String::new();
    // Writing to a String cannot fail.
    let _ = write(&mut text, report);
    text
}

fn write(out: &mut String, report: &Report) -> std::fmt::Result {
    let ride = &report.ride;
    writeln!(
        out,
        "{} samples, {} s at {} Hz",
        ride.samples,
        significant(ride.duration_s, 4),
        significant(ride.rate_hz, 5)
    )?;
    for warning in &ride.warnings {
        writeln!(out, "warning: {warning}")?;
    }
    writeln!(
        out,
        "\nIntervals (±) are of 95 %; the swarm's scatter is the standard deviation over its trials."
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
    if let Some(diagnosis) = &report.diagnosis {
        measured(out, "extended", &diagnosis.extended)?;
    }
    not_identifiable(out, report)?;
    let Some(diagnosis) = &report.diagnosis else {
        return Ok(());
    };
    writeln!(out, "\n{}", diagnosis.sentence)?;
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
    for warning in &diagnosis.warnings {
        writeln!(out, "warning: {warning}")?;
    }
    Ok(())
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

/// Why parameters have no interval.
fn not_identifiable(out: &mut String, report: &Report) -> std::fmt::Result {
    let extended = report.diagnosis.as_ref().map(|d| ("extended", &d.extended));
    let plain = [
        ("least squares", &report.least_squares),
        ("instrumental", &report.instrumental),
        ("output error", &report.output_error),
    ];
    for (method, estimates) in plain.into_iter().chain(extended) {
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
