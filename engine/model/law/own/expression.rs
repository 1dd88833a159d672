//! Expressions of a law, evaluated for eight parameter sets at once.

use std::str::FromStr;

use exmex::{BinOp, Express, FlatEx, MakeOperators, Operator};

use super::error::LawError;
use super::grammar::{self, Checked};
use veloid_core::numerics::lanes::{LANES, Lanes};

/// Values that an expression may speak of at most: those of the motion, states and parameters.
pub const MOST_VALUES: usize = 26;

/// What an expression computes with.
#[derive(Clone, Copy, Debug)]
struct Value(Lanes);

impl Default for Value {
    fn default() -> Self {
        Self(Lanes::ZERO)
    }
}

impl FromStr for Value {
    type Err = std::num::ParseFloatError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        text.parse().map(|value| Self(Lanes::all(value)))
    }
}

impl Value {
    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        Self(self.0.map(f))
    }
}

#[derive(Clone, Debug)]
struct Operators;

impl MakeOperators<Value> for Operators {
    fn make<'a>() -> Vec<Operator<'a, Value>> {
        fn of_two<'a>(
            name: &'a str,
            prio: i64,
            apply: fn(Value, Value) -> Value,
        ) -> Operator<'a, Value> {
            let is_commutative = false;
            Operator::make_bin(
                name,
                BinOp {
                    apply,
                    prio,
                    is_commutative,
                },
            )
        }
        let minus = BinOp {
            apply: |a: Value, b: Value| Value(a.0 - b.0),
            prio: 1,
            is_commutative: false,
        };
        vec![
            of_two("^", 4, |a, b| Value(a.0.zip(b.0, power))),
            of_two("/", 3, |a, b| Value(a.0 / b.0)),
            of_two("*", 2, |a, b| Value(a.0 * b.0)),
            Operator::make_bin_unary("-", minus, |a| Value(-a.0)),
            of_two("+", 0, |a, b| Value(a.0 + b.0)),
            of_two("min", 0, |a, b| Value(a.0.min(b.0))),
            of_two("max", 0, |a, b| Value(a.0.max(b.0))),
            of_two("atan2", 0, |a, b| Value(a.0.zip(b.0, f64::atan2))),
            Operator::make_unary("abs", |a| Value(a.0.abs())),
            Operator::make_unary("sign", |a| a.map(sign)),
            Operator::make_unary("step", |a| a.map(|x| if x > 0.0 { 1.0 } else { 0.0 })),
            Operator::make_unary("sqrt", |a| Value(a.0.sqrt())),
            Operator::make_unary("exp", |a| a.map(f64::exp)),
            Operator::make_unary("ln", |a| a.map(f64::ln)),
            Operator::make_unary("sin", |a| a.map(f64::sin)),
            Operator::make_unary("cos", |a| a.map(f64::cos)),
            Operator::make_unary("tan", |a| a.map(f64::tan)),
            Operator::make_unary("asin", |a| a.map(f64::asin)),
            Operator::make_unary("acos", |a| a.map(f64::acos)),
            Operator::make_unary("atan", |a| a.map(f64::atan)),
            Operator::make_unary("sinh", |a| a.map(f64::sinh)),
            Operator::make_unary("cosh", |a| a.map(f64::cosh)),
            Operator::make_unary("tanh", |a| a.map(f64::tanh)),
            Operator::make_constant("pi", Value(Lanes::all(std::f64::consts::PI))),
        ]
    }
}

fn sign(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() }
}

fn power(base: f64, exponent: f64) -> f64 {
    match exponent {
        2.0 => base * base,
        3.0 => base * base * base,
        _ => base.powf(exponent),
    }
}

/// An expression whose names are places in a list of values.
#[derive(Clone, Debug)]
pub struct Expression {
    tree: FlatEx<Value, Operators>,
    /// Where the values stand that it speaks of, in the order in which it wants them.
    places: Vec<usize>,
    /// As it was written.
    pub written: String,
    pub has_corners: bool,
    pub operations: usize,
}

impl Expression {
    /// Reads the expression of the law's `field`, in which `known` names stand for the values in that order.
    pub fn parse(field: &str, text: &str, known: &[String]) -> Result<Self, LawError> {
        let written = text.split_whitespace().collect::<Vec<_>>().join(" ");
        let Checked {
            text,
            has_corners,
            operations,
        } = grammar::check(field, text, known)?;
        let refused = |problem: String| LawError::Expression {
            field: field.to_owned(),
            column: 1,
            problem,
        };
        let tree = FlatEx::<Value, Operators>::parse(&text).map_err(|e| refused(e.to_string()))?;
        let place = |name: &String| known.iter().position(|known| known == name);
        let places: Option<Vec<usize>> = tree.var_names().iter().map(place).collect();
        Ok(Self {
            places: places.ok_or_else(|| refused("unknown name".to_owned()))?,
            tree,
            written,
            has_corners,
            operations,
        })
    }

    /// Whether it speaks of the value at this place.
    pub fn speaks_of(&self, place: usize) -> bool {
        self.places.contains(&place)
    }

    /// Its value; no number where it has none.
    pub fn at(&self, values: &[Lanes; MOST_VALUES]) -> Lanes {
        let mut wanted = [Value::default(); MOST_VALUES];
        for (wanted, place) in wanted.iter_mut().zip(&self.places) {
            *wanted = Value(values[*place]);
        }
        match self.tree.eval(&wanted[..self.places.len()]) {
            Ok(Value(lanes)) => lanes,
            Err(_) => Lanes([f64::NAN; LANES]),
        }
    }
}

/// What an expression makes of values by name, of which it may know more than it speaks of.
#[cfg(test)]
pub fn evaluated(text: &str, values: &std::collections::BTreeMap<String, f64>) -> f64 {
    let spoken = |name: &&String| veloid_report::simulation::names(text).any(|n| n == *name);
    let known: Vec<String> = values.keys().filter(spoken).cloned().collect();
    let expression = Expression::parse("formula", text, &known);
    let expression = expression.unwrap_or_else(|error| panic!("{text}: {error}"));
    let mut places = [Lanes::ZERO; MOST_VALUES];
    for (place, name) in places.iter_mut().zip(&known) {
        *place = Lanes::all(values[name]);
    }
    expression.at(&places).0[0]
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn value(text: &str) -> f64 {
        let known = ["x", "y"].map(str::to_owned);
        let mut values = [Lanes::ZERO; MOST_VALUES];
        (values[0], values[1]) = (Lanes::all(2.0), Lanes::all(-3.0));
        let expression = Expression::parse("force", text, &known).unwrap();
        expression.at(&values).0[7]
    }

    /// As in mathematics, where languages and libraries differ.
    #[test]
    fn expressions_mean_what_they_mean_on_paper() {
        for (text, truth) in [
            ("-x^2", -4.0),
            ("exp(-(y/x)^2)", (-2.25f64).exp()),
            ("x - y - 1", 4.0),
            ("x - 1 + 2", 3.0),
            ("-x + 1", -1.0),
            ("-x/y*3", 2.0),
            ("12/x/3", 2.0),
            ("12/x*3", 18.0),
            ("2*x^3*y", -48.0),
            ("(x^2)^0.5", 2.0),
            ("max(x, y) - min(x, y)*2", 8.0),
            ("2 + max(x, 1)*3", 8.0),
            ("max(-x, -y)", 3.0),
            ("atan2(1, 1)*4/pi", 1.0),
            ("sign(y)*abs(y)^1.5", -(3f64.powf(1.5))),
            ("step(x) + step(y) + step(0)", 1.0),
            ("1e-3*x", 2e-3),
            ("1e300*1e-300*x", 2.0),
            ("tanh(x/10)", 0.2f64.tanh()),
            ("sqrt(x*x + y*y)", 13f64.sqrt()),
            (".5*x", 1.0),
            ("5.", 5.0),
        ] {
            let found = value(text);
            assert!(
                (found - truth).abs() < 1e-12 * truth.abs().max(1.0),
                "{text} = {found}"
            );
        }
        assert!(value("ln(y)").is_nan());
    }
}
