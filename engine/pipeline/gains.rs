//! A displacement sensor's gain on an axle that only a force moves. Where z is read g times too large, m z'' + B z' + k z = F
//! becomes the same equation of an axle with m, B and k divided by g: the ride shows m/g, and only the bike file's mass
//! makes a gain of that.

use veloid_core::bicycle::{Axle, Bike, PerAxle};
use veloid_core::document::format_number::significant;
use veloid_report::Estimate;
use veloid_report::diagnosis::Diagnosis;
use veloid_ride::Ride;

/// Gains of the verdict that another mass explains as well, by axle.
fn gains(ride: &Ride, diagnosis: &Diagnosis) -> PerAxle<f64> {
    let mut found = PerAxle::default();
    for (axle, record) in ride.axles.iter() {
        let only_a_force = record.force.is_some() && !record.has_road() && !record.prescribed;
        let mut effects = diagnosis.effects.iter().filter(|_| only_a_force);
        let effect = effects.find(|e| e.id == "sensor_gain" && e.adequate && e.axle.acts_on(axle));
        if let Some(gain) = effect.and_then(|e| e.parameters.get("gain")) {
            found.set(axle, gain.value);
        }
    }
    found
}

/// The estimates without intervals of the axles on which a gain and a mass are alike.
pub fn withheld(
    ride: &Ride,
    diagnosis: &Diagnosis,
    estimates: &PerAxle<Estimate>,
) -> PerAxle<Estimate> {
    let gains = gains(ride, diagnosis);
    estimates.map(|axle, e| match gains.get(axle) {
        None => e.clone(),
        Some(gain) => e.clone().withheld(&format!(
            "a mass {0} times that of the bike file explains the ride as well as the displacement sensor's gain, with k and B {0} times as \
             large: weigh the axle or calibrate the sensor",
            significant(1.0 / gain, 3)
        )),
    })
}

/// The other reading of each such gain.
pub fn tie(ride: &Ride, bike: &Bike, diagnosis: &Diagnosis) -> Option<String> {
    let other = |(axle, gain): (Axle, &f64)| {
        let mass = bike.mass(axle)?;
        let [declared, other] = [mass, mass / gain].map(|kg| significant(kg, 3));
        Some(format!(
            "At the {axle} axle, which only a force moves, a mass of {other} kg in place of the {declared} kg of the bike file explains the \
             ride as well as the gain, with other k and B: weigh the axle or calibrate the sensor."
        ))
    };
    let others: Vec<String> = gains(ride, diagnosis).iter().filter_map(other).collect();
    (!others.is_empty()).then(|| others.join(" "))
}
