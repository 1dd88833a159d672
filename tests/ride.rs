//! An example ride in closed form: the steady answer of the plain model to a road of sines.

use std::f64::consts::TAU;
use std::fmt::Write;

pub const BIKE: &str = r#"{"bike": "lab-7", "mass_front_kg": 23.0, "mass_rear_kg": 63.0,
    "l_front_m": 0.808, "l_rear_m": 0.293}"#;

/// Settings that make an identification take a moment.
pub const QUICK: [(&str, &str); 4] = [
    ("trials", "3"),
    ("particles", "12"),
    ("iterations", "8"),
    ("diagnosis", "false"),
];

/// Settings that keep a core busy for as long as a test may take.
pub const LONG: [(&str, &str); 2] = [("iterations", "5000"), ("particles", "100")];

/// Mass (kg), stiffness (N/m), damping (N s/m), delay of the road (s).
const AXLES: [[f64; 4]; 2] = [[23.0, 110e3, 1200.0, 0.0], [63.0, 110e3, 1200.0, 0.2]];

/// 20 s at 200 Hz, noise-free.
pub fn example() -> Vec<u8> {
    table(4000, 200.0).into_bytes()
}

/// A ride of so many samples.
pub fn table(samples: usize, rate_hz: f64) -> String {
    let mut csv = "t,u_f,u_r,z_f,z_r\n".to_owned();
    for sample in 0..samples {
        let t = sample as f64 / rate_hz;
        let [(u_f, z_f), (u_r, z_r)] = AXLES.map(|axle| at(t, axle));
        writeln!(csv, "{t:.6},{u_f:.12},{u_r:.12},{z_f:.12},{z_r:.12}").unwrap();
    }
    csv
}

/// Road and displacement: z/u = (k + i w B) / (k - m w^2 + i w B).
fn at(t: f64, [m, k, b, delay]: [f64; 4]) -> (f64, f64) {
    let (mut u, mut z) = (0.0, 0.0);
    for i in 0..14 {
        let i = f64::from(i);
        let omega = TAU * (0.7 + 1.37 * i);
        let amplitude = 4e-3 / (1.0 + i);
        let phase = omega * (t - delay) + i * i;
        let (re, im) = (k - m * omega * omega, omega * b);
        let scale = amplitude / (re * re + im * im);
        let (gain_re, gain_im) = (scale * (k * re + im * im), scale * (im * re - k * im));
        u += amplitude * phase.cos();
        z += gain_re * phase.cos() - gain_im * phase.sin();
    }
    (u, z)
}
