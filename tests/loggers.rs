//! Three loggers of one ride, each in its own words: a laser at 500 Hz as a German Excel saves it, accelerometers, and the speed
//! of a head unit. From outside, by a form without JavaScript.

use std::fmt::Write;
use std::path::PathBuf;

use reqwest::multipart::{Form, Part};
use serde_json::Value;

use crate::harness::{Folder, Server, veloid};
use crate::ride;

/// The laser's distance to the road at rest (mm).
const REST_MM: f64 = 312.5;

/// Writes the files and says where they are.
pub fn three(folder: &Folder) -> [PathBuf; 3] {
    let [ride, bike] = ["ride.csv", "bike.json"].map(|name| text(&folder.0.join(name)));
    let sensors = "--road C --accelerometers 0.03 --laser front:2e-4:0:0 --laser-rate 500 --split";
    let more = ["--rate", "200", "--duration", "40"];
    let mut args = vec!["simulate", &ride, "--bike", &bike];
    args.extend(sensors.split(' ').chain(more));
    let done = veloid(&args);
    assert!(done.status.success(), "{done:?}");
    let rows = |name: &str| rows(folder, name);
    let laser = german(&rows("ride-laser-front.csv"));
    let imu = imu(&rows("ride-accelerometers.csv"));
    let track = tcx(&rows("ride-speed.csv"));
    [("laser.csv", laser), ("imu.csv", imu), ("ride.tcx", track)]
        .map(|(name, text)| folder.write(name, text))
}

fn text(path: &std::path::Path) -> String {
    path.to_str().unwrap().to_owned()
}

/// The numbers of a file with a header.
fn rows(folder: &Folder, name: &str) -> Vec<Vec<f64>> {
    let table = std::fs::read_to_string(folder.0.join(name)).unwrap();
    let rows = table.lines().skip(1);
    rows.map(|row| row.split(',').map(|cell| cell.parse().unwrap()).collect())
        .collect()
}

/// Of time and deflection (m), which shrinks where the distance to the road grows.
fn german(rows: &[Vec<f64>]) -> String {
    let mut csv = "\u{feff}Zeit (s);Abstand Gabel (mm)\r\n".to_owned();
    for row in rows {
        let line = format!("{:.4};{:.4}", row[0], REST_MM - 1e3 * row[1]);
        write!(csv, "{}\r\n", line.replace('.', ",")).unwrap();
    }
    csv
}

/// Of time and both accelerations (m/s^2).
fn imu(rows: &[Vec<f64>]) -> String {
    let mut csv = "time_s,acc_front_m_s2,acc_rear_m_s2,temp_c\n".to_owned();
    for row in rows {
        writeln!(csv, "{:.4},{:.5},{:.5},21.5", row[0], row[1], row[2]).unwrap();
    }
    csv
}

/// Of time and speed (m/s), once a second.
fn tcx(rows: &[Vec<f64>]) -> String {
    let mut points = String::new();
    let mut second = 0.0;
    for row in rows.iter().filter(|row| row[0] < 60.0) {
        if row[0] < second {
            continue;
        }
        writeln!(
            points,
            "<Trackpoint><Time>2026-05-01T10:00:{second:02}Z</Time><Extensions><ns3:TPX><ns3:Speed>{}</ns3:Speed></ns3:TPX>\
             </Extensions></Trackpoint>",
            row[1]
        )
        .unwrap();
        second += 1.0;
    }
    format!(
        "<?xml version=\"1.0\"?>\n<TrainingCenterDatabase xmlns:ns3=\"http://www.garmin.com/xmlschemas/ActivityExtension/v2\">\n\
         <Activities><Activity><Lap><Track>\n{points}</Track></Lap></Activity></Activities></TrainingCenterDatabase>\n"
    )
}

fn form(files: &[PathBuf; 3], parts: &[(&str, &str)]) -> Form {
    let mut form = Form::new();
    for path in files {
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        form = form.part(
            "file",
            Part::bytes(std::fs::read(path).unwrap()).file_name(name),
        );
    }
    for (key, value) in ride::QUICK.iter().chain(parts) {
        form = form.text((*key).to_owned(), (*value).to_owned());
    }
    form
}

async fn send(server: &Server, path: &str, form: Form) -> reqwest::Response {
    let request = server.client.post(server.address(path));
    request.multipart(form).send().await.unwrap()
}

const MAPS: [(&str, &str); 6] = [
    ("map", "laser.csv:t=Zeit (s)"),
    ("map", "laser.csv:d_f=Abstand Gabel (mm)"),
    ("map", "imu.csv:t=time_s"),
    ("map", "imu.csv:a_f=acc_front_m_s2"),
    ("map", "imu.csv:a_r=acc_rear_m_s2"),
    ("deflection_sign", "-1"),
];

#[tokio::test]
async fn a_preview_shows_each_file_with_its_guesses() {
    let folder = Folder::new();
    let files = three(&folder);
    let server = Server::with(&["--workers", "0"]);
    let seen = send(&server, "/v1/rides/preview", form(&files, &[])).await;
    let seen: Value = seen.json().await.unwrap();
    let shown = |table: usize, column: usize| &seen["tables"][table]["columns"][column];
    assert_eq!(shown(0, 1)["header"], "Abstand Gabel (mm)", "{seen}");
    let first = shown(0, 0)["first"].as_array().unwrap();
    assert!(first.len() == 3 && first[1].as_str().unwrap().contains(','));
    assert_eq!(shown(0, 0)["channel"], "t");
    assert!(shown(0, 1)["channel"].is_null());
    assert_eq!(shown(2, 1)["channel"], "v");
    assert_eq!(shown(2, 1)["unit"], "m/s");
    let guesses = seen["guesses"].as_array().unwrap().iter();
    let guesses: Vec<String> = guesses
        .map(|guess| {
            let [file, channel] = ["file", "channel"].map(|key| guess[key].as_str().unwrap());
            format!("{file} {channel} {}", guess["deflection_sign"])
        })
        .collect();
    assert_eq!(
        guesses,
        ["laser.csv d_f -1", "imu.csv a_f null", "imu.csv a_r null"]
    );
    let mapped = send(&server, "/v1/rides/preview", form(&files, &MAPS)).await;
    let mapped: Value = mapped.json().await.unwrap();
    assert!(mapped["problem"].is_null() && mapped["guesses"] == serde_json::json!([]));
    let laser = &mapped["tables"][0]["columns"][1];
    assert_eq!([&laser["channel"], &laser["unit"]], ["d_f", "mm"]);
}

/// A lab describes its logger beside the database, the server reads its files after a restart, and a layout is said in a part.
#[tokio::test]
async fn a_lab_adds_its_logger_and_says_how_a_file_is_laid_out() {
    let mut server = Server::with(&["--workers", "0"]);
    let strange =
        ride::table(400, 200.0).replacen("t,u_f,u_r,z_f,z_r", "clk,ADC1,ADC2,ADC3,ADC4", 1);
    let seen = |server: &Server, part: &[(&'static str, &'static str)]| {
        let ride = strange.clone().into_bytes();
        let form = crate::harness::whole_form(ride, ride::BIKE, part);
        let request = server.client.post(server.address("/v1/rides/preview"));
        async move {
            request
                .multipart(form)
                .send()
                .await
                .unwrap()
                .json::<Value>()
                .await
                .unwrap()
        }
    };
    let before = seen(&server, &[]).await;
    assert!(
        before["problem"].as_str().unwrap().contains("no time"),
        "{before}"
    );
    assert_eq!(
        before["tables"][0]["lines"][0]["cells"][0], "clk",
        "{before}"
    );
    let folder = server.folder.0.join("loggers");
    std::fs::create_dir_all(&folder).unwrap();
    let columns =
        "clk = 't [s]', ADC1 = 'u_f [m]', ADC2 = 'u_r [m]', ADC3 = 'z_f [m]', ADC4 = 'z_r [m]'";
    let own = format!("name = 'Trailer'\nrecognise = ['clk,ADC1']\ncolumns = {{ {columns} }}\n");
    std::fs::write(folder.join("trailer.toml"), own).unwrap();
    server.restart();
    let after = seen(&server, &[]).await;
    assert!(after["problem"].is_null(), "{after}");
    assert!(after["reading"].to_string().contains("Trailer"), "{after}");
    let cut = seen(
        &server,
        &[("layout", "first_row=102"), ("layout", "header_row=1")],
    )
    .await;
    assert_eq!(cut["rows"], 300, "{cut}");
    let odd = seen(&server, &[("layout", "first_row=0")]).await;
    assert!(
        odd["detail"].as_str().unwrap().contains("layout.first_row"),
        "{odd}"
    );
    let sole = seen(&server, &[("layout", "first_row")]).await;
    assert!(
        sole["detail"].as_str().unwrap().contains("KEY=VALUE"),
        "{sole}"
    );
}

/// A folder that is not there, and a description that cannot be used, are refused with their names.
#[test]
fn loggers_that_cannot_be_read_are_named() {
    let folder = Folder::new();
    let ride = folder.write("ride.csv", ride::table(400, 200.0));
    let bike = folder.write("bike.json", ride::BIKE);
    let refused = |loggers: &str| {
        let paths = [&ride, &bike].map(|path| path.to_str().unwrap());
        let loggers = text(&folder.0.join(loggers));
        let done = veloid(&[
            "identify",
            paths[0],
            "--bike",
            paths[1],
            "--loggers",
            &loggers,
        ]);
        assert!(!done.status.success());
        String::from_utf8_lossy(&done.stderr).into_owned()
    };
    assert!(refused("nowhere").contains("nowhere"));
    std::fs::create_dir(folder.0.join("own")).unwrap();
    folder.write(
        "own/broken.toml",
        "name = 'x'\nrecognise = ['y']\ncolumns = { a = 'speed' }\n",
    );
    let said = refused("own");
    assert!(
        said.contains("broken.toml") && said.contains("'speed' is no channel"),
        "{said}"
    );
}

/// Bicycle, rate and band with decimal commas, to the address of the plain form.
#[tokio::test]
async fn the_plain_form_takes_decimal_commas_and_files_of_several_loggers() {
    let folder = Folder::new();
    let files = three(&folder);
    let server = Server::with(&["--workers", "0"]);
    let bicycle = [
        ("bicycle", "fields"),
        ("bike_name", "comma"),
        ("mass_front_kg", "23,0"),
        ("mass_rear_kg", "63,25"),
        ("wheelbase_m", "1,101"),
        ("alpha", "0,02"),
        ("band_hz", "0,5:40,5"),
        ("pressure_front_bar", "2,2"),
    ];
    let parts = [&MAPS[..], &bicycle].concat();
    let sent = send(&server, "/", form(&files, &parts)).await;
    assert_eq!(sent.status(), 200, "it leads to the job's page");
    let job = sent.url().path().to_owned();
    assert!(job.starts_with("/jobs/"), "{job}");
    let view = server.json(&format!("/v1{job}")).await;
    let known = server.json("/v1/bikes/comma").await;
    assert_eq!(known["document"]["mass_rear_kg"], 63.25, "{known}");
    let ride = format!("/v1/rides/{}", view["ride"]["id"].as_str().unwrap());
    let ride = server.json(&ride).await;
    assert_eq!(ride["facts"]["pressure_front_bar"], 2.2, "{ride}");
    let wrong = [("mass_front_kg", "2.3,0"), ("bicycle", "fields")];
    let sent = send(&server, "/", form(&files, &wrong)).await;
    assert_eq!(sent.status(), 422);
    let page = sent.text().await.unwrap();
    assert!(page.contains("tabindex=\"-1\" autofocus"), "{page}");
    let beside = page.split("id=\"outcome\"").nth(1).unwrap();
    assert!(beside.contains("2.3,0"), "{beside}");
}
