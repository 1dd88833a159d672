//! The plain model as a script for MATLAB and Octave that simulates it along the ride: what a report without a model of the
//! diagnosis has.

use std::fmt::Write;

use veloid_engine::bicycle::Axle;
use veloid_engine::report::diagnosis::Diagnosis;
use veloid_engine::report::{Estimate, Report};

use super::head;
use super::plain::Plain;

/// What does not depend on the ride: the exact solution for inputs that are cubic splines.
const SIMULATE: &str = "
function z = simulate(t, u, F, zm, m, k, B, rest_point)
  % m z'' = k (u - z) + B (u' - z') + F, exact for cubic splines u and F: on every interval the
  % spline's derivatives are states of their own.
  h = t(2) - t(1);
  A = [0 1; -k/m -B/m];
  N = diag(ones(3, 1), 1);
  road = expm(h * [A, [0 0 0 0; k/m B/m 0 0]; zeros(4, 2), N]);
  push = expm(h * [A, [0 0 0 0; 1/m 0 0 0]; zeros(4, 2), N]);
  x = zeros(2, numel(t));
  free = zeros(2, numel(t), 3);
  free(1, 1, 1) = 1;
  free(2, 1, 2) = 1;
  Au = derivatives(t, lifted(u));
  AF = derivatives(t, lifted(F));
  step = expm(h * [A, [0; 1]; 0 0 0]);
  for i = 1:numel(t) - 1
    x(:, i + 1) = road(1:2, :) * [x(:, i); Au(:, i)] + push(1:2, 3:6) * AF(:, i);
    for j = 1:3
      free(:, i + 1, j) = step(1:2, 1:2) * free(:, i, j) + (j == 3) * step(1:2, 3);
    end
  end
  if isempty(zm)
    % From rest on the road.
    z = x(1, :)' + u(1) * free(1, :, 1)';
    return
  end
  % The initial state, and on a shaker the rest point, that suit the measurement best.
  G = squeeze(free(1, :, 1:2 + rest_point));
  z = x(1, :)' + G * (G \\ (zm - x(1, :)'));
end

function F = answer(t, d, Fm, k, B)
  % F = k d + B d' + c to the deflection d that a rig prescribes, by its cubic spline; c, and whether the force was logged as
  % a reaction, suit the measurement.
  if sum(diff(d) .* (Fm(1:end - 1) + Fm(2:end))) < 0, Fm = -Fm; end
  [at, c] = unmkpp(spline(t, d));
  F = k * d + B * ppval(mkpp(at, [3 * c(:, 1), 2 * c(:, 2), c(:, 3)]), t);
  F = F + mean(Fm - F);
end

function D = derivatives(t, y)
  c = ppval_coefficients(spline(t, y));
  D = [c(:, 4), c(:, 3), 2 * c(:, 2), 6 * c(:, 1)]';
end

function c = ppval_coefficients(pp)
  [~, c] = unmkpp(pp);
end
";

/// The script; `file` is the ride's name.
pub fn script(report: &Report, plain: &Plain, file: &str) -> String {
    let mut out = String::new();
    // Writing to a String cannot fail.
    let _ = match plain.needs_a_road {
        true => on_a_road(&mut out, report, plain),
        false => write(&mut out, report, file),
    };
    out
}

/// A function that simulates on a road that the user gives.
fn on_a_road(out: &mut String, report: &Report, plain: &Plain) -> std::fmt::Result {
    writeln!(out, "function [t, z] = veloid_model(file)")?;
    let call = "[t, z] = veloid_model('road.csv')";
    for line in head::roadless_lines(report, call, plain.input()) {
        writeln!(out, "% {line}")?;
    }
    let needs = quoted(&format!("This needs {}.", plain.input()));
    writeln!(out, "  if nargin < 1, error({needs}); end")?;
    writeln!(out, "  ride = importdata(file, ',', 1);")?;
    writeln!(
        out,
        "  column = @(name) ride.data(:, strcmp(strtrim(ride.colheaders), name));"
    )?;
    writeln!(out, "  t = column('t');")?;
    writeln!(out, "  z = [];")?;
    for (axle, e) in plain.axles.iter() {
        let road = match axle {
            Axle::Front => "u_f",
            Axle::Rear => "u_r",
        };
        writeln!(
            out,
            "  % {axle} axle: mass (kg), stiffness (N/m), damping (N s/m)"
        )?;
        writeln!(out, "  u = column('{road}');")?;
        writeln!(out, "  if isempty(u) || isempty(t), error({needs}); end")?;
        writeln!(
            out,
            "  z(:, end + 1) = simulate(t, u, 0 * t, [], {:?}, {:?}, {:?}, 0);",
            e.mass_kg, e.k_n_m, e.b_n_s_m
        )?;
    }
    writeln!(
        out,
        "  if nargout == 0, plot(t, z); xlabel('time (s)'); ylabel('displacement (m)'); end"
    )?;
    writeln!(out, "end")?;
    out.write_str(SIMULATE)?;
    out.write_str(include_str!("runtime/lifted.m"))
}

fn write(out: &mut String, report: &Report, file: &str) -> std::fmt::Result {
    writeln!(out, "function [t, z] = veloid_model(file)")?;
    writeln!(
        out,
        "% Simulates the identified plain model (output error) along the ride."
    )?;
    writeln!(
        out,
        "% veloid {}, bike {}. The ride is a CSV with commas, a header line and even time",
        report.veloid,
        quoted(&report.bike.bike)
    )?;
    writeln!(
        out,
        "% stamps; z holds one column per axle (m; N where a rig prescribes the motion)."
    )?;
    if let Some(diagnosis) = &report.diagnosis {
        left_out(out, diagnosis)?;
    }
    writeln!(out, "  if nargin < 1, file = {}; end", quoted(file))?;
    writeln!(out, "  ride = importdata(file, ',', 1);")?;
    writeln!(out, "  t = ride.data(:, {});", column(report, "t"))?;
    if let Some([from, to]) = report.ride.part_s {
        writeln!(out, "  % Only this part of the swing was used.")?;
        writeln!(out, "  used = t > {from:?} - 1e-9 & t < {to:?} + 1e-9;")?;
        writeln!(out, "  ride.data = ride.data(used, :);")?;
        writeln!(out, "  t = t(used);")?;
    }
    writeln!(out, "  none = zeros(size(t));")?;
    writeln!(out, "  z = [];")?;
    for (axle, estimate) in report.output_error.iter() {
        axle_lines(out, report, axle, estimate)?;
    }
    writeln!(
        out,
        "  if nargout == 0, plot(t, z); xlabel('time (s)'); ylabel('displacement (m)'); end"
    )?;
    writeln!(out, "end")?;
    out.write_str(SIMULATE)?;
    out.write_str(include_str!("runtime/lifted.m"))
}

/// The head's lines on what the diagnosis found and the script does not simulate.
fn left_out(out: &mut String, diagnosis: &Diagnosis) -> std::fmt::Result {
    if diagnosis.effects.is_empty() {
        return Ok(());
    }
    writeln!(
        out,
        "% The diagnosis found effects that are NOT in this script (docs/method.md has their laws):"
    )?;
    for effect in &diagnosis.effects {
        writeln!(out, "% {}", head::line(effect))?;
    }
    writeln!(
        out,
        "% With them in the model, stiffness (N/m) and damping (N s/m) are:"
    )?;
    for (axle, e) in diagnosis.extended.iter() {
        writeln!(out, "%   {axle}: {}, {}", e.k_n_m, e.b_n_s_m)?;
    }
    Ok(())
}

fn axle_lines(out: &mut String, report: &Report, axle: Axle, e: &Estimate) -> std::fmt::Result {
    let letter = if axle == Axle::Front { 'f' } else { 'r' };
    let channel = |name: &str| {
        let channel = format!("{name}_{letter}");
        let found = report.ride.columns.iter().find(|c| c.channel == channel)?;
        Some(format!(
            "{:?} * ride.data(:, {})",
            found.scale,
            column(report, &channel)
        ))
    };
    let none = || "none".to_owned();
    let (road, force) = (channel("u"), channel("force"));
    if e.mass_kg == 0.0 {
        let motion = channel("z").or_else(|| channel("d")).or(road);
        writeln!(out, "  % {axle} axle: stiffness (N/m), damping (N s/m)")?;
        return writeln!(
            out,
            "  z(:, end + 1) = answer(t, {}, {}, {:?}, {:?});",
            motion.unwrap_or_else(none),
            force.unwrap_or_else(none),
            e.k_n_m,
            e.b_n_s_m
        );
    }
    let rest_point = force.is_some() || road.is_none();
    writeln!(
        out,
        "  % {axle} axle: mass (kg), stiffness (N/m), damping (N s/m)"
    )?;
    writeln!(
        out,
        "  u = {}; F = {}; zm = {};",
        road.unwrap_or_else(none),
        force.unwrap_or_else(none),
        channel("z").unwrap_or_else(none)
    )?;
    writeln!(
        out,
        "  z(:, end + 1) = simulate(t, u, F, zm, {:?}, {:?}, {:?}, {});",
        e.mass_kg,
        e.k_n_m,
        e.b_n_s_m,
        u8::from(rest_point)
    )
}

/// Expression for a channel's column in the file, found by its header.
fn column(report: &Report, channel: &str) -> String {
    let header = report.ride.columns.iter().find(|c| c.channel == channel);
    let header = header.map_or(channel, |c| c.header.as_str());
    format!("strcmp(strtrim(ride.colheaders), {})", quoted(header))
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
