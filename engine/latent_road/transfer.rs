//! From the road to a sensor: the axle m z'' + B z' + k z = B u' + k u in the frequency domain.

use nalgebra::Complex;

use veloid_ride::SensorKind;

/// A sensor's response to the road's height, and its derivatives by ln(k/m) and ln(B/m).
pub struct Response {
    pub value: Complex<f64>,
    pub by_kappa: Complex<f64>,
    pub by_beta: Complex<f64>,
}

/// Response at `omega` (rad/s) of an axle of kappa = k/m (1/s^2) and beta = B/m (1/s): z/u = H = (kappa + i omega beta) /
/// (kappa - omega^2 + i omega beta).
pub fn response(kind: SensorKind, kappa: f64, beta: f64, omega: f64) -> Response {
    let forced = Complex::new(kappa, omega * beta);
    let per = 1.0 / (forced - omega * omega);
    let h = forced * per;
    // dH = -omega^2 / (kappa - omega^2 + i omega beta)^2 d(forced).
    let slope = -(omega * omega) * per * per;
    let (factor, value) = match kind {
        SensorKind::Acceleration => (-omega * omega, -omega * omega * h),
        SensorKind::Deflection => (-1.0, 1.0 - h),
        SensorKind::Displacement => (1.0, h),
        SensorKind::Road => (0.0, Complex::new(1.0, 0.0)),
    };
    Response {
        value,
        by_kappa: factor * slope * kappa,
        by_beta: factor * slope * Complex::new(0.0, omega * beta),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const KINDS: [SensorKind; 4] = [
        SensorKind::Acceleration,
        SensorKind::Deflection,
        SensorKind::Displacement,
        SensorKind::Road,
    ];

    #[test]
    fn responses_are_those_of_the_equation_of_motion() {
        let (kappa, beta, omega) = (4782.6, 50.0, 61.0);
        let of = |kind| response(kind, kappa, beta, omega).value;
        let (z, d) = (of(SensorKind::Displacement), of(SensorKind::Deflection));
        let i = Complex::new(0.0, omega);
        // z'' = kappa (u - z) + beta (u' - z') for u = 1.
        let left = i * i * z - (d * kappa + i * d * beta);
        assert!(left.norm() < 1e-9, "{left}");
        assert!((of(SensorKind::Acceleration) - i * i * z).norm() < 1e-9);
        assert!((z + d - of(SensorKind::Road)).norm() < 1e-12);
        // Slowly the axle follows the road; at its natural frequency |z/u|^2 = 1 + (kappa/(omega beta))^2.
        let slow = response(SensorKind::Displacement, kappa, beta, 1e-3).value;
        assert!((slow - 1.0).norm() < 1e-6);
        let natural = kappa.sqrt();
        let peak = response(SensorKind::Displacement, kappa, beta, natural).value;
        assert!((peak.norm_sqr() - 1.0 - kappa / (beta * beta)).abs() < 1e-9);
    }

    #[test]
    fn derivatives_are_those_of_the_response() {
        for kind in KINDS {
            let at = |x: f64, y: f64| response(kind, x.exp(), y.exp(), 55.0);
            let (x, y, h) = (8.4, 3.8, 1e-6);
            let found = at(x, y);
            let by_x = (at(x + h, y).value - at(x - h, y).value) / (2.0 * h);
            let by_y = (at(x, y + h).value - at(x, y - h).value) / (2.0 * h);
            let size = 1e-6 * (1.0 + found.value.norm());
            assert!((found.by_kappa - by_x).norm() < size, "{kind:?}");
            assert!((found.by_beta - by_y).norm() < size, "{kind:?}");
        }
    }
}
