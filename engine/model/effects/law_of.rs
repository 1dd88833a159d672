//! What an effect does, as reports write it out.

use std::collections::BTreeMap;

use super::Kind;
use crate::law::{Formula, OwnLaw, SIZES, Scale, Values, as_reported};
use veloid_report::simulation::{Law, LawState, names};

impl Kind {
    /// What the effect does, in expressions.
    pub fn law(self, scale: &Scale) -> Law {
        match (self, &scale.own) {
            (Self::Own(_), Some(law)) => of_own(law),
            _ => of_library(&self.spec().formula),
        }
    }

    /// The numbers that these expressions name.
    pub fn numbers(self, values: &Values, scale: &Scale) -> BTreeMap<String, f64> {
        let parameters = self.fitted(scale.own.as_deref());
        let law = self.law(scale);
        let is_named = |size: &str| {
            let mut words = law.expressions().flat_map(names);
            words.any(|word| word == size || (size == "wheel_radius" && word == "wheel"))
        };
        let sizes = SIZES.into_iter().zip(sizes(scale));
        let sizes = sizes.filter(|(size, _)| is_named(size) && !parameters.contains(size));
        (parameters.iter().copied().zip(values.iter().copied()))
            .chain(sizes)
            .map(|(name, value)| (name.to_owned(), value))
            .collect()
    }

    /// The values that these numbers are of, `own` being the law of the user's own.
    ///
    /// # Errors
    /// The first number that is missing.
    pub fn values_numbered(
        self,
        numbers: &BTreeMap<String, f64>,
        own: Option<&OwnLaw>,
    ) -> Result<Values, String> {
        let mut values = as_reported(&[]);
        for (value, name) in values.iter_mut().zip(self.fitted(own)) {
            *value = *numbers.get(name).ok_or_else(|| name.to_owned())?;
        }
        Ok(values)
    }

    /// Names of the values that a fit moves, and of the choices behind them.
    fn fitted(self, own: Option<&OwnLaw>) -> Vec<&str> {
        let spec = self.spec();
        match (self, own) {
            (Self::Own(_), Some(law)) => law.parameters.iter().map(|p| p.name.as_str()).collect(),
            _ => (spec.parameters.iter().map(|p| p.name))
                .chain(spec.formula.choices.iter().copied())
                .collect(),
        }
    }
}

/// Takes the sizes of a ride from the numbers of a law that names them.
pub fn set_sizes(scale: &mut Scale, numbers: &BTreeMap<String, f64>) {
    let sizes = [
        &mut scale.d_rms,
        &mut scale.w_rms,
        &mut scale.mean_speed,
        &mut scale.wheel_radius,
        &mut scale.lift,
    ];
    for (size, name) in sizes.into_iter().zip(SIZES) {
        if let Some(value) = numbers.get(name) {
            *size = *value;
        }
    }
}

/// The values of [`SIZES`].
fn sizes(scale: &Scale) -> [f64; SIZES.len()] {
    [
        scale.d_rms,
        scale.w_rms,
        scale.mean_speed,
        scale.wheel_radius,
        scale.lift,
    ]
}

fn of_own(law: &OwnLaw) -> Law {
    let (force, states) = law.written();
    let (tyre, body) = match law.is_on_body {
        true => (String::new(), force.to_owned()),
        false => (force.to_owned(), String::new()),
    };
    Law {
        tyre,
        body,
        states: states.map(state).collect(),
        ..Law::default()
    }
}

fn of_library(formula: &Formula) -> Law {
    Law {
        tyre: formula.tyre.to_owned(),
        body: formula.body.to_owned(),
        acceleration: formula.acceleration.to_owned(),
        states: formula.states.iter().copied().map(state).collect(),
        shift: formula.shift.to_owned(),
        half_window: formula.half_window.to_owned(),
        height: formula.height.to_owned(),
        slope: formula.slope.to_owned(),
        delay: formula.delay.to_owned(),
        gain: formula.gain.to_owned(),
        offset: formula.offset.to_owned(),
        lag: formula.lag.to_owned(),
    }
}

fn state((name, rate): (&str, &str)) -> LawState {
    LawState {
        name: name.to_owned(),
        rate: rate.to_owned(),
    }
}
