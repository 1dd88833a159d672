//! Numbers as people read them: thousands apart, as many digits as the uncertainty allows, an exponent
//! only where the size is far from one, and then one for value and margin.

use std::fmt;

/// Half width of a 95 % interval in standard errors.
pub const WIDE: f64 = 1.96;
/// Sizes from here on have an exponent: seven digits before the point cannot be read at a glance.
const LARGE: f64 = 1e6;
/// So have sizes below this: more than two zeros behind the point cannot be counted at a glance.
const SMALL: f64 = 1e-3;
/// Most digits of a value, however sure it is. No sensor gives as many, and a simulated ride without
/// noise would otherwise show those of its arithmetic.
const MOST: i32 = 10;
/// Digits of a value whose margin is not known.
const ALONE: i32 = 5;
const THIN_SPACE: char = '\u{202f}';
const MINUS: char = '\u{2212}';

/// A value and how far it may be off, with the same decimals and the same exponent.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Number {
    /// Digits of the value, thousands apart.
    pub value: String,
    /// Absent where it is not known.
    pub margin: Option<String>,
    /// What stands between the two and says what the margin is.
    pub mark: &'static str,
    /// Power of ten that multiplies both.
    pub exponent: Option<i32>,
}

impl Number {
    /// A value with its 95 % interval.
    pub fn measured(value: f64, std_error: impl Into<Option<f64>>) -> Self {
        Self::within(value, std_error.into().map(|error| WIDE * error), " ± ")
    }

    /// A value with the standard deviation of several like it, which is no interval.
    pub fn scattered(value: f64, scatter: impl Into<Option<f64>>) -> Self {
        Self::within(value, scatter.into(), ", scatter ")
    }

    /// So many significant digits, less zeros at the end.
    pub fn rough(value: f64, digits: i32) -> Self {
        let (value, exponent) = parts(value, decimals(value, digits));
        Self {
            value: trimmed(value),
            margin: None,
            mark: "",
            exponent,
        }
    }

    /// To two digits of the margin.
    fn within(value: f64, margin: Option<f64>, mark: &'static str) -> Self {
        let margin = margin.filter(|margin| margin.is_normal() && *margin > 0.0);
        let (Some(margin), true) = (margin, value.is_finite()) else {
            return Self::rough(value, ALONE);
        };
        let most = if value.is_normal() {
            decimals(value, MOST)
        } else {
            i32::MAX
        };
        let decimals = decimals(margin, 2).min(most);
        // Never reported as nothing.
        let margin = margin.max(10f64.powi(-decimals));
        let exponent = exponent(rounded(value.abs().max(margin), decimals));
        Self {
            value: shifted(value, decimals, exponent),
            margin: Some(shifted(margin, decimals, exponent)),
            mark,
            exponent,
        }
    }
}

impl fmt::Display for Number {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (value, mark) = (&self.value, self.mark);
        let text = match (&self.margin, self.exponent) {
            (Some(margin), Some(exponent)) => format!("({value}{mark}{margin})e{exponent}"),
            (Some(margin), None) => format!("{value}{mark}{margin}"),
            (None, Some(exponent)) => format!("{value}e{exponent}"),
            (None, None) => value.clone(),
        };
        f.pad(&text)
    }
}

/// A number with its unit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Quantity {
    /// Value and margin, in `unit`.
    pub number: Number,
    /// With its signs, on one line; empty where there is none.
    pub unit: String,
}

impl Quantity {
    /// A value with its 95 % interval.
    pub fn new(value: f64, std_error: impl Into<Option<f64>>, unit: &str) -> Self {
        let (scale, unit) = handy(value, unit);
        let std_error = std_error.into().map(|error| error * scale);
        Self {
            number: Number::measured(value * scale, std_error),
            unit,
        }
    }

    /// A value with the standard deviation of several like it.
    pub fn scattered(value: f64, scatter: impl Into<Option<f64>>, unit: &str) -> Self {
        let (scale, unit) = handy(value, unit);
        let scatter = scatter.into().map(|scatter| scatter * scale);
        Self {
            number: Number::scattered(value * scale, scatter),
            unit,
        }
    }

    /// So many significant digits, of what may not be known.
    pub fn rough(value: impl Into<Option<f64>>, digits: i32, unit: &str) -> Self {
        let Some(value) = value.into() else {
            return Self::choice("unknown");
        };
        let (scale, unit) = handy(value, unit);
        Self {
            number: Number::rough(value * scale, digits),
            unit,
        }
    }

    /// One of several, reported by its name.
    pub fn choice(name: &str) -> Self {
        Self {
            number: Number {
                value: name.to_owned(),
                margin: None,
                mark: "",
                exponent: None,
            },
            unit: String::new(),
        }
    }
}

impl fmt::Display for Quantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.number)?;
        if !self.unit.is_empty() {
            write!(f, "\u{a0}{}", self.unit)?;
        }
        Ok(())
    }
}

/// Small lengths, times and speeds in thousandths: how many there are to the unit, and what they are called.
fn handy(value: f64, unit: &str) -> (f64, String) {
    let (scale, unit) = match unit {
        "m" if value.abs() < 0.1 => (1e3, "mm"),
        "s" if value.abs() < 0.5 => (1e3, "ms"),
        "m/s" if value.abs() < 0.01 => (1e3, "mm/s"),
        "-" => (1.0, ""),
        unit => (1.0, unit),
    };
    (scale, powers(unit).replace(' ', "\u{a0}"))
}

/// `m^2` as m².
pub fn powers(text: &str) -> String {
    text.replace("^2", "²").replace("^3", "³")
}

/// So many significant digits.
pub fn significant(value: f64, digits: i32) -> String {
    fixed(value, decimals(value, digits))
}

/// So many decimals, negative ones rounding to tens.
pub fn fixed(value: f64, places: i32) -> String {
    let most = if value.is_normal() {
        decimals(value, MOST)
    } else {
        places
    };
    match parts(value, places.min(most)) {
        (text, Some(exponent)) => format!("{text}e{exponent}"),
        (text, None) => text,
    }
}

fn parts(value: f64, decimals: i32) -> (String, Option<i32>) {
    let exponent = exponent(rounded(value.abs(), decimals));
    (shifted(value, decimals, exponent), exponent)
}

/// The power of ten of a number rounded to so many digits.
fn power(value: f64, digits: i32) -> i32 {
    let digits = usize::try_from(digits - 1).unwrap_or(0);
    let text = format!("{value:.digits$e}");
    let power = text.split_once('e').and_then(|(_, e)| e.parse().ok());
    power.unwrap_or(0)
}

/// The decimals that so many digits of the value take.
fn decimals(value: f64, digits: i32) -> i32 {
    if value.is_normal() {
        digits - 1 - power(value, digits)
    } else {
        0
    }
}

fn rounded(value: f64, decimals: i32) -> f64 {
    match usize::try_from(decimals) {
        Ok(decimals) => format!("{value:.decimals$}").parse().unwrap_or(value),
        Err(_) => {
            let step = 10f64.powi(-decimals);
            (value / step).round() * step
        }
    }
}

fn exponent(size: f64) -> Option<i32> {
    let plain = !size.is_normal() || (SMALL..LARGE).contains(&size);
    // Of 15 digits, since 1e-7 is a little less than itself.
    (!plain).then(|| power(size, 15))
}

/// The number over a power of ten, with the decimals that it had before.
fn shifted(value: f64, decimals: i32, exponent: Option<i32>) -> String {
    if !value.is_finite() {
        return "–".to_owned();
    }
    let exponent = exponent.unwrap_or(0);
    // Either power is a number: 10^-308 is the least, 10^308 the largest.
    let value = if exponent < 0 {
        value * 10f64.powi(-exponent)
    } else {
        value / 10f64.powi(exponent)
    };
    let decimals = decimals + exponent;
    let places = usize::try_from(decimals).unwrap_or(0);
    grouped(&format!("{:.places$}", rounded(value, decimals)))
}

/// Without zeros that say nothing.
fn trimmed(text: String) -> String {
    if text.contains('.') {
        return text.trim_end_matches('0').trim_end_matches('.').to_owned();
    }
    text
}

/// Thousands apart, from five digits on, and nothing has no sign.
fn grouped(text: &str) -> String {
    let digits = text.trim_start_matches('-');
    let (whole, fraction) = digits.split_once('.').unwrap_or((digits, ""));
    let mut out = String::new();
    if text.starts_with('-') && digits.contains(|c| ('1'..='9').contains(&c)) {
        out.push(MINUS);
    }
    for (i, digit) in whole.chars().enumerate() {
        if i > 0 && whole.len() > 4 && (whole.len() - i).is_multiple_of(3) {
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use proptest::prelude::*;

    use super::*;

    fn text(value: f64, std_error: impl Into<Option<f64>>) -> String {
        let number = Number::measured(value, std_error).to_string();
        number.replace(THIN_SPACE, " ")
    }

    #[test]
    fn digits_follow_the_uncertainty() {
        assert_eq!(text(110_961.4, 50.6), "110 961 ± 99");
        assert_eq!(text(110_012.34, 4200.0), "110 000 ± 8200");
        assert_eq!(text(64_936.307, 1e-4), "64 936.30700 ± 0.00020");
        assert_eq!(text(0.9, 0.01), "0.900 ± 0.020");
        assert_eq!(text(-12.1, 0.4), "\u{2212}12.10 ± 0.78");
        assert_eq!(text(19.8696, 0.107), "19.87 ± 0.21");
        assert_eq!(text(0.012_341, 1.3e-4), "0.01234 ± 0.00025");
        assert_eq!(text(-0.001, 0.5), "0.00 ± 0.98");
    }

    #[test]
    fn margins_round_before_their_digits_are_counted() {
        assert_eq!(text(1.0, 0.0996 / WIDE), "1.00 ± 0.10");
        assert_eq!(text(2000.0, 99.6 / WIDE), "2000 ± 100");
        assert_eq!(text(999_999.6, 1.0), "999 999.6 ± 2.0");
        assert_eq!(text(999_999.96, 1.0), "(1.0000000 ± 0.0000020)e6");
    }

    #[test]
    fn sizes_far_from_one_share_an_exponent() {
        assert_eq!(text(1.007e9, 0.0223e9), "(1.007 ± 0.044)e9");
        assert_eq!(text(2.5e-9, 1e-10), "(2.50 ± 0.20)e-9");
        assert_eq!(text(0.0004, 0.01), "0.000 ± 0.020");
        assert_eq!(text(12.0, 1e9), "(0.0 ± 2.0)e9");
        assert_eq!(text(2.5e-9, None), "2.5e-9");
        assert_eq!(text(1e-7, None), "1e-7");
        assert_eq!(text(123_456_789.0, None), "1.2346e8");
        assert_eq!(significant(2.5e-9, 3), "2.50e-9");
        assert_eq!(fixed(1e12, 2), "1.000000000e12");
        assert_eq!(fixed(1e-5, 2), "0.00");
    }

    #[test]
    fn what_is_not_known_is_not_reported() {
        assert_eq!(text(23.0, None), "23");
        assert_eq!(text(3.0, f64::MAX), "3");
        assert_eq!(text(3.0, f64::NAN), "3");
        assert_eq!(text(3.0, 0.0), "3");
        assert_eq!(text(f64::NAN, 1.0), "–");
        assert_eq!(significant(f64::INFINITY, 2), "–");
        assert_eq!(significant(0.0, 2), "0");
        assert_eq!(significant(-0.5, 2), "\u{2212}0.50");
    }

    #[test]
    fn quantities_have_handy_units() {
        let text = |q: Quantity| q.to_string().replace(['\u{a0}', THIN_SPACE], " ");
        let measured = |value, error, unit| text(Quantity::new(value, error, unit));
        assert_eq!(measured(110_961.4, 50.6, "N/m"), "110 961 ± 99 N/m");
        assert_eq!(measured(0.0012, 1e-5, "m"), "1.200 ± 0.020 mm");
        assert_eq!(measured(0.012, 1e-3, "s"), "12.0 ± 2.0 ms");
        assert_eq!(measured(0.9, 0.01, "-"), "0.900 ± 0.020");
        assert_eq!(measured(3.0, 0.1, "N s^2/m^2"), "3.00 ± 0.20 N s²/m²");
        let swarm = Quantity::scattered(110_961.4, 99.0, "N/m");
        assert_eq!(text(swarm), "110 961, scatter 99 N/m");
        let large = Quantity::scattered(1.007e9, 4.4e7, "N/m");
        assert_eq!(text(large), "(1.007, scatter 0.044)e9 N/m");
        assert_eq!(text(Quantity::rough(1234.0, 3, "N/m")), "1230 N/m");
        assert_eq!(text(Quantity::rough(None, 3, "N/m")), "unknown");
        assert_eq!(text(Quantity::choice("front")), "front");
    }

    /// Reads a number as it stands, without its exponent.
    fn read(text: &str) -> f64 {
        text.replace(THIN_SPACE, "")
            .replace(MINUS, "-")
            .parse()
            .unwrap()
    }

    fn decimals_of(text: &str) -> usize {
        text.split_once('.')
            .map_or(0, |(_, fraction)| fraction.len())
    }

    /// Numbers of all sizes and signs.
    fn any_size() -> impl Strategy<Value = f64> {
        (-1.0..1.0f64, -300i32..300).prop_map(|(mantissa, power)| mantissa * 10f64.powi(power))
    }

    /// Those that physics has, mostly.
    fn usual() -> impl Strategy<Value = f64> {
        (-10.0..10.0f64, -9i32..9).prop_map(|(mantissa, power)| mantissa * 10f64.powi(power))
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        #[test]
        fn value_and_margin_share_decimals_and_exponent_and_parse_back(
            value in prop_oneof![usual(), any_size()],
            margin in prop_oneof![usual(), any_size()].prop_map(f64::abs),
        ) {
            let number = Number::within(value, Some(margin), " ± ");
            let reported = number.to_string();
            prop_assert!(!reported.contains("+-") && !reported.contains("+/-") && !reported.contains("NaN"), "{reported}");
            let Some(half) = &number.margin else {
                prop_assert!(!margin.is_normal());
                return Ok(());
            };
            prop_assert_eq!(decimals_of(&number.value), decimals_of(half), "{}", reported);
            let scale = 10f64.powi(number.exponent.unwrap_or(0));
            let (v, m) = (read(&number.value) * scale, read(half) * scale);
            let two = 10f64.powi(power(margin, 2) - 1);
            let least = if value.is_normal() { 10f64.powi(power(value, MOST) + 1 - MOST) } else { 0.0 };
            let unit = two.max(least);
            prop_assert!((v - value).abs() <= 0.501 * unit, "{value} {margin}: {reported}");
            prop_assert!((m - margin.max(unit)).abs() <= 0.501 * unit, "{value} {margin}: {reported}");
            prop_assert!(m >= 0.999 * unit, "{value} {margin}: {reported}");
            let size = v.abs().max(m);
            let plain = (SMALL * 0.999..LARGE * 1.001).contains(&size);
            prop_assert!(plain || number.exponent.is_some(), "{reported}");
            if number.exponent.is_some() {
                let most = read(&number.value).abs().max(read(half));
                prop_assert!((1.0..10.0).contains(&most), "{reported}");
                prop_assert!(!(SMALL * 1.001..LARGE * 0.999).contains(&size), "{reported}");
            }
        }

        #[test]
        fn larger_values_are_not_reported_as_smaller(
            a in prop_oneof![usual(), any_size()],
            nearer in 0.0..1e-3f64,
            other in prop_oneof![usual(), any_size()],
            margin in prop::option::of(usual().prop_map(f64::abs)),
            digits in 1..8i32,
        ) {
            for b in [other, a * (1.0 + nearer)] {
                let (low, high) = if a <= b { (a, b) } else { (b, a) };
                let whole = |x: f64| {
                    let n = Number::within(x, margin, " ± ");
                    read(&n.value) * 10f64.powi(n.exponent.unwrap_or(0))
                };
                prop_assert!(whole(low) <= whole(high) * (1.0 + 1e-14 * whole(high).signum()), "{low} {high}");
                let of = |x: f64| read(&significant(x, digits));
                prop_assert!(of(low) <= of(high), "{low} {high}");
            }
        }

        #[test]
        fn numbers_alone_keep_their_digits(value in prop_oneof![usual(), any_size()], digits in 1..=MOST) {
            let reported = significant(value, digits);
            let off = (read(&reported) - value).abs();
            prop_assert!(off <= 0.501 * 10f64.powi(1 - digits) * value.abs(), "{value}: {reported}");
        }
    }
}
