//! Exported scripts on rides that the model is not from.

use std::process::{Command, Output};

use crate::harness::{Folder, veloid};
use crate::skips::skip;

/// What both rides have, options of the identification and of the other ride, and its samples.
type Case = (
    &'static [&'static str],
    &'static [&'static str],
    &'static [&'static str],
    usize,
);

/// With other rates and lengths than the model's 30 s at 100 Hz.
const CASES: [Case; 4] = [
    (
        &["--effect", "coulomb_friction:front:friction=40"],
        &[],
        &["--rate", "160", "--duration", "15"],
        2401,
    ),
    (
        &[
            "--effect",
            "viscoelastic_tyre:rear:branch_stiffness=60000,relaxation_time=0.03",
        ],
        &[],
        &["--rate", "250", "--duration", "12"],
        3001,
    ),
    (
        &[],
        &["--no-diagnosis"],
        &["--rate", "128", "--duration", "20"],
        2561,
    ),
    (
        &["--shaker", "300:1:12"],
        &["--no-diagnosis"],
        &["--rate", "100", "--duration", "30"],
        3001,
    ),
];

#[test]
fn scripts_simulate_other_rides_and_agree() {
    for (both, identified, other, samples) in CASES {
        let folder = Folder::new();
        simulate(&folder, "own.csv", &[both, &["--duration", "30"]].concat());
        simulate(
            &folder,
            "other.csv",
            &[both, other, &["--seed", "7"]].concat(),
        );
        export(&folder, identified);
        let Some(found) = play(&folder, "other.csv") else {
            return;
        };
        assert!(found.iter().all(|(fit, _)| *fit > 97.0), "{found:?}");
        assert!(found.iter().all(|(_, n)| *n == samples), "{found:?}");
        with_gaps(&folder);
        let with_gaps = play(&folder, "gaps.csv").unwrap();
        for ((whole, _), (fit, n)) in found.iter().zip(with_gaps) {
            assert!((fit - whole).abs() < 2.0 && n == samples, "{fit} {whole}");
        }
    }
}

/// A column that is missing is named with its header.
#[test]
fn scripts_name_a_missing_column() {
    let folder = Folder::new();
    simulate(&folder, "own.csv", &["--duration", "20"]);
    export(&folder, &["--no-diagnosis"]);
    let increasing: String = (0..20).map(|i| format!("{i},0.1,0.2,0.3\n")).collect();
    folder.write("other.csv", "t,u_f,u_r,z_f\n".to_owned() + &increasing);
    for output in [python(&folder, "other.csv"), octave(&folder, "other.csv")] {
        let Some(output) = output else { continue };
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(1), "{output:?}");
        assert!(
            said.contains("no column for z_r: expected the header \"z_r\""),
            "{said}"
        );
    }
}

fn simulate(folder: &Folder, name: &str, arguments: &[&str]) {
    let [ride, bike] = [name, "bike.json"].map(|name| folder.0.join(name));
    let [ride, bike] = [&ride, &bike].map(|path| path.to_str().unwrap());
    let made = ["simulate", ride, "--bike", bike, "--noise", "2e-5"];
    let output = veloid(&[&made[..], arguments].concat());
    assert!(output.status.success(), "{output:?}");
}

/// Identifies own.csv and writes both scripts.
fn export(folder: &Folder, arguments: &[&str]) {
    let paths = ["own.csv", "bike.json", "veloid_model.py", "veloid_model.m"]
        .map(|name| folder.0.join(name).display().to_string());
    let [ride, bike, python, octave] = &paths;
    let asked = ["identify", ride, "--bike", bike, "--trials", "1"];
    let written = ["--iterations", "2", "--model", python, "--model", octave];
    let output = veloid(&[&asked[..], &written, arguments].concat());
    assert!(output.status.success(), "{output:?}");
}

/// Every eighth row of other.csv without its last cell, and every fiftieth row left out.
fn with_gaps(folder: &Folder) {
    let whole = std::fs::read_to_string(folder.0.join("other.csv")).unwrap();
    let rows = whole.lines().filter(|line| !line.starts_with('#'));
    let rows = rows.enumerate().filter(|(i, _)| i % 50 != 49);
    let rows = rows.map(|(i, row)| match row.rsplit_once(',') {
        Some((kept, _)) if i % 8 == 5 => format!("{kept},\n"),
        _ => format!("{row}\n"),
    });
    folder.write("gaps.csv", rows.collect::<String>());
}

/// Runs both scripts, which must agree; of each axle the fit (%) and the number of samples.
fn play(folder: &Folder, ride: &str) -> Option<Vec<(f64, usize)>> {
    let (by_python, by_octave) = (python(folder, ride)?, octave(folder, ride)?);
    let said = String::from_utf8_lossy(&by_python.stdout).into_owned();
    assert!(by_python.status.success(), "{by_python:?}");
    assert_eq!(said, String::from_utf8_lossy(&by_octave.stdout));
    eprintln!("{ride}: {said}");
    let [a, b] = ["python.csv", "octave.csv"].map(|name| curves(folder, name));
    for (a, b) in a.iter().zip(&b) {
        let largest = a.iter().fold(0.0, |most: f64, z| most.max(z.abs()));
        let off = a.iter().zip(b).map(|(a, b)| (a - b).abs());
        let off = off.fold(0.0, f64::max) / largest;
        assert!(a.len() == b.len() && off < 1e-6, "{ride}: {off}");
    }
    let fits = said.lines().map(|line| {
        let (_, behind) = line.split_once("fit ").unwrap_or_else(|| panic!("{said}"));
        behind.split(' ').next().unwrap().parse().unwrap()
    });
    Some(fits.zip(a).map(|(fit, z)| (fit, z.len())).collect())
}

/// The columns that a script wrote.
fn curves(folder: &Folder, name: &str) -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(folder.0.join(name)).unwrap();
    let mut columns = Vec::new();
    for line in text.lines() {
        for (i, cell) in line.split(',').enumerate() {
            columns.resize(columns.len().max(i + 1), Vec::new());
            columns[i].push(cell.parse().unwrap());
        }
    }
    columns
}

fn python(folder: &Folder, ride: &str) -> Option<Output> {
    let code = format!(
        "import numpy, veloid_model as m; t, z = m.main('{ride}'); \
         numpy.savetxt('python.csv', numpy.column_stack(list(z.values())), delimiter=',')"
    );
    let run = |code: &str| {
        let mut python = Command::new("python3");
        python.args(["-c", code]).current_dir(&folder.0).output()
    };
    if !run("import numpy, scipy").is_ok_and(|output| output.status.success()) {
        skip("no python3 with numpy and scipy to run the script");
        return None;
    }
    Some(run(&code).unwrap())
}

fn octave(folder: &Folder, ride: &str) -> Option<Output> {
    if Command::new("octave").arg("--version").output().is_err() {
        skip("no octave to run the script");
        return None;
    }
    let call =
        format!("[t, z] = veloid_model('{ride}'); dlmwrite('octave.csv', z, 'precision', 15);");
    let mut octave = Command::new("octave");
    octave.args(["--no-gui", "--quiet", "--eval", &call]);
    Some(octave.current_dir(&folder.0).output().unwrap())
}
