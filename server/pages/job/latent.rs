//! What was found out about a ride without a road sensor, in lines.

use veloid_engine::document::format_number::{Quantity, significant};
use veloid_engine::report::{Correction, LatentRoad, SensorFound};

/// Terms and what they are.
pub fn lines(latent: &LatentRoad) -> Vec<(String, String)> {
    let mut lines = Vec::new();
    let mut line = |term: &str, text: String| lines.push((term.to_owned(), text));
    if let Some(reason) = &latent.reason {
        line("Not identified", reason.clone());
        return lines;
    }
    if let Some(road) = &latent.road {
        line(
            "Road",
            format!(
                "ISO 8608 class {}, {} cm³ at 0.1 cycles/m, observed from {} to {} cycles/m",
                road.class,
                significant(1e6 * road.psd_m3, 3),
                significant(road.band_cycles_per_m[0], 2),
                significant(road.band_cycles_per_m[1], 2)
            ),
        );
    }
    if let Some(speed) = &latent.speed {
        line("Speed reads low by", reported(speed, 100.0, "%"));
    }
    for sensor in &latent.sensors {
        line(&sensor.channel, sensed(sensor));
    }
    line(
        "Data used",
        format!(
            "{} windows of {} s, {} Hz to {} Hz",
            latent.windows,
            significant(latent.window_s, 2),
            significant(latent.band_hz[0], 3),
            significant(latent.band_hz[1], 3)
        ),
    );
    for note in &latent.notes {
        line("Model mismatch", note.clone());
    }
    lines
}

/// The band of which stiffness and damping are, and the road's class.
pub fn band(latent: &LatentRoad) -> Option<String> {
    let road = latent.road.as_ref()?;
    let [low, high] = latent.band_hz.map(|hz| significant(hz, 3));
    Some(format!(
        "Identified from {low} Hz to {high} Hz, where both axles answer to the same road, of class {} (ISO 8608).",
        road.class
    ))
}

fn sensed(sensor: &SensorFound) -> String {
    let mut text = sensor.noise_in_words();
    if let Some(gain) = &sensor.gain {
        text += &format!(", gain {}", reported(gain, 1.0, "-"));
    }
    if let Some(delay) = &sensor.delay_s {
        text += &format!(", late by {}", reported(delay, 1e3, "ms"));
    }
    if let Some(drift) = &sensor.drift_ppm {
        text += &format!(", fast by {}", reported(drift, 1.0, "ppm"));
    }
    text
}

fn reported(correction: &Correction, scale: f64, unit: &str) -> String {
    let std_error = scale * correction.std_error;
    Quantity::new(scale * correction.value, Some(std_error), unit).to_string()
}
