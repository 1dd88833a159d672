//! What a script knows of an axle, as texts of its language.

use veloid_engine::bicycle::Axle;
use veloid_engine::report::simulation::AxleSimulation;

use super::content::{Content, Kind};
use super::expression::Dialect;
use super::motion::{Line, Motion, free, rests_on, start_s};

/// How a language writes values.
pub struct Language {
    pub dialect: &'static Dialect,
    pub quoted: fn(&str) -> String,
    pub truth: [&'static str; 2],
    /// What is not there.
    pub none: &'static str,
    /// What stands before the name of a function that is not called.
    pub handle: &'static str,
    /// Number of the first of several.
    pub first: usize,
    /// Pairs of numbers.
    pub pairs: fn(&[[usize; 2]]) -> String,
    /// Turns a row of numbers into what a start is.
    pub turned: &'static str,
}

/// The axle's fields by their names.
pub fn fields(
    content: &Content,
    axle: Axle,
    model: &AxleSimulation,
    language: &Language,
) -> Vec<(&'static str, String)> {
    let Language { none, handle, .. } = language;
    let truth = |yes: bool| language.truth[usize::from(yes)].to_owned();
    let known = |number: Option<f64>| number.map_or((*none).to_owned(), |x| format!("{x:?}"));
    let numbered: Vec<usize> = free(model).iter().map(|q| q + language.first).collect();
    let mut fields = vec![
        ("report", (language.quoted)(&content.reported(axle))),
        ("prescribed", truth(model.prescribed)),
        ("road", truth(model.road)),
        ("force", truth(model.force)),
        ("left_out", (language.pairs)(&model.left_out)),
        ("free", format!("{numbered:?}")),
        ("start_s", known(start_s(model))),
    ];
    if content.kind != Kind::Diagnosed {
        let plain = [model.mass_kg, model.k_n_m, model.b_n_s_m];
        fields.push(("plain", format!("{plain:?}")));
        fields.push(("error", known(content.error(axle))));
        return fields;
    }
    let motion = Motion {
        axle: model,
        dialect: language.dialect,
    };
    let function = |lines: Vec<Line>, name: &str| match lines.is_empty() {
        true => (*none).to_owned(),
        false => format!("{handle}{axle}_{name}"),
    };
    fields.extend([
        ("measured_rms", known(Some(model.measured_rms))),
        ("start", format!("{:?}{}", motion.start(), language.turned)),
        ("follows", format!("{:?}", motion.follows())),
        ("rests_on", format!("{:?}", rests_on(model))),
        ("steps", model.steps.to_string()),
        ("rates", format!("{handle}{axle}_rates")),
        ("read_road", function(motion.road(), "road")),
        ("sensor", function(motion.sensor(), "sensor")),
    ]);
    fields
}
