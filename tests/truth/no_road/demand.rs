//! What is demanded of rides, and whether it is met.

use crate::trial::share::Share;

/// Least share of rides that is right, largest share that is wrong.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Demand {
    pub right: Option<f64>,
    pub wrong: Option<f64>,
}

impl Demand {
    /// What is demanded, and whether it is met.
    pub fn judged(self, right: Share, wrong: Share) -> String {
        let least = self.right.map(|least| {
            let words = format!("right {} %", percent(least));
            judged(&words, right, [least, 1.0])
        });
        let most = self.wrong.map(|most| {
            let words = format!("wrong at most {} %", percent(most));
            judged(&words, wrong, [0.0, most])
        });
        let both: Vec<String> = [least, most].into_iter().flatten().collect();
        both.join("; ")
    }
}

/// Whether a share is within a range, or may be by chance; no more than the words where there are no rides.
pub fn judged(words: &str, share: Share, range: [f64; 2]) -> String {
    let part = share.count as f64 / share.of.max(1) as f64;
    let is_met = (range[0]..=range[1]).contains(&part);
    match share.of {
        0 => words.to_owned(),
        _ if is_met => format!("{words}: met"),
        _ if share.allows(range) => format!("{words}: not met, within chance"),
        _ => format!("{words}: not met"),
    }
}

fn percent(share: f64) -> f64 {
    (100.0 * share).round()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn demands_missed_within_chance_are_marked_so() {
        let demand = Demand {
            right: Some(0.8),
            wrong: Some(0.02),
        };
        let of = |count| Share { count, of: 100 };
        let text = |right, wrong| demand.judged(of(right), of(wrong));
        assert_eq!(text(80, 2), "right 80 %: met; wrong at most 2 %: met");
        assert_eq!(
            text(79, 20),
            "right 80 %: not met, within chance; wrong at most 2 %: not met"
        );
        let none = demand.judged(Share::default(), Share::default());
        assert_eq!(none, "right 80 %; wrong at most 2 %");
        assert_eq!(Demand::default().judged(of(1), of(1)), "");
    }
}
