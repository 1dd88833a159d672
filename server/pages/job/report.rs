//! The report's numbers as tables.

use veloid_engine::bicycle::{Axle, PerAxle};
use veloid_engine::document::format_number::{Quantity, fixed, significant};
use veloid_engine::report::diagnosis::Verdict;
use veloid_engine::report::{AxleResult, Estimate, Method, Report, ResultQuantity, RollReport};
use veloid_engine::result_of;

use super::inside::{self, InsideView};
use super::latent;
use crate::pages::words;

pub struct ReportView {
    pub version: String,
    pub result: Vec<ResultRow>,
    /// The method that the result of each axle is by, in words.
    pub by: String,
    /// Each axle's model from inside.
    pub inside: Vec<InsideView>,
    pub methods: Vec<MethodRow>,
    pub comparison: Vec<[String; 8]>,
    /// Why rows are absent.
    pub comparison_notes: Vec<String>,
    pub observer: Vec<[String; 7]>,
    pub roll: Option<Vec<String>>,
    /// What was found out without a road: terms and what they are.
    pub latent: Option<Vec<(String, String)>>,
    /// From what part of the sensors' spectra k and B were identified, and on which road.
    pub band: Option<String>,
    /// Mistakes that the verdict's sentence does not show.
    pub mistakes: Vec<String>,
    /// Whether a motion was simulated, which takes a road or a force.
    pub simulated: bool,
    pub trials: usize,
    pub seed: u64,
    pub settings: Vec<(String, String)>,
    pub what_next: Vec<String>,
}

/// The answer of one axle.
pub struct ResultRow {
    pub axle: &'static str,
    pub quantities: Vec<Answer>,
    /// Why values are withheld.
    pub reasons: Vec<String>,
}

/// A quantity of the base model.
pub struct Answer {
    /// Such as "k".
    pub name: String,
    /// Absent where it is withheld.
    pub quantity: Option<Quantity>,
    /// Why there is no interval beside the value.
    pub note: Option<String>,
}

/// What one method says of one axle.
pub struct MethodRow {
    pub method: String,
    pub axle: &'static str,
    /// Absent where the result withholds it.
    pub k: Option<Quantity>,
    pub b: Option<Quantity>,
    /// What stands beside the values: the swarm's scatter, or why there is no interval.
    pub k_note: Option<&'static str>,
    pub b_note: Option<&'static str>,
    pub k_bias: String,
    pub b_bias: String,
}

impl ReportView {
    pub fn of(report: &Report) -> Self {
        let result = result_of(report);
        Self {
            version: report.veloid.clone(),
            by: by(&result),
            result: (result.iter())
                .map(|(axle, result)| ResultRow::of(axle, result))
                .collect(),
            inside: inside::views(report, &result),
            methods: methods(report, &result),
            comparison: comparison(report),
            comparison_notes: report.comparison.notes.clone(),
            observer: observer(report),
            roll: report.roll.as_ref().map(roll),
            latent: report.latent_road.as_ref().map(latent::lines),
            band: report.latent_road.as_ref().and_then(latent::band),
            mistakes: (report.other_mistakes())
                .map(|mistake| mistake.sentence.clone())
                .collect(),
            simulated: !report.has_no_road(),
            trials: report.swarm.trials.len(),
            seed: report.settings.seed,
            settings: settings(report),
            what_next: report.what_next.clone(),
        }
    }
}

/// The method of the result, or of each axle's where they differ.
fn by(result: &PerAxle<AxleResult>) -> String {
    let of_axle = |(axle, result): (Axle, &AxleResult)| {
        let (_, quantity) = result.iter().next()?;
        Some((axle, quantity.method.title()))
    };
    let methods: Vec<(Axle, &str)> = result.iter().filter_map(of_axle).collect();
    match methods[..] {
        [(front, by_front), (rear, by_rear)] if by_front != by_rear => {
            format!("{front} axle: {by_front}; {rear} axle: {by_rear}")
        }
        [(_, by), ..] => by.to_owned(),
        [] => String::new(),
    }
}

fn k(e: &Estimate) -> Quantity {
    Quantity::new(e.k_n_m, e.k_std_n_m, "N/m")
}

fn b(e: &Estimate) -> Quantity {
    Quantity::new(e.b_n_s_m, e.b_std_n_s_m, "N s/m")
}

impl ResultRow {
    fn of(axle: Axle, result: &AxleResult) -> Self {
        let withheld = result.iter().filter(|(_, found)| found.value.is_none());
        let mut reasons: Vec<String> = withheld.filter_map(|(_, f)| f.why.clone()).collect();
        reasons.dedup();
        Self {
            axle: axle.name(),
            quantities: result.iter().map(Answer::of).collect(),
            reasons,
        }
    }
}

impl Answer {
    fn of((name, found): (&str, &ResultQuantity)) -> Self {
        Self {
            name: words::plain(name),
            quantity: found.quantity(),
            note: found.why.clone().filter(|_| found.value.is_some()),
        }
    }
}

fn methods(report: &Report, results: &PerAxle<AxleResult>) -> Vec<MethodRow> {
    let percent =
        |bias: Option<f64>| bias.map_or_else(|| "–".to_owned(), |p| format!("{} %", fixed(p, 2)));
    let withheld = (report.diagnosis.as_ref()).is_none_or(|d| d.verdict == Verdict::CannotTell);
    (Method::ALL.into_iter().rev())
        .filter(|method| *method != Method::Extended || !withheld)
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
            let stated = |name| {
                let result = results.get(axle);
                result.and_then(|r| r.withheld(name)).is_none()
            };
            let (has_k, has_b) = (stated("k"), stated("B"));
            let note = |why: &Option<String>| why.is_some().then_some("not identifiable");
            MethodRow {
                method: words::title(method.title()),
                axle: axle.name(),
                k: Some(k).filter(|_| has_k),
                b: Some(b).filter(|_| has_b),
                k_note: note(&e.k_not_identifiable).filter(|_| has_k),
                b_note: note(&e.b_not_identifiable).filter(|_| has_b),
                k_bias: percent(e.k_bias_percent.filter(|_| has_k)),
                b_bias: percent(e.b_bias_percent.filter(|_| has_b)),
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

/// How well the roll acceleration fits, and what was lacking.
fn roll(roll: &RollReport) -> Vec<String> {
    let errors = (roll.acceleration_error_rms_rad_s2).zip(roll.acceleration_error_max_rad_s2);
    let fit = errors.map(|(rms, most)| {
        format!(
            "The computed roll acceleration (eq. 4 of the paper) differs from the measured roll angle's second derivative by {} rad/s² (RMS), at most {} rad/s².",
            significant(rms, 3),
            significant(most, 3)
        )
    });
    fit.into_iter().chain(roll.notes.iter().cloned()).collect()
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
