//! Strange forces of position alone, or of position while something else lasts.

use std::f64::consts::TAU;

use super::super::contact::Contact;

/// A dented cup or disc spring that snaps through at one deflection: `-F x exp((1 - x^2) / 2)`, x = (d - centre) / width.
/// Values: F (N), its extreme on either side; centre and width (m).
pub fn snap_dome(p: &[f64], c: &Contact) -> f64 {
    let x = (c.d - p[1]) / p[2];
    -p[0] * x * (0.5 * (1.0 - x * x)).exp()
}

/// A leather or cork pad between unlike faces: `F x (x^2 + 0.01)^((q - 1) / 2)`, x = d / scale, with a power q > 1 pressed
/// and q < 1 stretched. Values: F (N), scale (m), both powers.
pub fn two_power_spring(p: &[f64], c: &Contact) -> f64 {
    let x = c.d / p[1];
    let power = if x > 0.0 { p[2] } else { p[3] };
    p[0] * x * (x * x + 0.01).powf((power - 1.0) / 2.0)
}

/// Teeth, a thread or the poles of a magnet passed on the way: `F sin(2 pi d / pitch)`. Values: F (N), pitch (m).
pub fn detent_ripple(p: &[f64], c: &Contact) -> f64 {
    p[0] * (TAU * c.d / p[1]).sin()
}

/// Rubber whose chains have no time to give way: `share k d r / (1 + r)`, r = |w| / rate. Values: share, rate (m/s).
pub fn rate_stiffened_spring(p: &[f64], c: &Contact) -> f64 {
    let r = c.w.abs() / p[1];
    p[0] * c.k * c.d * r / (1.0 + r)
}

/// A hose between the fork's and the seat's air chambers: `share k d_other`. Values: share.
pub fn interlinked_springs(p: &[f64], c: &Contact) -> f64 {
    p[0] * c.k * c.other_d
}

/// A rubber block that slides in and out from under the axle, hit while `within`: `K max(d - gap, 0)`.
/// Values: gap (m), K (N/m).
pub fn wandering_stop(p: &[f64], c: &Contact, within: bool) -> f64 {
    if within {
        p[1] * (c.d - p[0]).max(0.0)
    } else {
        0.0
    }
}
