//! From a logger's file to k, in the form and without a manual: SensorConnect, phyphox, and a file of a logger that nobody knows.

use std::fmt::Write;
use std::path::PathBuf;

use serde_json::Value;

use super::bicycle::be_quick;
use super::chromium::{Browser, Look};
use super::loggers::choose_files;
use crate::harness::{Folder, Server, veloid};
use crate::ride;

const BICYCLE: [(&str, &str); 4] = [
    ("bike_name", "somebody's"),
    ("mass_front_kg", "23"),
    ("mass_rear_kg", "63"),
    ("wheelbase_m", "1.101"),
];

/// Chooses channel and unit of columns.
async fn choose(browser: &Browser, columns: &[(&str, &str, &str)]) {
    for (header, channel, unit) in columns {
        let row = format!(".column[data-header='{header}']");
        browser.choose(&format!("{row} .channel"), channel).await;
        if !unit.is_empty() {
            let has_unit = format!(
                "return [...document.querySelector({:?}).options].some(({{ value }}) => value === {unit:?})",
                format!("{row} .unit")
            );
            browser.until(&has_unit, |has| *has == true).await;
            browser.choose(&format!("{row} .unit"), unit).await;
        }
    }
}

/// Fills in the bicycle, sends the ride and returns its report.
async fn report(browser: &Browser, server: &Server, bike: &[(&str, &str); 4]) -> Value {
    for (field, text) in bike {
        browser.fill(&format!("#{field}"), text).await;
    }
    be_quick(browser).await;
    browser.click("button.primary").await;
    browser.sees("h1", bike[0].1).await;
    browser.sees("#result", "axle").await;
    let job = browser.run("return location.pathname").await;
    let report = format!("/v1{}/report", job.as_str().unwrap());
    server.json(&report).await
}

fn is_near(estimate: &Value, truth: f64) {
    let off = estimate["k_n_m"].as_f64().unwrap() / truth - 1.0;
    assert!(off.abs() < 0.03, "{estimate}");
}

/// A ride with two accelerometers.
fn simulate(folder: &Folder, more: &[&str]) {
    let [ride, bike] = ["ride.csv", "bike.json"].map(|name| folder.0.join(name));
    let [ride, bike] = [&ride, &bike].map(|path| path.to_str().unwrap());
    let made = "--road C --accelerometers 0.03 --rate 200 --duration 60";
    let mut args = vec!["simulate", ride, "--bike", bike];
    args.extend(made.split(' '));
    args.extend(more);
    let done = veloid(&args);
    assert!(done.status.success(), "{done:?}");
}

/// Two nodes in g, each with its gravity, under the preamble of an export, and the speed of a head unit.
fn sensor_connect(folder: &Folder) -> [PathBuf; 2] {
    simulate(folder, &["--split"]);
    let rows = |name: &str| std::fs::read_to_string(folder.0.join(name)).unwrap();
    let stamp = |t: f64| {
        format!(
            "05/21/2026 10:{:02}:{:09.6}000",
            (t / 60.0) as u32,
            t % 60.0
        )
    };
    let mut nodes = "FILE_INFO\nFile Name,ride.csv\n\nSESSION_INFO\nStart Time,05/21/2026 10:00:00\n\nNODE_INFO\nNode Address,41\n\
                     Model,G-Link-200-8g\nSample Rate,200 Hz\nUnit,g\n\nDATA_START\nTime,41:ch3,42:ch3\n"
        .to_owned();
    for row in rows("ride-accelerometers.csv").lines().skip(1) {
        let cells: Vec<f64> = row.split(',').map(|cell| cell.parse().unwrap()).collect();
        let [front, rear] = [cells[1], cells[2]].map(|a| a / 9.80665 + 1.0);
        writeln!(nodes, "{},{front:.6},{rear:.6}", stamp(cells[0])).unwrap();
    }
    let mut speed = "Time,Speed (km/h)\n".to_owned();
    for row in rows("ride-speed.csv").lines().skip(1) {
        let (t, v) = row.split_once(',').unwrap();
        let [t, v]: [f64; 2] = [t, v].map(|cell| cell.parse().unwrap());
        writeln!(speed, "{},{:.4}", stamp(t), 3.6 * v).unwrap();
    }
    [
        folder.write("nodes.csv", nodes),
        folder.write("speed.csv", speed),
    ]
}

#[tokio::test]
async fn a_sensorconnect_export_is_identified_at_the_first_try() {
    let (server, folder) = (Server::start(), Folder::new());
    let files = sensor_connect(&folder);
    let Some(browser) = Browser::start(Look::WIDE).await else {
        return;
    };
    browser.goto(&server.address("/")).await;
    choose_files(&browser, &files).await;
    browser
        .sees("#one-reason", "no file is a complete ride")
        .await;
    browser.sees("#rides", "MicroStrain SensorConnect").await;
    choose(&browser, &[("41:ch3", "a_f", "g"), ("42:ch3", "a_r", "g")]).await;
    browser.sees("#rides", "60.0 s at 200 Hz").await;
    let report = report(&browser, &server, &BICYCLE).await;
    is_near(&report["latent_road"]["front"], 110e3);
    browser.stop().await;
}

/// Two sensors that phyphox reads over Bluetooth, and the phone's speed, as a German phone exports them.
fn phyphox(folder: &Folder) -> String {
    let mut csv = "\"Time (s)\";\"Acceleration front (m/s^2)\";\"Acceleration rear (m/s^2)\";\"Velocity (m/s)\"\n".to_owned();
    simulate(folder, &[]);
    let rows = std::fs::read_to_string(folder.0.join("ride.csv")).unwrap();
    for row in rows.lines().skip(1) {
        let cells = row
            .split(',')
            .map(|cell| format!("{:.9E}", cell.parse::<f64>().unwrap()));
        let cells: Vec<String> = cells.map(|cell| cell.replace('.', ",")).collect();
        writeln!(csv, "{}", cells.join(";")).unwrap();
    }
    csv
}

#[tokio::test]
async fn a_phyphox_export_is_identified_at_the_first_try() {
    let (server, folder) = (Server::start(), Folder::new());
    let file = server.folder.write("Raw Data.csv", phyphox(&folder));
    let Some(browser) = Browser::start(Look::NARROW).await else {
        return;
    };
    browser.goto(&server.address("/")).await;
    choose_files(&browser, &[file]).await;
    browser.sees("#rides", "60.0 s at 200 Hz").await;
    let report = report(&browser, &server, &BICYCLE).await;
    is_near(&report["latent_road"]["front"], 110e3);
    browser.stop().await;
}

/// A table in millimetres whose header is hidden by what stands around it.
fn unknown() -> String {
    let mut text =
        "Registro 7\n1|2|3|4|5\nReloj|Calle A|Calle B|Rueda A|Rueda B\n12|12|12|12|12\n".to_owned();
    for row in ride::table(4000, 200.0).lines().skip(1) {
        let cells: Vec<String> = row
            .split(',')
            .map(|cell| format!("{:.6}", 1e3 * cell.parse::<f64>().unwrap()))
            .collect();
        text.push_str(&cells.join("|"));
        text.push('\n');
    }
    text
}

#[tokio::test]
async fn a_file_of_an_unknown_logger_is_identified_at_the_first_try() {
    let server = Server::start();
    let [first, second] = ["one.txt", "two.txt"].map(|name| server.folder.write(name, unknown()));
    let Some(browser) = Browser::start(Look::WIDE).await else {
        return;
    };
    browser.goto(&server.address("/")).await;
    choose_files(&browser, &[first]).await;
    browser.click(".layout > summary").await;
    browser.sees(".layout .lines", "Rueda A").await;
    browser.choose(".layout [data-key=header_row]", "3").await;
    browser.choose(".layout [data-key=first_row]", "5").await;
    let all = [
        ("Reloj", "t", "ms"),
        ("Calle A", "u_f", "mm"),
        ("Calle B", "u_r", "mm"),
        ("Rueda A", "z_f", "mm"),
        ("Rueda B", "z_r", "mm"),
    ];
    choose(&browser, &all).await;
    browser.sees("#rides", "20.0 s at 200 Hz").await;
    let report = report(&browser, &server, &BICYCLE).await;
    assert!(
        report["output_error"]["front"]["k_std_n_m"].is_number(),
        "{report}"
    );
    // The next file of this logger needs none of it.
    browser.goto(&server.address("/")).await;
    choose_files(&browser, &[second]).await;
    browser.sees("#rides", "20.0 s at 200 Hz").await;
    browser.sees("#rides", "z_r from Rueda B (mm)").await;
    browser.stop().await;
}
