//! How long a proof may take before it stops by itself.

use std::time::{Duration, Instant};

/// When no further ride is begun.
#[derive(Clone, Copy, Debug, Default)]
pub struct Budget(Option<Instant>);

impl Budget {
    /// From now on as long as the text says: `90s`, `15m`, `2h`, `1h30m`.
    pub fn from_now(text: &str) -> Option<Self> {
        let until = Instant::now().checked_add(duration(text)?)?;
        Some(Self(Some(until)))
    }

    pub fn is_used(&self) -> bool {
        self.0.is_some_and(|until| Instant::now() >= until)
    }
}

/// Whole numbers, each with its unit, the largest first.
fn duration(text: &str) -> Option<Duration> {
    let mut rest = text;
    let mut sum = Duration::ZERO;
    for (unit, seconds) in [('h', 3600), ('m', 60), ('s', 1)] {
        let Some((count, after)) = rest.split_once(unit) else {
            continue;
        };
        if !count.bytes().all(|byte| byte.is_ascii_digit()) {
            return None;
        }
        let count: u64 = count.parse().ok()?;
        sum = sum.checked_add(Duration::from_secs(count.checked_mul(seconds)?))?;
        rest = after;
    }
    (rest.is_empty() && !text.is_empty()).then_some(sum)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn durations_are_written_as_people_do() {
        let seconds = |text| duration(text).map(|d| d.as_secs());
        assert_eq!(seconds("90s"), Some(90));
        assert_eq!(seconds("15m"), Some(900));
        assert_eq!(seconds("2h"), Some(7200));
        assert_eq!(seconds("1h30m"), Some(5400));
        assert_eq!(seconds("0s"), Some(0));
        let refused = [
            "",
            "15",
            "m",
            "-5m",
            "+5m",
            "1.5h",
            "15 m",
            "30m1h",
            "5m5m",
            "2d",
            "ü",
            "99999999999999999999s",
            "18446744073709551615h",
        ];
        for text in refused {
            assert_eq!(seconds(text), None, "{text}");
        }
    }

    #[test]
    fn a_budget_is_used_once_its_time_is_over() {
        assert!(!Budget::default().is_used());
        assert!(Budget::from_now("0s").expect("a duration").is_used());
        assert!(!Budget::from_now("1h").expect("a duration").is_used());
    }
}
