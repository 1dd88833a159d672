//! Numbers as people read them: grouped, with as many digits as their uncertainty allows.

use std::fmt;

use super::words;

/// Half width of a 95 % interval in standard errors.
const WIDE: f64 = 1.96;
/// Most digits of a value, however sure it is.
const DIGITS: i32 = 8;
const THIN_SPACE: char = '\u{202f}';

/// A value with its 95 % interval and unit.
#[derive(Debug, PartialEq)]
pub struct Quantity {
    pub value: String,
    /// Half width of the interval; absent where it is not known.
    pub margin: Option<String>,
    pub unit: String,
}

impl Quantity {
    /// `value` +- 95 %, small lengths and times in thousandths.
    pub fn new(value: f64, std_error: Option<f64>, unit: &str) -> Self {
        let (scale, unit) = match unit {
            "m" if value.abs() < 0.1 => (1e3, "mm"),
            "s" if value.abs() < 0.5 => (1e3, "ms"),
            "m/s" if value.abs() < 0.01 => (1e3, "mm/s"),
            unit => (1.0, unit),
        };
        let value = value * scale;
        let margin = std_error
            .map(|e| WIDE * e * scale)
            .filter(|m| m.is_finite() && *m > 0.0 && *m < 1e6 * value.abs().max(1e-12));
        let unit = words::unit(unit);
        let Some(margin) = margin else {
            return Self {
                value: trimmed(significant(value, 5)),
                margin: None,
                unit,
            };
        };
        // Two digits of the margin, none beyond.
        let decimals = 1 - margin.log10().floor() as i32;
        if value != 0.0 && decimals > DIGITS - 1 - value.abs().log10().floor() as i32 {
            return Self {
                value: significant(value, DIGITS),
                margin: Some(significant(margin, 2)),
                unit,
            };
        }
        Self {
            value: fixed(value, decimals),
            margin: Some(fixed(margin, decimals)),
            unit,
        }
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.value)?;
        if let Some(margin) = &self.margin {
            write!(f, " ± {margin}")?;
        }
        if !self.unit.is_empty() {
            write!(f, "\u{a0}{}", self.unit)?;
        }
        Ok(())
    }
}

/// So many significant digits.
pub fn significant(value: f64, digits: i32) -> String {
    if value == 0.0 || !value.is_finite() {
        return if value == 0.0 {
            "0".to_owned()
        } else {
            "–".to_owned()
        };
    }
    fixed(value, digits - 1 - value.abs().log10().floor() as i32)
}

/// So many decimals, negative ones rounding to tens; powers of ten far from 1.
pub fn fixed(value: f64, decimals: i32) -> String {
    if !value.is_finite() {
        return "–".to_owned();
    }
    let size = value.abs();
    if size != 0.0 && !(1e-3..1e9).contains(&size) {
        let exponent = size.log10().floor() as i32;
        let digits = (decimals + exponent).clamp(0, 6) as usize;
        let mantissa = value / 10f64.powi(exponent);
        return signed(&format!("{mantissa:.digits$}·10{}", superscript(exponent)));
    }
    if decimals < 0 {
        let step = 10f64.powi(-decimals);
        return grouped(&format!("{:.0}", (value / step).round() * step));
    }
    grouped(&format!("{value:.*}", decimals.min(9) as usize))
}

/// Without zeros that say nothing.
fn trimmed(text: String) -> String {
    if text.contains('.') && !text.contains('·') {
        return text.trim_end_matches('0').trim_end_matches('.').to_owned();
    }
    text
}

fn signed(text: &str) -> String {
    text.replace('-', "\u{2212}")
}

/// Thousands apart.
fn grouped(text: &str) -> String {
    let (sign, digits) = match text.strip_prefix('-') {
        Some(digits) => ("\u{2212}", digits),
        None => ("", text),
    };
    let (whole, fraction) = digits.split_once('.').unwrap_or((digits, ""));
    let mut out = sign.to_owned();
    for (i, digit) in whole.chars().enumerate() {
        if i > 0 && (whole.len() - i).is_multiple_of(3) && whole.len() > 4 {
            out.push(THIN_SPACE);
        }
        out.push(digit);
    }
    if !fraction.is_empty() {
        out.push('.');
        out.push_str(fraction);
    }
    out
}

fn superscript(exponent: i32) -> String {
    exponent
        .to_string()
        .chars()
        .map(|c| match c {
            '-' => '⁻',
            '1' => '¹',
            '2' => '²',
            '3' => '³',
            digit => char::from_u32(0x2070 + digit.to_digit(10).unwrap_or(0)).unwrap_or(digit),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(value: f64, std_error: Option<f64>, unit: &str) -> String {
        Quantity::new(value, std_error, unit)
            .to_string()
            .replace(['\u{a0}', THIN_SPACE], " ")
    }

    #[test]
    fn digits_follow_the_uncertainty() {
        assert_eq!(text(110_012.34, Some(42.0), "N/m"), "110 012 ± 82 N/m");
        assert_eq!(
            text(110_012.34, Some(4200.0), "N/m"),
            "110 000 ± 8 200 N/m".replace("8 200", "8200")
        );
        assert_eq!(
            text(64_936.307, Some(1e-4), "N/m"),
            "64 936.307 ± 2.0·10⁻⁴ N/m"
        );
        assert_eq!(text(0.9, Some(0.01), "-"), "0.900 ± 0.020");
        assert_eq!(text(12.1, Some(0.4), "N"), "12.10 ± 0.78 N");
        assert_eq!(text(0.0012, Some(1e-5), "m"), "1.200 ± 0.020 mm");
        assert_eq!(text(23.0, None, "kg"), "23 kg");
        assert_eq!(text(3.0, Some(f64::MAX), "N"), "3 N");
    }

    #[test]
    fn sizes_far_from_one_have_an_exponent() {
        assert_eq!(significant(2.5e-9, 3), "2.50·10⁻⁹");
        assert_eq!(significant(-0.5, 2), "\u{2212}0.50");
        assert_eq!(significant(f64::NAN, 2), "–");
        assert_eq!(significant(0.0, 2), "0");
        assert_eq!(fixed(1e12, 2), "1.000000·10¹²");
    }
}
