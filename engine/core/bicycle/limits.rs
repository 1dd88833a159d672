//! Stiffness and damping that the user fixes or bounds.

use std::collections::BTreeMap;

use super::{Axle, Bike, LimitError};
use crate::plant::Of;

/// The axle and the quantity of a key such as `f.k` or `rear.B`.
fn quantity(key: &str) -> Result<(Axle, Of), LimitError> {
    let named = || key.to_owned();
    let (axle, quantity) = key
        .split_once('.')
        .ok_or_else(|| LimitError::Key { key: named() })?;
    let axle = match axle {
        "f" | "front" => Axle::Front,
        "r" | "rear" => Axle::Rear,
        _ => {
            let axle = axle.to_owned();
            return Err(LimitError::Axle { key: named(), axle });
        }
    };
    match quantity {
        "k" => Ok((axle, Of::Stiffness)),
        "B" => Ok((axle, Of::Damping)),
        _ => Err(LimitError::Quantity {
            key: named(),
            quantity: quantity.to_owned(),
        }),
    }
}

/// What stands for a quantity, under its key.
fn find<T>(given: &BTreeMap<String, T>, axle: Axle, of: Of) -> Option<(&String, &T)> {
    let mut given = given.iter();
    given.find(|(key, _)| quantity(key) == Ok((axle, of)))
}

fn each_once<T>(given: &BTreeMap<String, T>) -> Result<(), LimitError> {
    for key in given.keys() {
        let (axle, of) = quantity(key)?;
        if let Some((first, _)) = find(given, axle, of).filter(|(first, _)| *first != key) {
            return Err(LimitError::Twice {
                first: first.clone(),
                second: key.clone(),
            });
        }
    }
    Ok(())
}

/// Values from a rigid rig down to none, of damping also the negative ones that a bench may show, and their unit.
fn reach(of: Of) -> ([f64; 2], &'static str) {
    match of {
        Of::Stiffness => ([0.0, 1e12], "N/m"),
        _ => ([-1e9, 1e9], "N s/m"),
    }
}

/// Checks names and numbers of what is fixed and bounded.
///
/// # Errors
/// Unknown axles and quantities, values that are no numbers, empty bounds, fixed values outside of them.
pub fn check(
    fix: &BTreeMap<String, f64>,
    bound: &BTreeMap<String, [f64; 2]>,
) -> Result<(), LimitError> {
    each_once(fix)?;
    each_once(bound)?;
    let values = bound
        .iter()
        .flat_map(|(key, ends)| ends.iter().map(move |x| (key, *x)));
    let mut values = values.chain(fix.iter().map(|(key, x)| (key, *x)));
    if let Some((key, value)) = values.find(|(_, value)| !value.is_finite()) {
        let key = key.clone();
        return Err(LimitError::NotFinite { key, value });
    }
    let fixed = fix.iter().map(|(key, x)| (key, *x));
    let bounds = (bound.iter()).flat_map(|(key, ends)| ends.iter().map(move |x| (key, *x)));
    for (key, value) in fixed.chain(bounds) {
        let ([low, high], unit) = reach(quantity(key)?.1);
        if !(low..=high).contains(&value) {
            let key = key.clone();
            return Err(LimitError::OutOfReach {
                key,
                value,
                low,
                high,
                unit,
            });
        }
    }
    for (key, [low, high]) in bound {
        let (key, [low, high]) = (key.clone(), [*low, *high]);
        if low >= high {
            return Err(LimitError::Empty { key, low, high });
        }
        let (axle, of) = quantity(&key)?;
        if let Some((key, value)) = find(fix, axle, of)
            && !(low..=high).contains(value)
        {
            let (key, value) = (key.clone(), *value);
            return Err(LimitError::Outside {
                key,
                value,
                low,
                high,
            });
        }
    }
    Ok(())
}

impl Bike {
    /// The limits within which a quantity lies (N/m or N s/m), which are equal where it is fixed; nothing where it is free.
    pub fn limit(&self, axle: Axle, of: Of) -> Option<[f64; 2]> {
        let fixed = find(&self.fix, axle, of).map(|(_, value)| [*value; 2]);
        fixed.or_else(|| find(&self.bound, axle, of).map(|(_, ends)| *ends))
    }

    /// Those of k and B.
    pub fn limits(&self, axle: Axle) -> [Option<[f64; 2]>; 2] {
        [Of::Stiffness, Of::Damping].map(|of| self.limit(axle, of))
    }

    /// Everything that is fixed or bounded: its key and axle.
    pub fn limited(&self) -> impl Iterator<Item = (&str, Axle)> {
        let keys = self.fix.keys().chain(self.bound.keys());
        keys.filter_map(|key| Some((key.as_str(), quantity(key).ok()?.0)))
    }

    /// The bicycle with what is fixed and bounded for one identification, which goes before its own.
    ///
    /// # Errors
    /// As [`check`]; axles that are fitted as one.
    pub fn with_limits(
        &self,
        fix: &BTreeMap<String, f64>,
        bound: &BTreeMap<String, [f64; 2]>,
    ) -> Result<Self, LimitError> {
        check(fix, bound)?;
        let mut bike = self.clone();
        for (key, value) in fix {
            bike.fix.retain(|own, _| quantity(own) != quantity(key));
            bike.fix.insert(key.clone(), *value);
        }
        for (key, ends) in bound {
            bike.bound.retain(|own, _| quantity(own) != quantity(key));
            bike.bound.insert(key.clone(), *ends);
        }
        bike.check_limits()?;
        Ok(bike)
    }

    pub(super) fn check_limits(&self) -> Result<(), LimitError> {
        check(&self.fix, &self.bound)?;
        match self.limited().next().filter(|_| self.equal_axles) {
            Some((key, _)) => Err(LimitError::EqualAxles {
                key: key.to_owned(),
            }),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn fixed(pairs: &[(&str, f64)]) -> BTreeMap<String, f64> {
        pairs
            .iter()
            .map(|(key, x)| ((*key).to_owned(), *x))
            .collect()
    }

    fn bounded(pairs: &[(&str, [f64; 2])]) -> BTreeMap<String, [f64; 2]> {
        pairs
            .iter()
            .map(|(key, x)| ((*key).to_owned(), *x))
            .collect()
    }

    fn bike() -> Bike {
        Bike {
            mass_front_kg: Some(25.0),
            fix: fixed(&[("front.k", 5e4)]),
            ..Bike::default()
        }
    }

    #[test]
    fn what_one_identification_fixes_goes_before_the_bike_file() {
        let bike = bike();
        assert_eq!(bike.limits(Axle::Front), [Some([5e4, 5e4]), None]);
        let bound = bounded(&[("f.B", [0.0, 2000.0])]);
        let bike = bike.with_limits(&fixed(&[("f.k", 6e4)]), &bound).unwrap();
        assert_eq!(
            bike.limits(Axle::Front),
            [Some([6e4, 6e4]), Some([0.0, 2000.0])]
        );
        assert_eq!(bike.limits(Axle::Rear), [None, None]);
    }

    #[test]
    fn every_mistake_has_its_message() {
        let said = |fix: &[(&str, f64)], bound: &[(&str, [f64; 2])]| {
            let refused = bike().with_limits(&fixed(fix), &bounded(bound));
            refused.unwrap_err().to_string()
        };
        for (key, message) in [
            ("k", "'k', expected AXLE.QUANTITY such as f.k"),
            ("x.k", "x.k: unknown axle 'x', expected f, front, r or rear"),
            ("f.c", "f.c: unknown quantity 'c', expected k or B"),
        ] {
            assert!(said(&[(key, 1.0)], &[]).starts_with(message), "{key}");
        }
        let message = "f.k is inf, expected a finite number";
        assert_eq!(said(&[("f.k", f64::INFINITY)], &[]), message);
        let message = "f.k is -1, expected 0e0 to 1e12 N/m";
        assert_eq!(said(&[("f.k", -1.0)], &[]), message);
        assert_eq!(said(&[], &[("f.k", [-1.0, 5.0])]), message);
        let message = "f.B is bounded by 9 and 9, expected the lower bound first";
        assert_eq!(said(&[], &[("f.B", [9.0, 9.0])]), message);
        let message = "front.k is fixed at 50000, outside its bounds 0 to 100";
        assert_eq!(said(&[], &[("f.k", [0.0, 100.0])]), message);
        let message = "f.k and front.k are the same quantity, expected one of them";
        assert_eq!(said(&[("f.k", 1.0), ("front.k", 1.0)], &[]), message);
        let equal = Bike {
            equal_axles: true,
            ..bike()
        };
        let refused = equal.check_limits().unwrap_err().to_string();
        assert!(
            refused.starts_with("front.k cannot hold beside equal_axles"),
            "{refused}"
        );
    }
}
