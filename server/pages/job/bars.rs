//! Held-out errors as bars, drawn on the server.

use std::fmt::Write;

use veloid_engine::document::format_number::significant;
use veloid_engine::report::diagnosis::HeldOut;

const ROW: f64 = 26.0;
const LEFT: f64 = 120.0;
const WIDTH: f64 = 250.0;

/// Error before and after, and the noise, as an SVG image.
pub fn of(axle: &str, held: &HeldOut, extended: bool) -> String {
    let ([plain, extension, noise], si) = held.errors();
    let extension = extension.filter(|_| extended);
    let (factor, unit) = if si == "m" { (1e3, "mm") } else { (1.0, si) };
    let bars: Vec<_> = [
        ("plain model", "plain", plain),
        ("with the effects", "extended", extension),
        ("noise floor", "noise", noise),
    ]
    .into_iter()
    .filter_map(|(label, class, rms)| Some((label, class, rms?)))
    .collect();
    let most = bars
        .iter()
        .map(|(_, _, rms)| *rms)
        .fold(f64::MIN_POSITIVE, f64::max);
    let height = ROW * bars.len() as f64;
    let mut svg = format!(
        "<svg class=\"bars\" viewBox=\"0 0 480 {height}\" role=\"img\" aria-label=\"Held-out error, {axle} axle\">"
    );
    for (i, (label, class, rms)) in bars.iter().enumerate() {
        let (y, length) = (ROW * i as f64, (WIDTH * rms / most).max(2.0));
        let (text, end) = (y + 16.0, LEFT + length + 8.0);
        let value = significant(factor * rms, 3);
        // Writing to a String cannot fail.
        let _ = write!(
            svg,
            "<text x=\"0\" y=\"{text}\">{label}</text>\
             <rect class=\"{class}\" x=\"{LEFT}\" y=\"{}\" width=\"{length:.1}\" height=\"14\" rx=\"2\"/>\
             <text x=\"{end:.1}\" y=\"{text}\">{value} {unit}</text>",
            y + 5.0
        );
    }
    svg.push_str("</svg>");
    svg
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_bar_is_the_largest_error() {
        let held = HeldOut {
            plain_rms_m: Some(2e-3),
            extended_rms_m: Some(1e-3),
            noise_floor_m: Some(5e-4),
            ..HeldOut::default()
        };
        let svg = of("front", &held, true);
        assert!(svg.contains("width=\"250.0\"") && svg.contains("width=\"125.0\""));
        assert!(svg.contains("2.00 mm"));
        assert!(!of("front", &held, false).contains("with the effects"));
    }
}
