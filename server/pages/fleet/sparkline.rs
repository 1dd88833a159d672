//! Stiffness over a bicycle's latest rides as a small image: front and rear, each as a share of its own median.

use std::fmt::Write;

use veloid_engine::document::format_number::Quantity;

use crate::fleet::{PooledBike, PooledParameter};

const WIDTH: f64 = 120.0;
const HEIGHT: f64 = 28.0;
/// Room for the width of the lines.
const EDGE: f64 = 2.0;
/// Least range: less than this share of the median looks flat.
const RANGE: f64 = 0.1;

/// Nothing where no axle has two rides.
pub fn of(bike: &PooledBike) -> Option<String> {
    let of_axle = |axle: &'static str| {
        let mut parameters = bike.parameters.iter();
        let found = parameters.find(|p| p.axle == axle && p.name == "k_n_m")?;
        (found.values.len() > 1).then_some((axle, found))
    };
    let lines: Vec<(&str, &PooledParameter)> =
        ["front", "rear"].into_iter().filter_map(of_axle).collect();
    let shares: Vec<Vec<f64>> = lines.iter().map(|(_, p)| shares(&p.values)).collect();
    let all = || shares.iter().flatten().copied();
    let (least, most) = (
        all().fold(-0.5 * RANGE, f64::min),
        all().fold(0.5 * RANGE, f64::max),
    );
    let described: Vec<String> = lines.iter().map(|(axle, p)| described(axle, p)).collect();
    let mut svg = format!(
        "<svg class=\"sparkline\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"{}\">",
        described.join("; ")
    );
    for ((axle, _), shares) in lines.iter().zip(&shares) {
        let across = (WIDTH - 2.0 * EDGE) / (shares.len() - 1) as f64;
        let up = (HEIGHT - 2.0 * EDGE) / (most - least);
        let point = |(i, share): (usize, &f64)| {
            format!(
                "{:.1},{:.1}",
                EDGE + across * i as f64,
                EDGE + up * (most - share)
            )
        };
        let points: Vec<String> = shares.iter().enumerate().map(point).collect();
        // Writing to a String cannot fail.
        let _ = write!(
            svg,
            "<polyline class=\"{axle}\" points=\"{}\"/>",
            points.join(" ")
        );
    }
    svg.push_str("</svg>");
    (!lines.is_empty()).then_some(svg)
}

/// How far each value is from the median, as a share of it.
fn shares(values: &[f64]) -> Vec<f64> {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let median = sorted[sorted.len() / 2];
    let share = |value: &f64| (value / median - 1.0).clamp(-1.0, 1.0);
    let shares = values.iter().map(share);
    shares
        .map(|s| if s.is_finite() { s } else { 0.0 })
        .collect()
}

fn described(axle: &str, parameter: &PooledParameter) -> String {
    let values = &parameter.values;
    let rough = |value: Option<&f64>| Quantity::rough(value.copied(), 3, &parameter.unit);
    let (first, last) = (rough(values.first()), rough(values.last()));
    format!(
        "{axle} stiffness over {} rides, from {first} to {last}",
        values.len()
    )
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn shares_are_of_the_median_and_nothing_is_infinite() {
        assert_eq!(
            shares(&[90.0, 100.0, 110.0]),
            [-0.09999999999999998, 0.0, 0.10000000000000009]
        );
        assert_eq!(shares(&[0.0, 0.0]), [0.0, 0.0]);
        assert_eq!(shares(&[1.0, 1.0, 9.0])[2], 1.0);
    }
}
