//! What a law sees of its axle at one moment.

/// Deflection d (m, positive pressed) and its rate w; position z of the axle mass; k and B of the axle.
#[derive(Default)]
pub struct Contact {
    pub t: f64,
    pub x: f64,
    pub speed: f64,
    pub crank: f64,
    pub d: f64,
    pub w: f64,
    pub z: f64,
    pub z_rate: f64,
    pub other_d: f64,
    pub k: f64,
    pub b: f64,
}
