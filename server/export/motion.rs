//! The equations of one axle as assignments in the order in which they are computed.

use veloid_engine::report::simulation::{ActingEffect, AxleSimulation, Law, LawState, names};

use super::expression::{Dialect, translated};

/// One line of a script.
#[derive(Clone, Debug, PartialEq)]
pub enum Line {
    Comment(String),
    Set(String, String),
}

impl Line {
    pub fn set(name: impl Into<String>, value: impl Into<String>) -> Self {
        Self::Set(name.into(), value.into())
    }

    pub fn speaks_of(&self, name: &str) -> bool {
        match self {
            Self::Comment(_) => false,
            Self::Set(_, value) => names(value).any(|word| word == name),
        }
    }

    pub fn text(&self, dialect: &Dialect) -> String {
        match self {
            Self::Comment(text) => format!("{} {text}", dialect.comment),
            Self::Set(name, value) => format!("{name} = {value}{}", dialect.end),
        }
    }
}

/// An axle that is written out.
pub struct Motion<'a> {
    pub axle: &'a AxleSimulation,
    pub dialect: &'a Dialect,
}

impl Motion<'_> {
    /// Effects with the numbers that tell their names apart.
    fn effects(&self) -> impl Iterator<Item = (usize, &ActingEffect)> {
        self.axle
            .effects
            .iter()
            .enumerate()
            .map(|(i, e)| (i + 1, e))
    }

    fn write(&self, number: usize, effect: &ActingEffect, text: &str) -> String {
        translated(text, self.dialect, &|name| {
            written_name(number, effect, name)
        })
    }

    /// Names of the states, the mass's first.
    pub fn states(&self) -> Vec<String> {
        let own = self.effects().flat_map(|(number, effect)| {
            let states = effect.law.states.iter();
            states.map(move |state| own_name(number, &state.name))
        });
        let of_mass = ["z", "z_dot"].map(str::to_owned);
        of_mass.into_iter().chain(own).collect()
    }

    /// Where they start.
    pub fn start(&self) -> Vec<f64> {
        let own = self.axle.effects.iter().flat_map(|e| e.initial.clone());
        let of_mass = match self.axle.prescribed {
            true => [0.0; 2],
            false => [self.axle.height_m, self.axle.velocity_m_s],
        };
        of_mass.into_iter().chain(own).collect()
    }

    /// Where they start on another ride: 0 at zero, 1 where the mass is, 2 as fast as it moves. States called `height` and
    /// `velocity` are those of another mass.
    pub fn follows(&self) -> Vec<usize> {
        let of_mass = match self.axle.prescribed {
            true => [0, 0],
            false => [1, 2],
        };
        let states = (self.axle.effects.iter()).flat_map(|effect| &effect.law.states);
        let own = states.map(|state| match state.name.as_str() {
            "height" => 1,
            "velocity" => 2,
            _ => 0,
        });
        of_mass.into_iter().chain(own).collect()
    }

    /// Rates of the states.
    pub fn rates(&self) -> Vec<String> {
        let own = self.effects().flat_map(|(number, effect)| {
            let states = effect.law.states.iter();
            states.map(move |state| format!("{}_rate", own_name(number, &state.name)))
        });
        let of_mass = match self.axle.prescribed {
            true => ["0.0", "0.0"],
            false => ["z_dot", "acceleration"],
        };
        of_mass.map(str::to_owned).into_iter().chain(own).collect()
    }

    /// From road, slope, push and the states to the acceleration and the effects' rates.
    pub fn lines(&self) -> Vec<Line> {
        let axle = self.axle;
        let on_tyre = self.effects().find(|(_, effect)| effect.on_tyre);
        let [height, velocity] = match on_tyre {
            Some((number, effect)) => {
                let name = |q: usize| own_name(number, &effect.law.states[q].name);
                [name(0), name(1)]
            }
            None => ["z", "z_dot"].map(str::to_owned),
        };
        let mut lines = vec![
            Line::set("m", format!("{:?}", axle.mass_kg)),
            Line::set("k", format!("{:?}", axle.k_n_m)),
            Line::set("B", format!("{:?}", axle.b_n_s_m)),
            Line::set("felt_after", if axle.prescribed { "0.0" } else { "dt" }),
            Line::set("d", format!("road - {height} + ({:?})", axle.rest_m)),
            Line::set("w", format!("slope - {velocity}")),
            Line::set("tyre", "k * d + B * w"),
            Line::set(
                "body",
                format!("push + ({:?}) - k * ({:?})", axle.constant_n, axle.rest_m),
            ),
        ];
        for (number, effect) in self.effects() {
            lines.extend(self.forces(number, effect));
        }
        let force = match on_tyre {
            Some(_) => "body / m",
            None => "(tyre + body) / m",
        };
        lines.push(Line::set("acceleration", force));
        for (number, effect) in self.effects() {
            lines.extend(self.moved(number, effect));
        }
        lines
    }

    /// The numbers of an effect, and its forces.
    fn forces(&self, number: usize, effect: &ActingEffect) -> Vec<Line> {
        let law = &effect.law;
        let moving: Vec<&str> = [&law.tyre, &law.body, &law.acceleration]
            .into_iter()
            .chain(law.states.iter().map(|state| &state.rate))
            .map(String::as_str)
            .filter(|text| !text.is_empty())
            .collect();
        if moving.is_empty() {
            return Vec::new();
        }
        let mut lines = vec![Line::Comment(effect.id.clone())];
        lines.extend(numbers(number, effect, &moving));
        for (force, text) in [("tyre", &law.tyre), ("body", &law.body)] {
            if !text.is_empty() {
                let sum = format!("{force} + ({})", self.write(number, effect, text));
                lines.push(Line::set(force, sum));
            }
        }
        lines
    }

    fn moved(&self, number: usize, effect: &ActingEffect) -> Vec<Line> {
        let law = &effect.law;
        let rate = |state: &LawState| {
            let name = format!("{}_rate", own_name(number, &state.name));
            Line::set(name, self.write(number, effect, &state.rate))
        };
        let mut lines: Vec<Line> = law.states.iter().map(rate).collect();
        if !law.acceleration.is_empty() {
            let text = self.write(number, effect, &law.acceleration);
            lines.push(Line::set("acceleration", text));
        }
        lines
    }

    /// How the road is read at a sample; nothing where it is read as it was recorded.
    pub fn road(&self) -> Vec<Line> {
        self.added(&|law| {
            vec![
                ("shift", "+", &law.shift),
                ("half_window", "+", &law.half_window),
                ("height", "+", &law.height),
                ("height_rate", "+", &law.slope),
            ]
        })
    }

    /// How the sensor reads at a sample; nothing where it reads what is there.
    pub fn sensor(&self) -> Vec<Line> {
        self.added(&|law| {
            vec![
                ("delay", "+", &law.delay),
                ("gain", "*", &law.gain),
                ("offset", "+", &law.offset),
                ("lag", "+", &law.lag),
            ]
        })
    }

    fn added<'l>(
        &'l self,
        hooks: &dyn Fn(&'l Law) -> Vec<(&'static str, &'static str, &'l String)>,
    ) -> Vec<Line> {
        let mut lines = Vec::new();
        for (number, effect) in self.effects() {
            let mut hooks = hooks(&effect.law);
            hooks.retain(|(_, _, text)| !text.is_empty());
            if hooks.is_empty() {
                continue;
            }
            lines.push(Line::Comment(effect.id.clone()));
            let texts: Vec<&str> = hooks.iter().map(|(_, _, text)| text.as_str()).collect();
            lines.extend(numbers(number, effect, &texts));
            for (name, operator, text) in hooks {
                let text = self.write(number, effect, text);
                lines.push(Line::set(name, format!("{name} {operator} ({text})")));
            }
        }
        lines
    }
}

/// The numbers of an effect that these expressions speak of.
fn numbers(number: usize, effect: &ActingEffect, texts: &[&str]) -> Vec<Line> {
    let spoken = |name: &str| texts.iter().any(|text| names(text).any(|n| n == name));
    let mut lines = Vec::new();
    for (name, value) in &effect.numbers {
        let for_wheel = name == "wheel_radius" && spoken("wheel");
        if spoken(name) || for_wheel {
            lines.push(Line::set(own_name(number, name), format!("{value:?}")));
        }
        if for_wheel {
            let radius = own_name(number, name);
            lines.push(Line::set("wheel", format!("distance / {radius}")));
        }
    }
    lines
}

/// A name in an effect's law as the script has it: its own are apart from those of other effects and from the language's words.
fn written_name(number: usize, effect: &ActingEffect, name: &str) -> String {
    let is_state = effect.law.states.iter().any(|state| state.name == name);
    match is_state || effect.numbers.contains_key(name) {
        true => own_name(number, name),
        false => name.to_owned(),
    }
}

fn own_name(number: usize, name: &str) -> String {
    format!("{name}_{number}")
}

/// What is unknown of the start on another ride, as numbers of height, velocity and constant force.
pub fn free(axle: &AxleSimulation) -> Vec<usize> {
    match (axle.prescribed, axle.force || !axle.road) {
        (true, _) => vec![2],
        (false, true) => vec![0, 1, 2],
        (false, false) => vec![0, 1],
    }
}

/// How much of another ride the start is fitted to (s); none where the axle never forgets it: all of the ride. As `veloid validate` does.
pub fn start_s(axle: &AxleSimulation) -> Option<f64> {
    let swings = axle.mass_kg > 0.0 && axle.k_n_m > 0.0;
    let is_driven = axle.road || axle.force || axle.prescribed;
    let period = || std::f64::consts::TAU * (axle.mass_kg / axle.k_n_m).sqrt();
    match (axle.prescribed || swings) && is_driven {
        false => None,
        true if swings && free(axle).contains(&2) => Some((2.0 * period()).max(1.0)),
        true => Some(1.0),
    }
}

/// The stiffness (N/m) by which a constant force moves the place from which laws count; 0 where they count from the road.
pub fn rests_on(axle: &AxleSimulation) -> f64 {
    if axle.rest_m == 0.0 { 0.0 } else { axle.k_n_m }
}
