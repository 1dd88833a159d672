use nalgebra::{Matrix2, Matrix3, Vector2, Vector3};

use super::{Found, Point, Theta};
use veloid_core::bicycle::{Bike, PerAxle};
use veloid_core::numerics::finite::std_error;
use veloid_report::{Estimate, RecursivePath};
use veloid_ride::Ride;

/// Estimates with standard errors, and the recursive path, of every axle: one k and one B for both
/// where the bike has equal axles and both masses are known.
pub fn estimates(
    found: &PerAxle<Found>,
    ride: &Ride,
    bike: &Bike,
) -> (PerAxle<Estimate>, PerAxle<RecursivePath>) {
    if let (Some(front), Some(rear)) = (&found.front, &found.rear)
        && bike.shares_axles()
        && let Some(joint) = joint(front, rear, ride)
    {
        return joint;
    }
    let estimates = found.map(|axle, f| estimate(f.theta, &f.covariance, bike.mass(axle)));
    let paths = found.map(|_, f| {
        let mut path = RecursivePath::default();
        for Point { sample, theta, .. } in &f.path {
            let [kappa, beta, per_mass] = theta;
            push(
                &mut path,
                ride.time_s(*sample),
                kappa / per_mass,
                beta / per_mass,
            );
        }
        path
    });
    (estimates, paths)
}

fn push(path: &mut RecursivePath, t: f64, k: f64, b: f64) {
    if !(k.is_finite() && b.is_finite()) {
        return;
    }
    path.t_s.push(t);
    path.k_n_m.push(k);
    path.b_n_s_m.push(b);
}

/// k, B and m with standard errors by the delta method.
fn estimate([kappa, beta, g]: Theta, covariance: &Matrix3<f64>, mass: Option<f64>) -> Estimate {
    let std = |by: [f64; 3]| {
        let by = Vector3::from(by);
        std_error(by.dot(&(covariance * by)))
    };
    Estimate {
        k_n_m: kappa / g,
        b_n_s_m: beta / g,
        k_std_n_m: std([1.0 / g, 0.0, -kappa / (g * g)]),
        b_std_n_s_m: std([0.0, 1.0 / g, -beta / (g * g)]),
        mass_kg: mass.unwrap_or(1.0 / g),
        mass_std_kg: match mass {
            Some(_) => None,
            None => std([0.0, 0.0, -1.0 / (g * g)]),
        },
        ..Estimate::default()
    }
    .reportable()
}

/// Least squares over both axles at once, each weighted by the inverse variance of its errors, put
/// together from the axles' own information.
fn joint(
    front: &Found,
    rear: &Found,
    ride: &Ride,
) -> Option<(PerAxle<Estimate>, PerAxle<RecursivePath>)> {
    let mut path = RecursivePath::default();
    for f in &front.path {
        if let Some(r) = rear.path.iter().find(|r| r.sample == f.sample)
            && let Some((pair, _)) = combine([(front, f), (rear, r)])
        {
            push(&mut path, ride.time_s(f.sample), pair[0], pair[1]);
        }
    }
    let (pair, shares) = combine([(front, front.path.last()?), (rear, rear.path.last()?)])?;
    let mut covariance = Matrix2::zeros();
    for (found, share) in [front, rear].into_iter().zip(shares) {
        let m = 1.0 / found.theta[2];
        let own = found.covariance.fixed_view::<2, 2>(0, 0) * (m * m);
        covariance += share * own * share.transpose();
    }
    let one = |found: &Found| {
        Estimate {
            k_n_m: pair[0],
            b_n_s_m: pair[1],
            k_std_n_m: std_error(covariance[(0, 0)]),
            b_std_n_s_m: std_error(covariance[(1, 1)]),
            mass_kg: 1.0 / found.theta[2],
            ..Estimate::default()
        }
        .reportable()
    };
    let estimates = PerAxle {
        front: Some(one(front)),
        rear: Some(one(rear)),
    };
    let paths = PerAxle {
        front: Some(path.clone()),
        rear: Some(path),
    };
    Some((estimates, paths))
}

/// k and B from two axles' estimates, and each axle's share in them.
fn combine(points: [(&Found, &Point); 2]) -> Option<(Vector2<f64>, [Matrix2<f64>; 2])> {
    let informations = points.map(|(found, p)| p.information * (found.weight * p.theta[2].powi(2)));
    let inverse = (informations[0] + informations[1]).try_inverse()?;
    let shares = informations.map(|i| inverse * i);
    let mut pair = Vector2::zeros();
    for (share, (_, p)) in shares.iter().zip(points) {
        let [kappa, beta, per_mass] = p.theta;
        pair += share * Vector2::new(kappa / per_mass, beta / per_mass);
    }
    Some((pair, shares))
}
