//! Strange forces that take energy out and remember nothing.

use super::super::contact::Contact;

/// A wedge damper or leaf spring, whose friction is pressed by the spring itself: `mu k |d| tanh(w / rate)`.
/// Values: mu, the rate over which it reverses (m/s).
pub fn load_friction(p: &[f64], c: &Contact) -> f64 {
    p[0] * c.k * c.d.abs() * (c.w / p[1]).tanh()
}

/// A conductor that passes a magnet, whose currents lag more the faster it goes: `C w / (1 + (w / rate)^2)`.
/// Values: C (N s/m), rate of the largest force (m/s).
pub fn eddy_damping(p: &[f64], c: &Contact) -> f64 {
    p[0] * c.w / (1.0 + (c.w / p[1]).powi(2))
}

/// A switched damper, firm only while it slows the body down: `C w (1 - tanh(z' w / threshold)) / 2`.
/// Values: C (N s/m), threshold (m^2/s^2).
pub fn skyhook_damper(p: &[f64], c: &Contact) -> f64 {
    0.5 * p[0] * c.w * (1.0 - (c.z_rate * c.w / p[1]).tanh())
}

/// A damper that hangs on a cable, taut only beyond a position and only when it is pulled: `C max(w, 0) e`, e rising from 0
/// to 1 as d goes from slack to slack + stretch. Values: C (N s/m), slack and stretch (m).
pub fn slack_cable(p: &[f64], c: &Contact) -> f64 {
    let taut = ((c.d - p[1]) / p[2]).clamp(0.0, 1.0);
    p[0] * taut * c.w.max(0.0)
}

/// A sliding joint that the pedals press twice a turn: `C w (1 + cos(2 crank + phase))`. Values: C (N s/m), phase (rad).
pub fn crank_damping(p: &[f64], c: &Contact) -> f64 {
    p[0] * c.w * (1.0 + (2.0 * c.crank + p[1]).cos())
}
