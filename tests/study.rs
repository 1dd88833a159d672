//! Several rides as one, at the command line.

use std::path::Path;

use serde_json::Value;

use crate::harness::{Folder, veloid};

/// Three rides of half a minute that the program simulates, and their bike file.
fn rides(folder: &Folder) -> (Vec<String>, String) {
    let path = |name: &str| folder.0.join(name).to_str().unwrap().to_owned();
    let bike = path("bike.json");
    let rides: Vec<String> = (1..=3)
        .map(|seed| {
            let ride = path(&format!("ride{seed}.csv"));
            let seed = seed.to_string();
            let short = ["--duration", "30", "--noise", "2e-5"];
            let given = ["simulate", &ride, "--seed", &seed, "--bike", &bike];
            let output = veloid(&[&given[..], &short].concat());
            assert!(output.status.success(), "{output:?}");
            ride
        })
        .collect();
    (rides, bike)
}

fn studied(rides: &[String], more: &[&str]) -> std::process::Output {
    let mut given = vec!["study"];
    given.extend(rides.iter().map(String::as_str));
    given.extend(more);
    veloid(&given)
}

#[test]
fn rides_are_reported_as_one_and_each_by_its_name() {
    let folder = Folder::new();
    let (rides, bike) = rides(&folder);
    let json = folder.0.join("study.json");
    let output = studied(&rides, &["--bike", &bike, "--json", json.to_str().unwrap()]);
    assert!(output.status.success(), "{output:?}");
    let reported = String::from_utf8(output.stdout).unwrap();
    assert!(
        reported.contains("nothing is missing") && reported.contains("all together"),
        "{reported}"
    );
    let report: Value = serde_json::from_slice(&std::fs::read(Path::new(&json)).unwrap()).unwrap();
    let names: Vec<&str> = (report["rides"].as_array().unwrap().iter())
        .map(|r| r["name"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["ride1.csv", "ride2.csv", "ride3.csv"]);
    let k = |of: &Value| of["k_n_m"].as_f64().unwrap();
    let std = |of: &Value| of["k_std_n_m"].as_f64().unwrap();
    let whole = &report["axles"]["front"]["estimate"];
    assert!((k(whole) - 110e3).abs() < 4.0 * std(whole), "{whole}");
    let each = &report["rides"].as_array().unwrap();
    assert!(each.iter().all(|r| std(&r["axles"]["front"]) > std(whole)));
}

#[test]
fn a_ride_that_cannot_take_part_is_named_and_too_few_are_refused() {
    let folder = Folder::new();
    let (mut rides, bike) = rides(&folder);
    let flat = folder.0.join("flat.csv");
    let text = std::fs::read_to_string(&rides[2]).unwrap();
    let header = text
        .lines()
        .find(|l| l.starts_with("t,") || l.contains("z_f"))
        .unwrap();
    let still = (0..3000).map(|i| {
        let columns = header.split(',').count();
        format!("{}{}", f64::from(i) * 0.01, ",0".repeat(columns - 1))
    });
    let still: Vec<String> = still.collect();
    std::fs::write(&flat, format!("{header}\n{}\n", still.join("\n"))).unwrap();
    rides[2] = flat.to_str().unwrap().to_owned();
    let output = studied(&rides, &["--bike", &bike]);
    let reported = String::from_utf8_lossy(&output.stdout).into_owned();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    let left = reported.contains("excluded: flat.csv") || said.contains("flat.csv");
    assert!(left, "{reported}{said}");

    let few = studied(&rides[1..], &["--bike", &bike]);
    assert_eq!(few.status.code(), Some(2), "{few:?}");
    let bikes = studied(&rides, &["--bike", &bike, "--bike", &bike]);
    assert_eq!(bikes.status.code(), Some(2));
    let said = String::from_utf8_lossy(&bikes.stderr).into_owned();
    assert!(said.contains("2 bike files for 3 rides"), "{said}");
    let one = studied(&rides[..1], &["--bike", &bike]);
    assert_eq!(one.status.code(), Some(2));
}
