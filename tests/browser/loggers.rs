//! Three loggers that call their columns what they like become one ride; what the user chooses is kept.

use serde_json::json;

use super::bicycle::be_quick;
use super::chromium::{Browser, Look, axe};
use crate::harness::{Folder, Server};
use crate::{loggers, ride};

/// The channel of each column, file by file.
const CHOSEN: &str = "return [...document.querySelectorAll('.log')].map((log) => \
    [...log.querySelectorAll('.column')].map((row) => [row.dataset.header, row.querySelector('select').value]))";

/// All of them at once, as a drop does.
pub async fn choose_files(browser: &Browser, paths: &[std::path::PathBuf]) {
    let paths: Vec<&str> = paths.iter().map(|path| path.to_str().unwrap()).collect();
    let field = browser.find("#file").await;
    field.send_keys(&paths.join("\n")).await.unwrap();
}

#[tokio::test]
async fn three_loggers_are_identified_at_the_first_try() {
    let server = Server::start();
    let folder = Folder::new();
    let files = loggers::three(&folder);
    let Some(browser) = Browser::start(Look::WIDE).await else {
        return;
    };
    browser.goto(&server.address("/")).await;
    choose_files(&browser, &files).await;
    for (field, text) in [
        ("bike_name", "three loggers"),
        ("mass_front_kg", "23,0"),
        ("mass_rear_kg", "63"),
        ("wheelbase_m", "1,101"),
    ] {
        browser.fill(&format!("#{field}"), text).await;
    }
    be_quick(&browser).await;
    browser.click("button.primary").await;
    browser
        .sees("h1", "three loggers: laser.csv, imu.csv, ride.tcx")
        .await;
    browser.sees("#result", "axle").await;
    let job = browser.run("return location.pathname").await;
    let report = format!("/v1{}/report", job.as_str().unwrap());
    let report = server.json(&report).await;
    let front = &report["output_error"]["front"];
    let off = front["k_n_m"].as_f64().unwrap() / 110e3 - 1.0;
    assert!(off.abs() < 0.02, "{front}");
    assert!(front["k_std_n_m"].is_number(), "{front}");
    browser.stop().await;
}

#[tokio::test]
async fn one_ride_is_proposed_with_a_table_for_each_file() {
    let server = Server::with(&["--workers", "0"]);
    let folder = Folder::new();
    let files = loggers::three(&folder);
    for look in [Look::WIDE, Look::NARROW] {
        let Some(browser) = Browser::start(look).await else {
            return;
        };
        browser.goto(&server.address("/")).await;
        choose_files(&browser, &files).await;
        browser
            .sees("#one-reason", "no file is a complete ride by itself")
            .await;
        browser.sees("#rides", "40.0 s at 200 Hz").await;
        let expected = json!([
            [["Zeit (s)", ""], ["Abstand Gabel (mm)", "d_f"]],
            [
                ["time_s", ""],
                ["acc_front_m_s2", "a_f"],
                ["acc_rear_m_s2", "a_r"],
                ["temp_c", ""]
            ],
            [["t", ""], ["v", ""], ["cadence", ""]]
        ]);
        assert_eq!(browser.run(CHOSEN).await, expected);
        let checked = "return document.querySelector('#together').checked";
        assert_eq!(browser.run(checked).await, true);
        browser.sees(".log:nth-of-type(1) .column td", "0,").await;
        let sign = "return document.querySelector('.sign select').value";
        assert_eq!(browser.run(sign).await, "-1");
        let unit = "return document.querySelector(`.column[data-header='Abstand Gabel (mm)'] .unit`).selectedOptions[0].text";
        assert_eq!(browser.run(unit).await, "mm");
        let wide = "return document.documentElement.scrollWidth - innerWidth";
        assert!(browser.run(wide).await.as_f64() <= Some(0.0));
        // A ride that is complete takes the proposal back.
        let whole = server.folder.write("whole.csv", ride::example());
        choose_files(&browser, &[whole]).await;
        browser
            .sees("#rides li:nth-child(4)", "20.0 s at 200 Hz")
            .await;
        assert_eq!(browser.run(checked).await, false);
        browser.click("[aria-label='Remove whole.csv']").await;
        browser
            .sees("#rides li:nth-child(1)", "40.0 s at 200 Hz")
            .await;
        // What the user decides stays.
        browser.click("#together").await;
        browser
            .sees("#rides li:nth-child(3) .fault", "no axle")
            .await;
        assert_eq!(browser.run(checked).await, false);
        browser.stop().await;
    }
}

#[tokio::test]
async fn the_tables_have_no_serious_fault_of_access() {
    let server = Server::with(&["--workers", "0"]);
    let folder = Folder::new();
    let files = loggers::three(&folder);
    let Some(axe) = axe() else { return };
    for look in [Look::WIDE, Look::NARROW] {
        let Some(browser) = Browser::start(look).await else {
            return;
        };
        for theme in ["light", "dark"] {
            let page = format!("/?theme={theme}");
            browser.goto(&server.address(&page)).await;
            choose_files(&browser, &files).await;
            browser.sees("#rides", "40.0 s at 200 Hz").await;
            let faults = browser.check(&axe).await;
            assert_eq!(faults, json!([]), "{theme}, {look:?}");
        }
        browser.stop().await;
    }
}

#[tokio::test]
async fn choices_are_kept_for_the_header_and_can_be_forgotten() {
    let server = Server::start();
    let Some(browser) = Browser::start(Look::WIDE).await else {
        return;
    };
    let headers = "Zeit [s],roadFront,Fahrbahn hinten [m],V4,Weg hinten [m]";
    let logged = |samples| ride::table(samples, 200.0).replacen("t,u_f,u_r,z_f,z_r", headers, 1);
    let first = server.folder.write("monday.csv", logged(2000));
    let second = server.folder.write("tuesday.csv", logged(2400));
    browser.goto(&server.address("/")).await;
    browser.click("[name=bicycle][value=file]").await;
    browser.fill("#bike", ride::BIKE).await;
    be_quick(&browser).await;
    choose_files(&browser, &[first]).await;
    browser.sees(".columns", "this browser remembers").await;
    browser
        .choose(".column[data-header='V4'] .channel", "z_f")
        .await;
    browser.sees("#rides", "z_f from V4 (m)").await;
    browser.click("button.primary").await;
    browser.sees("h1", "lab-7: monday.csv").await;

    browser.goto(&server.address("/")).await;
    choose_files(&browser, &[second]).await;
    browser.sees("#rides", "z_f from V4 (m)").await;
    browser
        .sees(
            ".columns",
            "Channels from your last upload with this header",
        )
        .await;
    browser.click(".kept button").await;
    let chosen = "return document.querySelector(`.column[data-header=V4] .channel`).value";
    browser.until(chosen, |chosen| *chosen == "").await;
    let kept = "return localStorage.getItem('columns')";
    assert_eq!(browser.run(kept).await, "[]");
    browser.stop().await;
}

#[tokio::test]
async fn a_unit_is_chosen_beside_its_column() {
    let server = Server::with(&["--workers", "0"]);
    let Some(browser) = Browser::start(Look::NARROW).await else {
        return;
    };
    let table = ride::table(2000, 200.0).replacen("z_f", "Weg vorne", 1);
    let path = server.folder.write("plain.csv", table);
    browser.goto(&server.address("/")).await;
    choose_files(&browser, &[path]).await;
    browser.sees("#rides", "z_f from Weg vorne (m)").await;
    browser
        .choose(".column[data-header='Weg vorne'] .unit", "mm")
        .await;
    browser.sees("#rides", "z_f from Weg vorne (mm)").await;
    browser.choose(".column[data-header=z_r] .unit", "cm").await;
    browser.sees("#rides", "z_r (cm)").await;
    browser.stop().await;
}
