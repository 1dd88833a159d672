//! The identified model as a Python script that simulates it along the ride.

use std::fmt::Write;

use veloid_engine::bicycle::Axle;
use veloid_engine::report::Report;
use veloid_engine::report::simulation::{AxleSimulation, Simulation};

use super::expression::PYTHON;
use super::facts::{self, AS_READ};
use super::head;
use super::motion::{Line, Motion};

const IMPORTS: &str = "
import sys
from math import acos, asin, atan, atan2, cos, cosh, exp, log, pi, sin, sinh, sqrt, tan, tanh

import numpy as np
from scipy.interpolate import CubicSpline
";

/// What no ride changes.
const RUNTIME: [&str; 4] = [
    include_str!("runtime/table.py"),
    include_str!("runtime/lifted.py"),
    include_str!("runtime/ride.py"),
    include_str!("runtime/simulation.py"),
];

/// The script; `file` is the ride's name.
pub fn script(report: &Report, simulation: &Simulation, file: &str) -> String {
    let mut out = String::new();
    // Writing to a String cannot fail.
    let _ = write(&mut out, report, simulation, file);
    out
}

fn write(
    out: &mut String,
    report: &Report,
    simulation: &Simulation,
    file: &str,
) -> std::fmt::Result {
    for line in head::lines(report, "python veloid_model.py ride.csv") {
        writeln!(out, "{}", format!("# {line}").trim_end())?;
    }
    out.push_str(IMPORTS);
    writeln!(out, "\nFILE = {}", quoted(file))?;
    writeln!(out, "AS_READ = {}", quoted(AS_READ))?;
    channels(out, report)?;
    let centred: Vec<&str> = facts::deflections(report).map(|(z, _)| z).collect();
    writeln!(
        out,
        "# Channels whose mean is taken off.\nCENTRED = {centred:?}"
    )?;
    let names: Vec<String> = (facts::needed(simulation).iter())
        .map(|name| quoted(name))
        .collect();
    writeln!(out, "NEEDED = [{}]", names.join(", "))?;
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
    for (axle, model) in simulation.axles.iter() {
        functions(out, axle, model)?;
    }
    writeln!(out, "\n\nMODELS = {{")?;
    for (axle, model) in simulation.axles.iter() {
        axle_entry(out, report, axle, model)?;
    }
    writeln!(out, "}}")?;
    RUNTIME.iter().try_for_each(|part| out.write_str(part))
}

/// The columns of the ride's file, and the part of it that was used.
pub fn channels(out: &mut String, report: &Report) -> std::fmt::Result {
    writeln!(
        out,
        "# Of each channel the column's header, and the factor that makes it SI."
    )?;
    writeln!(out, "CHANNELS = {{")?;
    for (channel, header, scale) in facts::channels(report) {
        writeln!(out, "    {channel:?}: ({}, {scale:?}),", quoted(header))?;
    }
    writeln!(out, "}}")?;
    match report.ride.part_s {
        Some([from, to]) => writeln!(out, "PART = ({from:?}, {to:?})"),
        None => writeln!(out, "PART = None"),
    }
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
    report: &Report,
    axle: Axle,
    model: &AxleSimulation,
) -> std::fmt::Result {
    let motion = Motion {
        axle: model,
        dialect: &PYTHON,
    };
    let truth = |yes: bool| if yes { "True" } else { "False" };
    let function = |lines: Vec<Line>, name: &str| match lines.is_empty() {
        true => "None".to_owned(),
        false => format!("{axle}_{name}"),
    };
    writeln!(out, "    \"{axle}\": {{")?;
    writeln!(
        out,
        "        \"report\": {},",
        quoted(&facts::reported(report, axle))
    )?;
    writeln!(out, "        \"prescribed\": {},", truth(model.prescribed))?;
    writeln!(out, "        \"road\": {},", truth(model.road))?;
    writeln!(out, "        \"force\": {},", truth(model.force))?;
    writeln!(out, "        \"start\": {:?},", motion.start())?;
    writeln!(out, "        \"steps\": {},", model.steps)?;
    writeln!(out, "        \"rates\": {axle}_rates,")?;
    writeln!(
        out,
        "        \"read_road\": {},",
        function(motion.road(), "road")
    )?;
    writeln!(
        out,
        "        \"sensor\": {},",
        function(motion.sensor(), "sensor")
    )?;
    writeln!(out, "        \"left_out\": {:?},", model.left_out)?;
    writeln!(out, "        \"measured_rms\": {:?},", model.measured_rms)?;
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
