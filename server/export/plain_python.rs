//! The plain model as a Python script that simulates it along the ride: what a report without a model of the diagnosis has.

use std::fmt::Write;

use veloid_engine::report::Report;

use super::facts::AS_READ;
use super::head;
use super::python::{channels, quoted};

const IMPORTS: &str = "
import sys

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.linalg import expm
";

/// What no ride changes.
const RUNTIME: [&str; 3] = [
    include_str!("runtime/table.py"),
    include_str!("runtime/lifted.py"),
    include_str!("runtime/plain.py"),
];

/// The script; `file` is the ride's name.
pub fn script(report: &Report, file: &str) -> String {
    let mut out = String::new();
    // Writing to a String cannot fail.
    let _ = write(&mut out, report, file);
    out
}

fn write(out: &mut String, report: &Report, file: &str) -> std::fmt::Result {
    for line in head::plain_lines(report, "python veloid_model.py ride.csv") {
        writeln!(out, "# {line}")?;
    }
    out.push_str(IMPORTS);
    writeln!(out, "\nFILE = {}", quoted(file))?;
    writeln!(out, "AS_READ = {}", quoted(AS_READ))?;
    channels(out, report)?;
    writeln!(out, "# Axle, mass (kg), stiffness (N/m), damping (N s/m).")?;
    writeln!(out, "AXLES = [")?;
    for (axle, e) in report.output_error.iter() {
        writeln!(
            out,
            "    (\"{axle}\", {:?}, {:?}, {:?}),",
            e.mass_kg, e.k_n_m, e.b_n_s_m
        )?;
    }
    writeln!(out, "]")?;
    RUNTIME.iter().try_for_each(|part| out.write_str(part))
}
