//! Shares of rides, with what chance allows.

use statrs::distribution::{Beta, ContinuousCDF};

/// So many of so many.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Share {
    pub count: usize,
    pub of: usize,
}

impl Share {
    /// How many of the answers are yes.
    pub fn of(answers: impl IntoIterator<Item = bool>) -> Self {
        let mut share = Self::default();
        for yes in answers {
            share.count += usize::from(yes);
            share.of += 1;
        }
        share
    }

    /// Clopper and Pearson's 95 % limits of the probability.
    pub fn limits(self) -> [f64; 2] {
        let (yes, no) = (self.count as f64, (self.of - self.count) as f64);
        let quantile =
            |a: f64, b: f64, p: f64| Beta::new(a, b).map_or(0.5, |beta| beta.inverse_cdf(p));
        let low = match self.count {
            0 => 0.0,
            _ => quantile(yes, no + 1.0, 0.025),
        };
        let high = match self.of - self.count {
            0 => 1.0,
            _ => quantile(yes + 1.0, no, 0.975),
        };
        [low, high]
    }

    /// Whether a probability between `from` and `to` may have given it.
    pub fn allows(self, [from, to]: [f64; 2]) -> bool {
        let [low, high] = self.limits();
        low <= to && from <= high
    }
}

impl std::fmt::Display for Share {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        if self.of == 0 {
            return f.write_str("none");
        }
        let percent = 100.0 * self.count as f64 / self.of as f64;
        let [low, high] = self.limits().map(|x| 100.0 * x);
        write!(
            f,
            "{} of {}, {percent:.1} % ({low:.1} to {high:.1})",
            self.count, self.of
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_those_of_the_tables() {
        let near = |count, of, low: f64, high: f64| {
            let [a, b] = Share { count, of }.limits();
            assert!((a - low).abs() < 1e-4 && (b - high).abs() < 1e-4, "{a} {b}");
        };
        near(0, 10, 0.0, 0.3085);
        near(1, 10, 0.0025, 0.4450);
        near(10, 10, 0.6915, 1.0);
        near(5, 100, 0.0164, 0.1128);
    }

    #[test]
    fn a_range_is_allowed_where_it_meets_the_limits() {
        let share = Share { count: 5, of: 100 };
        assert!(share.allows([0.005, 0.02]));
        assert!(!share.allows([0.005, 0.01]));
        assert!(!share.allows([0.12, 0.4]));
        assert!(Share::default().allows([0.1, 0.2]));
    }
}
