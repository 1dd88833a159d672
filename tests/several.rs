//! One ride in several files, each on a clock of its own, from outside.

use reqwest::multipart::{Form, Part};
use reqwest::{Response, StatusCode};
use serde_json::Value;

use crate::harness::{Folder, Server, nothing_is_kept, veloid};
use crate::ride;

pub const NAMES: [&str; 3] = [
    "ride-accelerometers.csv",
    "ride-laser-rear.csv",
    "ride-speed.csv",
];

/// Writes the paper's bench as three loggers, the laser's clock late by so many ms and fast by so many ppm.
pub fn simulated(folder: &Folder, offset_ms: &str, drift_ppm: &str, seed: &str) {
    let [ride, bike] = ["ride.csv", "bike.json"].map(|name| path(folder, name));
    let laser = format!("rear:2e-4:{offset_ms}:{drift_ppm}");
    let written = [
        "simulate", &ride, "--bike", &bike, "--seed", seed, "--split",
    ];
    let sensors = ["--road", "C", "--accelerometers", "0.03", "--laser", &laser];
    let done = veloid(&[&written[..], &sensors].concat());
    assert!(done.status.success(), "{done:?}");
    let reported = String::from_utf8(done.stdout).unwrap();
    let expected = NAMES.map(|name| path(folder, name)).join("\n") + "\n";
    assert_eq!(reported, expected);
    assert!(!folder.0.join("ride.csv").exists());
}

fn path(folder: &Folder, name: &str) -> String {
    folder.0.join(name).to_str().unwrap().to_owned()
}

/// A swarm that ends soon, and the report on the standard output.
const QUICK: [&str; 8] = [
    "--trials",
    "1",
    "--particles",
    "8",
    "--iterations",
    "2",
    "--json",
    "-",
];

fn identify(folder: &Folder, more: &[&str]) -> std::process::Output {
    let files = NAMES.map(|name| path(folder, name));
    let [imu, laser, speed] = &files;
    let bike = path(folder, "bike.json");
    veloid(
        &[
            &["identify", imu, laser, speed, "--bike", &bike],
            &QUICK[..],
            &["--no-diagnosis"],
            more,
        ]
        .concat(),
    )
}

fn reported(output: &std::process::Output) -> Value {
    assert!(output.status.success(), "{output:?}");
    serde_json::from_slice(&output.stdout).unwrap()
}

#[test]
fn the_clock_of_each_file_is_found_and_reported() {
    for (offset_ms, drift, seed) in [("-2900", "200", "1"), ("1700", "-150", "2")] {
        let folder = Folder::new();
        simulated(&folder, offset_ms, drift, seed);
        let report = reported(&identify(&folder, &[]));
        let ride = &report["ride"];
        let clock = &ride["clocks"][0];
        assert_eq!(
            [&clock["file"], &clock["beside_file"]],
            [NAMES[1], NAMES[0]]
        );
        let found = |key: &str| clock["found"][key].as_f64().unwrap();
        let offset: f64 = offset_ms.parse().unwrap();
        let drift: f64 = drift.parse().unwrap();
        // The laser's file begins with its first sample, up to 1/30 s after its clock reads 0, and so does the drift.
        let shift = ride["files"][1]["shift_s"].as_f64().unwrap();
        let begun = (offset.max(0.0) - offset) * 1e-6 * drift;
        let expected = offset - begun + 1e3 * shift + 1e-3 * drift * found("at_s");
        let off = 1e3 * found("offset_s") - expected;
        assert!(off.abs() < 1.0, "{off} ms of {offset_ms}");
        assert!((found("drift_ppm") - drift).abs() < 8.0, "{clock}");
        let warnings = ride["warnings"].to_string();
        for said in [
            "ride-laser-rear.csv (d_r) was corrected to the clock of ride-accelerometers.csv (a_r)",
            "ride-speed.csv: it records no motion that another file also records",
        ] {
            assert!(warnings.contains(said), "{warnings}");
        }
        assert!(ride["files"][2]["kept"].is_string() && ride["files"][1]["kept"].is_null());
        let k = report["output_error"]["rear"]["k_n_m"].as_f64().unwrap();
        assert!((k / 110e3 - 1.0).abs() < 0.02, "{k}");
    }
}

#[test]
fn options_name_their_file() {
    let folder = Folder::new();
    simulated(&folder, "-800", "0", "3");
    let laser = folder.0.join(NAMES[1]);
    let text = std::fs::read_to_string(&laser).unwrap();
    let odd = text.replacen("t,d_r", "time,distance", 1);
    std::fs::write(&laser, odd.trim_end().to_owned() + "\n100,NA\n").unwrap();
    let own = [
        "--map",
        "ride-laser-rear.csv:d_r=distance",
        "--map",
        "t=time",
        "--rows",
        "ride-laser-rear.csv:0:1700",
        "--offset",
        "ride-laser-rear.csv:0.8",
        "--missing",
        "NA",
    ];
    let report = reported(&identify(&folder, &own));
    assert_eq!(report["ride"]["files"][1]["rows"], 1700);
    let offset = report["ride"]["clocks"][0]["found"]["offset_s"]
        .as_f64()
        .unwrap();
    assert!(offset.abs() < 0.05, "{offset}");
    for (wrong, said) in [
        (
            ["--map", "laser.csv:d_r=distance"],
            "'laser.csv', expected one of ride-accelerometers.csv",
        ),
        (
            ["--map", "d_r=dist"],
            "d_r=dist names no column of the file",
        ),
        (["--rows", "0:100"], "FILE:FROM:TO"),
        (["--offset", "0.8"], "FILE:SECONDS"),
        (
            ["--map", "ride-laser-rear.csv:a_r=distance"],
            "a_r is already in ride-accelerometers.csv, column 3",
        ),
    ] {
        let output = identify(&folder, &[&["--map", "t=time"][..], &wrong].concat());
        assert_eq!(output.status.code(), Some(2), "{wrong:?}");
        let reported = String::from_utf8_lossy(&output.stderr);
        assert!(reported.contains(said), "{reported}");
    }
}

pub fn form(folder: &Folder, names: &[&str]) -> Form {
    let bike = std::fs::read_to_string(folder.0.join("bike.json")).unwrap();
    let mut form = Form::new().text("bike", bike);
    for name in names {
        let bytes = std::fs::read(folder.0.join(name)).unwrap();
        form = form.part("file", Part::bytes(bytes).file_name((*name).to_owned()));
    }
    for (key, value) in ride::QUICK {
        form = form.text(key, value);
    }
    form
}

pub async fn send(server: &Server, path: &str, form: Form) -> Response {
    let request = server.client.post(server.address(path));
    request.multipart(form).send().await.unwrap()
}

/// The ride's list of files, and each file's bytes.
async fn holds_the_files(server: &Server, ride: &str, folder: &Folder) {
    let view = server.json(ride).await;
    assert_eq!(view["name"], NAMES.join(", "));
    let response = server.get(view["file"].as_str().unwrap()).await;
    assert_eq!(response.status(), StatusCode::MULTIPLE_CHOICES);
    let list: Value = response.json().await.unwrap();
    assert_eq!(list, view["files"]);
    for (i, name) in NAMES.iter().enumerate() {
        assert_eq!(list[i]["name"], *name);
        let response = server.get(list[i]["file"].as_str().unwrap()).await;
        assert_eq!(response.status(), 200);
        let tag = response.headers()["etag"].to_str().unwrap().to_owned();
        assert_eq!(tag, format!("\"{}\"", list[i]["sha256"].as_str().unwrap()));
        let bytes = response.bytes().await.unwrap();
        assert!(
            bytes == std::fs::read(folder.0.join(name)).unwrap()[..],
            "{name}"
        );
    }
    let other = server.get(&format!("{ride}/file?name=other.csv")).await;
    assert_eq!(other.status(), 404);
}

#[tokio::test]
async fn a_server_takes_several_files_as_one_ride() {
    let folder = Folder::new();
    simulated(&folder, "-1300", "100", "4");
    let mut server = Server::start();
    let before = server.submit(&ride::QUICK).await;
    server.succeeded(&before).await;

    let seen: Value = send(&server, "/v1/rides/preview", form(&folder, &NAMES))
        .await
        .json()
        .await
        .unwrap();
    assert!(
        seen["problem"].is_null() && seen["files"][2]["name"] == NAMES[2],
        "{seen}"
    );
    let response = send(&server, "/v1/rides", form(&folder, &NAMES)).await;
    assert_eq!(response.status(), 202);
    let job = response.headers()["location"].to_str().unwrap().to_owned();
    let view = server.succeeded(&job).await;
    let ride = format!("/v1/rides/{}", view["ride"]["id"].as_str().unwrap());
    holds_the_files(&server, &ride, &folder).await;
    let again = send(&server, "/v1/rides", form(&folder, &NAMES)).await;
    assert_eq!(again.headers()["veloid-known"], "true");
    assert_eq!(again.headers()["location"], job.as_str());

    // What was read at the upload is gone with the process.
    server.crash_and_restart();
    let series = server.get(&format!("{job}/series")).await;
    assert_eq!(series.status(), 200);
    let report = server.json(&format!("{job}/report")).await;
    assert_eq!(report["ride"]["clocks"][0]["file"], NAMES[1]);
    let page = server
        .get(&format!("/jobs/{}", view["id"].as_str().unwrap()))
        .await;
    assert!(
        page.text()
            .await
            .unwrap()
            .contains("file?name=ride-speed.csv")
    );
    holds_the_files(&server, &ride, &folder).await;
    let first = server.json(&before).await;
    let one = format!("/v1/rides/{}/file", first["ride"]["id"].as_str().unwrap());
    assert_eq!(
        server.get(&one).await.bytes().await.unwrap(),
        ride::example()[..]
    );
}

#[tokio::test]
async fn a_backup_holds_every_file() {
    let folder = Folder::new();
    simulated(&folder, "20", "0", "5");
    let server = Server::on_sqlite(&[]);
    let response = send(&server, "/v1/rides", form(&folder, &NAMES)).await;
    let job = response.headers()["location"].to_str().unwrap().to_owned();
    let view = server.succeeded(&job).await;
    let kept = Folder::new();
    let backup = path(&kept, "backup");
    let output = server.beside(&["backup", &backup]).output().unwrap();
    assert!(output.status.success(), "{output:?}");
    let restored = Folder::new();
    let output = veloid(&["restore", &backup, "--data", restored.0.to_str().unwrap()]);
    assert!(output.status.success(), "{output:?}");
    let restored = Server::in_folder(restored, &[]);
    let ride = format!("/v1/rides/{}", view["ride"]["id"].as_str().unwrap());
    holds_the_files(&restored, &ride, &folder).await;
}

/// Of two rides that share files each is erased with its own, and what they share with the last.
#[tokio::test]
async fn every_file_is_erased_with_the_last_ride_that_has_it() {
    let folder = Folder::new();
    simulated(&folder, "20", "0", "6");
    let server = Server::start();
    let mut rides = Vec::new();
    for names in [&NAMES[..], &[NAMES[0], NAMES[2]]] {
        let response = send(&server, "/v1/rides", form(&folder, names)).await;
        assert_eq!(response.status(), 202);
        let job = response.headers()["location"].to_str().unwrap().to_owned();
        let view = server.succeeded(&job).await;
        rides.push(format!(
            "/v1/rides/{}",
            view["ride"]["id"].as_str().unwrap()
        ));
    }
    let view = server.json(&rides[0]).await;
    let sums: Vec<String> = (view["files"].as_array().unwrap().iter())
        .map(|file| file["sha256"].as_str().unwrap().to_owned())
        .collect();
    let kept = || -> Vec<bool> {
        let of = |sum: &String| server.folder.0.join("rides").join(sum).exists();
        sums.iter().map(of).collect()
    };
    assert_eq!(kept(), [true; 3]);
    for (ride, left) in rides.iter().zip([[true, false, true], [false; 3]]) {
        let request = server.client.delete(server.address(ride));
        assert_eq!(request.send().await.unwrap().status(), 200);
        let pruned = server.beside(&["prune", "--grace-days", "0"]).output();
        assert!(pruned.unwrap().status.success());
        assert_eq!(kept(), left);
    }
}

#[tokio::test]
async fn what_cannot_be_one_ride_is_refused_and_leaves_nothing() {
    let folder = Folder::new();
    simulated(&folder, "20", "0", "6");
    std::fs::copy(folder.0.join(NAMES[0]), folder.0.join("copy.csv")).unwrap();
    let server = Server::on_sqlite(&[]);
    let own = |key: &'static str, value: &'static str| form(&folder, &NAMES).text(key, value);
    let many = (0..17).fold(form(&folder, &[]), |form, i| {
        form.part(
            "file",
            Part::bytes(b"t,v\n0,1\n".to_vec()).file_name(format!("{i}.csv")),
        )
    });
    for (form, status, said) in [
        (
            form(&folder, &[NAMES[0], NAMES[0]]),
            400,
            "two files have the name 'ride-accelerometers.csv'",
        ),
        (
            form(&folder, &[NAMES[0], "copy.csv"]),
            422,
            "a_f is already in ride-accelerometers.csv",
        ),
        (own("name", "x.csv"), 400, "`name` with several files"),
        (own("rate_hz", "x.csv:30"), 422, "for the file 'x.csv'"),
        (own("offset_s", "3"), 422, "FILE:SECONDS"),
        (
            own(
                "options",
                "{\"files\": {\"ride-speed.csv\": {\"rate\": 1}}}",
            ),
            422,
            "rate",
        ),
        (many, 422, "17 files"),
    ] {
        let response = send(&server, "/v1/rides", form).await;
        assert_eq!(response.status(), status, "{said}");
        let problem: Value = response.json().await.unwrap();
        let detail = problem["detail"].as_str().unwrap();
        assert!(detail.contains(said), "{detail}");
    }
    nothing_is_kept(&server);
}

/// Columns of a table, by their places.
fn columns(text: &str, places: &[usize]) -> String {
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        let kept: Vec<&str> = places.iter().map(|i| cells[*i]).collect();
        kept.join(",") + "\n"
    };
    text.lines().map(row).collect()
}

#[test]
fn files_of_which_nobody_knows_when_they_began_carry_no_interval() {
    let folder = Folder::new();
    let table = ride::table(4000, 200.0);
    let road = folder.write("road.csv", columns(&table, &[0, 1, 2]));
    let axles = folder.write("axles.csv", columns(&table, &[0, 3, 4]));
    let bike = folder.write("bike.json", ride::BIKE);
    let identified = |more: &[&str]| {
        let [road, axles, bike] = [&road, &axles, &bike].map(|path| path.to_str().unwrap());
        let files = ["identify", axles, road, "--bike", bike];
        reported(&veloid(&[&files[..], &QUICK, more].concat()))
    };
    let report = identified(&[]);
    assert_eq!(report["diagnosis"]["verdict"], "cannot_tell");
    let said = report["diagnosis"]["sentence"].as_str().unwrap();
    assert!(
        said.contains("the clock offset between road.csv (u_f) and axles.csv (z_f) is unknown"),
        "{said}"
    );
    assert!(report["output_error"]["front"]["k_std_n_m"].is_null());
    let report = identified(&["--offset", "road.csv:0"]);
    assert_ne!(report["diagnosis"]["verdict"], "cannot_tell");
    let k = report["output_error"]["front"]["k_n_m"].as_f64().unwrap();
    assert!((k / 110e3 - 1.0).abs() < 0.01, "{k}");
}
