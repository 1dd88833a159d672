//! What a column may be chosen to hold.

use veloid_engine::ride::channels;

/// A channel, what it is, and the units that its numbers may have.
pub struct Choice {
    pub channel: &'static str,
    pub meaning: &'static str,
    units: &'static [&'static str],
}

impl Choice {
    /// The units, with commas between.
    pub fn units(&self) -> String {
        self.units.join(",")
    }
}

/// Every channel.
pub fn choices() -> Vec<Choice> {
    channels()
        .map(|(channel, units)| Choice {
            channel,
            meaning: meaning(channel),
            units,
        })
        .collect()
}

fn meaning(channel: &str) -> &'static str {
    match channel {
        "t" => "time",
        "u_f" => "road, front",
        "u_r" => "road, rear",
        "z_f" => "displacement, front",
        "z_r" => "displacement, rear",
        "d_f" => "laser, front",
        "d_r" => "laser, rear",
        "a_f" => "acceleration, front",
        "a_r" => "acceleration, rear",
        "force_f" => "force, front",
        "force_r" => "force, rear",
        "v" => "speed",
        "v_lat" => "lateral speed",
        "cadence" => "cadence",
        "roll" => "roll angle",
        "steer" => "steering angle",
        "yaw_rate" => "yaw rate",
        _ => "",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_channel_has_its_meaning_and_units() {
        for choice in choices() {
            assert!(!choice.meaning.is_empty(), "{}", choice.channel);
            assert!(!choice.units().is_empty(), "{}", choice.channel);
        }
    }
}
