//! Rides without a sensor for the road, from outside.

use serde_json::Value;

use crate::harness::{self, Folder, Server, veloid};

/// A ride of two accelerometers and a speed, its bike, and the truth.
fn simulated(folder: &Folder) -> [String; 3] {
    let paths = ["ride.csv", "bike.json", "truth.json"]
        .map(|name| folder.0.join(name).to_str().unwrap().to_owned());
    let [ride, bike, truth] = &paths;
    let bicycle = ["--stiffness", "110000:95000", "--damping", "1150:900"];
    let road = ["--road", "c", "--accelerometers", "0.03"];
    let written = ["simulate", ride, "--bike", bike, "--truth", truth];
    let done = veloid(&[&written[..], &bicycle, &road].concat());
    assert!(done.status.success(), "{done:?}");
    paths
}

fn is_found(report: &Value, truth: &str) {
    let truth: Value = serde_json::from_slice(&std::fs::read(truth).unwrap()).unwrap();
    let found = &report["latent_road"];
    for axle in ["front", "rear"] {
        for (key, most) in [("k_n_m", 0.02), ("b_n_s_m", 0.04)] {
            let value = |of: &Value| of[axle][key].as_f64().unwrap();
            let off = value(found) / value(&truth) - 1.0;
            assert!(off.abs() < most, "{axle} {key}: {off}");
        }
        assert!(found[axle]["k_std_n_m"].as_f64().unwrap() > 0.0);
        assert!(report["output_error"][axle].is_null());
    }
    assert_eq!(found["road"]["class"], "C");
    let diagnosis = &report["diagnosis"];
    assert_eq!(diagnosis["verdict"], "cannot_tell");
    let said = diagnosis["sentence"].as_str().unwrap();
    assert!(said.contains("the road was not measured"), "{said}");
    let notes = report["comparison"]["notes"].to_string();
    assert!(notes.contains("skipped"), "{notes}");
}

#[test]
fn the_command_line_needs_no_road() {
    let folder = Folder::new();
    let [ride, bike, truth] = simulated(&folder);
    let (report, summary) = harness::identify(ride.as_ref(), bike.as_ref(), &[]);
    is_found(&report, &truth);
    for said in [
        "latent road     front",
        "road: ISO 8608 class C",
        "a_r: noise 0.0",
        "was not measured",
    ] {
        assert!(summary.contains(said), "{said}: {summary}");
    }
}

#[tokio::test]
async fn a_server_identifies_and_shows_it() {
    let folder = Folder::new();
    let [ride, bike, truth] = simulated(&folder);
    let server = Server::start();
    let (ride, bike) = (
        std::fs::read(ride).unwrap(),
        std::fs::read_to_string(bike).unwrap(),
    );
    let answer = server.upload(ride, &bike, &[]).await;
    assert_eq!(answer.status(), 202);
    let job = answer.headers()["location"].to_str().unwrap().to_owned();
    server.succeeded(&job).await;
    is_found(&server.json(&format!("{job}/report")).await, &truth);
    let id = job.rsplit('/').next().unwrap();
    let page = server.get(&format!("/jobs/{id}")).await;
    assert_eq!(page.status(), 200);
    let page = page.text().await.unwrap();
    for said in [
        "Method: latent road",
        "ISO 8608 class C",
        "Latent road (none measured)",
    ] {
        assert!(page.contains(said), "{said}");
    }
    let found = server.json("/v1/parameters?method=latent_road").await;
    assert_eq!(found["items"].as_array().map(Vec::len), Some(4), "{found}");
    for path in ["series", "trials", "model", "model?format=matlab"] {
        let answer = server.get(&format!("{job}/{path}")).await;
        assert_eq!(answer.status(), 200, "{path}");
    }
    assert_eq!(server.get("/bikes/simulated").await.status(), 200);
}

#[test]
fn one_accelerometer_alone_is_reported_so() {
    let folder = Folder::new();
    let [ride, bike, _] = simulated(&folder);
    let text = std::fs::read_to_string(&ride).unwrap();
    std::fs::write(&ride, text.replacen("a_r", "other", 1)).unwrap();
    let (report, summary) = harness::identify(ride.as_ref(), bike.as_ref(), &["--trials", "2"]);
    assert!(report["latent_road"]["front"].is_null());
    assert_eq!(report["diagnosis"]["verdict"], "cannot_tell");
    assert!(summary.contains("one accelerometer alone"), "{summary}");
}

/// A ride of the paper's bench: accelerometers at 100 Hz, a laser at 30 Hz on a logger whose clock is `clock` (ms, ppm).
fn bench(folder: &Folder, clock: &str, more: &[&str]) -> [String; 2] {
    let [ride, bike] =
        ["ride.csv", "bike.json"].map(|name| folder.0.join(name).to_str().unwrap().to_owned());
    let laser = format!("rear:2e-4:{clock}");
    let sensors = ["--accelerometers", "0.03", "--laser", &laser, "--road", "c"];
    let written = ["simulate", &ride, "--bike", &bike];
    let done = veloid(&[&written[..], &sensors, more].concat());
    assert!(done.status.success(), "{done:?}");
    [ride, bike]
}

/// Whether the clock was found and set right, and k and B of the rear axle with it.
fn is_set_right(report: &Value, offset_s: f64, drift_ppm: f64) {
    let clock = &report["ride"]["clocks"][0];
    assert_eq!(clock["channel"], "d_r");
    assert_eq!(clock["applied"], true, "{clock}");
    let value = |key: &str| clock["found"][key].as_f64().unwrap();
    for (key, std, truth, most) in [
        ("offset_s", "offset_std_s", offset_s, 1e-3),
        ("drift_ppm", "drift_std_ppm", drift_ppm, 10.0),
    ] {
        let off = (value(key) - truth).abs();
        assert!(off < most && off < 3.0 * value(std), "{key}: {clock}");
    }
    for (key, std, truth, most) in [
        ("k_n_m", "k_std_n_m", 110e3, 0.01),
        ("b_n_s_m", "b_std_n_s_m", 1150.0, 0.03),
    ] {
        let value = |key: &str| report["output_error"]["rear"][key].as_f64().unwrap();
        let off = (value(key) / truth - 1.0).abs();
        assert!(off < most, "{key}: {off}");
        let part = report["laser_error"]["rear"][key].as_f64().unwrap();
        assert!(part > 0.0 && value(std) > part, "{key}: {part}");
    }
}

#[test]
fn a_lasers_clock_is_set_right() {
    for (clock, more) in [
        ("20:200", &[][..]),
        ("-1000:-50", &[]),
        ("2500:100", &["--seed", "2"]),
    ] {
        let folder = Folder::new();
        let [ride, bike] = bench(&folder, clock, more);
        let (report, summary) = harness::identify(ride.as_ref(), bike.as_ref(), &["--trials", "2"]);
        let (offset, drift) = clock.split_once(':').unwrap();
        let (offset, drift): (f64, f64) = (offset.parse().unwrap(), drift.parse().unwrap());
        is_set_right(&report, 1e-3 * offset, drift);
        assert!(
            summary.contains("d_r was corrected to the clock of a_r"),
            "{summary}"
        );
        assert_eq!(report["diagnosis"]["verdict"], "nothing_missing", "{clock}");
        let notes = report["comparison"]["notes"].to_string();
        assert!(notes.contains("rear axle: the laser"), "{notes}");
    }
}

#[test]
fn one_axle_tells_the_clock_but_not_what_is_missing() {
    let folder = Folder::new();
    let [ride, bike] = bench(&folder, "20:100", &["--only", "rear"]);
    for speed in [true, false] {
        if !speed {
            let text = std::fs::read_to_string(&ride).unwrap();
            std::fs::write(&ride, text.replacen(",v,", ",other,", 1)).unwrap();
        }
        let (report, _) = harness::identify(ride.as_ref(), bike.as_ref(), &["--trials", "2"]);
        let found = &report["ride"]["clocks"][0]["found"];
        let off = found["offset_s"].as_f64().unwrap() - 0.02;
        let std = found["offset_std_s"].as_f64().unwrap();
        assert!(std < 1e-3 && off.abs() < 3.0 * std, "{found}");
        let k = report["output_error"]["rear"]["k_n_m"].as_f64().unwrap();
        assert!((k / 110e3 - 1.0).abs() < 0.02, "{k}");
        assert_eq!(report["latent_road"].is_null(), !speed);
        assert_eq!(report["diagnosis"]["verdict"], "cannot_tell");
        let said = report["diagnosis"]["sentence"].as_str().unwrap();
        assert!(said.contains("looks the same as a late clock"), "{said}");
    }
}

#[test]
fn a_laser_of_another_ride_has_no_verdict() {
    let folder = Folder::new();
    let [ride, bike] = bench(&folder, "0", &[]);
    let elsewhere = Folder::new();
    let [other, _] = bench(&elsewhere, "0", &["--seed", "9"]);
    let [own, others] = [&ride, &other].map(|path| std::fs::read_to_string(path).unwrap());
    let mixed = own.lines().zip(others.lines()).map(|(own, other)| {
        let (sensors, _) = own.rsplit_once(',').unwrap();
        let (_, laser) = other.rsplit_once(',').unwrap();
        format!("{sensors},{laser}\n")
    });
    std::fs::write(&ride, mixed.collect::<String>()).unwrap();
    let (report, summary) = harness::identify(ride.as_ref(), bike.as_ref(), &["--trials", "2"]);
    let clock = &report["ride"]["clocks"][0];
    assert!(
        clock["found"].is_null() && clock["reason"].is_string(),
        "{clock}"
    );
    assert_eq!(report["diagnosis"]["verdict"], "cannot_tell");
    assert!(
        summary.contains("the clock offset between d_r and a_r is unknown"),
        "{summary}"
    );
}

#[tokio::test]
async fn a_server_says_what_was_done_to_a_clock() {
    let folder = Folder::new();
    let [ride, bike] = bench(&folder, "20:100", &[]);
    let server = Server::start();
    let bytes = std::fs::read(ride).unwrap();
    let bike = std::fs::read_to_string(bike).unwrap();
    let answer = server.upload(bytes, &bike, &[]).await;
    let job = answer.headers()["location"].to_str().unwrap().to_owned();
    server.succeeded(&job).await;
    is_set_right(&server.json(&format!("{job}/report")).await, 0.02, 100.0);
    let id = job.rsplit('/').next().unwrap();
    let page = server
        .get(&format!("/jobs/{id}"))
        .await
        .text()
        .await
        .unwrap();
    for said in [
        "d_r was corrected to the clock of a_r",
        "rear axle: the laser",
    ] {
        assert!(page.contains(said), "{said}");
    }
    let series = server.get(&format!("{job}/series")).await;
    assert_eq!(series.status(), 200);
}

#[test]
fn lasers_that_cannot_be_are_refused() {
    let folder = Folder::new();
    let ride = folder.0.join("ride.csv").to_str().unwrap().to_owned();
    let refused = |more: &[&str]| {
        let done = veloid(&[&["simulate", &ride][..], more].concat());
        assert!(!done.status.success(), "{done:?}");
        String::from_utf8(done.stderr).unwrap()
    };
    let sensors = ["--accelerometers", "0.03"];
    for (more, said) in [
        (
            &["--laser", "middle:1e-4"][..],
            "'middle' is not front or rear",
        ),
        (&["--laser", "rear:x"], "'x' is not a number"),
        (&["--laser", "rear:1e-4:0:0:0"], "expected AXLE:NOISE"),
        (&["--laser", "rear:-1"], "noise of the laser"),
        (&["--laser", "rear:0:0:1e9"], "drift of the laser's clock"),
        (
            &["--laser", "rear:0", "--laser", "rear:1e-4"],
            "two on the rear axle",
        ),
        (
            &["--laser", "rear:0", "--only", "front"],
            "nothing else is recorded",
        ),
        (
            &["--laser", "rear:0", "--laser-rate", "0"],
            "rate of the laser",
        ),
    ] {
        let answer = refused(&[&sensors[..], more].concat());
        assert!(answer.contains(said), "{said}: {answer}");
    }
    assert!(refused(&["--laser", "rear:0"]).contains("--accelerometers"));
}

/// The ride as an accelerometer and a laser on each axle record it, all on one logger at 100 Hz.
fn on_one_logger(ride: &str) {
    let text = std::fs::read_to_string(ride).unwrap();
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let rows: Vec<Vec<f64>> = lines
        .map(|line| line.split(',').map(|x| x.parse().unwrap()).collect())
        .collect();
    let column = |name: &str| names.iter().position(|n| *n == name).unwrap();
    let step = rows[1][0] - rows[0][0];
    let thin = (0.01 / step).round() as usize;
    let mut made = "t,a_f,a_r,d_f,d_r,v\n".to_owned();
    for i in (thin..rows.len() - 1).step_by(thin) {
        let z = |row: usize, axle: &str| rows[row][column(&format!("z_{axle}"))];
        let a = |axle| (z(i - 1, axle) - 2.0 * z(i, axle) + z(i + 1, axle)) / (step * step);
        let d = |axle| rows[i][column(&format!("u_{axle}"))] - z(i, axle);
        let [a, d] = [["f", "r"].map(a), ["f", "r"].map(d)];
        let cells = [rows[i][0], a[0], a[1], d[0], d[1], rows[i][column("v")]];
        made += &cells.map(|x| format!("{x:?}")).join(",");
        made.push('\n');
    }
    std::fs::write(ride, made).unwrap();
}

#[test]
fn what_delays_a_force_is_not_taken_for_a_clock() {
    for (effect, passes_for_ms) in [
        (
            "viscoelastic_tyre:front:branch_stiffness=30000,relaxation_time=0.01",
            -0.7,
        ),
        (
            "unsprung_mass:front:mass_fraction=0.1,natural_frequency=18,damping_ratio=0.1",
            -2.2,
        ),
    ] {
        let folder = Folder::new();
        let [ride, bike] =
            ["ride.csv", "bike.json"].map(|name| folder.0.join(name).to_str().unwrap().to_owned());
        let written = [
            "simulate", &ride, "--bike", &bike, "--rate", "1000", "--road", "c",
        ];
        let done = veloid(&[&written[..], &["--effect", effect]].concat());
        assert!(done.status.success(), "{done:?}");
        on_one_logger(&ride);
        let (report, _) = harness::identify(ride.as_ref(), bike.as_ref(), &["--trials", "2"]);
        let clock = &report["ride"]["clocks"][0];
        let late_ms = 1e3 * clock["found"]["middle_offset_s"].as_f64().unwrap();
        assert!((late_ms - passes_for_ms).abs() < 0.1, "{clock}");
        assert_eq!(report["diagnosis"]["verdict"], "cannot_tell");
        let said = report["diagnosis"]["sentence"].as_str().unwrap();
        assert!(said.contains("accelerometers alone"), "{said}");
    }
}
