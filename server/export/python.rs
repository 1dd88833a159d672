//! The identified model as a Python script that simulates it along a ride.

use std::fmt::Write;

use veloid_engine::bicycle::Axle;
use veloid_engine::report::simulation::AxleSimulation;

use super::content::{Content, Kind};
use super::expression::PYTHON;
use super::facts;
use super::fields::{Language, fields};
use super::head;
use super::motion::{Line, Motion};

const IMPORTS: &str = "
import sys
from math import acos, asin, atan, atan2, ceil, cos, cosh, exp, log, pi, sin, sinh, sqrt, tan, tanh

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.linalg import expm
";

const LANGUAGE: Language = Language {
    dialect: &PYTHON,
    quoted,
    truth: ["False", "True"],
    none: "None",
    handle: "",
    first: 0,
    pairs: |pairs| format!("{pairs:?}"),
    turned: "",
};

/// What no ride changes.
const RIDE: [&str; 3] = [
    include_str!("runtime/table.py"),
    include_str!("runtime/lifted.py"),
    include_str!("runtime/axle.py"),
];
const DIAGNOSED: [&str; 2] = [
    include_str!("runtime/road.py"),
    include_str!("runtime/simulation.py"),
];
const PLAIN: &str = include_str!("runtime/plain.py");
const MAIN: &str = include_str!("runtime/main.py");

/// The script; `file` is the ride's name.
pub fn script(content: &Content, file: &str) -> String {
    let mut out = String::new();
    // Writing to a String cannot fail.
    let _ = write(&mut out, content, file);
    out
}

fn write(out: &mut String, content: &Content, file: &str) -> std::fmt::Result {
    let simulation = content.simulation.as_ref();
    for line in head::lines(content, "python veloid_model.py ride.csv") {
        writeln!(out, "{}", format!("# {line}").trim_end())?;
    }
    out.push_str(IMPORTS);
    writeln!(out, "\nFILE = {}", quoted(file))?;
    writeln!(out, "TAKES = {}", quoted(content.takes()))?;
    writeln!(
        out,
        "# Of each channel the column's header, and the factor that makes it SI; others are called by their names."
    )?;
    writeln!(out, "CHANNELS = {{")?;
    for (channel, header, scale) in facts::channels(content) {
        writeln!(out, "    {channel:?}: ({}, {scale:?}),", quoted(header))?;
    }
    writeln!(out, "}}")?;
    writeln!(
        out,
        "# Channels whose mean is taken off.\nCENTRED = {:?}",
        facts::centred(content)
    )?;
    writeln!(out, "NEEDED = {:?}", facts::needed(simulation))?;
    let needs_road = LANGUAGE.truth[usize::from(content.kind == Kind::Roadless)];
    writeln!(out, "NEEDS_ROAD = {needs_road}")?;
    writeln!(
        out,
        "# The model's own ride: the part of its file (s), and its samples."
    )?;
    match content.report.ride.part_s {
        Some([from, to]) => writeln!(out, "PART = ({from:?}, {to:?})")?,
        None => writeln!(out, "PART = None")?,
    }
    writeln!(out, "STEP = {:?}", simulation.step_s)?;
    writeln!(out, "SAMPLES = {}", simulation.samples)?;
    let [from, to] = simulation.held_out;
    writeln!(out, "HELD_OUT = ({from}, {to})")?;
    match &simulation.pitch {
        None => writeln!(out, "PITCH = None")?,
        Some(p) => writeln!(
            out,
            "PITCH = ({:?}, {:?}, {:?}, {:?}, {:?})",
            p.coupling, p.l_front_m, p.l_rear_m, p.mass_front_kg, p.mass_rear_kg
        )?,
    }
    let parts: &[&str] = match content.kind {
        Kind::Diagnosed => {
            for (axle, model) in simulation.axles.iter() {
                functions(out, axle, model)?;
            }
            &DIAGNOSED
        }
        Kind::Plain | Kind::Roadless => &[PLAIN],
    };
    writeln!(out, "\n\nMODELS = {{")?;
    for (axle, model) in simulation.axles.iter() {
        axle_entry(out, content, axle, model)?;
    }
    writeln!(out, "}}")?;
    let parts = RIDE.iter().chain(parts).chain([&MAIN]);
    parts.into_iter().try_for_each(|part| out.write_str(part))
}

/// The functions of one axle.
fn functions(out: &mut String, axle: Axle, model: &AxleSimulation) -> std::fmt::Result {
    let motion = Motion {
        axle: model,
        dialect: &PYTHON,
    };
    writeln!(
        out,
        "\n\ndef {axle}_rates(t, dt, road, slope, push, speed, speed_rate, crank, distance, x):"
    )?;
    writeln!(out, "    {} = x", motion.states().join(", "))?;
    body(out, &motion.lines())?;
    writeln!(
        out,
        "    return acceleration, [{}]",
        motion.rates().join(", ")
    )?;
    let road = motion.road();
    if !road.is_empty() {
        writeln!(out, "\n\ndef {axle}_road(speed, distance):")?;
        writeln!(out, "    shift = half_window = height = height_rate = 0.0")?;
        body(out, &road)?;
        writeln!(out, "    return shift, half_window, height, height_rate")?;
    }
    let sensor = motion.sensor();
    if !sensor.is_empty() {
        writeln!(out, "\n\ndef {axle}_sensor(t):")?;
        writeln!(out, "    delay, gain, offset, lag = 0.0, 1.0, 0.0, 0.0")?;
        body(out, &sensor)?;
        writeln!(out, "    return delay, gain, offset, lag")?;
    }
    Ok(())
}

fn body(out: &mut String, lines: &[Line]) -> std::fmt::Result {
    for line in lines {
        writeln!(out, "    {}", line.text(&PYTHON))?;
    }
    Ok(())
}

fn axle_entry(
    out: &mut String,
    content: &Content,
    axle: Axle,
    model: &AxleSimulation,
) -> std::fmt::Result {
    writeln!(out, "    \"{axle}\": {{")?;
    for (name, value) in fields(content, axle, model, &LANGUAGE) {
        writeln!(out, "        \"{name}\": {value},")?;
    }
    writeln!(out, "    }},")
}

/// A Python string, whatever the text holds.
pub fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars().filter(|c| !c.is_control()) {
        if c == '"' || c == '\\' {
            out.push('\\');
        }
        out.push(c);
    }
    out.push('"');
    out
}

#[cfg(test)]
mod tests {
    use super::quoted;

    #[test]
    fn no_name_leaves_its_quotes() {
        assert_eq!(quoted("a\"); exit(\\\n"), "\"a\\\"); exit(\\\\\"");
    }
}
