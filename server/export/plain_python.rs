//! The plain model as a Python script that simulates it along the ride: what a report without a model of the diagnosis has.

use std::fmt::Write;

use veloid_engine::report::Report;

use super::head;
use super::plain::Plain;
use super::python::{channels, quoted};

const IMPORTS: &str = "
import sys

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.linalg import expm
";

/// The columns of a road that the user gives.
const ROAD: &str = r#"CHANNELS = {name: (name, 1.0) for name in ("t", "u_f", "u_r")}
PART = None
"#;

/// What no ride changes.
const RUNTIME: [&str; 3] = [
    include_str!("runtime/table.py"),
    include_str!("runtime/lifted.py"),
    include_str!("runtime/plain.py"),
];

/// The script; `file` is the ride's name.
pub fn script(report: &Report, plain: &Plain, file: &str) -> String {
    let mut out = String::new();
    // Writing to a String cannot fail.
    let _ = write(&mut out, report, plain, file);
    out
}

fn write(out: &mut String, report: &Report, plain: &Plain, file: &str) -> std::fmt::Result {
    let lines = match plain.needs_a_road {
        true => head::roadless_lines(report, "python veloid_model.py road.csv", plain.input()),
        false => head::plain_lines(report, "python veloid_model.py ride.csv"),
    };
    for line in lines {
        writeln!(out, "# {line}")?;
    }
    out.push_str(IMPORTS);
    writeln!(out, "\nFILE = {}", quoted(file))?;
    writeln!(out, "AS_READ = {}", quoted(plain.input()))?;
    match plain.needs_a_road {
        true => out.write_str(ROAD)?,
        false => channels(out, report)?,
    }
    writeln!(out, "# Axle, mass (kg), stiffness (N/m), damping (N s/m).")?;
    writeln!(out, "AXLES = [")?;
    for (axle, e) in plain.axles.iter() {
        writeln!(
            out,
            "    (\"{axle}\", {:?}, {:?}, {:?}),",
            e.mass_kg, e.k_n_m, e.b_n_s_m
        )?;
    }
    writeln!(out, "]")?;
    RUNTIME.iter().try_for_each(|part| out.write_str(part))
}
