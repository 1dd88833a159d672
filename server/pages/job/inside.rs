//! The report's `dynamics` and `validation` in words and tables.

use veloid_engine::bicycle::{Axle, PerAxle};
use veloid_engine::document::format_number::{fixed, significant};
use veloid_engine::report::dynamics::{Dynamics, ParameterErrors, Pole};
use veloid_engine::report::validation::{Distortion, FrequencyResponse, Validation};
use veloid_engine::report::{AxleResult, Report};

/// One axle's model from inside.
pub struct InsideView {
    pub axle: &'static str,
    /// Whether what the fit leaves is noise.
    pub fit: Vec<(&'static str, String)>,
    /// What the model swings like, and how well the record shows that.
    pub response: Vec<(&'static str, String)>,
    /// What distorts.
    pub missing: Vec<(&'static str, String)>,
    /// Rows of the parameters' errors: name, standard error of the fit and as reported, correlations.
    pub errors: Vec<[String; 4]>,
}

/// Of every axle that has any; nothing of stored reports of earlier versions.
pub fn views(report: &Report, results: &PerAxle<AxleResult>) -> Vec<InsideView> {
    let view = |axle: Axle| {
        let (dynamics, validation) = (report.dynamics.get(axle), report.validation.get(axle));
        let result = results.get(axle)?;
        if dynamics.is_none() && validation.is_none() {
            return None;
        }
        Some(InsideView {
            axle: axle.name(),
            fit: validation.map(fit).unwrap_or_default(),
            response: response(dynamics, validation, result),
            missing: validation.map(missing).unwrap_or_default(),
            errors: (dynamics.and_then(|d| d.parameters.as_ref()))
                .map(errors)
                .unwrap_or_default(),
        })
    };
    Axle::BOTH.into_iter().filter_map(view).collect()
}

fn fit(validation: &Validation) -> Vec<(&'static str, String)> {
    let mut lines = Vec::new();
    if let Some(tests) = &validation.residual {
        let of = match tests.model {
            veloid_engine::report::Method::Extended => "the model with the effects",
            _ => "the plain model",
        };
        lines.push((
            "Residual of",
            format!(
                "{of} on the fitted part, {} samples, whitened by an autoregressive noise model of order {}",
                tests.samples, tests.noise_order
            ),
        ));
        lines.push(("Autocorrelation", tests.autocorrelation.sentence.clone()));
        if let Some(cross) = &tests.cross_correlation {
            lines.push(("Cross-correlation", cross.sentence.clone()));
        }
    }
    lines.extend(because(validation, "residual"));
    lines
}

fn response(
    dynamics: Option<&Dynamics>,
    validation: Option<&Validation>,
    result: &AxleResult,
) -> Vec<(&'static str, String)> {
    let mut lines = Vec::new();
    if let Some(dynamics) = dynamics {
        let stated = |name| result.get(name).and_then(|found| found.quantity());
        if let Some(hz) = stated("natural_frequency") {
            lines.push(("Natural frequency", hz.to_string()));
        }
        if let Some(ratio) = stated("damping_ratio") {
            let words = match ratio_of(result) {
                r if r < 0.0 => "negative: a motion grows",
                r if r < 1.0 => "underdamped: it swings",
                _ => "overdamped: it creeps back without swinging",
            };
            lines.push(("Damping ratio", format!("{ratio} ({words})")));
        }
        if !dynamics.poles.is_empty() {
            let of = match dynamics.linear_part {
                true => ", of the linear part: the effects are not among them",
                false => "",
            };
            lines.push(("Poles", format!("{}{of}", poles(&dynamics.poles))));
        }
        if let Some(errors) = &dynamics.parameters {
            let number = errors.condition.map_or_else(
                || "singular".to_owned(),
                |condition| format!("condition number {}", significant(condition, 2)),
            );
            lines.push(("Errors", format!("{number}: {}", errors.least_known)));
        }
        lines.extend(dynamics.why.iter().map(|why| ("Absent", why.clone())));
    }
    if let Some(validation) = validation {
        lines.extend(
            validation
                .response
                .iter()
                .map(|r| ("Measured", measured(r))),
        );
        lines.extend(because(validation, "response"));
    }
    lines
}

fn ratio_of(result: &AxleResult) -> f64 {
    let found = result.get("damping_ratio").and_then(|found| found.value);
    found.unwrap_or_default()
}

fn poles(poles: &[Pole]) -> String {
    let real = |pole: &Pole| significant(pole.re_1_s, 4);
    match poles {
        [one, other] if one.im_rad_s != 0.0 && one.im_rad_s == -other.im_rad_s => {
            let im = significant(one.im_rad_s.abs(), 4);
            format!("{} ± {im} i 1/s", real(one))
        }
        _ => {
            let all: Vec<String> = poles.iter().map(real).collect();
            format!("{} 1/s", all.join(" and "))
        }
    }
}

fn measured(response: &FrequencyResponse) -> String {
    let band = |[from, to]: &[f64; 2]| {
        format!(
            "from {} to {} Hz",
            significant(*from, 3),
            significant(*to, 3)
        )
    };
    let bands: Vec<String> = response.coherent_hz.iter().map(band).collect();
    let bands = match bands.is_empty() {
        true => "at no frequency".to_owned(),
        false => bands.join(", "),
    };
    format!(
        "{} by Welch's method, {} segments of {} s ({} window, {} % overlap); coherence above {} {bands}",
        response.of,
        response.segments,
        significant(response.segment_s, 3),
        response.window,
        fixed(100.0 * response.overlap, 0),
        response.coherent_above
    )
}

fn missing(validation: &Validation) -> Vec<(&'static str, String)> {
    let mut lines = Vec::new();
    if let Some(response) = &validation.response {
        let distortion = response.distortion.as_ref().map(distortion);
        let why = response
            .distortion_why
            .as_ref()
            .map(|why| format!("not measured: {why}"));
        lines.extend(distortion.or(why).map(|text| ("Distortion", text)));
    }
    lines.extend(because(validation, "restoring"));
    lines
}

fn distortion(found: &Distortion) -> String {
    let percent = |share: Option<f64>| {
        share.map_or("not free".to_owned(), |share| {
            format!("{} %", significant(100.0 * share, 2))
        })
    };
    format!(
        "odd multiples {}, even multiples {}, noise {} of the output ({} periods of {} s)",
        percent(found.odd),
        percent(found.even),
        percent(Some(found.noise)),
        found.periods,
        significant(found.period_s, 3)
    )
}

/// Why a part is absent; reasons that name no part stand with the first.
fn because(
    validation: &Validation,
    part: &'static str,
) -> impl Iterator<Item = (&'static str, String)> {
    let parts = ["residual", "response", "restoring"];
    let belongs = move |why: &&String| match parts.iter().find(|name| why.starts_with(**name)) {
        Some(name) => *name == part,
        None => part == parts[0],
    };
    let why = validation.why.iter().filter(belongs);
    why.map(|why| ("Absent", why.clone()))
}

/// Rows of the parameters: name and unit, standard error of the fit, as reported, and correlations.
fn errors(found: &ParameterErrors) -> Vec<[String; 4]> {
    let row = |i: usize| {
        let others = (0..found.names.len()).filter(|j| *j != i).map(|j| {
            format!(
                "{} with {}",
                significant(found.correlation[i][j], 2),
                found.names[j]
            )
        });
        [
            format!("{} ({})", found.names[i], found.units[i]),
            significant(found.covariance[i][i].sqrt(), 3),
            significant(found.widened[i], 3),
            others.collect::<Vec<_>>().join(", "),
        ]
    };
    // What a stored report holds less of is not shown.
    let n = found.names.len();
    let is_whole = |rows: &[Vec<f64>]| rows.len() == n && rows.iter().all(|row| row.len() == n);
    let is_whole = is_whole(&found.covariance) && is_whole(&found.correlation);
    match is_whole && found.units.len() == n && found.widened.len() == n {
        true => (0..n).map(row).collect(),
        false => Vec::new(),
    }
}
