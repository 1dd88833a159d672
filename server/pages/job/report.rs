//! The report's numbers as tables.

use veloid_engine::bicycle::Axle;
use veloid_engine::document::format_number::{Quantity, fixed, significant};
use veloid_engine::report::{Estimate, Report};

use super::latent;
use crate::pages::estimate::{best, without_road};
use crate::pages::words;
use veloid_engine::report::Method;

pub struct ReportView {
    pub version: String,
    pub result: Vec<ResultRow>,
    /// Whether the result is the extended model's.
    pub extended: bool,
    pub methods: Vec<MethodRow>,
    pub comparison: Vec<[String; 8]>,
    /// Why rows are absent.
    pub comparison_notes: Vec<String>,
    pub observer: Vec<[String; 7]>,
    pub roll: Option<Vec<String>>,
    /// What was found out without a road: terms and what they are.
    pub latent: Option<Vec<(String, String)>>,
    /// Whether the result is that method's.
    pub without_road: bool,
    /// Mistakes that the verdict's sentence does not show.
    pub mistakes: Vec<String>,
    pub trials: usize,
    pub seed: u64,
    pub settings: Vec<(String, String)>,
}

/// The parameters to go by, of one axle.
pub struct ResultRow {
    pub axle: &'static str,
    pub k: Quantity,
    pub b: Quantity,
    /// Why there is no interval.
    pub k_unknown: Option<String>,
    pub b_unknown: Option<String>,
    pub mass: Quantity,
    pub mass_known: bool,
}

/// What one method says of one axle.
pub struct MethodRow {
    pub method: String,
    pub axle: &'static str,
    pub k: Quantity,
    pub b: Quantity,
    /// What stands beside the values: the swarm's scatter, or why there is no interval.
    pub k_note: Option<&'static str>,
    pub b_note: Option<&'static str>,
    pub k_bias: String,
    pub b_bias: String,
}

impl ReportView {
    pub fn of(report: &Report) -> Self {
        let extension = report.diagnosis.as_ref().filter(|d| !d.effects.is_empty());
        Self {
            version: report.veloid.clone(),
            result: best(report)
                .iter()
                .map(|(axle, e)| ResultRow::of(axle, e))
                .collect(),
            extended: extension.is_some(),
            methods: methods(report),
            comparison: comparison(report),
            comparison_notes: report.comparison.notes.clone(),
            observer: observer(report),
            roll: report.roll.as_ref().map(|roll| roll.notes.clone()),
            without_road: without_road(report).is_some(),
            latent: report.latent_road.as_ref().map(latent::lines),
            mistakes: (report.other_mistakes())
                .map(|mistake| mistake.sentence.clone())
                .collect(),
            trials: report.swarm.trials.len(),
            seed: report.settings.seed,
            settings: settings(report),
        }
    }
}

fn k(e: &Estimate) -> Quantity {
    Quantity::new(e.k_n_m, e.k_std_n_m, "N/m")
}

fn b(e: &Estimate) -> Quantity {
    Quantity::new(e.b_n_s_m, e.b_std_n_s_m, "N s/m")
}

impl ResultRow {
    fn of(axle: Axle, e: &Estimate) -> Self {
        Self {
            axle: axle.name(),
            k: k(e),
            b: b(e),
            k_unknown: e.k_not_identifiable.clone(),
            b_unknown: e.b_not_identifiable.clone(),
            mass: match e.mass_kg > 0.0 {
                true => Quantity::new(e.mass_kg, e.mass_std_kg, "kg"),
                false => Quantity::choice("none moves"),
            },
            mass_known: e.mass_kg > 0.0 && e.mass_std_kg.is_none(),
        }
    }
}

fn methods(report: &Report) -> Vec<MethodRow> {
    let percent =
        |bias: Option<f64>| bias.map_or_else(|| "–".to_owned(), |p| format!("{} %", fixed(p, 2)));
    let plain = (Method::ALL.into_iter().rev()).filter(|m| *m != Method::Extended);
    plain
        .flat_map(|method| {
            let estimates = report.estimates(method);
            let of = |axle| Some((method, axle, estimates.get(axle)?.clone()));
            Axle::BOTH.into_iter().filter_map(of).collect::<Vec<_>>()
        })
        .map(|(method, axle, e)| {
            let (k, b) = match method {
                Method::Swarm => (
                    Quantity::scattered(e.k_n_m, e.k_scatter_n_m, "N/m"),
                    Quantity::scattered(e.b_n_s_m, e.b_scatter_n_s_m, "N s/m"),
                ),
                _ => (k(&e), b(&e)),
            };
            let note = |why: &Option<String>| why.is_some().then_some("not identifiable");
            MethodRow {
                method: words::title(method.title()),
                axle: axle.name(),
                k,
                b,
                k_note: note(&e.k_not_identifiable),
                b_note: note(&e.b_not_identifiable),
                k_bias: percent(e.k_bias_percent),
                b_bias: percent(e.b_bias_percent),
            }
        })
        .collect()
}

fn comparison(report: &Report) -> Vec<[String; 8]> {
    let digits = |x: f64| significant(x, 3);
    let rows = report.comparison.rows.iter();
    rows.map(|row| {
        [
            words::title(&words::method(&row.method)),
            row.axle.name().to_owned(),
            digits(1e3 * row.position_max_m),
            digits(1e6 * row.position_mse_m2),
            digits(row.velocity_max_m_s),
            digits(row.velocity_mse_m2_s2),
            digits(row.acceleration_max_m_s2),
            digits(row.acceleration_mse_m2_s4),
        ]
    })
    .collect()
}

fn observer(report: &Report) -> Vec<[String; 7]> {
    let rows = report.observer.iter();
    rows.map(|(axle, o)| {
        [
            axle.name().to_owned(),
            significant(1e3 * o.position_max_m, 3),
            significant(1e3 * o.position_rms_m, 3),
            significant(o.velocity_max_m_s, 3),
            significant(o.velocity_rms_m_s, 3),
            significant(o.jerk_bound_m_s3, 3),
            significant(o.converged_after_s, 2),
        ]
    })
    .collect()
}

/// Every setting as the report has it.
fn settings(report: &Report) -> Vec<(String, String)> {
    match serde_json::to_value(&report.settings) {
        Ok(serde_json::Value::Object(map)) => map
            .into_iter()
            .map(|(key, value)| (key, value.to_string()))
            .collect(),
        _ => Vec::new(),
    }
}
