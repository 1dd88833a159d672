//! What an effect says of itself.

use std::borrow::Cow;

use super::formula::Formula;
use super::limits::Values;
use super::need::Need;
use super::scale::Scale;
use veloid_report::diagnosis::Stronger;

/// Where an effect can act.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Acts {
    /// On the front or the rear axle separately.
    OneAxle,
    /// On the front axle only.
    Front,
    /// On the rear axle only.
    Rear,
    /// On both axles with one set of parameters.
    Both,
}

/// Of what a law is one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// Of the deflection.
    Spring,
    /// Of its rate.
    Damper,
}

/// A fitted parameter.
pub struct Parameter {
    pub name: &'static str,
    pub unit: &'static str,
    /// A typical size, from which the fit takes its steps.
    pub size: fn(&Scale) -> f64,
    /// Hard limits of the fit.
    pub limits: fn(&Scale) -> [f64; 2],
}

/// A parameter as it is reported.
pub struct Reported {
    pub name: Cow<'static, str>,
    pub unit: Cow<'static, str>,
    pub value: f64,
    /// Whether a real bicycle can have this value.
    pub physical: bool,
}

/// From k/m, B/m and an effect's values to others.
pub type Twin = fn([f64; 2], &Values) -> ([f64; 2], Values);

pub struct Spec {
    pub id: &'static str,
    pub acts: Acts,
    pub needs: &'static [Need],
    /// The parameters that the fit moves. Values beyond them are choices that starts make.
    pub parameters: &'static [Parameter],
    /// Parameters in which the effect is nearly linear and that are zero without it: their starts are
    /// scaled to the residual. None: starts are taken as they are.
    pub amplitudes: &'static [usize],
    /// The parameter, fitted and reported under this number, that shows how large the effect is, and whether it does more
    /// when it is larger.
    pub size_parameter: usize,
    pub stronger: Stronger,
    /// Parameter sets to start the fit from; with two amplitudes, one of them zero, in pairs.
    pub starts: fn(&Scale) -> Vec<Values>,
    /// Starts between the best start and its neighbours, at the given zoom (1, 2, ..), if any.
    pub nearer: fn(&Values, &Scale, u32) -> Vec<Values>,
    pub report: fn(&Values, &Scale) -> Vec<Reported>,
    /// Stiffness (N/m) that the effect adds at most, which the integrator must resolve.
    pub stiffens: fn(&Values, &Scale) -> f64,
    /// Damping (N s/m) that the effect adds at most, likewise.
    pub damps: fn(&Values, &Scale) -> f64,
    /// k/m and B/m of an axle that moves slowly as it does with the effect, for a fit without it to start from.
    pub alone: fn([f64; 2], &Values) -> [f64; 2],
    /// Other numbers that move what is measured in exactly the same way, beside nothing but this effect.
    pub twin: Option<Twin>,
    pub states: usize,
    /// Whether two states are the height and the velocity of a second mass.
    pub second_mass: bool,
    /// Whether the second mass, the first parameter's share of the whole, stands on the tyre and carries the rest.
    pub carries: bool,
    pub on_road: bool,
    pub on_sensor: bool,
    /// Whether the effect belongs to a moment of this ride, so that the held-out part need not show it.
    pub local: bool,
    /// Whether the effect is so slow that coloured noise imitates it: what it predicts under the noise of
    /// a model without it says nothing, only a refit does.
    pub slow: bool,
    /// Whether the force has corners, which the integrator must meet with shorter steps.
    pub corners: bool,
    /// Whether the likelihood has many peaks, so that a fit also starts from afar.
    pub peaks: bool,
    /// Parameters for which a value and a deviation are expected where the ride says nothing.
    pub expected: &'static [(usize, f64, f64)],
    /// The force that comes to the tyre's, k d + B w, or what takes its place; by the names that are reported.
    pub law: &'static str,
    /// The same for machines, as the fit computes it.
    pub formula: Formula,
    /// The effect in plain words.
    pub words: &'static str,
    /// The effect with its size, as a sentence names it: `{name}` stands for a reported parameter. Empty where it is never named.
    pub noun: &'static str,
    pub confused_with: &'static [&'static str],
    /// The variable of which the force is a law, if it is one of a single variable.
    pub family: Option<Family>,
    /// Whether such a law is alike in both directions.
    pub is_odd: bool,
    /// Whether it is a general law against which others are held: it is never named.
    pub is_general: bool,
    /// The general law of which this one is the case with the last parameter zero, where both have states of their own.
    pub case_of: Option<&'static str>,
    /// Whether it takes the place of the plain spring, of which something must be left.
    pub replaces_spring: bool,
    /// Whether its first parameter is a stiffness that relaxes beside the plain one.
    pub relaxes: bool,
    /// Laws of which this one is a limit, so that they explain a ride at least as well.
    pub limit_of: &'static [&'static str],
    pub source: &'static str,
}

impl Spec {
    /// What most effects have in common; the rest each says for itself.
    pub const ORDINARY: Spec = Spec {
        id: "",
        acts: Acts::OneAxle,
        needs: &[],
        parameters: &[],
        amplitudes: &[],
        size_parameter: 0,
        stronger: Stronger::Larger,
        starts: |_| Vec::new(),
        nearer: |_, _, _| Vec::new(),
        report: |_, _| Vec::new(),
        stiffens: |_, _| 0.0,
        damps: |_, _| 0.0,
        alone: |base, _| base,
        twin: None,
        states: 0,
        second_mass: false,
        carries: false,
        on_road: false,
        on_sensor: false,
        local: false,
        slow: false,
        corners: false,
        peaks: false,
        expected: &[],
        law: "",
        formula: Formula::NONE,
        words: "",
        noun: "",
        confused_with: &[],
        family: None,
        is_odd: false,
        is_general: false,
        case_of: None,
        replaces_spring: false,
        relaxes: false,
        limit_of: &[],
        source: "",
    };
}

/// A parameter that is reported as it is fitted, physical within `range`.
pub fn reported(parameter: &Parameter, value: f64, range: [f64; 2]) -> Reported {
    Reported {
        name: parameter.name.into(),
        unit: parameter.unit.into(),
        value,
        physical: (range[0]..=range[1]).contains(&value),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_is_physical_within_its_range_and_at_its_ends() {
        let parameter = Parameter {
            name: "friction",
            unit: "N",
            size: |_| 1.0,
            limits: |_| [0.0, 1.0],
        };
        let physical = |value: f64| reported(&parameter, value, [0.0, 2.0]).physical;
        assert!(physical(0.0) && physical(1.5) && physical(2.0));
        assert!(!physical(-1e-9) && !physical(2.1) && !physical(f64::NAN));
        let told = reported(&parameter, 1.5, [0.0, 2.0]);
        assert_eq!(
            (&*told.name, &*told.unit, told.value),
            ("friction", "N", 1.5)
        );
    }
}
