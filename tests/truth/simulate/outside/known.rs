//! The twelve laws that the developers of the diagnosis have known since before suite `strange`.

use super::super::contact::Contact;

/// `c |w|^p sign(w)`, regular within 0.2 mm/s. Values: c, p.
pub fn power_damping(p: &[f64], c: &Contact) -> f64 {
    p[0] * c.w * (c.w * c.w + 4e-8).powf((p[1] - 1.0) / 2.0)
}

/// LuGre. Values: kinetic force (N), breakaway force (N), Stribeck speed (m/s), presliding distance (m).
pub fn stribeck_friction(p: &[f64], c: &Contact, s: &[f64], rate: &mut [f64]) -> f64 {
    let bristle = p[0] / p[3];
    let limit = p[0] + (p[1] - p[0]) * (-(c.w / p[2]).powi(2)).exp();
    rate[0] = c.w - bristle * c.w.abs() / limit * s[0];
    bristle * s[0]
}

/// Values: share of k, rolling radius (m), phase (rad).
pub fn parametric_wheel(p: &[f64], c: &Contact) -> f64 {
    p[0] * c.k * (c.x / p[1] + p[2]).cos() * c.d
}

/// Values: extra mass (kg), linear (N/m) and cubic spring (N/m^3), damper (N s/m).
pub fn hardening_frame_mode(p: &[f64], c: &Contact, s: &[f64], rate: &mut [f64]) -> f64 {
    let (q, q_rate) = (s[0] - c.z, s[1] - c.z_rate);
    let pull = p[1] * q + p[2] * q.powi(3) + p[3] * q_rate;
    rate[0] = s[1];
    rate[1] = -pull / p[0];
    pull
}

/// Values: half gap (m), contact stiffness (N/m), impact loss (s/m), lag (s).
pub fn impact_backlash(p: &[f64], c: &Contact, s: &[f64], rate: &mut [f64]) -> f64 {
    let depth = (c.d.abs() - p[0]).max(0.0) * c.d.signum();
    let contact = p[1] * depth * (1.0 + p[2] * c.w * c.d.signum()).max(0.0);
    rate[0] = (contact - s[0]) / p[3];
    s[0]
}

/// Values: loss of k per unit heat, typical rate (m/s), time constant (s).
pub fn thermal_softening(p: &[f64], c: &Contact, s: &[f64], rate: &mut [f64]) -> f64 {
    rate[0] = ((c.w / p[1]).powi(2) - s[0]) / p[2];
    -c.k * c.d * (p[0] * s[0]).min(0.8)
}

/// Half a sine of the rider's hands over the stretch (from s, to s, N).
pub fn posture_burst(stretch: Option<&[f64; 3]>, c: &Contact) -> f64 {
    stretch.map_or(0.0, |&[from, to, size]| {
        size * (std::f64::consts::PI * (c.t - from) / (to - from)).sin()
    })
}

/// Values: strength (N m^2), gap (m).
pub fn magnetic_repulsion(p: &[f64], c: &Contact) -> f64 {
    let left = (p[1] - c.d).max(0.15 * p[1]);
    p[0] * (left.powi(-2) - p[1].powi(-2))
}
