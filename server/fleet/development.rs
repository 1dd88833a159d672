//! What became of a parameter over a bicycle's rides: nothing, a drift, a step or both, as one choice by the Bayesian information
//! criterion (Schwarz 1978), since each of a drift and a step alone also explains much of the other.

use serde::Serialize;
use utoipa::ToSchema;

use crate::time;

const DAY_MS: f64 = 86_400_000.0;
/// Fewest rides, and fewest on each side of a step.
const LEAST: usize = 8;
const SIDE: usize = 3;
/// A larger model has to be better by so much: strong evidence (Kass and Raftery 1995, doi:10.1080/01621459.1995.10476572).
const STRONG: f64 = 6.0;
/// Parameters of the models. A step counts for three, its place among them, which is searched for (Zhang and Siegmund
/// 2007, doi:10.1111/j.1541-0420.2006.00662.x).
const DRIFT: f64 = 2.0;
const STEP: f64 = 4.0;
const BOTH: f64 = 5.0;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    None,
    Drift,
    Step,
    Both,
}

/// What became of a parameter.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct Development {
    pub kind: Kind,
    /// Change per day, in the parameter's unit; 0 without a drift.
    pub per_day: f64,
    /// Time of the first ride after the step.
    #[schema(format = DateTime)]
    pub at: Option<String>,
    /// Height of the step beside the drift, in the parameter's unit; 0 without a step.
    pub step: f64,
}

/// Weighted sums over rides: weight, time, value and their products.
#[derive(Clone, Copy, Default)]
struct Sums {
    w: f64,
    t: f64,
    y: f64,
    tt: f64,
    ty: f64,
    yy: f64,
}

impl Sums {
    fn and(self, [t, y, w]: [f64; 3]) -> Self {
        Self {
            w: self.w + w,
            t: self.t + w * t,
            y: self.y + w * y,
            tt: self.tt + w * t * t,
            ty: self.ty + w * t * y,
            yy: self.yy + w * y * y,
        }
    }

    fn less(self, part: Self) -> Self {
        Self {
            w: self.w - part.w,
            t: self.t - part.t,
            y: self.y - part.y,
            tt: self.tt - part.tt,
            ty: self.ty - part.ty,
            yy: self.yy - part.yy,
        }
    }
}

/// Levels of these groups of rides, with a common slope or none: what is left, and the slope.
fn fit(groups: &[Sums], sloped: bool) -> (f64, f64) {
    let sum = |of: fn(&Sums) -> f64| groups.iter().map(of).sum::<f64>();
    let yy = sum(|g| g.yy - g.y * g.y / g.w);
    let ty = sum(|g| g.ty - g.t * g.y / g.w);
    let tt = sum(|g| g.tt - g.t * g.t / g.w);
    match sloped && tt > 0.0 {
        true => (yy - ty * ty / tt, ty / tt),
        false => (yy, 0.0),
    }
}

/// A fitted model.
#[derive(Clone, Copy)]
struct Model {
    kind: Kind,
    bic: f64,
    slope: f64,
    split: usize,
    step: f64,
}

impl Development {
    /// `points`: time (epoch ms), value, standard deviation, oldest first. None where there are too few, or all alike.
    pub fn of(points: &[(i64, f64, f64)]) -> Option<Self> {
        if points.len() < LEAST {
            return None;
        }
        let rides = centred(points);
        let all = rides
            .iter()
            .fold(Sums::default(), |sums, ride| sums.and(*ride));
        let (total, _) = fit(&[all], false);
        if !(total > 0.0 && total.is_finite()) {
            return None;
        }
        let n = points.len() as f64;
        // A fit that leaves nothing is not infinitely good.
        let bic =
            |left: f64, parameters: f64| n * (left / total).max(1e-12).ln() + parameters * n.ln();
        let none = Model {
            kind: Kind::None,
            bic: bic(total, 1.0),
            slope: 0.0,
            split: 0,
            step: 0.0,
        };
        let (left, slope) = fit(&[all], true);
        let drift = Model {
            kind: Kind::Drift,
            bic: bic(left, DRIFT),
            slope,
            ..none
        };
        let (mut step, mut both) = (none, none);
        let mut before = rides[..SIDE - 1]
            .iter()
            .fold(Sums::default(), |sums, ride| sums.and(*ride));
        for split in SIDE..=rides.len() - SIDE {
            before = before.and(rides[split - 1]);
            let groups = [before, all.less(before)];
            for (model, kind, parameters) in
                [(&mut step, Kind::Step, STEP), (&mut both, Kind::Both, BOTH)]
            {
                let (left, slope) = fit(&groups, kind == Kind::Both);
                let bic = bic(left, parameters);
                if model.kind == Kind::None || bic < model.bic {
                    let [a, b] = groups.map(|g| (g.y - slope * g.t) / g.w);
                    *model = Model {
                        kind,
                        bic,
                        slope,
                        split,
                        step: b - a,
                    };
                }
            }
        }
        let one = if step.bic < drift.bic { step } else { drift };
        let mut found = none;
        for model in [one, both] {
            if model.bic + STRONG < found.bic {
                found = model;
            }
        }
        Some(Self {
            kind: found.kind,
            per_day: found.slope,
            at: (found.split > 0).then(|| time::text(points[found.split].0)),
            step: found.step,
        })
    }
}

/// Time (days), value and weight, time and value from their weighted means.
fn centred(points: &[(i64, f64, f64)]) -> Vec<[f64; 3]> {
    let first = points.first().map_or(0, |point| point.0);
    let rides = points
        .iter()
        .map(|(ms, value, deviation)| [(ms - first) as f64 / DAY_MS, *value, deviation.powi(-2)]);
    let all = rides
        .clone()
        .fold(Sums::default(), |sums, ride| sums.and(ride));
    let (t, y) = (all.t / all.w, all.y / all.w);
    rides.map(|[a, b, w]| [a - t, b - y, w]).collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use rand::RngExt;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;

    use super::*;

    const DAY: i64 = 86_400_000;

    /// 40 rides in 180 days, k = 100 kN/m, scatter 1 %, with a drift over the whole and a step at a random place, both in %.
    fn season(seed: u64, drift: f64, step: f64) -> Vec<(i64, f64, f64)> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut days: Vec<f64> = (0..40).map(|_| 180.0 * random.random::<f64>()).collect();
        days.sort_by(f64::total_cmp);
        let at = random.random_range(8..32);
        let ride = |(i, day): (usize, &f64)| {
            let noise: f64 = (0..12).map(|_| random.random::<f64>()).sum::<f64>() - 6.0;
            let stepped = if i >= at { step } else { 0.0 };
            let value = 100.0 + noise + drift * day / 180.0 + stepped;
            ((day * DAY as f64) as i64, 1e3 * value, 1e3)
        };
        days.iter().enumerate().map(ride).collect()
    }

    #[test]
    fn two_hundred_seasons_are_reported_for_what_they_are() {
        for (drift, step, kind, least) in [
            (0.0, 0.0, Kind::None, 196),
            (-6.0, 0.0, Kind::Drift, 190),
            (0.0, 4.0, Kind::Step, 190),
            (-8.0, 8.0, Kind::Both, 190),
        ] {
            let right =
                |seed: &u64| Development::of(&season(*seed, drift, step)).unwrap().kind == kind;
            let count = (0..200).filter(right).count();
            assert!(count >= least, "{kind:?}: {count} of 200");
        }
    }

    #[test]
    fn drift_and_step_are_sized_beside_each_other() {
        let found = Development::of(&season(3, -8.0, 8.0)).unwrap();
        assert!((found.per_day * 180.0 / 1e3 + 8.0).abs() < 2.0, "{found:?}");
        assert!(
            (found.step / 1e3 - 8.0).abs() < 1.5 && found.at.is_some(),
            "{found:?}"
        );
        assert_eq!(Development::of(&season(3, 0.0, 9.0)[..7]), None);
        assert_eq!(Development::of(&[(7, 1.0, 1.0); 20]), None);
        let same_day: Vec<_> = (0..20).map(|i| (0, f64::from(i % 2), 1.0)).collect();
        assert_eq!(Development::of(&same_day).unwrap().kind, Kind::None);
    }
}
