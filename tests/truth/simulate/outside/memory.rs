//! Strange forces with a memory: `s` are the law's own states, `rate` their rates. All start at 0.

use super::super::contact::Contact;

/// Rate over which dry friction reverses, m/s.
const SLIP_M_S: f64 = 3e-3;

/// Grease that breaks down with use and sets again at rest: `C (1 - s) w`, `s' = |w| (1 - s) / travel - s / recovery`.
/// Values: C (N s/m), travel (m), recovery (s).
pub fn thixotropic_grease(p: &[f64], c: &Contact, s: &[f64], rate: &mut [f64]) -> f64 {
    rate[0] = c.w.abs() / p[1] * (1.0 - s[0]) - s[0] / p[2];
    p[0] * (1.0 - s[0]) * c.w
}

/// Dry contact that grows the longer it rests (Dieterich): `F (1 + a ln(1 + s / onset)) sign w`, `s' = 1 - |w| s / slip`,
/// the sign a tangent of 3 mm/s. Values: F (N), a, slip (m), onset (s).
pub fn dwell_friction(p: &[f64], c: &Contact, s: &[f64], rate: &mut [f64]) -> f64 {
    rate[0] = 1.0 - c.w.abs() * s[0] / p[2];
    p[0] * (1.0 + p[1] * (s[0].max(0.0) / p[3]).ln_1p()) * (c.w / SLIP_M_S).tanh()
}

/// A latch or an over-centre spring with two seats, flipped when pressed past 0.385 of a reach and not before:
/// `F s`, `lag s' = s - s^3 + d / reach`. Values: F (N), reach (m), lag (s).
pub fn bistable_latch(p: &[f64], c: &Contact, s: &[f64], rate: &mut [f64]) -> f64 {
    rate[0] = (s[0] - s[0].powi(3) + c.d / p[1]) / p[2];
    p[0] * s[0]
}

/// A relief chamber at the end of a long hose: the deflection of some time ago takes force away, `-share k s4`, where
/// `s_n' = 4 (s_(n-1) - s_n) / delay` through four cells from s_0 = d. Values: share, delay (s).
pub fn delayed_relief(p: &[f64], c: &Contact, s: &[f64], rate: &mut [f64]) -> f64 {
    let mut before = c.d;
    for (rate, own) in rate.iter_mut().zip(s) {
        *rate = 4.0 * (before - own) / p[1];
        before = *own;
    }
    -p[0] * c.k * before
}

/// Plastic that flows by hops over barriers (Eyring), which creeps with the logarithm of time: `s`,
/// `s' = K (w - v sinh(s / F))`. Values: K (N/m), v (m/s), F (N).
pub fn log_creep(p: &[f64], c: &Contact, s: &[f64], rate: &mut [f64]) -> f64 {
    rate[0] = p[0] * (c.w - p[1] * (s[0] / p[2]).clamp(-12.0, 12.0).sinh());
    s[0]
}

/// A levelling strut that follows no faster than its pump: `share k (d - s)`, `s' = fastest tanh((d - s) / near)`.
/// Values: share, fastest (m/s), near (m).
pub fn slow_follower(p: &[f64], c: &Contact, s: &[f64], rate: &mut [f64]) -> f64 {
    let behind = c.d - s[0];
    rate[0] = p[1] * (behind / p[2]).tanh();
    p[0] * c.k * behind
}

/// Liquid in a bottle that rises along its walls: a mass whose pull saturates, `m omega^2 q / sqrt(1 + (q / reach)^2)
/// + C q' |q'|`, q = s1 - z. Values: m (kg), omega (rad/s), reach (m), C (N s^2/m^2).
pub fn slosh(p: &[f64], c: &Contact, s: &[f64], rate: &mut [f64]) -> f64 {
    let (q, q_rate) = (s[0] - c.z, s[1] - c.z_rate);
    let held = p[0] * p[1] * p[1] * q / (1.0 + (q / p[2]).powi(2)).sqrt();
    let pull = held + p[3] * q_rate * q_rate.abs();
    rate[0] = s[1];
    rate[1] = -pull / p[0];
    pull
}

/// An air chamber with a leak: excess pressure `y = (1 + s) (1 - d / length)^-1.4 - 1`, force `F y`, and through the leak
/// `s' = -leak y / (y^2 + 0.0004)^(1/4)`; d / length stays within -0.6 and 0.7. Values: F (N), length (m), leak (1/s).
pub fn leaking_air_spring(p: &[f64], c: &Contact, s: &[f64], rate: &mut [f64]) -> f64 {
    let pressed = (c.d / p[1]).clamp(-0.6, 0.7);
    let excess = (1.0 + s[0]) * (1.0 - pressed).powf(-1.4) - 1.0;
    rate[0] = -p[2] * excess / (excess * excess + 4e-4).powf(0.25);
    p[0] * excess
}

/// A sand bag, jammed by pressure and loosened by shaking: `share k d s`,
/// `time s' = (1 - s) |d| / depth - s |w| / rate`. Values: share, depth (m), time (s), rate (m/s).
pub fn granular_jamming(p: &[f64], c: &Contact, s: &[f64], rate: &mut [f64]) -> f64 {
    rate[0] = ((1.0 - s[0]) * c.d.abs() / p[1] - s[0] * c.w.abs() / p[3]) / p[2];
    p[0] * c.k * c.d * s[0]
}

/// A glued joint that holds until it is bent too far, once, and that has aged enough to break: `share k d (1 - s)`,
/// `s' = 400 (1 - s)` while t > aged and |d| > limit. Values: share, limit (m), aged (s).
pub fn breaking_bond(p: &[f64], c: &Contact, s: &[f64], rate: &mut [f64]) -> f64 {
    if c.t > p[2] && c.d.abs() > p[1] {
        rate[0] = 400.0 * (1.0 - s[0]);
    }
    p[0] * c.k * c.d * (1.0 - s[0])
}

/// A firm damper whose valve a hit throws open for a while: `C w (1 - s)`,
/// `s' = 250 (1 - s) max(|w| / hit - 1, 0) - s / closing`. Values: C (N s/m), hit (m/s), closing (s).
pub fn inertia_valve(p: &[f64], c: &Contact, s: &[f64], rate: &mut [f64]) -> f64 {
    let opening = 250.0 * (c.w.abs() / p[1] - 1.0).max(0.0);
    rate[0] = opening * (1.0 - s[0]) - s[0] / p[2];
    p[0] * c.w * (1.0 - s[0])
}

/// A generator in the damper, behind a rectifier that conducts beyond a voltage: `C s`,
/// `lag s' = w - clamp(w, -threshold, threshold) - s`. Values: C (N s/m), threshold (m/s), lag of its coil (s).
pub fn rectified_generator(p: &[f64], c: &Contact, s: &[f64], rate: &mut [f64]) -> f64 {
    rate[0] = (c.w - c.w.clamp(-p[1], p[1]) - s[0]) / p[2];
    p[0] * s[0]
}

/// A hydraulic mount, whose column of fluid resonates with the deflection: `K (d - s1)`,
/// `m s1'' = K (d - s1) - C s1' |s1'|`. Values: K (N/m), m (kg), C (N s^2/m^2).
pub fn hydraulic_mount(p: &[f64], c: &Contact, s: &[f64], rate: &mut [f64]) -> f64 {
    let push = p[0] * (c.d - s[0]);
    rate[0] = s[1];
    rate[1] = (push - p[2] * s[1] * s[1].abs()) / p[1];
    push
}

/// A headset or seat that each hit drives further in and that works itself loose again: `F s`,
/// `s' = 200 (1 - s) max(d / hit - 1, 0) - s / recovery`. Values: F (N), hit (m), recovery (s).
pub fn impact_preload(p: &[f64], c: &Contact, s: &[f64], rate: &mut [f64]) -> f64 {
    let driven = 200.0 * (c.d / p[1] - 1.0).max(0.0);
    rate[0] = driven * (1.0 - s[0]) - s[0] / p[2];
    p[0] * s[0]
}
