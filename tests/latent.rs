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
    for sensor in found["sensors"].as_array().unwrap() {
        let count = |key: &str| sensor[key].as_array().map_or(0, Vec::len);
        assert!(count("density") > 30, "{sensor}");
        assert_eq!(count("density"), count("frequency_hz"));
    }
    assert_eq!(found["road"]["class"], "C");
    let diagnosis = &report["diagnosis"];
    assert_eq!(diagnosis["verdict"], "nothing_missing", "{diagnosis}");
    let detectable = diagnosis["detectable"].as_array().unwrap();
    let friction = detectable.iter().find(|d| d["id"] == "coulomb_friction");
    let friction = friction.unwrap()["smallest_detectable"].as_f64().unwrap();
    assert!((0.1..10.0).contains(&friction), "{friction} N");
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
        "a_f: noise 0.0",
        "explain this ride to within its noise",
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
        "where both axles answer to the same road, of class C",
        "id=\"sensors\"",
        "id=\"road-spectrum\"",
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

/// The script simulates on a road that the user gives, and says so where there is none.
#[test]
fn a_model_without_a_road_needs_one() {
    let folder = Folder::new();
    let [ride, bike, _] = simulated(&folder);
    let script = folder.0.join("veloid_model.py");
    let found = [
        "identify",
        &ride,
        "--bike",
        &bike,
        "--model",
        script.to_str().unwrap(),
    ];
    assert!(veloid(&found).status.success());
    let road = folder.0.join("road.csv");
    let made = [
        "simulate",
        road.to_str().unwrap(),
        "--bike",
        &bike,
        "--road",
        "c",
    ];
    let bicycle = ["--stiffness", "110000:95000", "--damping", "1150:900"];
    assert!(veloid(&[&made[..], &bicycle].concat()).status.success());
    let scipy = ["-c", "import numpy, scipy"];
    let has = std::process::Command::new("python3").args(scipy).output();
    if !has.is_ok_and(|output| output.status.success()) {
        return crate::skips::skip("no python3 with numpy and scipy to run the script");
    }
    let run = |code: &str| {
        let mut python = std::process::Command::new("python3");
        python
            .args(["-c", code])
            .current_dir(&folder.0)
            .output()
            .unwrap()
    };
    let on_its_own = run("import veloid_model as m; m.main('ride.csv')");
    assert_eq!(on_its_own.status.code(), Some(1), "{on_its_own:?}");
    let said = String::from_utf8(on_its_own.stderr).unwrap();
    assert!(said.contains("u_f") && said.contains("a road"), "{said}");

    let off = "import numpy as np, veloid_model as m; t, z = m.main('road.csv'); table = m.read('road.csv'); \
        of = lambda name: np.array([float(cell) for cell in table[name]])[len(t) // 10:]; \
        off = [np.std(z[axle][len(t) // 10:] - of(name)) / np.std(of(name)) for axle, name in (('front', 'z_f'), ('rear', 'z_r'))]; \
        assert max(off) < 0.02, off";
    let on_a_road = run(off);
    assert!(on_a_road.status.success(), "{on_a_road:?}");
    let said = String::from_utf8(on_a_road.stdout).unwrap();
    assert!(
        said.contains("front: displacement") && said.contains("rear: displacement"),
        "{said}"
    );
}

/// One accelerometer alone identifies nothing, so there is nothing to simulate.
#[tokio::test]
async fn without_a_model_there_is_no_script() {
    let folder = Folder::new();
    let [ride, bike, _] = simulated(&folder);
    let whole = std::fs::read_to_string(&ride).unwrap();
    let lines = whole.lines().filter(|line| !line.starts_with('#'));
    let one = lines.map(|line| {
        let cells: Vec<&str> = line.split(',').collect();
        let header = whole.lines().find(|line| !line.starts_with('#')).unwrap();
        let kept = header
            .split(',')
            .zip(cells)
            .filter(|(name, _)| *name != "a_r");
        kept.map(|(_, cell)| cell).collect::<Vec<_>>().join(",") + "\n"
    });
    let one: String = one.collect();
    let path = folder.write("one.csv", &one);
    let script = folder.0.join("model.py");
    let said = veloid(&[
        "identify",
        path.to_str().unwrap(),
        "--bike",
        &bike,
        "--model",
        script.to_str().unwrap(),
    ]);
    assert_eq!(said.status.code(), Some(1), "{said:?}");
    assert!(!script.exists());
    let error = String::from_utf8(said.stderr).unwrap();
    assert!(
        error.contains("no model to simulate: one accelerometer alone"),
        "{error}"
    );

    let server = Server::start();
    let bicycle = std::fs::read_to_string(bike).unwrap();
    let answer = server.upload(one.into_bytes(), &bicycle, &[]).await;
    let job = answer.headers()["location"].to_str().unwrap().to_owned();
    server.succeeded(&job).await;
    for format in ["python", "matlab"] {
        let answer = server.get(&format!("{job}/model?format={format}")).await;
        assert_eq!(answer.status(), 409);
        let problem: Value = answer.json().await.unwrap();
        assert_eq!(problem["type"], "urn:veloid:problem:no-model");
        let detail = problem["detail"].as_str().unwrap();
        assert!(detail.contains("one accelerometer alone"), "{detail}");
    }
}

/// A concealed effect is named with its size at its axle, k and B are those beside it, and the page's figures have their data.
#[test]
fn an_effect_is_named_without_a_road() {
    let folder = Folder::new();
    let [ride, bike] =
        ["ride.csv", "bike.json"].map(|name| folder.0.join(name).to_str().unwrap().to_owned());
    let done = veloid(&[
        "simulate",
        &ride,
        "--bike",
        &bike,
        "--road",
        "c",
        "--accelerometers",
        "0.03",
        "--stiffness",
        "110000:95000",
        "--damping",
        "1150:900",
        "--effect",
        "coulomb_friction:rear:friction=30",
    ]);
    assert!(done.status.success(), "{done:?}");
    let (report, summary) = harness::identify(ride.as_ref(), bike.as_ref(), &["--trials", "2"]);
    let diagnosis = &report["diagnosis"];
    assert_eq!(diagnosis["verdict"], "named", "{}", diagnosis["sentence"]);
    let effect = &diagnosis["effects"][0];
    assert_eq!(
        (&effect["id"], &effect["axle"]),
        (&"coulomb_friction".into(), &"rear".into())
    );
    let friction = effect["parameters"]["friction"]["value"].as_f64().unwrap();
    assert!((friction / 30.0 - 1.0).abs() < 0.35, "{friction} N");
    assert!(summary.contains("Dry friction of"), "{summary}");
    for (axle, k) in [("front", 110e3), ("rear", 95e3)] {
        let found = &report["result"][axle]["k"];
        assert_eq!(found["method"], "extended", "{found}");
        assert!(
            (found["value"].as_f64().unwrap() / k - 1.0).abs() < 0.02,
            "{found}"
        );
    }
    let evidence = &diagnosis["evidence"]["rear"];
    assert_eq!(evidence["predicted"], "acceleration");
    assert!(evidence["worst"]["measured_m"].as_array().unwrap().len() > 50);
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

/// A ride of accelerometers on both axles and a laser on the front one, all on one logger, and its bike.
fn laser_on_one_axle(folder: &Folder) -> [String; 2] {
    let [ride, bike] =
        ["ride.csv", "bike.json"].map(|name| folder.0.join(name).to_str().unwrap().to_owned());
    let written = [
        "simulate",
        &ride,
        "--bike",
        &bike,
        "--stiffness",
        "110000:118000",
    ];
    let sensors = ["--accelerometers", "0.03", "--laser", "front:5e-5:0:0"];
    let rates = ["--laser-rate", "200", "--rate", "200"];
    let done = veloid(&[&written[..], &sensors, &rates].concat());
    assert!(done.status.success(), "{done:?}");
    [ride, bike]
}

/// The axle without a laser has the estimate that needs none, wherever results are shown.
#[tokio::test]
async fn a_laser_on_one_axle_loses_no_other() {
    let folder = Folder::new();
    let [ride, bike] = laser_on_one_axle(&folder);
    let (report, summary) = harness::identify(ride.as_ref(), bike.as_ref(), &["--trials", "2"]);
    assert_eq!(report["result"]["front"]["k"]["method"], "output_error");
    let k = &report["result"]["rear"]["k"];
    assert_eq!(k["method"], "latent_road");
    let [low, high] = [0, 1].map(|i| k["interval"][i].as_f64().unwrap());
    assert!(low < 118e3 && 118e3 < high && high - low < 2e3, "{k}");
    assert_eq!(report["result"]["rear"]["mass"]["value"], 63.0);
    assert!(!summary.contains("withheld"), "{summary}");
    assert!(!summary.contains("only one axle"), "{summary}");
    let said = "There is no verdict on the rear axle, whose road was not measured.";
    assert!(summary.contains(said), "{summary}");

    let server = Server::start();
    let (ride, bike) = (
        std::fs::read(ride).unwrap(),
        std::fs::read_to_string(bike).unwrap(),
    );
    let answer = server.upload(ride, &bike, &[]).await;
    let job = answer.headers()["location"].to_str().unwrap().to_owned();
    let view = server.succeeded(&job).await;
    let rows = server.json("/v1/parameters?method=result").await;
    let rows = rows["items"].as_array().unwrap();
    let rear = rows
        .iter()
        .find(|row| row["axle"] == "rear" && row["name"] == "k_n_m");
    let value = rear.unwrap()["value"].as_f64().unwrap();
    assert!(low < value && value < high, "{value}");
    let course = server.json("/v1/bikes/simulated/course").await;
    let courses = course["courses"].as_array().unwrap();
    assert!(courses.iter().any(|c| c["axle"] == "rear"), "{course}");
    let page = server.get(view["links"]["page"].as_str().unwrap()).await;
    let page = page.text().await.unwrap();
    let by = "front axle: output error (plain model); rear axle: latent road (none measured)";
    assert!(page.contains(by), "{page}");
}

/// Where something acts on the axle with the laser, the other one's estimate, which rests on it, has no interval.
#[test]
fn physics_of_one_axle_takes_the_interval_of_the_other() {
    let folder = Folder::new();
    let [ride, bike] =
        ["ride.csv", "bike.json"].map(|name| folder.0.join(name).to_str().unwrap().to_owned());
    let written = [
        "simulate", &ride, "--bike", &bike, "--rate", "1000", "--road", "c",
    ];
    let effect = ["--effect", "coulomb_friction:front:friction=20"];
    let done = veloid(&[&written[..], &effect].concat());
    assert!(done.status.success(), "{done:?}");
    on_one_logger(&ride);
    let text = std::fs::read_to_string(&ride).unwrap();
    std::fs::write(&ride, text.replacen(",d_r,", ",other,", 1)).unwrap();
    let (report, _) = harness::identify(ride.as_ref(), bike.as_ref(), &["--trials", "2"]);
    assert_eq!(report["diagnosis"]["where"]["front"]["mismatch"], true);
    let k = &report["result"]["rear"]["k"];
    assert!(k["value"].is_number() && k["interval"].is_null(), "{k}");
    let why = k["why"].as_str().unwrap();
    assert!(why.contains("acts on the other axle"), "{why}");
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
