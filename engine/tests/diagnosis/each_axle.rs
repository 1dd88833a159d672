//! An axle with physics of the library beside one with physics that is in none.

use super::*;

/// N/m^3
const K3: f64 = 3e9;

#[test]
#[ignore = "slow"]
fn each_axle_is_judged_whatever_happens_on_the_other() {
    let stiffening = ride(|_, d, _| K3 * d.powi(3));
    // A damper that is switched over every three seconds.
    let switched = ride(|t, _, w| match (t / 3.0) as usize % 2 {
        0 => 2.5 * B * w,
        _ => 0.0,
    });
    let both = Ride {
        axles: PerAxle {
            front: stiffening.axles.front.clone(),
            rear: switched.axles.front,
        },
        ..stiffening
    };
    let d = diagnosed(&both);
    let affirmed = d.effects.iter().filter(|e| e.affirmed);
    let affirmed: Vec<_> = affirmed.map(|e| (e.id.as_str(), e.axle)).collect();
    assert_eq!(
        affirmed,
        [("cubic_stiffness", Place::Front)],
        "{}",
        d.sentence
    );
    assert_eq!(d.verdict, Verdict::NamedInPart, "{}", d.sentence);
    let found = d.effects[0].parameters["k3"].value;
    let rest = d.rest.unwrap();
    assert!(
        rest.front.is_none() && rest.rear.is_some(),
        "{}",
        d.sentence
    );
    assert!((found / K3 - 1.0).abs() < 0.05, "{found}");
}
