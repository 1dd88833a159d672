//! The identified model as a script for MATLAB and Octave that simulates it along a ride.

use std::fmt::Write;

use veloid_engine::bicycle::Axle;
use veloid_engine::report::simulation::AxleSimulation;

use super::content::{Content, Kind};
use super::expression::MATLAB;
use super::facts;
use super::fields::{Language, fields};
use super::head;
use super::motion::{Line, Motion};

const LANGUAGE: Language = Language {
    dialect: &MATLAB,
    quoted,
    truth: ["false", "true"],
    none: "[]",
    handle: "@",
    first: 1,
    pairs: |pairs| {
        let rows: Vec<String> = pairs
            .iter()
            .map(|[from, to]| format!("{from}, {to}"))
            .collect();
        format!("[{}]", rows.join("; "))
    },
    turned: "'",
};

/// What no ride changes.
const RIDE: [&str; 4] = [
    include_str!("runtime/main.m"),
    include_str!("runtime/table.m"),
    include_str!("runtime/lifted.m"),
    include_str!("runtime/axle.m"),
];
const DIAGNOSED: [&str; 2] = [
    include_str!("runtime/road.m"),
    include_str!("runtime/simulation.m"),
];
const PLAIN: &str = include_str!("runtime/plain.m");

/// What stands in the column of inputs, in its order.
const INPUTS: [&str; 8] = [
    "t",
    "road",
    "slope",
    "push",
    "speed",
    "speed_rate",
    "crank",
    "distance",
];

/// The script; `file` is the ride's name.
pub fn script(content: &Content, file: &str) -> String {
    let mut out = String::new();
    // Writing to a String cannot fail.
    let _ = write(&mut out, content, file);
    out
}

fn write(out: &mut String, content: &Content, file: &str) -> std::fmt::Result {
    let simulation = content.simulation.as_ref();
    writeln!(out, "function [t, z] = veloid_model(file)")?;
    for line in head::lines(content, "[t, z] = veloid_model('ride.csv')") {
        writeln!(out, "{}", format!("% {line}").trim_end())?;
    }
    writeln!(
        out,
        "% z holds one column per axle (m; N where a rig prescribes the motion)."
    )?;
    writeln!(out, "  if nargin < 1, file = {}; end", quoted(file))?;
    writeln!(out, "  model.takes = {};", quoted(content.takes()))?;
    writeln!(
        out,
        "  % Of each channel the column's header, and the factor that makes it SI; others are called by their names."
    )?;
    writeln!(out, "  model.channels = cell(0, 3);")?;
    for (channel, header, scale) in facts::channels(content) {
        writeln!(
            out,
            "  model.channels(end + 1, :) = {{{}, {}, {scale:?}}};",
            quoted(&channel),
            quoted(header)
        )?;
    }
    writeln!(out, "  % Channels whose mean is taken off.")?;
    writeln!(out, "  model.centred = {};", list(&facts::centred(content)))?;
    writeln!(
        out,
        "  model.needed = {};",
        list(&facts::needed(simulation))
    )?;
    writeln!(
        out,
        "  model.needs_road = {};",
        content.kind == Kind::Roadless
    )?;
    let part = content.report.ride.part_s;
    let part = part.map_or_else(Vec::new, |part| part.to_vec());
    writeln!(
        out,
        "  % The model's own ride: the part of its file (s), and its samples."
    )?;
    writeln!(out, "  model.part = {part:?};")?;
    writeln!(out, "  model.step = {:?};", simulation.step_s)?;
    writeln!(out, "  model.samples = {};", simulation.samples)?;
    writeln!(out, "  model.held_out = {:?};", simulation.held_out)?;
    let pitch = simulation.pitch.as_ref().map_or_else(Vec::new, |p| {
        vec![
            p.coupling,
            p.l_front_m,
            p.l_rear_m,
            p.mass_front_kg,
            p.mass_rear_kg,
        ]
    });
    writeln!(out, "  model.pitch = {pitch:?};")?;
    writeln!(
        out,
        "  % How often the start is improved, each time to the square of its relative error; the plain model is linear."
    )?;
    let rounds = if content.kind == Kind::Diagnosed {
        4
    } else {
        1
    };
    writeln!(out, "  model.rounds = {rounds};")?;
    writeln!(out, "  model.axles = {{}};")?;
    for (axle, model) in simulation.axles.iter() {
        axle_lines(out, content, axle, model)?;
    }
    writeln!(out, "  [t, z] = run_model(model, file);")?;
    writeln!(
        out,
        "  if nargout == 0, plot(t, z); xlabel('time (s)'); ylabel('displacement (m)'); clear t z; end"
    )?;
    writeln!(out, "end")?;
    let parts: &[&str] = match content.kind {
        Kind::Diagnosed => {
            for (axle, model) in simulation.axles.iter() {
                functions(out, axle, model)?;
            }
            &DIAGNOSED
        }
        Kind::Plain | Kind::Roadless => &[PLAIN],
    };
    let parts = RIDE.iter().chain(parts);
    parts.into_iter().try_for_each(|part| out.write_str(part))
}

/// Texts as a cell array.
fn list(texts: &[impl AsRef<str>]) -> String {
    let texts: Vec<String> = texts.iter().map(|text| quoted(text.as_ref())).collect();
    format!("{{{}}}", texts.join(", "))
}

fn axle_lines(
    out: &mut String,
    content: &Content,
    axle: Axle,
    model: &AxleSimulation,
) -> std::fmt::Result {
    writeln!(out, "  axle = struct('name', '{axle}');")?;
    for (name, value) in fields(content, axle, model, &LANGUAGE) {
        writeln!(out, "  axle.{name} = {value};")?;
    }
    writeln!(out, "  model.axles{{end + 1}} = axle;")
}

/// The functions of one axle.
fn functions(out: &mut String, axle: Axle, model: &AxleSimulation) -> std::fmt::Result {
    let motion = Motion {
        axle: model,
        dialect: &MATLAB,
    };
    writeln!(
        out,
        "\nfunction [acceleration, r] = {axle}_rates(dt, in, x)"
    )?;
    let lines = motion.lines();
    for (i, name) in INPUTS.iter().enumerate() {
        if lines.iter().any(|line| line.speaks_of(name)) {
            writeln!(out, "  {name} = in({});", i + 1)?;
        }
    }
    for (i, name) in motion.states().iter().enumerate() {
        writeln!(out, "  {name} = x({});", i + 1)?;
    }
    body(out, &lines)?;
    writeln!(out, "  r = [{}];\nend", motion.rates().join("; "))?;
    let road = motion.road();
    if !road.is_empty() {
        writeln!(
            out,
            "\nfunction [shift, half_window, height, height_rate] = {axle}_road(speed, distance)"
        )?;
        writeln!(
            out,
            "  shift = 0; half_window = 0; height = 0; height_rate = 0;"
        )?;
        body(out, &road)?;
        writeln!(out, "end")?;
    }
    let sensor = motion.sensor();
    if !sensor.is_empty() {
        writeln!(
            out,
            "\nfunction [delay, gain, offset, lag] = {axle}_sensor(t)"
        )?;
        writeln!(out, "  delay = 0; gain = 1; offset = 0; lag = 0;")?;
        body(out, &sensor)?;
        writeln!(out, "end")?;
    }
    Ok(())
}

fn body(out: &mut String, lines: &[Line]) -> std::fmt::Result {
    for line in lines {
        writeln!(out, "  {}", line.text(&MATLAB))?;
    }
    Ok(())
}

/// A MATLAB string, whatever the text holds.
pub fn quoted(text: &str) -> String {
    let plain: String = text.chars().filter(|c| !c.is_control()).collect();
    format!("'{}'", plain.replace('\'', "''"))
}

#[cfg(test)]
mod tests {
    use super::quoted;

    #[test]
    fn no_name_leaves_its_quotes() {
        assert_eq!(quoted("a'); system('x\n"), "'a''); system(''x'");
    }
}
