use veloid_core::Silent;
use veloid_core::bicycle::Bike;
use veloid_core::settings::Settings;
use veloid_methods::simulate::simulated_ride::SimulatedRide;

/// On a road k and B are as uncertain as the mass, in parts of themselves.
#[test]
fn a_masss_deviation_is_borne_in_proportion() {
    let bike = |std: Option<f64>| Bike {
        mass_front_kg: Some(23.0),
        mass_rear_kg: Some(63.0),
        mass_front_std_kg: std,
        ..Bike::default()
    };
    let settings = Settings {
        trials: 1,
        iterations: 2,
        diagnosis: false,
        ..Settings::default()
    };
    let ride = SimulatedRide::default().ride();
    let reported = |std| veloid_engine::identify(&ride, &bike(std), &settings, &Silent).unwrap();
    let (exact, unsure) = (reported(None), reported(Some(0.46)));
    let [before, after] = [&exact, &unsure].map(|r| r.output_error.front.clone().unwrap());
    assert_eq!((before.k_n_m, before.b_n_s_m), (after.k_n_m, after.b_n_s_m));
    let ratio = |std: Option<f64>, before: Option<f64>, value: f64| {
        (std.unwrap().powi(2) - before.unwrap().powi(2)).sqrt() / value
    };
    let k = ratio(after.k_std_n_m, before.k_std_n_m, after.k_n_m);
    let b = ratio(after.b_std_n_s_m, before.b_std_n_s_m, after.b_n_s_m);
    assert!(
        (k / 0.02 - 1.0).abs() < 0.02 && (b / 0.02 - 1.0).abs() < 0.02,
        "{k} {b}"
    );
    let rear = |r: &veloid_report::Report| r.output_error.rear.clone().unwrap().k_std_n_m;
    assert_eq!(rear(&exact), rear(&unsure));
    let said = unsure.comparison.notes.concat();
    assert!(
        said.contains("front axle: the mass's standard deviation moves k by 2"),
        "{said}"
    );
}
