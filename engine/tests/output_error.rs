use rayon::prelude::*;
use veloid_core::bicycle::Axle;
use veloid_core::bicycle::Bike;
use veloid_core::bicycle::PerAxle;
use veloid_core::numerics::random::Normal;
use veloid_core::numerics::spline::lifted;
use veloid_core::plant::Coefficients;
use veloid_core::plant::PlantRef;
use veloid_core::settings::Settings;
use veloid_engine::observe;
use veloid_methods::output_error::minima::not_at_rest;
use veloid_methods::output_error::problem::Problem;
use veloid_methods::output_error::start::starts_from;
use veloid_methods::output_error::*;
use veloid_methods::simulate::linear::{Input, simulate};
use veloid_methods::simulate::simulated_ride::SimulatedRide;
use veloid_report::Estimate;
use veloid_ride::Ride;
use veloid_ride::{AxleRecord, ReadOptions, read};

/// A minute on a rough road by the plain model itself, with white noise on z.
fn ride(noise: f64) -> (Ride, Bike) {
    let n = 6000;
    let step = 0.01;
    let mut state = 1_u64;
    let mut uniform = move || {
        state = state
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let waves: Vec<(f64, f64, f64)> = (0..200)
        .map(|i| {
            let f = 0.1 * (150.0_f64).powf(i as f64 / 200.0);
            (f, 0.004 / f.sqrt(), std::f64::consts::TAU * uniform())
        })
        .collect();
    let road: Vec<f64> = (0..n)
        .map(|i| {
            waves
                .iter()
                .map(|(f, a, p)| a * (std::f64::consts::TAU * f * i as f64 * step + p).sin())
                .sum()
        })
        .collect();
    let mut axles = PerAxle::default();
    for (axle, m) in [(Axle::Front, 23.0), (Axle::Rear, 63.0)] {
        let (z, _) = simulate(
            &Input::new(&lifted(&road), None, step),
            110e3 / m,
            1150.0 / m,
            1.0 / m,
            0.0,
            [road[0], 0.0],
        );
        let z = z
            .iter()
            .map(|z| z + noise * (0..12).map(|_| uniform() - 0.5).sum::<f64>())
            .collect();
        axles.set(
            axle,
            AxleRecord {
                road: road.clone(),
                force: None,
                displacement: z,
                acceleration: None,
                valid: vec![true; n],
                prescribed: false,
                plant: PlantRef::default(),
                band: None,
            },
        );
    }
    let ride = Ride {
        step_s: step,
        samples: n,
        axles,
        ..Ride::default()
    };
    let bike = Bike {
        mass_front_kg: Some(23.0),
        mass_rear_kg: Some(63.0),
        ..Bike::default()
    };
    (ride, bike)
}

fn starts_at(kappa: f64, beta: f64) -> Vec<PerAxle<Start>> {
    let s = Some(Start {
        kappa,
        beta,
        per_mass: 0.02,
    });
    vec![PerAxle { front: s, rear: s }]
}

#[test]
fn noise_free_ride_gives_the_truth() {
    let (ride, bike) = ride(0.0);
    for fit in fit(&ride, &bike, &Settings::default(), &starts_at(2500.0, 60.0))
        .unwrap()
        .iter()
    {
        let e = fit.1.estimate(true);
        assert!((e.k_n_m / 110e3 - 1.0).abs() < 1e-6, "{e:?}");
        assert!((e.b_n_s_m / 1150.0 - 1.0).abs() < 1e-6, "{e:?}");
        assert_eq!(fit.1.undetermined, None);
    }
}

#[test]
fn a_fit_beside_another_minimum_that_fits_as_well_has_no_interval() {
    let (ride, bike) = ride(1e-2);
    let settings = Settings::default();
    let fits = fit(&ride, &bike, &settings, &starts_at(2500.0, 60.0)).unwrap();
    let fit = fits.front.unwrap();
    let record = ride.axles.front.as_ref().unwrap();
    let problem = Problem::new(Axle::Front, record, &bike, ride.step_s).unwrap();
    let std = fit.covariance[(0, 0)].sqrt();
    assert!(std > 0.01 * fit.plain.kappa, "{std}");
    let beside = |stds: f64| {
        let other = Coefficients {
            kappa: fit.plain.kappa + stds * std,
            ..fit.plain
        };
        problem.alone(fit.clone(), &[other], &Split::of(&ride, &settings))
    };
    let e = beside(2.2).estimate(true);
    assert_eq!((e.k_std_n_m, e.b_std_n_s_m), (None, None));
    let why = e.k_not_identifiable.unwrap();
    assert!(why.contains("another minimum fits as well"), "{why}");
    for stds in [1.5, 20.0] {
        assert_eq!(beside(stds).undetermined, None, "{stds}");
    }
}

#[test]
fn a_fit_has_converged_within_a_tenth_of_a_standard_error() {
    let says = |stds: f64| not_at_rest(stds * stds * 1e-6, 4e-3, 4000, 1.0);
    assert_eq!(says(0.099), None);
    assert!(says(0.101).unwrap().contains("did not converge"));
    assert_eq!(not_at_rest(0.9e-12, 1e-15, 4000, 1.0), None, "rounding");
}

#[test]
fn noise_is_met_by_its_standard_error() {
    let (ride, bike) = ride(5e-5);
    for (_, fit) in fit(&ride, &bike, &Settings::default(), &starts_at(2500.0, 60.0))
        .unwrap()
        .iter()
    {
        let e = fit.estimate(true);
        assert!(
            (e.k_n_m / 110e3 - 1.0).abs() < 0.005 && (e.b_n_s_m / 1150.0 - 1.0).abs() < 0.02,
            "{e:?}"
        );
        assert!(
            (e.k_n_m - 110e3).abs() < 4.0 * e.k_std_n_m.unwrap() && e.k_std_n_m.unwrap() < 500.0,
            "{e:?}"
        );
        assert!((fit.held_rms / 5e-5 - 1.0).abs() < 0.1);
    }
}

#[test]
fn equal_axles_share_one_pair() {
    let (ride, bike) = ride(5e-5);
    let bike = Bike {
        equal_axles: true,
        ..bike
    };
    let found = fit(&ride, &bike, &Settings::default(), &starts_at(2500.0, 60.0)).unwrap();
    let [f, r] = Axle::BOTH.map(|a| found.get(a).unwrap().estimate(true));
    assert!((f.k_n_m / r.k_n_m - 1.0).abs() < 1e-12 && (f.b_n_s_m / r.b_n_s_m - 1.0).abs() < 1e-12);
    assert!((f.k_n_m / 110e3 - 1.0).abs() < 0.005);
}

#[test]
fn a_mass_needs_a_force() {
    let (ride, bike) = ride(0.0);
    let bike = Bike {
        mass_front_kg: None,
        ..bike
    };
    let message = fit(&ride, &bike, &Settings::default(), &starts_at(2500.0, 60.0))
        .unwrap_err()
        .to_string();
    assert!(message.contains("mass_front_kg is null"), "{message}");
}

/// How often the 95 % intervals hold the truth, and by how much the estimates scatter: the table of
/// docs/method.md. `cargo test --release -p veloid-engine coverage_of_the_intervals -- --ignored
/// --nocapture`
#[test]
#[ignore = "the table of docs/method.md; half a minute"]
fn coverage_of_the_intervals() {
    const SEEDS: u64 = 200;
    let bike = Bike {
        mass_front_kg: Some(23.0),
        mass_rear_kg: Some(63.0),
        ..Bike::default()
    };
    let settings = Settings::default();
    let found: Vec<[Estimate; 2]> = (1..=SEEDS)
        .into_par_iter()
        .map(|seed| {
            let simulated_ride = SimulatedRide {
                noise_displacement_m: 5e-5,
                seed,
                ..SimulatedRide::default()
            };
            let ride = simulated_ride.ride();
            let observed = observe(&ride, &bike, &settings).unwrap();
            let starts = [starts_from(&observed.instrumental)];
            let fits = fit(&ride, &bike, &settings, &starts).unwrap();
            Axle::BOTH.map(|axle| fits.get(axle).unwrap().estimate(true))
        })
        .collect();
    println!(
        "| parameter | coverage % | mean error % | standard deviation % | mean standard error % |"
    );
    println!("|---|---|---|---|---|");
    for (i, axle) in Axle::BOTH.into_iter().enumerate() {
        let k = found.iter().map(|e| (e[i].k_n_m, e[i].k_std_n_m.unwrap()));
        let b = found
            .iter()
            .map(|e| (e[i].b_n_s_m, e[i].b_std_n_s_m.unwrap()));
        row(&format!("k {axle}"), 110e3, k.collect());
        row(&format!("B {axle}"), 1150.0, b.collect());
    }

    fn row(name: &str, truth: f64, found: Vec<(f64, f64)>) {
        let percent = 100.0 / truth;
        let mean = |of: &dyn Fn(&(f64, f64)) -> f64| {
            found.iter().map(of).sum::<f64>() / found.len() as f64
        };
        let inside = |(x, std): &(f64, f64)| f64::from((x - truth).abs() <= 1.96 * std);
        let covered = 100.0 * mean(&inside);
        let off = mean(&|(x, _)| percent * (x - truth));
        let spread = mean(&|(x, _)| (percent * (x - truth) - off).powi(2)).sqrt();
        let claimed = mean(&|(_, std)| percent * std);
        println!("| {name} | {covered:.1} | {off:+.3} | {spread:.3} | {claimed:.3} |");
        assert!((90.0..=98.0).contains(&covered), "{name}: {covered} %");
    }
}

/// A drive on a rail: a force, a mass, viscous and dry friction, and no spring.
fn drive() -> Ride {
    let (step, fine, n) = (0.01, 100, 3000);
    let (mass, viscous, dry) = (95.0, 200.0, 20.0);
    let h = step / fine as f64;
    let (mut x, mut v) = (0.0, 0.0);
    let (mut force, mut displacement) = (Vec::new(), Vec::new());
    for i in 0..n {
        let t = i as f64 * step;
        // A controller holds it to a course; the force is kept between the samples' splines.
        let course = 0.1 * (1.3 * t).sin() + 0.05 * (0.4 * t).sin();
        let rate = 0.13 * (1.3 * t).cos() + 0.02 * (0.4 * t).cos();
        let f = 2000.0 * (course - x) + 800.0 * (rate - v);
        force.push(f);
        displacement.push(x);
        for _ in 0..fine {
            let friction = viscous * v + dry * f64::tanh(v / 1e-3);
            v += h * (f - friction) / mass;
            x += h * v;
        }
    }
    let record = AxleRecord {
        road: vec![0.0; n],
        force: Some(force),
        displacement,
        acceleration: None,
        valid: vec![true; n],
        prescribed: false,
        plant: PlantRef::default(),
        band: None,
    };
    Ride {
        sensors: Vec::new(),
        axles: PerAxle {
            front: Some(record),
            rear: None,
        },
        samples: n,
        ..ride(0.0).0
    }
}

/// The k that fits best is below zero here; starts on both sides lead to it.
#[test]
fn a_drive_without_a_spring_is_fitted() {
    let ride = drive();
    let fitted = |mass, starts: &[PerAxle<Start>]| {
        let bike = Bike {
            mass_front_kg: mass,
            ..Bike::default()
        };
        fit(&ride, &bike, &Settings::default(), starts)
            .unwrap()
            .front
            .unwrap()
    };
    let places = [(-4.0, 4.0), (0.5, 2.0), (80.0, 5.0)].map(|(k, b)| starts_at(k, b));
    let found = places.each_ref().map(|at| fitted(Some(95.0), at));
    for fit in &found {
        assert!((-0.01..0.0).contains(&fit.plain.kappa), "{:?}", fit.plain);
        assert!((fit.train_rms / found[0].train_rms - 1.0).abs() < 1e-9);
    }
    let unweighed = fitted(None, &places.concat());
    assert!(unweighed.train_rms < found[0].train_rms);
    assert!((unweighed.estimate(false).mass_kg / 95.0 - 1.0).abs() < 0.2);
}

/// The silverbox: a cubic spring, so the plain model holds out at 6.2 to 7.0 mV (an independent fit: 6.30). Skipped
/// where ../shared is not at hand.
#[test]
fn val_silverbox_holds_out_as_elsewhere() {
    let Some(path) = crate::skips::recording("silverbox/SNLS80mV.csv") else {
        return;
    };
    let bytes = std::fs::read(path).unwrap();
    let map = [("force_f", "V1"), ("z_f", "V2")].map(|(c, v)| (c.to_owned(), v.to_owned()));
    let options = ReadOptions {
        map: map.into(),
        rate_hz: Some(610.35),
        rows: Some((40_650, 127_400)),
        ..ReadOptions::default()
    };
    let bike = Bike::default();
    let ride = read(&bytes, "SNLS80mV.csv", &bike, &options).unwrap();
    for held_out in [0.25, 0.4] {
        let settings = Settings {
            held_out,
            ..Settings::default()
        };
        let observed = observe(&ride, &bike, &settings).unwrap();
        let fits = fit(
            &ride,
            &bike,
            &settings,
            &[starts_from(&observed.instrumental)],
        )
        .unwrap();
        let rms = fits.front.unwrap().held_rms;
        println!("{held_out}: {rms}");
        assert!((6.2e-3..7.0e-3).contains(&rms), "{held_out}: {rms} V");
    }
}

/// A swing of 3 Hz or a bench of 3 Hz that noise drives, 20 s at 100 Hz.
fn bench(driven: bool) -> (Ride, Bike) {
    let (mut ride, mut bike) = ride(0.0);
    let (n, step) = (2000, 0.01);
    let mut noise = Normal::new(11);
    let force: Option<Vec<f64>> = driven.then(|| (0..n).map(|_| 120.0 * noise.draw()).collect());
    let road = vec![0.0; n];
    let kappa = (3.0 * std::f64::consts::TAU).powi(2);
    let input = Input::new(&road, force.as_deref(), step);
    let initial = if driven { [0.0; 2] } else { [0.05, 0.0] };
    let z = simulate(&input, kappa, 0.4, 1.0 / 40.0, 0.0, initial).0;
    ride.axles.front = Some(AxleRecord {
        road,
        force,
        displacement: z,
        acceleration: None,
        valid: vec![true; n],
        prescribed: false,
        plant: PlantRef::default(),
        band: None,
    });
    ride.axles.rear = None;
    (ride.samples, ride.step_s) = (n, step);
    bike.mass_front_kg = (!driven).then_some(40.0);
    (ride, bike)
}

#[test]
fn a_fit_from_a_wrong_basin_finds_the_right_one() {
    let truth = 40.0 * (3.0 * std::f64::consts::TAU).powi(2);
    for driven in [false, true] {
        let (ride, bike) = bench(driven);
        for factor in [1.0 / 7000.0, 0.2, 5.0, 200.0] {
            let from = starts_at(factor * truth / 40.0, 2.0);
            let found = fit(&ride, &bike, &Settings::default(), &from).unwrap();
            let e = found.front.unwrap().estimate(!driven);
            assert!(
                (e.k_n_m / truth - 1.0).abs() < 1e-3,
                "{factor} {driven}: {e:?}"
            );
            assert!(
                (e.b_n_s_m / 16.0 - 1.0).abs() < 1e-2,
                "{factor} {driven}: {e:?}"
            );
        }
    }
}

/// Squares that z = e^(-B/2m t) (a cos wt + b sin wt) + c leaves at k/m and B/m, with the best a, b and c.
fn left(rows: &[[f64; 2]], kappa: f64, beta: f64) -> f64 {
    let turn = (kappa - 0.25 * beta * beta).max(0.0).sqrt();
    let mut normal = nalgebra::Matrix4::<f64>::zeros();
    for [t, z] in rows {
        let fade = (-0.5 * beta * t).exp();
        let (sin, cos) = (turn * t).sin_cos();
        let row = nalgebra::Vector4::new(fade * cos, fade * sin, 1.0, *z);
        normal += row * row.transpose();
    }
    let inner = normal.fixed_view::<3, 3>(0, 0).into_owned();
    let outer = normal.fixed_view::<3, 1>(0, 3).into_owned();
    let solved = inner.cholesky().map(|c| c.solve(&outer));
    solved.map_or(f64::INFINITY, |x| normal[(3, 3)] - x.dot(&outer))
}

/// The plain fit of a swing leaves as little as the best of all frequencies and dampings, wherever it starts.
#[test]
fn val_no_grid_finds_a_better_plain_fit_of_a_recorded_swing() {
    for (file, column) in [
        ("pendulums/bicycle_fork_compound.csv", "gyro_V"),
        ("pendulums/bicycle_fork_torsional.csv", "gyro_V"),
        ("pendulums/encoder_swing.csv", "angle_rad"),
        ("magnet_beam/free_decay.csv", "beam_strain_1e-4"),
    ] {
        let Some(path) = crate::skips::recording(file) else {
            return;
        };
        let mut options = ReadOptions::default();
        options.map.insert("z_f".to_owned(), column.to_owned());
        let bike = Bike {
            mass_front_kg: Some(1.0),
            ..Bike::default()
        };
        let ride = read(&std::fs::read(path).unwrap(), file, &bike, &options).unwrap();
        let settings = Settings::default();
        let found = fit(&ride, &bike, &settings, &starts_at(1e3, 3.0)).unwrap();
        let plain = found.front.unwrap().plain;
        let end = Split::of(&ride, &settings).train.end;
        let z = &ride.axles.front.as_ref().unwrap().displacement;
        let rows: Vec<[f64; 2]> = (0..end)
            .step_by(end.div_ceil(3000))
            .map(|i| [i as f64 * ride.step_s, z[i]])
            .collect();
        let highest = 3.0 * plain.kappa.sqrt() / std::f64::consts::TAU;
        let count = (4.0 * highest * end as f64 * ride.step_s) as usize;
        let mut least = f64::INFINITY;
        for i in 1..count {
            let omega = std::f64::consts::TAU * highest * i as f64 / count as f64;
            for j in 0..16 {
                let beta = 2.0 * omega * 5e-4 * 1.6_f64.powi(j);
                least = least.min(left(&rows, omega * omega, beta));
            }
        }
        let own = left(&rows, plain.kappa, plain.beta);
        assert!(own <= 1.001 * least, "{file}: {own} instead of {least}");
    }
}
