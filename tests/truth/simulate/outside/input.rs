//! Strange forces that come from outside of the suspension.

use std::f64::consts::TAU;

use super::super::contact::Contact;

/// A patch or a valve that thickens the tyre at one place: `F (exp(sharpness (cos a - 1)) - mean)`, a the wheel's angle from
/// there. Values: F (N), sharpness, rolling radius (m), phase (rad).
pub fn valve_bump(p: &[f64], c: &Contact) -> f64 {
    let mean = 1.0 / (TAU * p[1]).sqrt();
    p[0] * ((p[1] * ((c.x / p[2] + p[3]).cos() - 1.0)).exp() - mean)
}

/// Gusts on the rider: the sum of `F sin(omega t + phase)` over (omega rad/s, phase rad, F N), coloured by the draw of F.
pub fn gusts(lines: &[[f64; 3]], c: &Contact) -> f64 {
    lines
        .iter()
        .map(|[omega, phase, force]| force * (omega * c.t + phase).sin())
        .sum()
}
