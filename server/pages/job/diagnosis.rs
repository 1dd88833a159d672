//! The report's diagnosis in words and tables.

use veloid_engine::bicycle::Axle;
use veloid_engine::document::format_number::{Quantity, fixed, powers, significant};
use veloid_engine::report::Report;
use veloid_engine::report::diagnosis::{
    Detectable, Diagnosis, EffectReport, HeldOut, Place, Stronger, Verdict,
};
use veloid_engine::report::windows::Support;
use veloid_engine::result_of;

use super::bars;
use super::tried::TriedView;
use crate::pages::words;

pub struct DiagnosisView {
    pub verdict: &'static str,
    pub label: &'static str,
    pub sentence: String,
    pub effects: Vec<EffectView>,
    pub alternatives: Vec<String>,
    pub warnings: Vec<String>,
    pub axles: Vec<AxleView>,
    pub tried: Vec<TriedView>,
    /// Effects, their values, parameters, gain, held-out errors, and why each set is not the answer.
    pub candidates: Vec<(String, [String; 5])>,
    pub detectable: Vec<[String; 4]>,
    pub switched_off: Vec<(String, String)>,
}

/// One effect of the verdict.
pub struct EffectView {
    pub id: String,
    pub title: String,
    pub axle: &'static str,
    /// Name, value, and why there is no interval.
    pub parameters: Vec<(String, Quantity, Option<String>)>,
    pub evidence: String,
    pub notes: Vec<String>,
}

/// What the diagnosis says of one axle.
pub struct AxleView {
    pub axle: &'static str,
    /// Whether the plain model misses something, in words.
    pub mismatch: String,
    pub windows: Vec<String>,
    pub bands: Vec<String>,
    pub states: Vec<String>,
    pub bars: String,
    pub explained: Option<String>,
    pub held_out: String,
    pub consequences: Vec<(String, String, String)>,
}

/// Whether any stiffness or damping is reported.
fn has_result(report: &Report) -> bool {
    let results = result_of(report);
    let mut quantities = results.iter().flat_map(|(_, result)| result.iter());
    quantities.any(|(_, quantity)| quantity.std_error.is_some())
}

fn verdict(verdict: Verdict, has_result: bool) -> (&'static str, &'static str) {
    match verdict {
        Verdict::NothingMissing => ("nothing_missing", "Nothing is missing from the model"),
        Verdict::Named => ("named", "The model is missing something"),
        Verdict::Ambiguous => (
            "ambiguous",
            "The model is missing something; several explanations are possible",
        ),
        Verdict::NamedInPart => (
            "named_in_part",
            "The model is missing something; part of it has a name",
        ),
        Verdict::CannotTell if has_result => ("cannot_tell", "No verdict on missing physics"),
        Verdict::CannotTell => ("cannot_tell", "No result: fix this first"),
        Verdict::Unnamed => ("unnamed", "The model is missing something without a name"),
    }
}

const UNKNOWN: &str = "unknown";

/// A number where it is known.
fn known(value: Option<f64>, text: impl Fn(f64) -> String) -> String {
    value.map_or(UNKNOWN.to_owned(), text)
}

impl DiagnosisView {
    pub fn of(report: &Report) -> Option<Self> {
        let d = report.diagnosis.as_ref()?;
        let (verdict, label) = verdict(d.verdict, has_result(report));
        Some(Self {
            verdict,
            label,
            sentence: powers(&d.sentence),
            effects: d.effects.iter().map(EffectView::of).collect(),
            alternatives: d
                .alternatives
                .iter()
                .map(|set| {
                    let names = set
                        .iter()
                        .map(|n| format!("{} ({})", words::plain(&n.id), n.axle.name()));
                    names.collect::<Vec<_>>().join(" with ")
                })
                .collect(),
            warnings: d.warnings.clone(),
            axles: Axle::BOTH
                .into_iter()
                .filter_map(|axle| AxleView::of(d, axle, report.settings.alpha))
                .collect(),
            tried: (d.windows.iter())
                .map(|(axle, windows)| {
                    let unit = d.held_out.get(axle).map_or("m", |held| held.errors().1);
                    TriedView::of(axle.name(), windows, unit)
                })
                .collect(),
            candidates: (d.tried.iter())
                .map(|tried| (tried.name(), tried.columns(d.held_out_unit())))
                .collect(),
            detectable: d.detectable.iter().map(detectable).collect(),
            switched_off: d
                .switched_off
                .iter()
                .map(|x| (words::title(&x.id), x.why.clone()))
                .collect(),
        })
    }
}

/// Effect, axle, parameter, and from where on it would have shown.
fn detectable(x: &Detectable) -> [String; 4] {
    let size = x.smallest_detectable.map(|size| {
        let quantity = Quantity::rough(size, 3, &x.unit);
        match x.stronger {
            Stronger::Larger => format!("{quantity} or more"),
            Stronger::Smaller => format!("{quantity} or less"),
        }
    });
    let why = || x.reason.clone().unwrap_or("not on this ride".to_owned());
    [
        words::title(&x.id),
        x.axle.name().to_owned(),
        words::plain(&x.parameter),
        size.unwrap_or_else(why),
    ]
}

impl EffectView {
    fn of(effect: &EffectReport) -> Self {
        let mut notes = Vec::new();
        if !effect.adequate {
            notes.push("only the nearest shape: it does not explain the ride".to_owned());
        }
        if !effect.material {
            notes.push("significant, but too small to matter".to_owned());
        }
        let chance = match effect.p_value {
            None => "Found as a replacement for another effect, so its probability by chance was not computed"
                .to_owned(),
            Some(p) if p < 1e-4 => "Probability by chance alone below 0.0001".to_owned(),
            Some(p) => format!("Probability by chance alone {}", significant(p, 2)),
        };
        let parameters = effect.parameters.iter();
        let parameters = parameters.map(|(name, p)| {
            (
                words::plain(name),
                p.quantity(name),
                p.not_identifiable.clone(),
            )
        });
        Self {
            id: effect.id.clone(),
            title: words::title(&effect.id),
            axle: effect.axle.name(),
            parameters: parameters.collect(),
            evidence: match &effect.support {
                Some(support) => supported(support),
                None => format!(
                    "{chance}; the log likelihood falls by {} without it.",
                    known(effect.separation, |gain| fixed(gain, 1))
                ),
            },
            notes,
        }
    }
}

/// Evidence that does not rest on a complete model.
fn supported(support: &Support) -> String {
    let share = support.share.map_or(String::new(), |share| {
        format!(
            "Without it {} % of the squared held-out error returns. ",
            fixed(100.0 * share, 0)
        )
    });
    let next = support.next.as_ref().map_or(String::new(), |id| {
        format!("; {} comes nearest in its place", words::plain(id))
    });
    format!(
        "{share}Support {} in {} parts of the record{next}.",
        fixed(support.weight, 2),
        support.windows
    )
}

/// What the effects explain, where it is known what noise leaves to explain; else how far the error falls.
fn explained(held: &HeldOut) -> Option<String> {
    if let Some(share) = held.explained_share.filter(|share| *share > 0.0) {
        let percent = fixed(100.0 * share, 1);
        return Some(format!(
            "The effects explain {percent} % of the variance above the sensor's noise."
        ));
    }
    let ([plain, extended, _], unit) = held.errors();
    let (plain, extended) = (plain?, extended?);
    let rough = |rms: f64| Quantity::rough(rms, 3, unit);
    (extended < plain).then(|| {
        format!(
            "With the effects the error falls from {} to {}.",
            rough(plain),
            rough(extended)
        )
    })
}

impl AxleView {
    fn of(d: &Diagnosis, axle: Axle, alpha: f64) -> Option<Self> {
        let (held, place) = (d.held_out.get(axle)?, d.location.get(axle)?);
        let range = |[from, to]: &[f64; 2], unit: &str| {
            format!(
                "{} to {} {unit}",
                significant(*from, 3),
                significant(*to, 3)
            )
        };
        let here = |e: &EffectReport| e.axle == Place::Both || Place::from(axle) == e.axle;
        let extended = d.effects.iter().any(here);
        Some(Self {
            axle: axle.name(),
            mismatch: place.in_words(alpha),
            windows: place.windows_s.iter().map(|w| range(w, "s")).collect(),
            bands: place.bands_hz.iter().map(|b| range(b, "Hz")).collect(),
            states: place.states.clone(),
            bars: bars::of(axle.name(), held, extended),
            explained: extended.then(|| explained(held)).flatten(),
            held_out: range(&held.window_s, "s"),
            consequences: d.consequences.get(axle).map_or_else(Vec::new, |c| {
                let row =
                    |what: &str, before: String, after: String| (what.to_owned(), before, after);
                let mut rows = vec![
                    row(
                        "Largest wheel load",
                        known(c.peak_load_plain_n, |f| format!("{} N", fixed(f, 0))),
                        known(c.peak_load_extended_n, |f| format!("{} N", fixed(f, 0))),
                    ),
                    row(
                        "Resonance, undamped",
                        known(c.resonance_plain_hz, |f| format!("{} Hz", fixed(f, 2))),
                        known(c.resonance_extended_hz, |f| format!("{} Hz", fixed(f, 2))),
                    ),
                ];
                if let Some(share) = c.airborne_share.filter(|share| *share > 0.0) {
                    rows.push(row(
                        "Time without wheel load",
                        "–".to_owned(),
                        format!("{} %", significant(100.0 * share, 2)),
                    ));
                }
                rows.retain(|(_, before, after)| before != UNKNOWN || after != UNKNOWN);
                if extended { rows } else { Vec::new() }
            }),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_size_that_would_show_has_a_direction_or_a_reason() {
        let shown = |size, stronger| {
            let x = Detectable {
                id: "wheel_lift".to_owned(),
                axle: Place::Front,
                parameter: "static_load".to_owned(),
                smallest_detectable: size,
                stronger,
                reason: None,
                unit: "N".to_owned(),
            };
            let [.., size] = detectable(&x);
            size.replace('\u{a0}', " ")
        };
        assert_eq!(shown(Some(250.0), Stronger::Smaller), "250 N or less");
        assert_eq!(shown(Some(250.0), Stronger::Larger), "250 N or more");
        assert_eq!(shown(None, Stronger::Larger), "not on this ride");
    }

    #[test]
    fn without_a_measured_floor_no_share_is_reported() {
        let held = |share| HeldOut {
            plain_rms_m: Some(2e-3),
            extended_rms_m: Some(1e-3),
            explained_share: share,
            ..HeldOut::default()
        };
        let reported = |share| explained(&held(share)).unwrap_or_default();
        assert!(reported(Some(0.987)).contains("98.7 %"));
        assert_eq!(
            reported(None).replace('\u{a0}', " "),
            "With the effects the error falls from 2 mm to 1 mm."
        );
        assert_eq!(explained(&HeldOut::default()), None);
    }
}
