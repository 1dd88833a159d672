//! Recordings of other people, which lie outside the repository.

use std::fmt::Write;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Instant;

use serde_json::Value;

use crate::files::{self, FilesError};

/// A recording, how it is read, and what those who know it found in it.
pub struct Recording {
    file: &'static str,
    mass_kg: Option<f64>,
    arguments: &'static [&'static str],
    known: &'static str,
    /// Most that may be left on the held-out part, in units of the file.
    most: Option<f64>,
}

pub const RECORDINGS: [Recording; 5] = [
    Recording {
        file: "silverbox/SNLS80mV.csv",
        mass_kg: None,
        arguments: &[
            "--map",
            "force_f=V1",
            "--map",
            "z_f=V2",
            "--rate",
            "610.35",
            "--rows",
            "40650:127400",
        ],
        known: "a cubic spring",
        most: Some(0.4e-3),
    },
    Recording {
        file: "spring_mass/real_linear_h_1.txt",
        mass_kg: Some(1.0),
        arguments: &["--map", "t=2", "--map", "z_f=3"],
        known: "nothing",
        most: None,
    },
    Recording {
        file: "pendulums/bicycle_fork_torsional.csv",
        mass_kg: Some(1.0),
        arguments: &["--map", "z_f=gyro_V"],
        known: "nothing",
        most: None,
    },
    Recording {
        file: "pendulums/encoder_swing.csv",
        mass_kg: Some(1.0),
        arguments: &["--map", "z_f=angle_rad"],
        known: "softening and dry friction",
        most: None,
    },
    Recording {
        file: "magnet_beam/free_decay.csv",
        mass_kg: Some(1.0),
        arguments: &["--map", "z_f=beam_strain_1e-4"],
        known: "hardening, and damping that grows with amplitude",
        most: None,
    },
];

/// What the binary says of each recording in `folder`, as a table.
pub fn table(binary: &Path, folder: &Path, work: &Path) -> Result<String, FilesError> {
    files::create_folder(work)?;
    let mut text = String::from(
        "| recording | known to be left out | verdict | named | held out, plain | held out, extended | at most | time (s) |\n|---|---|---|---|---|---|---|---|\n",
    );
    for recording in &RECORDINGS {
        text += &recording.row(binary, folder, work)?;
    }
    Ok(text)
}

impl Recording {
    fn row(&self, binary: &Path, folder: &Path, work: &Path) -> Result<String, FilesError> {
        let mut row = format!("| `{}` | {} |", self.file, self.known);
        let ride = folder.join(self.file);
        if !ride.exists() {
            return Ok(row + " not at hand | | | | | |\n");
        }
        let (bike, out) = (work.join("bike_real.json"), work.join("report_real.json"));
        let mass = serde_json::json!({"bike": "recording", "mass_front_kg": self.mass_kg});
        files::write(&bike, &format!("{mass:#}\n"))?;
        let begun = Instant::now();
        let run = Command::new(binary)
            .arg("identify")
            .args([&ride, Path::new("--bike"), &bike, Path::new("--json"), &out])
            .args(self.arguments)
            .stdin(Stdio::null())
            .output();
        let seconds = begun.elapsed().as_secs_f64();
        if !run.is_ok_and(|done| done.status.success()) {
            return Ok(row + " failed | | | | | |\n");
        }
        let said = said(&files::read_json(&out)?["diagnosis"]);
        let most = self
            .most
            .map_or(String::new(), |most| format!("{most:.2e}"));
        let _ = writeln!(row, " {said} | {most} | {seconds:.1} |");
        Ok(row)
    }
}

/// Verdict, effects and both held-out errors of a diagnosis.
fn said(diagnosis: &Value) -> String {
    let effects = diagnosis["effects"].as_array();
    let named: Vec<String> = effects
        .into_iter()
        .flatten()
        .filter_map(|effect| Some(format!("`{}`", effect["id"].as_str()?)))
        .collect();
    let rms = |which| match diagnosis["held_out"]["front"][which].as_f64() {
        Some(rms) => format!("{rms:.2e}"),
        None => "-".to_owned(),
    };
    format!(
        "{} | {} | {} | {}",
        diagnosis["verdict"].as_str().unwrap_or("-"),
        named.join(", "),
        rms("plain_rms_m"),
        rms("extended_rms_m")
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_recording_is_a_row_whether_it_is_at_hand_or_not() {
        let said = said(&json!({
            "verdict": "named", "effects": [{"id": "cubic_stiffness"}],
            "held_out": {"front": {"plain_rms_m": 6.547e-3, "extended_rms_m": 3.6e-4}}}));
        assert_eq!(said, "named | `cubic_stiffness` | 6.55e-3 | 3.60e-4");
        let nowhere = std::env::temp_dir().join(format!("veloid-real-{}", std::process::id()));
        let text = table(Path::new("nothing"), &nowhere, &nowhere).expect("a table");
        std::fs::remove_dir_all(&nowhere).expect("removed");
        let columns = |line: &str| line.matches('|').count();
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 2 + RECORDINGS.len());
        assert!(
            lines.iter().all(|line| columns(line) == columns(lines[0])),
            "{text}"
        );
        assert!(text.contains("not at hand"));
    }
}
