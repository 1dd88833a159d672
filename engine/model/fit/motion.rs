//! How a model moves along the ride.

use super::integrate::run;
use super::model::{FINE, Model};
use super::unit::Point;
use crate::dataset::{Dataset, Track};
use veloid_core::numerics::lanes::{LANES, Lanes};
use veloid_core::numerics::spline::slopes;
use veloid_core::plant::Coefficients;
use veloid_methods::output_error::AxleFit;
use veloid_methods::simulate::linear::Input;

/// A model's motion along the ride on one axle.
pub struct Motion {
    pub z: Vec<f64>,
    pub d: Vec<f64>,
    pub w: Vec<f64>,
    /// z'' and what the linear spring and damper alone would give (m/s^2).
    pub acceleration: Vec<f64>,
    pub linear: Vec<f64>,
}

impl Motion {
    /// The plain model's motion as output error has fitted it.
    pub fn of_fit(track: &Track, fit: &AxleFit) -> Self {
        let fitted = track.measured.iter().zip(&fit.residual);
        let z = track.height(fitted.map(|(y, r)| y - r).collect());
        let v = slopes(&z, track.input.step);
        let p = &fit.plain;
        Self::plain(&track.input, z, &v, p)
    }

    /// A motion that the base model alone brings about.
    fn plain(input: &Input, z: Vec<f64>, v: &[f64], base: &Coefficients) -> Self {
        let Coefficients {
            kappa,
            beta,
            per_mass,
            constant,
            ..
        } = *base;
        let d: Vec<f64> = input.road.iter().zip(&z).map(|(u, z)| u - z).collect();
        let w: Vec<f64> = (input.road_slope.iter().zip(v))
            .map(|(u, v)| u - v)
            .collect();
        let linear: Vec<f64> = (0..z.len())
            .map(|i| {
                let push = input.force.as_ref().map_or(0.0, |(f, _)| f[i]);
                kappa * d[i] + beta * w[i] + per_mass * push + constant
            })
            .collect();
        Self {
            acceleration: linear.clone(),
            z,
            d,
            w,
            linear,
        }
    }
}

/// The motion of every track under a model.
pub fn motions(dataset: &Dataset, model: &Model) -> Vec<Motion> {
    (0..dataset.tracks.len())
        .map(|t| {
            let (fit, a) = model.of_track(t);
            let points: [Point; LANES] = std::array::from_fn(|_| fit.point.clone());
            let lanes: Vec<_> = (0..fit.unit.tracks.len())
                .map(|a| fit.unit.lanes(dataset, &points, a))
                .collect();
            let axles: Vec<_> = fit
                .unit
                .tracks
                .iter()
                .zip(&lanes)
                .map(|(t, l)| (&dataset.tracks[*t], l))
                .collect();
            let coupling = fit.unit.coupling(&points);
            let substeps = model.substeps(dataset, FINE);
            let out = run(
                dataset,
                &axles,
                coupling.as_ref(),
                0..dataset.samples,
                substeps,
                true,
            );
            let m = &out[a];
            let input = &dataset.tracks[t].input;
            let lane = |x: &[Lanes]| -> Vec<f64> { x.iter().map(|x| x.0[0]).collect() };
            let (z, v, acceleration) = (lane(&m.z), lane(&m.v), lane(&m.a));
            Motion {
                acceleration,
                ..Motion::plain(input, z, &v, &fit.point.base[a])
            }
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plain_motion_is_what_spring_damper_and_push_bring_about() {
        let road = [1.0, 2.0, 4.0, 7.0];
        let force = [10.0, 20.0, -30.0, 0.0];
        let input = Input::new(&road, Some(&force), 0.5);
        let (z, v) = (vec![0.5, 1.0, 1.5, 2.0], [3.0, 2.0, 1.0, 0.0]);
        let m = Motion::plain(
            &input,
            z.clone(),
            &v,
            &Coefficients {
                kappa: 100.0,
                beta: 7.0,
                per_mass: 0.1,
                constant: -2.0,
                ..Coefficients::default()
            },
        );
        for i in 0..4 {
            let (d, w) = (road[i] - z[i], input.road_slope[i] - v[i]);
            assert_eq!((m.d[i], m.w[i]), (d, w));
            let expected = 100.0 * d + 7.0 * w + 0.1 * force[i] - 2.0;
            assert!((m.linear[i] - expected).abs() < 1e-9);
        }
        assert_eq!((m.acceleration, m.z), (m.linear, z));
    }

    #[test]
    fn the_motion_under_a_law_is_faster_by_its_force() {
        use crate::effects::Kind;
        use crate::example;
        use veloid_core::bicycle::Axle;
        let dataset = example::dataset();
        let cubic = example::term(Kind::CubicStiffness, Axle::Front);
        let model = example::model(&dataset, &[(cubic, 3e9)]);
        let [front, rear] = &motions(&dataset, &model)[..] else {
            panic!("two axles");
        };
        let most = |x: &[f64]| x.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
        for i in 0..dataset.samples {
            let extra = front.acceleration[i] - front.linear[i];
            let law = 3e9 * front.d[i].powi(3) / example::FRONT;
            assert!((extra - law).abs() < 1e-6 * most(&front.linear));
            let extra = rear.acceleration[i] - rear.linear[i];
            assert!(extra.abs() < 1e-6 * most(&rear.linear));
        }
    }
}
