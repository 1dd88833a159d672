//! Two axles with effects, and the numbers that a fit moves.

use super::motion::{Deflected, Driven};
use super::record::Record;
use veloid_core::bicycle::{Axle, PerAxle};
use veloid_core::numerics::lanes::{LANES, Lanes};
use veloid_core::plant::Coefficients;
use veloid_model::fit::Term;
use veloid_model::fit::integrate::{AxleLanes, EffectLanes};
use veloid_model::law::{MAX_OWN_STATES, Scale, Values};

/// Natural logarithms of k/m (1/s^2) and B/m (1/s).
pub type Base = [f64; 2];
/// Within which they are looked for.
pub const KAPPA: [f64; 2] = [200.0, 40_000.0];
pub const BETA: [f64; 2] = [0.5, 400.0];

#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    pub base: PerAxle<Base>,
    pub effects: Vec<(Term, Values)>,
    /// By segment, the distance (m) that a wheel out of round has turned ahead of the speed's integral, which drifts; none is zero.
    pub rolled: Vec<f64>,
}

/// A number that a fit moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Slot {
    Base(Axle, usize),
    /// A parameter of an effect, in its typical sizes.
    Value(usize, usize),
}

impl Model {
    pub fn new(front: Base, rear: Base) -> Self {
        Self {
            base: PerAxle {
                front: Some(front),
                rear: Some(rear),
            },
            effects: Vec::new(),
            rolled: Vec::new(),
        }
    }

    pub fn base(&self, axle: Axle) -> Base {
        self.base.get(axle).copied().unwrap_or_default()
    }

    pub fn with(&self, term: Term, values: Values) -> Self {
        let mut model = self.clone();
        model.effects.push((term, values));
        model
    }

    pub fn terms(&self) -> Vec<Term> {
        let mut terms: Vec<Term> = self.effects.iter().map(|(term, _)| *term).collect();
        terms.sort();
        terms
    }

    pub fn slots(&self) -> Vec<Slot> {
        let base = Axle::BOTH.into_iter();
        let mut slots: Vec<Slot> = base
            .flat_map(|axle| [0, 1].map(|q| Slot::Base(axle, q)))
            .collect();
        for (i, (term, _)) in self.effects.iter().enumerate() {
            let own = term.kind.spec().parameters.len();
            slots.extend((0..own).map(|q| Slot::Value(i, q)));
        }
        slots
    }

    /// The model with a slot moved, no further than it may be.
    pub fn moved(&self, slot: Slot, by: f64, scales: &PerAxle<Scale>) -> Self {
        let mut model = self.clone();
        match slot {
            Slot::Base(axle, q) => {
                let mut base = model.base(axle);
                let [low, high] = if q == 0 { KAPPA } else { BETA };
                base[q] = (base[q] + by).clamp(low.ln(), high.ln());
                model.base.set(axle, base);
            }
            Slot::Value(i, q) => {
                let (term, values) = &mut model.effects[i];
                if let Some(scale) = scales.get(axle_of(term)) {
                    let parameter = &term.kind.spec().parameters[q];
                    let [low, high] = (parameter.limits)(scale);
                    let value = values[q] + by * (parameter.size)(scale);
                    values[q] = value.max(low).min(high);
                }
            }
        }
        model
    }
}

/// The axle that a term acts on, of the two.
pub fn axle_of(term: &Term) -> Axle {
    match term.acts_on(Axle::Front) {
        true => Axle::Front,
        false => Axle::Rear,
    }
}

/// Eight models at most, on one axle; the last one stands for those that are lacking. They have the same effects.
pub fn lanes(models: &[Model], axle: Axle, per_mass: f64) -> AxleLanes {
    let of = |lane: usize| &models[lane.min(models.len() - 1)];
    let each = |f: &dyn Fn(&Model) -> f64| Lanes(std::array::from_fn(|lane| f(of(lane))));
    let mut effects: Vec<EffectLanes> = Vec::new();
    let own = |(term, _): &&(Term, Values)| term.acts_on(axle);
    let mut places: Vec<usize> = (0..models[0].effects.len())
        .filter(|i| own(&&models[0].effects[*i]))
        .collect();
    places.sort_by_key(|i| models[0].effects[*i].0);
    for i in places {
        effects.push(EffectLanes {
            kind: models[0].effects[i].0.kind,
            values: std::array::from_fn(|q| each(&|m| m.effects[i].1[q])),
            initial: [Lanes::ZERO; MAX_OWN_STATES],
        });
    }
    AxleLanes {
        base: Coefficients {
            kappa: each(&|m| m.base(axle)[0].exp()),
            beta: each(&|m| m.base(axle)[1].exp()),
            per_mass: Lanes::all(per_mass),
            constant: Lanes::ZERO,
            height: Lanes::ZERO,
            velocity: Lanes::ZERO,
        },
        effects,
    }
}

/// The sizes of an axle's motion, from which effects take their starts and limits.
pub fn scale(record: &Record, bike: &Sizes, base: Base, moved: &[Moments]) -> Scale {
    let all = |f: &dyn Fn(&Moments) -> f64| -> f64 {
        (moved.iter().map(|m| f(m).powi(2)).sum::<f64>() / moved.len().max(1) as f64).sqrt()
    };
    let fold =
        |f: &dyn Fn(&Moments) -> f64, by: fn(f64, f64) -> f64| moved.iter().map(f).fold(0.0, by);
    let (d_low, d_high) = (fold(&|m| m.low, f64::min), fold(&|m| m.high, f64::max));
    let duration: f64 = record.segments.iter().map(|s| s.duration()).sum();
    Scale {
        mass: bike.mass,
        k: bike.mass * base[0].exp(),
        b: bike.mass * base[1].exp(),
        d_rms: all(&|m| m.d),
        d_low,
        d_high,
        d_peak: d_high.max(-d_low),
        w_rms: all(&|m| m.w),
        z_rms: all(&|m| m.d),
        v_rms: all(&|m| m.w),
        a_rms: all(&|m| m.a),
        train_s: duration,
        duration,
        step: 1.0 / record.rate_hz,
        static_load: bike.static_load,
        wheel_radius: bike.wheel_radius,
        train_distance: record
            .segments
            .iter()
            .filter_map(|s| s.distance.last())
            .fold(0.0, |a, b| f64::max(a, *b)),
        ..Scale::TYPICAL
    }
}

/// What the bike file says of an axle; NaN where it says nothing.
#[derive(Clone, Copy)]
pub struct Sizes {
    pub mass: f64,
    pub static_load: f64,
    pub wheel_radius: f64,
}

/// RMS of deflection (m), its rate (m/s) and the acceleration (m/s^2), and the deflection's ends.
#[derive(Clone, Copy, Debug, Default)]
pub struct Moments {
    pub d: f64,
    pub w: f64,
    pub a: f64,
    pub low: f64,
    pub high: f64,
}

impl Moments {
    pub fn of_lead(moved: &Deflected, a: &[f64], window: &[f64]) -> Self {
        Self::of(&moved.d, &moved.w, a.iter().copied(), window)
    }

    pub fn of_other(moved: &Driven, window: &[f64]) -> Self {
        Self::of(&moved.d, &moved.w, moved.a.iter().map(|a| a.0[0]), window)
    }

    fn of(d: &[Lanes], w: &[Lanes], a: impl Iterator<Item = f64>, window: &[f64]) -> Self {
        let mut sums = Self::default();
        let mut count = 0.0;
        for (((d, w), a), _) in d
            .iter()
            .zip(w)
            .zip(a)
            .zip(window)
            .filter(|(_, w)| **w > 0.5)
        {
            let (d, w) = (d.0[0], w.0[0]);
            sums.d += d * d;
            sums.w += w * w;
            sums.a += a * a;
            (sums.low, sums.high) = (sums.low.min(d), sums.high.max(d));
            count += 1.0;
        }
        let rms = |sum: f64| (sum / f64::max(count, 1.0)).sqrt();
        Self {
            d: rms(sums.d),
            w: rms(sums.w),
            a: rms(sums.a),
            ..sums
        }
    }
}

const _: () = assert!(LANES == 8);
