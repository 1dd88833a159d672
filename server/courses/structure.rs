//! Level, steps and drifts as columns of a regression.

use nalgebra::DMatrix;

use crate::Ride;

/// What happens between a ride and the one before it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The level changes.
    Step,
    /// The level begins to drift.
    Begin,
    /// A drift ends.
    End,
    /// A drift ends and the level changes, as at a service.
    Reset,
}

/// A change that shows from a ride on, which is given by its place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Change {
    pub ride: usize,
    pub kind: Kind,
}

/// A drift, by the rides from which its beginning and its end show; one that goes on has no end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Span {
    pub from: usize,
    pub to: Option<usize>,
}

/// Changes by their rides.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Structure(pub Vec<Change>);

impl Structure {
    pub fn drifts(&self) -> Vec<Span> {
        let mut found: Vec<Span> = Vec::new();
        for Change { ride, kind } in &self.0 {
            match (kind, found.last_mut()) {
                (Kind::Begin, _) => found.push(Span {
                    from: *ride,
                    to: None,
                }),
                (Kind::End | Kind::Reset, Some(drift)) => drift.to = Some(*ride),
                _ => {}
            }
        }
        found
    }

    pub fn steps(&self) -> impl Iterator<Item = usize> {
        let steps = self.0.iter();
        let steps = steps.filter(|change| matches!(change.kind, Kind::Step | Kind::Reset));
        steps.map(|change| change.ride)
    }

    /// Whether drifts begin where none goes on and end where one does.
    pub fn is_consistent(&self) -> bool {
        let mut drifts = false;
        self.0.iter().all(|change| {
            let (fits, then) = match change.kind {
                Kind::Step => (true, drifts),
                Kind::Begin => (!drifts, true),
                Kind::End | Kind::Reset => (drifts, false),
            };
            drifts = then;
            fits
        })
    }

    pub fn with(&self, change: Change) -> Self {
        let mut changes = self.0.clone();
        let place = changes.partition_point(|other| other.ride < change.ride);
        changes.insert(place, change);
        Self(changes)
    }

    pub fn without(&self, place: usize) -> Self {
        let mut changes = self.0.clone();
        changes.remove(place);
        Self(changes)
    }

    /// Columns of the rides: level, facts, steps, drifts (days), in this order.
    pub fn columns(&self, rides: &[Ride], facts: &[Vec<f64>]) -> DMatrix<f64> {
        let n = rides.len();
        let from = |step: usize| {
            (0..n)
                .map(move |i| f64::from(u8::from(i >= step)))
                .collect()
        };
        let ramp = |drift: &Span| {
            let from = begins(rides, drift.from);
            let to = drift.to.map_or(f64::INFINITY, |to| begins(rides, to));
            let passed = |ride: &Ride| (ride.day.min(to) - from).max(0.0);
            rides.iter().map(passed).collect()
        };
        let mut columns: Vec<Vec<f64>> = vec![vec![1.0; n]];
        columns.extend(facts.iter().map(|fact| fact[..n].to_vec()));
        columns.extend(self.steps().map(from));
        columns.extend(self.drifts().iter().map(ramp));
        DMatrix::from_fn(n, columns.len(), |i, j| columns[j][i])
    }
}

/// The day of the ride before: from there on a drift may have begun that shows on this one.
pub fn begins(rides: &[Ride], ride: usize) -> f64 {
    let before = rides.get(ride.saturating_sub(1));
    before.map_or(f64::INFINITY, |ride| ride.day)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_drift_ends_once() {
        let of = |kinds: &[Kind]| {
            let changes = kinds.iter().enumerate();
            Structure(
                changes
                    .map(|(ride, kind)| Change { ride, kind: *kind })
                    .collect(),
            )
        };
        use Kind::{Begin, End, Reset, Step};
        for (kinds, consistent) in [
            (&[Begin, Step, End, Begin, Reset][..], true),
            (&[End], false),
            (&[Begin, Begin], false),
            (&[Begin, End, Reset], false),
        ] {
            assert_eq!(of(kinds).is_consistent(), consistent, "{kinds:?}");
        }
        let [first, second] = of(&[Begin, Reset, Step, Begin]).drifts()[..] else {
            unreachable!()
        };
        assert_eq!((first.from, first.to), (0, Some(1)));
        assert_eq!((second.from, second.to), (3, None));
    }

    #[test]
    fn a_drift_stops_where_it_ends() {
        let ride = |day: f64| Ride {
            day,
            value: 0.0,
            std_error: 1.0,
        };
        let rides: Vec<Ride> = (0..6).map(|i| ride(2.0 * f64::from(i))).collect();
        let changes = [(2, Kind::Begin), (4, Kind::Reset)];
        let changes = changes.map(|(ride, kind)| Change { ride, kind });
        let columns = Structure(changes.to_vec()).columns(&rides, &[]);
        let column = |j: usize| columns.column(j).iter().copied().collect::<Vec<f64>>();
        assert_eq!(column(1), [0.0, 0.0, 0.0, 0.0, 1.0, 1.0]);
        assert_eq!(column(2), [0.0, 0.0, 2.0, 4.0, 4.0, 4.0]);
    }
}
