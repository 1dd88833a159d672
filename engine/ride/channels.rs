//! The channels of a ride under the names that files have for them.

use super::{Ride, channel_name};

impl Ride {
    /// Names and values of what was recorded, each as long as the ride has samples, in SI units; not the time
    /// ([`Ride::time_s`]).
    pub fn channels(&self) -> Vec<(&'static str, &[f64])> {
        let mut channels: Vec<(&str, &[f64])> = Vec::new();
        for (axle, names) in [
            (&self.axles.front, ["u_f", "z_f", "force_f", "a_f"]),
            (&self.axles.rear, ["u_r", "z_r", "force_r", "a_r"]),
        ] {
            let Some(record) = axle else { continue };
            if record.has_road() {
                channels.push((names[0], &record.road));
            }
            channels.push((names[1], &record.displacement));
            for (name, values) in [(names[2], &record.force), (names[3], &record.acceleration)] {
                channels.extend(values.as_deref().map(|values| (name, values)));
            }
        }
        let sensors = self.sensors.iter();
        channels.extend(sensors.map(|s| (channel_name(s.kind, s.axle), s.values.as_slice())));
        for (name, channel) in [
            ("v", &self.speed),
            ("cadence", &self.cadence),
            ("roll", &self.roll),
            ("steer", &self.steer),
            ("yaw_rate", &self.yaw_rate),
            ("v_lat", &self.lateral_speed),
        ] {
            channels.extend(channel.as_deref().map(|values| (name, values)));
        }
        channels
    }
}
