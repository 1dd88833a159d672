//! Whether a model's residual is noise: its correlations with itself and with the input, whitened (Ljung 1999, System Identification,
//! 16.6).

use veloid_core::numerics::autoregressive::NoiseModel;
use veloid_methods::simulate::sensitivity::{PARAMETERS, walk};
use veloid_report::Method;
use veloid_report::validation::{CorrelationTest, ResidualTests, TestedInput};

use crate::record::{Models, Record, shortened};

/// Longest lag (samples).
const LAGS: usize = 25;
/// Standard deviations that white noise keeps within 99 % of the time.
const BOUND: f64 = 2.576;
/// Lags of these few outside from which more than chance is at work: of 25, white noise has three or more outside once in 500 records.
const MANY: usize = 3;
/// The same of correlations with the input, whose neighbouring lags are much alike where it is slow: of 300 axles of plain rides
/// (`tests/rigs/residuals.py`) 8 had three or more outside, and 3 five or more.
const MANY_OF_INPUT: usize = 5;
/// Samples without which there are no correlations: the bound is then a quarter.
const LEAST: usize = 100;
/// Share of an input's correlation that is free at least, after what the fit has taken off: below, rounding decides, as of a sine.
const FREE: f64 = 0.05;

/// The tests of what the model that the result comes from leaves, under the noise model that its intervals use.
pub fn residual_tests(record: &Record, models: &Models) -> Result<ResidualTests, String> {
    let (model, residual) = match &models.extended {
        Some(extended) => (Method::Extended, &extended.residual),
        None => (Method::OutputError, &models.plain.residual),
    };
    let masked: Vec<f64> = (record.train.clone())
        .map(|i| if record.valid[i] { residual[i] } else { 0.0 })
        .collect();
    let noise = NoiseModel::fit(&masked);
    let order = noise.a.len();
    // Whitened samples whose past is known too.
    let mut known_since = 0;
    let counts: Vec<bool> = (record.train.clone())
        .map(|i| {
            known_since = if record.valid[i] { known_since + 1 } else { 0 };
            known_since > order
        })
        .collect();
    let samples = counts.iter().filter(|counts| **counts).count();
    let white = centred(noise.whiten(&masked), &counts);
    let power: f64 = white.iter().map(|w| w * w).sum();
    if samples < LEAST || !(power > 0.0) {
        return Err(format!(
            "residual: {samples} samples with something left, at least {LEAST} are needed"
        ));
    }
    let bound = BOUND / (samples as f64).sqrt();
    let tested = tested_input(record).map(|(input, values)| {
        let filtered = centred(noise.whiten(&values[record.train.clone()]), &counts);
        let size = norm(&filtered);
        let at = |lag| correlation(&filtered, &white, lag) / (power.sqrt() * size);
        let fitted = fitted(record, models);
        // At a lag the correlation is a sum over the noise, with these weights.
        let left = |lag| {
            let earlier = filtered.iter().zip(counts.iter().skip(lag));
            let earlier = earlier.map(|(x, counts)| if *counts { *x } else { 0.0 });
            let weights: Vec<f64> = std::iter::repeat_n(0.0, lag).chain(earlier).collect();
            let whole = projected_off(&fitted, transposed_whitening(&noise, &weights));
            norm(&noise.noise_model_transposed(&whole)) / size
        };
        let bounds = (0..=LAGS).map(|lag| bound * left(lag).max(FREE)).collect();
        let values = (0..=LAGS).map(at).collect();
        (input, test(values, bounds, 0, "the input", MANY_OF_INPUT))
    });
    let (input, cross_correlation) = tested.unzip();
    let itself = |lag| correlation(&white, &white, lag) / power;
    Ok(ResidualTests {
        model,
        samples,
        noise_order: order,
        lag_s: shortened((0..=LAGS).map(|lag| lag as f64 * record.step())),
        autocorrelation: test(
            (0..=LAGS).map(itself).collect(),
            vec![bound; LAGS + 1],
            1,
            "itself",
            MANY,
        ),
        cross_correlation,
        input,
    })
}

/// Less their mean; zero where they do not count.
fn centred(values: Vec<f64>, counts: &[bool]) -> Vec<f64> {
    let known = || values.iter().zip(counts).filter(|(_, counts)| **counts);
    let mean = known().map(|(x, _)| x).sum::<f64>() / known().count().max(1) as f64;
    let of = |(x, counts): (&f64, &bool)| if *counts { x - mean } else { 0.0 };
    values.iter().zip(counts).map(of).collect()
}

/// Sum of the products of a sample and the other record's one some samples later.
fn correlation(earlier: &[f64], later: &[f64], lag: usize) -> f64 {
    let pairs = earlier.iter().zip(later.iter().skip(lag));
    pairs.map(|(x, w)| x * w).sum()
}

/// What drives the axle.
fn tested_input<'r>(record: &'r Record) -> Option<(TestedInput, &'r [f64])> {
    let slope = record.input.road_slope.as_slice();
    let (input, values) = if record.input.prescribed {
        (TestedInput::DeflectionRate, slope)
    } else if record.has_road {
        (TestedInput::RoadSlope, slope)
    } else {
        (TestedInput::Force, record.force()?)
    };
    values
        .iter()
        .any(|x| *x != values[0])
        .then_some((input, values))
}

/// Directions of the residual that the fit has taken off, orthonormal: the sensitivities of what the plain fit moves, at the
/// model's own k, B and m.
fn fitted(record: &Record, models: &Models) -> Vec<Vec<f64>> {
    let own = models.extended.as_ref().map(|model| &model.base);
    let base = own.unwrap_or(&models.plain.plain);
    let free: Vec<usize> = (0..PARAMETERS)
        .filter(|q| models.plain.covariance[(*q, *q)] > 0.0)
        .collect();
    let mut columns = vec![vec![0.0; record.train.len()]; free.len()];
    walk(record.input, base, record.train.len(), |i, _, by| {
        if record.valid[i] {
            for (column, q) in columns.iter_mut().zip(&free) {
                column[i] = by[*q];
            }
        }
    });
    let mut found: Vec<Vec<f64>> = Vec::new();
    for column in columns {
        let size = norm(&column);
        // Twice, for the digits that the first time leaves of nearly the same directions.
        let left = projected_off(&found, projected_off(&found, column));
        let now = norm(&left);
        if now > 1e-9 * size {
            found.push(left.iter().map(|x| x / now).collect());
        }
    }
    found
}

fn norm(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Less its parts along orthonormal directions.
fn projected_off(directions: &[Vec<f64>], mut x: Vec<f64>) -> Vec<f64> {
    for direction in directions {
        let part: f64 = direction.iter().zip(&x).map(|(d, x)| d * x).sum();
        x.iter_mut()
            .zip(direction)
            .for_each(|(x, d)| *x -= part * d);
    }
    x
}

/// The transpose of the whitening filter: the same backwards in time.
fn transposed_whitening(noise: &NoiseModel, x: &[f64]) -> Vec<f64> {
    let backwards: Vec<f64> = x.iter().rev().copied().collect();
    let mut found = noise.whiten(&backwards);
    found.reverse();
    found
}

/// Correlations from a lag on; `many` of them outside are more than chance.
fn test(
    values: Vec<f64>,
    bounds: Vec<f64>,
    from: usize,
    with: &str,
    many: usize,
) -> CorrelationTest {
    let counted = values.iter().zip(&bounds).skip(from);
    let outside = counted.filter(|(r, bound)| r.abs() > **bound).count();
    let lags = values.len() - from;
    let meaning = match (outside >= many, with) {
        (false, _) => "no more than white noise may, of which neighbouring lags are alike",
        (true, "itself") => "the residual still contains dynamics or coloured noise",
        (true, _) => "the residual still contains an answer to the input",
    };
    let joint = if outside >= many { ": " } else { ", " };
    CorrelationTest {
        sentence: format!(
            "{outside} of {lags} lags with {with} leave the 99 % bounds{joint}{meaning}"
        ),
        values: shortened(values),
        bounds: shortened(bounds),
        outside,
        lags,
        share_outside: outside as f64 / lags as f64,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use veloid_core::numerics::example::white;
    use veloid_core::plant::Coefficients;
    use veloid_methods::output_error::AxleFit;
    use veloid_methods::simulate::linear::Input;

    /// The tests of a residual on a road of white slope.
    fn tests(residual: &[f64], road_slope: Vec<f64>) -> ResidualTests {
        let n = residual.len();
        let input = Input {
            step: 0.01,
            road: vec![0.0; n],
            road_slope,
            force: None,
            prescribed: false,
        };
        let record = Record {
            measured: residual,
            valid: &vec![true; n],
            input: &input,
            has_road: true,
            train: 0..n,
        };
        let models = Models {
            plain: &AxleFit {
                residual: residual.to_vec(),
                ..AxleFit::exact(Coefficients::default(), n)
            },
            extended: None,
        };
        residual_tests(&record, &models).unwrap()
    }

    #[test]
    fn noise_of_any_colour_keeps_within_the_bounds_as_often_as_white_noise() {
        let colour = NoiseModel {
            a: vec![-1.2, 0.5],
            variance: 1.0,
        };
        let (mut outside, mut lags) = ([0, 0], [0, 0]);
        for seed in 1..=60 {
            let residual = colour.noise_model(&white(2000, seed));
            let found = tests(&residual, white(2000, seed + 1000));
            let cross = found.cross_correlation.unwrap();
            for (i, test) in [found.autocorrelation, cross].into_iter().enumerate() {
                outside[i] += test.outside;
                lags[i] += test.lags;
            }
        }
        for i in 0..2 {
            let share = outside[i] as f64 / lags[i] as f64;
            assert!((0.002..0.02).contains(&share), "{outside:?} of {lags:?}");
        }
    }

    #[test]
    fn an_answer_to_the_input_shows_at_its_lags() {
        let slope = white(4000, 3);
        let noise = white(4000, 4);
        let answer = |i: usize| if i < 5 { 0.0 } else { 0.2 * slope[i - 5] };
        let residual: Vec<f64> = (0..4000).map(|i| noise[i] + answer(i)).collect();
        let cross = tests(&residual, slope.clone()).cross_correlation.unwrap();
        assert!(cross.values[5] > 4.0 * cross.bounds[5], "{cross:?}");
        for (with, many) in [("itself", MANY), ("the input", MANY_OF_INPUT)] {
            let said = |count| test(vec![1.0; count], vec![0.5; count], 0, with, many).sentence;
            assert!(said(many - 1).contains("no more than white noise may"));
            assert!(said(many).contains("the residual still contains"));
        }
    }
}
