//! A token bucket: a rate with bursts of up to ten seconds' worth.

use std::time::{Duration, Instant};

const BURST_S: f64 = 10.0;

pub struct Bucket {
    left: f64,
    at: Instant,
}

impl Bucket {
    /// A full one.
    pub fn new(per_minute: u32, now: Instant) -> Self {
        Self {
            left: full(per_minute),
            at: now,
        }
    }

    /// Takes one out, or says how long to wait until there is one.
    pub fn take(&mut self, per_minute: u32, now: Instant) -> Result<(), Duration> {
        let per_second = f64::from(per_minute) / 60.0;
        let passed = now.saturating_duration_since(self.at).as_secs_f64();
        self.left = (self.left + passed * per_second).min(full(per_minute));
        self.at = now;
        if self.left < 1.0 {
            return Err(Duration::from_secs_f64((1.0 - self.left) / per_second));
        }
        self.left -= 1.0;
        Ok(())
    }
}

fn full(per_minute: u32) -> f64 {
    (f64::from(per_minute) / 60.0 * BURST_S).max(1.0)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_burst_then_the_rate() {
        let begin = Instant::now();
        let mut bucket = Bucket::new(60, begin);
        for _ in 0..10 {
            bucket.take(60, begin).unwrap();
        }
        assert_eq!(bucket.take(60, begin), Err(Duration::from_secs(1)));
        let later = begin + Duration::from_secs(3);
        for _ in 0..3 {
            bucket.take(60, later).unwrap();
        }
        assert!(bucket.take(60, later).is_err());
        let much_later = begin + Duration::from_secs(3600);
        for _ in 0..10 {
            bucket.take(60, much_later).unwrap();
        }
        assert!(bucket.take(60, much_later).is_err(), "no more than full");
    }
}
