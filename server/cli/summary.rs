//! The report for a person at a terminal.

use std::fmt::Write;

use veloid_engine::bicycle::PerAxle;
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
        "{} samples, {:.2} s at {:.2} Hz",
        ride.samples, ride.duration_s, ride.rate_hz
    )?;
    for warning in &ride.warnings {
        writeln!(out, "warning: {warning}")?;
    }
    writeln!(
        out,
        "\n{:<16}{:<7}{:>12}{:>11}{:>12}{:>11}",
        "method", "axle", "k (N/m)", "+/-", "B (N s/m)", "+/-"
    )?;
    let swarm = PerAxle {
        front: report.swarm.front.clone(),
        rear: report.swarm.rear.clone(),
    };
    for (method, estimates) in [
        ("least squares", &report.least_squares),
        ("instrumental", &report.instrumental),
        ("swarm", &swarm),
        ("output error", &report.output_error),
    ] {
        rows(out, method, estimates)?;
    }
    let Some(diagnosis) = &report.diagnosis else {
        return Ok(());
    };
    rows(out, "extended", &diagnosis.extended)?;
    writeln!(out, "\n{}", diagnosis.sentence)?;
    for effect in &diagnosis.effects {
        for (name, parameter) in &effect.parameters {
            writeln!(
                out,
                "  {} ({name}): {} +/- {} {}",
                effect.id,
                Significant(parameter.value),
                error(parameter.std_error),
                parameter.unit
            )?;
        }
    }
    for warning in &diagnosis.warnings {
        writeln!(out, "warning: {warning}")?;
    }
    Ok(())
}

fn rows(out: &mut String, method: &str, estimates: &PerAxle<Estimate>) -> std::fmt::Result {
    for (axle, e) in estimates.iter() {
        writeln!(
            out,
            "{method:<16}{:<7}{:>12.6}{:>11}{:>12.6}{:>11}",
            axle.name(),
            Significant(e.k_n_m),
            error(e.k_std_n_m),
            Significant(e.b_n_s_m),
            error(e.b_std_n_s_m)
        )?;
    }
    Ok(())
}

fn error(std_error: Option<f64>) -> String {
    std_error.map_or("unknown".to_owned(), |e| format!("{e:.2e}"))
}

/// A number with as many significant digits as the precision says.
struct Significant(f64);

impl std::fmt::Display for Significant {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let digits = f.precision().unwrap_or(6) as i32;
        let before = self.0.abs().max(f64::MIN_POSITIVE).log10().floor() as i32 + 1;
        let text = if (-3..=digits + 2).contains(&before) {
            format!(
                "{:.*}",
                usize::try_from(digits - before).unwrap_or(0),
                self.0
            )
        } else {
            format!("{:.*e}", usize::try_from(digits - 1).unwrap_or(0), self.0)
        };
        f.pad_integral(true, "", &text)
    }
}

#[cfg(test)]
mod tests {
    use super::Significant;

    #[test]
    fn six_digits_whatever_the_size() {
        let text = |x: f64| format!("{:>12.6}", Significant(x));
        assert_eq!(text(109_364.123), "      109364");
        assert_eq!(text(1_234.567_8), "     1234.57");
        assert_eq!(text(0.012_345_678), "   0.0123457");
        assert_eq!(text(1.5e12), "  1.50000e12");
    }
}
