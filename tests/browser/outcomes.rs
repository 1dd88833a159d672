//! What pressing the button came to is in sight, has the focus, and stands beside the button; fields refuse nothing that the API
//! takes.

use serde_json::json;

use super::bicycle::be_quick;
use super::chromium::{Browser, Look};
use super::finished;
use super::loggers::choose_files;
use crate::harness::Server;
use crate::ride;

/// Where the focus is, whether that is in sight, and what stands beside the button.
const FOCUS: &str = "const seen = document.activeElement; const { top, bottom } = seen.getBoundingClientRect(); \
    return [seen.innerText, top >= 0 && bottom <= innerHeight, document.querySelector('#outcome').innerText]";

#[tokio::test]
async fn an_error_and_what_is_known_have_the_focus_and_stand_beside_the_button() {
    let server = Server::start();
    finished(&server, "1").await;
    for look in [Look::WIDE, Look::NARROW] {
        let Some(browser) = Browser::start(look).await else {
            return;
        };
        browser.goto(&server.address("/?bike=lab-7")).await;
        let broken = server.folder.write("broken.csv", "t,z_f\n0,1\n");
        choose_files(&browser, &[broken]).await;
        browser.sees("#rides .fault", "").await;
        browser.click("button.primary").await;
        browser.sees("#outcome .fault", "expected at least").await;
        let seen = browser.run(FOCUS).await;
        assert!(
            seen[0].as_str().unwrap().contains("expected at least"),
            "{seen}"
        );
        assert_eq!(seen[1], true, "{seen}");
        assert_eq!(seen[0], seen[2]);
        browser.click("[aria-label='Remove broken.csv']").await;

        let path = server.folder.write("ride.csv", ride::example());
        choose_files(&browser, &[path]).await;
        be_quick(&browser).await;
        browser.fill("#seed", "1").await;
        browser.click("button.primary").await;
        browser.sees("#outcome", "identified before").await;
        let seen = browser.run(FOCUS).await;
        assert!(
            seen[0].as_str().unwrap().contains("identified before"),
            "{seen}"
        );
        assert_eq!(seen[1], true, "{seen}");
        browser.click("#outcome a").await;
        browser.sees("h1", "lab-7: ride.csv").await;

        browser.goto(&server.address("/")).await;
        let path = server.folder.write("ride.csv", ride::example());
        choose_files(&browser, &[path]).await;
        browser.click("button.primary").await;
        browser
            .sees("#outcome", "Choose a bicycle or enter its values.")
            .await;
        let focus = "return document.activeElement.id";
        assert_eq!(browser.run(focus).await, "fleet");
        let seen = "const { top, bottom } = document.querySelector('#bike-fault').getBoundingClientRect(); \
                    return top >= 0 && bottom > top && bottom <= innerHeight";
        assert_eq!(browser.run(seen).await, true);
        browser.stop().await;
    }
}

/// Fields take what the API takes.
#[tokio::test]
async fn no_pattern_of_the_form_refuses_what_the_api_takes() {
    let server = Server::with(&["--workers", "0"]);
    let Some(browser) = Browser::start(Look::WIDE).await else {
        return;
    };
    browser.goto(&server.address("/")).await;
    for (field, text) in [
        ("rows", "0:500"),
        ("rows", " 0 : 500 "),
        ("rows", "laser.csv:0:500"),
        ("rows", "my:laser.csv: 0:500"),
        ("map1", "z_f=V2"),
        ("map1", "laser.csv:d_f=Abstand Gabel (mm)"),
        ("map1", "my laser.csv: d_f = a=b [mm]"),
        ("rate_hz", "laser.csv:30,5"),
        ("rate_hz", "610,35"),
        ("alpha", "0,05"),
        ("band_hz", "0,5:40"),
        ("fact-pressure_front_bar", "2,2"),
        ("fact-temperature_c", "-3,5"),
        ("mass_front_kg", "23,5"),
    ] {
        let valid = format!(
            "const field = document.getElementById('{field}'); field.value = '{text}'; \
             return [field.value, field.checkValidity()]"
        );
        assert_eq!(browser.run(&valid).await, json!([text, true]), "{field}");
    }
    browser.stop().await;
}
