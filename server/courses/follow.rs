use crate::Rides;
use crate::evidence::{additions, of_another};
use crate::least_squares::Fit;
use crate::robust::believed;
use crate::structure::{Change, Structure};

/// Evidence (natural logarithm) from which on a change is reported. With 200 rides of four parameters at most 1 % of bicycles without a
/// change exceed it (`examples/alarms.rs`).
pub const THRESHOLD: f64 = 9.6;
/// Rounds in which changes are moved.
const ROUNDS: usize = 4;
/// Rides by which the beginning of a drift that has ended is moved at once.
const NEAR: usize = 5;

/// What was found on the way.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Followed {
    pub structure: Structure,
    /// The ride after which each change was reported first, in the order of the reports.
    pub reported: Vec<usize>,
}

/// Looks at rides one after the other.
pub fn follow(data: Rides) -> Followed {
    let mut found = Followed::default();
    for n in 1..=data.rides.len() {
        let so_far = Rides {
            rides: &data.rides[..n],
            facts: &data.telling(n),
        };
        found.structure = refined(so_far, found.structure);
        let evidence = of_another(so_far, &found.structure, THRESHOLD);
        if let Some(evidence) = evidence.filter(|evidence| evidence.log >= THRESHOLD) {
            found.structure = refined(so_far, found.structure.with(evidence.best));
            found.reported.push(n - 1);
        }
    }
    found
}

/// Each change where it explains most beside the others, and as what it does.
fn refined(data: Rides, mut structure: Structure) -> Structure {
    for _ in 0..ROUNDS {
        let mut is_settled = true;
        for place in 0..structure.0.len() {
            let old = structure.0[place];
            let rest = structure.without(place);
            let best = match rest.is_consistent() {
                true => best_beside(data, &rest),
                false => best_near(data, &rest, old),
            };
            if let Some(best) = best.filter(|best| *best != old) {
                structure = rest.with(best);
                is_settled = false;
            }
        }
        if is_settled {
            break;
        }
    }
    structure
}

/// The change that explains most beside others.
fn best_beside(data: Rides, others: &Structure) -> Option<Change> {
    let columns = others.columns(data.rides, data.facts);
    let (between, _) = most_likely(data, others)?;
    let values: Vec<f64> = data.rides.iter().map(|ride| ride.value).collect();
    let fit = Fit::of(data.rides, &values, &columns, between)?;
    let changes = additions(data.rides, others, &fit, between).into_iter();
    let changes = changes.filter(|(change, _)| others.with(*change).is_consistent());
    let best = changes.max_by(|a, b| a.1.total_cmp(&b.1));
    best.map(|(change, _)| change)
}

/// Where the beginning of a drift that has ended explains most, not far from where it was.
fn best_near(data: Rides, others: &Structure, old: Change) -> Option<Change> {
    let near = old.ride.saturating_sub(NEAR).max(1)..(old.ride + NEAR + 1).min(data.rides.len());
    let is_free = |ride: &usize| others.0.iter().all(|change| change.ride != *ride);
    let scored = near.filter(is_free).filter_map(|ride| {
        let change = Change { ride, ..old };
        let whole = others.with(change);
        let (_, fit) = most_likely(data, &whole).filter(|_| whole.is_consistent())?;
        Some((fit.likelihood, change))
    });
    let best = scored.max_by(|a, b| a.0.total_cmp(&b.0));
    best.map(|(_, change)| change)
}

fn most_likely(data: Rides, structure: &Structure) -> Option<(f64, Fit)> {
    let columns = structure.columns(data.rides, data.facts);
    let values = believed(data.rides, &columns);
    Fit::most_likely(data.rides, &values, &columns)
}
