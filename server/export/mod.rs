//! The identified model in other languages, to run and to read.

mod content;
mod expression;
mod facts;
mod fields;
mod format;
mod head;
mod matlab;
mod motion;
mod python;
mod table;

use veloid_engine::report::Report;

use content::Content;

pub use content::NoModel;
pub use format::Format;
pub use table::table;
pub use veloid_engine::report::IdentifiedModel;

/// The model as a script for MATLAB and Octave; `file` is the ride's name. The plain model alone where no diagnosis has left another.
pub fn matlab(report: &Report, file: &str) -> Result<String, NoModel> {
    Ok(matlab::script(&Content::of(report)?, file))
}

/// The same in Python.
pub fn python(report: &Report, file: &str) -> Result<String, NoModel> {
    Ok(python::script(&Content::of(report)?, file))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use veloid_engine::bicycle::PerAxle;
    use veloid_engine::diagnosis::effects::catalogue::catalogue;
    use veloid_engine::report::simulation::{ActingEffect, AxleSimulation, Simulation, names};

    use super::expression::{MATLAB, PYTHON};
    use super::facts;
    use super::motion::{Line, Motion};

    /// Effects that scripts simulate by equations of their own, in `coupled` and `rates`.
    const ON_BOTH_AXLES: [&str; 1] = ["pitch_coupling"];

    /// An axle with one effect, every number of which is 2.
    fn axle(effect: ActingEffect) -> AxleSimulation {
        AxleSimulation {
            prescribed: false,
            mass_kg: 20.0,
            k_n_m: 1e5,
            b_n_s_m: 1e3,
            constant_n: 0.0,
            rest_m: 0.0,
            height_m: 0.0,
            velocity_m_s: 0.0,
            steps: 1,
            road: true,
            force: false,
            effects: vec![effect],
            left_out: Vec::new(),
            measured_rms: 1.0,
        }
    }

    /// What scripts know without an effect.
    const KNOWN: [&str; 30] = [
        "d",
        "w",
        "z",
        "z_dot",
        "speed",
        "t",
        "crank",
        "pi",
        "k",
        "B",
        "m",
        "tyre",
        "acceleration",
        "speed_rate",
        "distance",
        "dt",
        "felt_after",
        "abs",
        "sign",
        "step",
        "sqrt",
        "exp",
        "sin",
        "cos",
        "min",
        "max",
        "ln",
        "wheel",
        "body",
        "road",
    ];

    #[test]
    fn every_effect_is_in_the_scripts() {
        for entry in catalogue() {
            let law = entry.written;
            let own = law
                .expressions()
                .flat_map(names)
                .filter(|name| !KNOWN.contains(name));
            let numbers = own.filter(|name| law.states.iter().all(|state| state.name != *name));
            let numbers = numbers.map(|name| (name.to_owned(), 2.0)).collect();
            let is_written = law.expressions().next().is_some();
            assert_eq!(
                is_written,
                !ON_BOTH_AXLES.contains(&entry.id),
                "{}",
                entry.id
            );
            let axle = axle(ActingEffect {
                id: entry.id.to_owned(),
                numbers,
                initial: vec![0.0; law.states.len()],
                on_tyre: entry.id == "unsprung_mass",
                law,
            });
            for dialect in [&PYTHON, &MATLAB] {
                let motion = Motion {
                    axle: &axle,
                    dialect,
                };
                let lines = [motion.lines(), motion.road(), motion.sensor()].concat();
                let comment = Line::Comment(entry.id.to_owned());
                assert_eq!(lines.contains(&comment), is_written, "{}", entry.id);
                // Of what has states, a second mass alone starts with the axle.
                let is_mass = entry.id.ends_with("_mass");
                let own = motion.follows().split_off(2);
                assert!(own.iter().all(|of| (*of > 0) == is_mass), "{}", entry.id);
            }
        }
    }

    #[test]
    fn the_rate_of_the_speed_is_asked_of_the_table_alone() {
        let transfer = catalogue()
            .into_iter()
            .find(|e| e.id == "load_transfer")
            .unwrap();
        let effect = ActingEffect {
            id: "load_transfer".to_owned(),
            numbers: [("cog_height", 1.0), ("lift", 30.0)]
                .map(|(n, v)| (n.to_owned(), v))
                .into(),
            law: transfer.written,
            initial: Vec::new(),
            on_tyre: false,
        };
        let simulation = Simulation {
            step_s: 0.01,
            samples: 100,
            held_out: [60, 100],
            axles: PerAxle {
                front: Some(axle(effect)),
                rear: None,
            },
            pitch: None,
        };
        assert_eq!(facts::needed(&simulation), ["speed_rate"]);
    }
}
