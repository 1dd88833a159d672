//! The report's diagnosis in words and tables.

use veloid_engine::bicycle::Axle;
use veloid_engine::diagnosis::{Diagnosis, EffectReport, NextRide, Place, Verdict};
use veloid_engine::number::{Quantity, fixed, powers, significant};
use veloid_engine::report::Report;

use super::bars;
use crate::pages::words;

pub struct DiagnosisView {
    pub verdict: &'static str,
    pub label: &'static str,
    pub sentence: String,
    pub effects: Vec<EffectView>,
    pub alternatives: Vec<String>,
    pub warnings: Vec<String>,
    pub axles: Vec<AxleView>,
    pub next: Option<NextRide>,
    pub detectable: Vec<[String; 4]>,
    pub switched_off: Vec<(String, String)>,
}

/// One effect of the verdict.
pub struct EffectView {
    pub title: String,
    pub axle: &'static str,
    pub parameters: Vec<(String, Quantity)>,
    pub evidence: String,
    pub notes: Vec<&'static str>,
}

/// What the diagnosis says of one axle.
pub struct AxleView {
    pub axle: &'static str,
    pub mismatch: bool,
    pub p_value: String,
    pub windows: Vec<String>,
    pub bands: Vec<String>,
    pub states: Vec<String>,
    pub bars: String,
    pub explained: Option<String>,
    pub held_out: String,
    pub consequences: Vec<(String, String, String)>,
}

fn verdict(verdict: Verdict) -> (&'static str, &'static str) {
    match verdict {
        Verdict::NothingMissing => ("nothing_missing", "Nothing is missing"),
        Verdict::Named => ("named", "Something is missing, and this is what"),
        Verdict::Ambiguous => (
            "ambiguous",
            "Something is missing; this ride leaves a choice",
        ),
        Verdict::Unnamed => ("unnamed", "Something is missing that has no name here"),
    }
}

fn place_of(axle: Axle) -> Place {
    match axle {
        Axle::Front => Place::Front,
        Axle::Rear => Place::Rear,
    }
}

impl DiagnosisView {
    pub fn of(report: &Report) -> Option<Self> {
        let d = report.diagnosis.as_ref()?;
        let (verdict, label) = verdict(d.verdict);
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
                .filter_map(|axle| AxleView::of(d, axle))
                .collect(),
            next: d.next_ride.clone(),
            detectable: d
                .detectable
                .iter()
                .map(|x| {
                    [
                        words::title(&x.id),
                        x.axle.name().to_owned(),
                        words::plain(&x.parameter),
                        Quantity::rough(x.smallest_detectable, 3, &x.unit).to_string(),
                    ]
                })
                .collect(),
            switched_off: d
                .switched_off
                .iter()
                .map(|x| (words::title(&x.id), x.why.clone()))
                .collect(),
        })
    }
}

impl EffectView {
    fn of(effect: &EffectReport) -> Self {
        let mut notes = Vec::new();
        if !effect.adequate {
            notes.push("only the nearest shape: it does not explain the ride");
        }
        if !effect.inside_physical_range {
            notes.push("outside the range that physics allows");
        }
        if !effect.material {
            notes.push("certain, but too small to matter");
        }
        let chance = match effect.p_value {
            p if p < 1e-4 => "below 0.0001".to_owned(),
            p => significant(p, 2),
        };
        let parameters = effect.parameters.iter();
        let parameters = parameters.map(|(name, p)| (words::plain(name), p.quantity(name)));
        Self {
            title: words::title(&effect.id),
            axle: effect.axle.name(),
            parameters: parameters.collect(),
            evidence: format!(
                "By chance alone with probability {chance}; without it the ride loses {} in log likelihood.",
                fixed(effect.separation, 1)
            ),
            notes,
        }
    }
}

impl AxleView {
    fn of(d: &Diagnosis, axle: Axle) -> Option<Self> {
        let (held, place) = (d.held_out.get(axle)?, d.location.get(axle)?);
        let range = |[from, to]: &[f64; 2], unit: &str| {
            format!(
                "{} to {} {unit}",
                significant(*from, 3),
                significant(*to, 3)
            )
        };
        let here = |e: &EffectReport| e.axle == Place::Both || place_of(axle) == e.axle;
        let extended = d.effects.iter().any(here);
        Some(Self {
            axle: axle.name(),
            mismatch: place.mismatch,
            p_value: significant(place.p_value, 2),
            windows: place.windows_s.iter().map(|w| range(w, "s")).collect(),
            bands: place.bands_hz.iter().map(|b| range(b, "Hz")).collect(),
            states: place.states.clone(),
            bars: bars::of(axle.name(), held, extended),
            explained: (extended && held.explained_share > 0.0)
                .then(|| fixed(100.0 * held.explained_share, 1)),
            held_out: range(&held.window_s, "s"),
            consequences: d.consequences.get(axle).map_or_else(Vec::new, |c| {
                let row =
                    |what: &str, before: String, after: String| (what.to_owned(), before, after);
                let mut rows = vec![
                    row(
                        "Largest wheel load",
                        format!("{} N", fixed(c.peak_load_plain_n, 0)),
                        format!("{} N", fixed(c.peak_load_extended_n, 0)),
                    ),
                    row(
                        "Resonance, undamped",
                        format!("{} Hz", fixed(c.resonance_plain_hz, 2)),
                        format!("{} Hz", fixed(c.resonance_extended_hz, 2)),
                    ),
                ];
                if c.airborne_share > 0.0 {
                    rows.push(row(
                        "Time without wheel load",
                        "–".to_owned(),
                        format!("{} %", significant(100.0 * c.airborne_share, 2)),
                    ));
                }
                if extended { rows } else { Vec::new() }
            }),
        })
    }
}
