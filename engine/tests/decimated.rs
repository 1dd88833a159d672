use veloid_methods::simulate::simulated_ride::SimulatedRide;
use veloid_ride::decimated;

#[test]
fn what_is_slow_keeps_its_shape_on_fewer_samples() {
    let mut ride = SimulatedRide::default().ride();
    let step = ride.step_s;
    let swing = |t: f64| 1e-3 * (2.0 * t).sin();
    for record in [&mut ride.axles.front, &mut ride.axles.rear]
        .into_iter()
        .flatten()
    {
        record.displacement = (0..ride.samples).map(|i| swing(i as f64 * step)).collect();
        record.valid[1234] = false;
    }
    let fewer = decimated(&ride, 0.5).unwrap_or_else(|| unreachable!("0.5 Hz at 100 Hz"));
    let factor = (fewer.step_s / step).round() as usize;
    assert!(factor > 1 && fewer.samples >= 1000, "{factor}");
    for (_, record) in fewer.axles.iter() {
        assert_eq!(record.displacement.len(), fewer.samples);
        for i in 20..fewer.samples - 20 {
            let error = record.displacement[i] - swing(i as f64 * fewer.step_s);
            assert!(error.abs() < 1e-6, "{i}: {error}");
        }
        assert!(!record.valid[1234 / factor]);
    }
    assert!(decimated(&ride, 20.0).is_none());
}
