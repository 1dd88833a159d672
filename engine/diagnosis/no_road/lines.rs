//! On which axle a line of the spectrum arises. A wheel out of round and pedals move their axle at one place of the spectrum, and either
//! axle explains what is left; on the wrong one the road has a line there, and roads are smooth.

use std::f64::consts::TAU;

use super::fit::Frame;
use super::model::{Model, axle_of};
use super::record::Segment;
use veloid_fourier::Complex;
use veloid_model::effects::Kind;
use veloid_model::fit::Term;
use veloid_model::law::Values;

/// Turns over a segment by which neighbours of a line lie beside it, on either side.
const NEIGHBOURS: std::ops::Range<usize> = 3..11;

/// Twice the power of the road that a model finds at its effects' lines, beside the power next to them: about 2 on a smooth road,
/// as -2 ln L has it.
pub fn lines(frame: &Frame, model: &Model) -> f64 {
    let is_line = |(term, _): &&(Term, Values)| has_line(term.kind);
    let effects: Vec<&(Term, Values)> = model.effects.iter().filter(is_line).collect();
    if effects.is_empty() {
        return 0.0;
    }
    let predictor = &frame.predictor;
    let mut sum = 0.0;
    for (s, segment) in predictor.record.segments.iter().enumerate() {
        let road = predictor.ridden(std::slice::from_ref(model), s).road;
        let road: Vec<f64> = road.iter().map(|r| r.0[0]).collect();
        for (term, values) in &effects {
            let radius = predictor
                .scales
                .get(axle_of(term))
                .map_or(f64::NAN, |s| s.wheel_radius);
            let line = match term.kind {
                Kind::WheelOutOfRound => line(
                    segment,
                    &road,
                    |i| segment.distance[i] / (radius * values[2]),
                    true,
                ),
                _ => line(segment, &road, |i| 2.0 * segment.crank[i], false),
            };
            sum += line;
        }
    }
    sum
}

pub fn has_line(kind: Kind) -> bool {
    matches!(kind, Kind::WheelOutOfRound | Kind::PedallingForce)
}

fn line(segment: &Segment, road: &[f64], phase: impl Fn(usize) -> f64, of_slope: bool) -> f64 {
    let steps = segment.steps();
    let turns = (phase(steps - 1) - phase(0)) / TAU;
    let power = |part: f64| {
        let mut sum = Complex::new(0.0, 0.0);
        for i in (0..steps).step_by(segment.over) {
            let height =
                road[i] * segment.window[i] / if of_slope { segment.speed[i] } else { 1.0 };
            sum += Complex::new(0.0, -part * phase(i)).exp() * height;
        }
        sum.norm_sqr()
    };
    let beside: Vec<f64> = NEIGHBOURS
        .flat_map(|k| [k as f64, -(k as f64)])
        .map(|k| power(1.0 + k / turns))
        .collect();
    2.0 * power(1.0) * beside.len() as f64 / beside.iter().sum::<f64>()
}
