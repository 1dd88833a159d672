//! A law of the user's own, written in a few lines of TOML: parameters, states, and the force as an expression.

mod error;
mod expression;
mod file;
mod grammar;

pub use self::error::LawError;
#[cfg(test)]
pub use self::expression::evaluated;
use self::expression::{Expression, MOST_VALUES};
use self::file::{File, Start, Written};
use super::limits::{LaneValues, MAX_OWN_STATES, MAX_PARAMETERS, Values};
use super::need::Need;
use veloid_core::numerics::lanes::{LANES, Lanes};

pub use self::file::Where;

/// What expressions may speak of beside states and parameters: deflection u - z (m) and its rate (m/s), height (m) and velocity
/// (m/s) of the axle mass, speed (m/s), time (s), angles of crank and wheel (rad).
pub const MOTION: [&str; 8] = ["d", "w", "z", "z_dot", "speed", "t", "crank", "wheel"];
/// Their values.
pub type OwnMotion = [Lanes; MOTION.len()];

const _: () = assert!(MOTION.len() + MAX_OWN_STATES + MAX_PARAMETERS <= MOST_VALUES);
const DEFLECTION: usize = 0;
const RATE: usize = 1;
const SPEED: usize = 4;
const CRANK: usize = 6;
const WHEEL: usize = 7;

/// Characters of a name, of a unit, and of the plain words.
const MOST_NAME: usize = 40;
const MOST_UNIT: usize = 20;
const MOST_WORDS: usize = 200;
/// Sets of starting values.
const MOST_STARTS: usize = 27;

/// A parameter of a law.
#[derive(Clone, Debug)]
pub struct OwnParameter {
    pub name: String,
    pub unit: String,
    pub starts: Vec<f64>,
    pub range: [f64; 2],
}

impl OwnParameter {
    /// A typical size, from which a fit takes its steps.
    pub fn size(&self) -> f64 {
        let largest = self.starts.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        match largest > 0.0 {
            true => largest,
            false => 0.1 * (self.range[1] - self.range[0]),
        }
    }
}

/// A law of the user's own.
#[derive(Clone, Debug)]
pub struct OwnLaw {
    pub id: String,
    pub words: String,
    pub acts: Where,
    pub parameters: Vec<OwnParameter>,
    /// A parameter in which the force is linear and that is zero without it.
    pub amplitude: Option<usize>,
    /// Whether the force belongs to the mass alone, and not to what lies between it and the road.
    pub is_on_body: bool,
    force: Expression,
    rates: Vec<Expression>,
    names_of_states: Vec<String>,
}

impl OwnLaw {
    /// Reads a law.
    ///
    /// # Errors
    /// Text that is no TOML, unknown or missing keys, values out of range, expressions that mean nothing: with the place.
    pub fn read(text: &str) -> Result<Self, LawError> {
        let File {
            id,
            axle,
            force,
            parameters,
            states,
            words,
        } = file::read(text)?;
        let parameters: Vec<OwnParameter> = (parameters.into_iter())
            .map(|(name, written)| parameter(name, written))
            .collect::<Result<_, _>>()?;
        names(&id, &parameters, states.keys())?;
        let words = words.unwrap_or_else(|| format!("custom law {}", id.replace('_', " ")));
        short("words", &words, MOST_WORDS)?;
        let known: Vec<String> = (MOTION.iter().map(|name| (*name).to_owned()))
            .chain(states.keys().cloned())
            .chain(parameters.iter().map(|p| p.name.clone()))
            .collect();
        let rates: Vec<Expression> = (states.iter())
            .map(|(name, text)| Expression::parse(&format!("states.{name}"), text, &known))
            .collect::<Result<_, _>>()?;
        let force = Expression::parse("force", &force, &known)?;
        let names_of_states = states.into_keys().collect();
        let mut law = Self {
            words,
            acts: axle,
            amplitude: None,
            is_on_body: false,
            force,
            rates,
            names_of_states,
            parameters,
            id,
        };
        law.every_parameter_is_used(&known)?;
        law.is_on_body = ![DEFLECTION, RATE].iter().any(|place| law.speaks_of(*place));
        law.amplitude = (0..law.parameters.len()).find(|q| law.is_linear_in(*q));
        Ok(law)
    }

    fn expressions(&self) -> impl Iterator<Item = &Expression> {
        self.rates.iter().chain([&self.force])
    }

    fn speaks_of(&self, place: usize) -> bool {
        self.expressions().any(|e| e.speaks_of(place))
    }

    fn every_parameter_is_used(&self, known: &[String]) -> Result<(), LawError> {
        let first = known.len() - self.parameters.len();
        let unused = (first..known.len()).find(|place| !self.speaks_of(*place));
        match unused {
            None => Ok(()),
            Some(place) => Err(wrong(
                &format!("parameters.{}", known[place]),
                "is used in no expression, so its value cannot be determined",
            )),
        }
    }

    /// Whether the force has corners or jumps.
    pub fn has_corners(&self) -> bool {
        self.expressions().any(|e| e.has_corners)
    }

    /// What the law asks of a ride.
    pub fn needs(&self) -> Vec<Need> {
        let asked = [
            (SPEED, &[Need::Speed][..]),
            (CRANK, &[Need::Cadence]),
            (WHEEL, &[Need::Speed, Need::WheelRadius]),
        ];
        let asked = asked
            .into_iter()
            .filter(|(place, _)| self.speaks_of(*place));
        asked.flat_map(|(_, needs)| needs.iter().copied()).collect()
    }

    /// The force as it was written, and each state with its rate.
    pub fn written(&self) -> (&str, impl Iterator<Item = (&str, &str)>) {
        let states = self.names_of_states.iter().zip(&self.rates);
        let states = states.map(|(name, rate)| (name.as_str(), rate.written.as_str()));
        (&self.force.written, states)
    }

    pub fn states(&self) -> usize {
        self.rates.len()
    }

    /// Operators and functions of one evaluation.
    pub fn operations(&self) -> usize {
        self.expressions().map(|e| e.operations).sum()
    }

    /// Parameter sets to start a fit from: every start of each with every one of the others.
    pub fn starts(&self) -> Vec<Values> {
        let mut sets = vec![[0.0; MAX_PARAMETERS]];
        for (q, parameter) in self.parameters.iter().enumerate() {
            let with = |set: &Values, start: f64| {
                let mut set = *set;
                set[q] = start;
                set
            };
            sets = (sets.iter())
                .flat_map(|set| parameter.starts.iter().map(move |start| with(set, *start)))
                .collect();
        }
        sets
    }

    /// The force (N).
    #[inline(never)]
    pub fn force(&self, p: &LaneValues, m: &OwnMotion, s: &[Lanes]) -> Lanes {
        self.force.at(&self.values(p, m, s))
    }

    /// Writes the states' rates.
    #[inline(never)]
    pub fn rates(&self, p: &LaneValues, m: &OwnMotion, s: &[Lanes], rates: &mut [Lanes]) {
        let values = self.values(p, m, s);
        for (rate, expression) in rates.iter_mut().zip(&self.rates) {
            *rate = expression.at(&values);
        }
    }

    fn values(&self, p: &LaneValues, m: &OwnMotion, s: &[Lanes]) -> [Lanes; MOST_VALUES] {
        let states = s.iter().take(self.rates.len());
        let mut values = [Lanes::ZERO; MOST_VALUES];
        let known = m.iter().chain(states).chain(p);
        values
            .iter_mut()
            .zip(known)
            .for_each(|(v, known)| *v = *known);
        values
    }

    /// Whether the force grows in proportion to this parameter and the states do not know of it, by its values at
    /// places of no meaning.
    fn is_linear_in(&self, q: usize) -> bool {
        let OwnParameter { range, starts, .. } = &self.parameters[q];
        if !(range[0] <= 0.0 && range[1] >= 0.0) || starts.iter().all(|start| *start == 0.0) {
            return false;
        }
        let place = MOTION.len() + self.rates.len() + q;
        let mut values = [Lanes::ZERO; MOST_VALUES];
        // From a micrometre or so up to metres, so that what is only felt in small motion is felt.
        for (i, value) in values.iter_mut().enumerate() {
            let places = |lane: usize| {
                let odd = 0.7 + 0.13 * ((1 + i) * (1 + lane)) as f64 % 1.0;
                odd * 0.1f64.powi(lane as i32)
            };
            *value = Lanes(std::array::from_fn(places));
        }
        for (i, parameter) in self.parameters.iter().enumerate() {
            values[MOTION.len() + self.rates.len() + i] = Lanes::all(parameter.starts[0]);
        }
        let unit = starts.iter().copied().find(|start| *start != 0.0);
        let by = |factor: f64| {
            let mut values = values;
            values[place] = Lanes::all(factor * unit.unwrap_or(1.0));
            self.force.at(&values)
        };
        let (none, one, two) = (by(0.0), by(1.0), by(2.0));
        let is_linear = |lane: usize| {
            let [none, one, two] = [none, one, two].map(|force| force.0[lane]);
            none == 0.0 && one.is_finite() && (two - 2.0 * one).abs() <= 1e-9 * one.abs()
        };
        (0..LANES).all(is_linear) && !self.rates.iter().any(|e| e.speaks_of(place))
    }
}

fn wrong(field: &str, problem: impl Into<String>) -> LawError {
    LawError::Field {
        field: field.to_owned(),
        problem: problem.into(),
    }
}

fn short(field: &str, text: &str, most: usize) -> Result<(), LawError> {
    let length = text.chars().count();
    if length > most || text.chars().any(char::is_control) {
        let problem = format!("{length} characters, expected at most {most} on one line");
        return Err(wrong(field, problem));
    }
    Ok(())
}

fn parameter(name: String, written: Written) -> Result<OwnParameter, LawError> {
    let field = format!("parameters.{name}");
    let Written { unit, start, range } = written;
    short(&format!("{field}.unit"), &unit, MOST_UNIT)?;
    let [low, high] = range;
    if !(low.is_finite() && high.is_finite() && low < high) {
        return Err(wrong(
            &format!("{field}.range"),
            format!("{low} to {high} is not a range"),
        ));
    }
    let starts: Vec<f64> = match start {
        Start::One(start) => vec![start],
        Start::Several(starts) => starts,
    };
    if starts.is_empty() {
        return Err(wrong(&format!("{field}.start"), "no value to start from"));
    }
    if let Some(start) = starts.iter().find(|start| !(low..=high).contains(*start)) {
        let problem = format!("{start} is outside {low} to {high}");
        return Err(wrong(&format!("{field}.start"), problem));
    }
    Ok(OwnParameter {
        name,
        unit,
        starts,
        range,
    })
}

/// Checks the names and the counts of everything that has one.
fn names<'a>(
    id: &str,
    parameters: &[OwnParameter],
    states: impl ExactSizeIterator<Item = &'a String>,
) -> Result<(), LawError> {
    let count = parameters.len();
    if !(1..=MAX_PARAMETERS).contains(&count) {
        return Err(wrong(
            "parameters",
            format!("{count}, expected 1 to {MAX_PARAMETERS}"),
        ));
    }
    if states.len() > MAX_OWN_STATES {
        return Err(wrong(
            "states",
            format!("{}, expected at most {MAX_OWN_STATES}", states.len()),
        ));
    }
    let starts: usize = parameters.iter().map(|p| p.starts.len()).product();
    if starts > MOST_STARTS {
        let problem = format!("{starts} combinations of starts, expected at most {MOST_STARTS}");
        return Err(wrong("parameters", problem));
    }
    let of_parameters = parameters.iter().map(|p| ("parameters", p.name.as_str()));
    let of_states = states.map(|name| ("states", name.as_str()));
    let mut taken: Vec<&str> = MOTION.into_iter().chain(["pi"]).collect();
    for (field, name) in [("id", id)]
        .into_iter()
        .chain(of_parameters)
        .chain(of_states)
    {
        let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
        if !(name.starts_with(|c: char| c.is_ascii_alphabetic()) && name.chars().all(is_word)) {
            let problem = format!(
                "'{}' is not a name, expected letters, digits and _",
                name.escape_default()
            );
            return Err(wrong(field, problem));
        }
        short(field, name, MOST_NAME)?;
        if field == "id" {
            continue;
        }
        if taken.contains(&name) || grammar::is_function(name) {
            return Err(wrong(
                field,
                format!("'{name}' already has another meaning"),
            ));
        }
        taken.push(name);
    }
    Ok(())
}

#[cfg(test)]
mod tests;
