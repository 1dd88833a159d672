//! The identified model as a script for MATLAB and Octave that simulates it along the ride.

use std::fmt::Write;

use veloid_engine::bicycle::Axle;
use veloid_engine::report::Report;
use veloid_engine::report::simulation::{AxleSimulation, Simulation};

use super::expression::MATLAB;
use super::facts::{self, AS_READ};
use super::head;
use super::motion::{Line, Motion};
use super::plain_matlab::quoted;

/// What no ride changes.
const RUNTIME: [&str; 3] = [
    include_str!("runtime/lifted.m"),
    include_str!("runtime/ride.m"),
    include_str!("runtime/simulation.m"),
];

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
    writeln!(out, "function [t, z] = veloid_model(file)")?;
    for line in head::lines(report, "[t, z] = veloid_model('ride.csv')") {
        writeln!(out, "{}", format!("% {line}").trim_end())?;
    }
    writeln!(
        out,
        "% The file is a CSV with commas and one header line; z holds one column per axle (m; N where a rig prescribes the motion)."
    )?;
    writeln!(out, "  if nargin < 1, file = {}; end", quoted(file))?;
    writeln!(out, "  ride = importdata(file, ',', 1);")?;
    writeln!(out, "  ride.headers = strtrim(ride.colheaders);")?;
    writeln!(out, "  ride.as_read = {};", quoted(AS_READ))?;
    writeln!(
        out,
        "  % Of each channel the column's header, and the factor that makes it SI."
    )?;
    writeln!(out, "  ride.channels = cell(0, 3);")?;
    for (channel, header, scale) in facts::channels(report) {
        writeln!(
            out,
            "  ride.channels(end + 1, :) = {{{}, {}, {scale:?}}};",
            quoted(&channel),
            quoted(header)
        )?;
    }
    let centred: Vec<String> = facts::deflections(report).map(|(z, _)| quoted(z)).collect();
    writeln!(out, "  % Channels whose mean is taken off.")?;
    writeln!(out, "  ride.centred = {{{}}};", centred.join(", "))?;
    let part = report
        .ride
        .part_s
        .map_or_else(Vec::new, |part| part.to_vec());
    writeln!(out, "  ride.part = {part:?};")?;
    writeln!(out, "  ride.step = {:?};", simulation.step_s)?;
    writeln!(out, "  ride.samples = {};", simulation.samples)?;
    writeln!(out, "  ride.held_out = {:?};", simulation.held_out)?;
    let pitch = simulation.pitch.as_ref().map_or_else(Vec::new, |p| {
        vec![
            p.coupling,
            p.l_front_m,
            p.l_rear_m,
            p.mass_front_kg,
            p.mass_rear_kg,
        ]
    });
    writeln!(out, "  ride.pitch = {pitch:?};")?;
    let needed: Vec<String> = (facts::needed(simulation).iter())
        .map(|name| quoted(name))
        .collect();
    writeln!(out, "  ride = completed(ride, {{{}}});", needed.join(", "))?;
    writeln!(out, "  axles = {{}};")?;
    for (axle, model) in simulation.axles.iter() {
        axle_lines(out, report, axle, model)?;
    }
    out.write_str(MAIN)?;
    for (axle, model) in simulation.axles.iter() {
        functions(out, axle, model)?;
    }
    RUNTIME.iter().try_for_each(|part| out.write_str(part))
}

const MAIN: &str = "  groups = num2cell(1:numel(axles));
  if ~isempty(ride.pitch), groups = {1:numel(axles)}; end
  t = ride.t;
  z = zeros(ride.samples, numel(axles));
  for group = groups
    motions = simulate(ride, axles(group{1}));
    for q = 1:numel(group{1})
      a = group{1}(q);
      axle = axles{a};
      z(:, a) = sensed(ride, axle, motions{q});
      left = axle.measured - z(:, a);
      unit = 'm';
      if axle.prescribed, unit = 'N'; end
      fprintf('%s: held-out error %.6g %s, %s\\n', axle.name, sqrt(mean(left(axle.counts) .^ 2)), unit, axle.report);
    end
  end
  if nargout == 0, plot(t, z); xlabel('time (s)'); ylabel('displacement (m)'); clear t z; end
end
";

fn axle_lines(
    out: &mut String,
    report: &Report,
    axle: Axle,
    model: &AxleSimulation,
) -> std::fmt::Result {
    let motion = Motion {
        axle: model,
        dialect: &MATLAB,
    };
    let function = |lines: Vec<Line>, name: &str| match lines.is_empty() {
        true => "[]".to_owned(),
        false => format!("@{axle}_{name}"),
    };
    let left_out: Vec<String> = (model.left_out.iter())
        .map(|[from, to]| format!("{from}, {to}"))
        .collect();
    writeln!(
        out,
        "  axle = struct('name', '{axle}', 'report', {});",
        quoted(&facts::reported(report, axle))
    )?;
    writeln!(out, "  axle.prescribed = {};", model.prescribed)?;
    writeln!(out, "  axle.road = {};", model.road)?;
    writeln!(out, "  axle.force = {};", model.force)?;
    writeln!(out, "  axle.start = {:?}';", motion.start())?;
    writeln!(out, "  axle.steps = {};", model.steps)?;
    writeln!(out, "  axle.rates = @{axle}_rates;")?;
    writeln!(
        out,
        "  axle.read_road = {};",
        function(motion.road(), "road")
    )?;
    writeln!(
        out,
        "  axle.sensor = {};",
        function(motion.sensor(), "sensor")
    )?;
    writeln!(out, "  axle.left_out = [{}];", left_out.join("; "))?;
    writeln!(out, "  axle.measured_rms = {:?};", model.measured_rms)?;
    writeln!(out, "  axles{{end + 1}} = with_inputs(ride, axle);")
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
