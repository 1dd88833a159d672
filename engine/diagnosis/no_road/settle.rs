//! A model with everything that wanders.

use super::fit::{Fit, Frame};
use super::model::Model;
use super::nuisance::Course;
use super::record::Record;
use veloid_core::bicycle::PerAxle;
use veloid_model::law::Scale;

/// Rounds in which the nuisances follow the model.
const ROUNDS: usize = 6;

/// A model fitted along with the courses that suit it, from a delay (s) and a gain of the other axle's sensor.
pub fn settled(
    record: &Record,
    scales: &PerAxle<Scale>,
    start: &Model,
    [late, gain]: [f64; 2],
) -> Option<(Fit, Vec<Course>)> {
    let mut model = start.clone();
    let mut courses: Vec<Course> = (record.segments.iter())
        .map(|segment| Course::started(segment, record.lines.len(), late, gain))
        .collect();
    let mut best: Option<(Fit, Vec<Course>)> = None;
    for _ in 0..ROUNDS {
        let frame = Frame::around(record, scales, &courses, &model)?;
        let fit = frame.fit(&model, 3, 0.1)?;
        let gained = best
            .as_ref()
            .map_or(f64::INFINITY, |(b, _)| b.cost - fit.cost);
        model = fit.model.clone();
        let next = frame.settled(&model)?;
        if gained > 0.0 {
            best = Some((fit, courses.clone()));
        }
        if gained < 0.5 {
            break;
        }
        courses = next;
    }
    best
}
