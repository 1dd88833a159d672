//! How long rides take, by what acts in them and by their length.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::figure::quantile;
use super::run::Runs;
use crate::files::FilesError;

/// One ride from start to finish.
#[derive(Clone, Debug)]
pub struct Timed {
    /// Class of the key: `clean`, `single`, `two`, `outside`.
    pub class: String,
    pub duration_s: f64,
    pub seconds: f64,
    pub verdict: String,
}

/// Identifies rides, given by name, class and length, one after the other, each alone on the machine, until the budget is used.
pub fn alone(runs: &Runs, rides: &[(String, &'static str, f64)]) -> Result<Vec<Timed>, FilesError> {
    let mut timed = Vec::new();
    for (name, class, duration_s) in rides {
        let Some(outcome) = runs.one(name)? else {
            continue;
        };
        eprintln!("{name}: {} in {:.1} s", outcome.verdict, outcome.seconds);
        timed.push(Timed {
            class: (*class).to_owned(),
            duration_s: *duration_s,
            seconds: outcome.seconds,
            verdict: outcome.verdict,
        });
    }
    Ok(timed)
}

/// Median, 90 % and worst of each group.
pub fn table(timed: &[Timed]) -> String {
    let mut groups: BTreeMap<(usize, u64), Vec<&Timed>> = BTreeMap::new();
    for ride in timed {
        let class = CLASSES.iter().position(|(class, _)| ride.class == *class);
        let key = (class.unwrap_or(CLASSES.len()), ride.duration_s as u64);
        groups.entry(key).or_default().push(ride);
    }
    let mut text = String::from(
        "| concealed | length (s) | rides | median (s) | 90 % (s) | worst (s) | verdict of the worst |\n|---|---|---|---|---|---|---|\n",
    );
    for ((class, duration_s), rides) in groups {
        let seconds: Vec<f64> = rides.iter().map(|ride| ride.seconds).collect();
        let at = |share| quantile(&seconds, share).unwrap_or(f64::NAN);
        let worst = rides
            .iter()
            .max_by(|a, b| a.seconds.total_cmp(&b.seconds))
            .map_or("", |ride| &ride.verdict);
        let _ = writeln!(
            text,
            "| {} | {duration_s} | {} | {:.1} | {:.1} | {:.1} | {worst} |",
            CLASSES.get(class).map_or("?", |(_, name)| name),
            rides.len(),
            at(0.5),
            at(0.9),
            at(1.0)
        );
    }
    text
}

const CLASSES: [(&str, &str); 4] = [
    ("clean", "nothing"),
    ("single", "one effect"),
    ("two", "two effects"),
    ("outside", "not in the library"),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rides_are_grouped_by_what_acts_and_by_length() {
        let ride = |class: &str, duration_s, seconds| Timed {
            class: class.to_owned(),
            duration_s,
            seconds,
            verdict: format!("in {seconds} s"),
        };
        let text = table(&[
            ride("two", 60.0, 4.0),
            ride("clean", 60.0, 3.0),
            ride("clean", 60.0, 1.0),
            ride("clean", 300.0, 9.0),
            ride("clean", 60.0, 2.0),
        ]);
        let rows: Vec<&str> = text.lines().skip(2).collect();
        assert_eq!(
            rows,
            [
                "| nothing | 60 | 3 | 2.0 | 3.0 | 3.0 | in 3 s |",
                "| nothing | 300 | 1 | 9.0 | 9.0 | 9.0 | in 9 s |",
                "| two effects | 60 | 1 | 4.0 | 4.0 | 4.0 | in 4 s |",
            ]
        );
    }
}
