//! The bicycle told in the upload form: in single fields, each checked while it is typed, and in one way at a time.

use serde_json::{Value, json};

use super::chromium::{Browser, Look};
use super::finished;
use crate::harness::Server;
use crate::ride;

/// Every field for a number.
const NUMBERS: &str = "return [...document.querySelectorAll('[data-way=fields] [inputmode=decimal]')].map(({ id }) => id)";

async fn choose_file(browser: &Browser, server: &Server) {
    let path = server.folder.write("ride.csv", ride::example());
    let field = browser.find("#file").await;
    field.send_keys(path.to_str().unwrap()).await.unwrap();
}

pub async fn be_quick(browser: &Browser) {
    browser.click("#options > summary").await;
    for (field, value) in ride::QUICK {
        match field {
            "diagnosis" => browser.choose("#diagnosis", value).await,
            _ => browser.fill(&format!("#{field}"), value).await,
        }
    }
}

#[tokio::test]
async fn a_bicycle_is_described_in_fields_and_faults_stand_beside_them() {
    let server = Server::start();
    for (look, is_known) in [(Look::NARROW, false), (Look::WIDE, true)] {
        let Some(browser) = Browser::start(look).await else {
            return;
        };
        browser.goto(&server.address("/")).await;
        browser.click("[name=bicycle][value=fields]").await;
        for (field, text, said) in [
            ("mass_front_kg", "51 lb", "expected a number of kg"),
            ("l_front_m", "808", "l_front_m is 808.0, expected 0.01 to 5"),
            ("wheelbase_m", "1.1", "needs both masses"),
            ("mass_rear_std_kg", "0.5", "mass_rear_kg is null"),
            ("bike_name", "..", "a step in a path"),
        ] {
            browser.fill(&format!("#{field}"), text).await;
            browser.sees(&format!("#{field}-fault"), said).await;
            let wrong = format!("return document.querySelector('#{field}').ariaInvalid");
            assert_eq!(browser.run(&wrong).await, "true");
            browser.fill(&format!("#{field}"), "").await;
            let fault = format!("return document.querySelector('#{field}-fault').innerText");
            browser.until(&fault, |fault| *fault == "").await;
        }
        for (field, text) in [
            ("bike_name", "field bike"),
            ("mass_front_kg", "23"),
            ("mass_rear_kg", "63 kg"),
            ("wheelbase_m", "1.101"),
        ] {
            browser.fill(&format!("#{field}"), text).await;
        }
        browser
            .sees("#bike-understood", "0.80655 m front, 0.29445 m rear")
            .await;
        let wide = "return document.documentElement.scrollWidth - innerWidth";
        assert!(browser.run(wide).await.as_f64() <= Some(0.0));
        be_quick(&browser).await;
        choose_file(&browser, &server).await;
        browser.sees("#rides", "20.0 s at 200 Hz").await;
        browser.click("button.primary").await;
        match is_known {
            false => browser.sees("h1", "field bike: ride.csv").await,
            true => browser.sees("#rides", "before").await,
        }
        browser.stop().await;
    }
    let known = server.json("/v1/bikes/field%20bike").await;
    assert_eq!(known["document"]["mass_rear_kg"], 63.0, "{known}");
}

#[tokio::test]
async fn every_field_filled_reaches_the_bike_file() {
    let server = Server::start();
    finished(&server, "1").await;
    let Some(browser) = Browser::start(Look::WIDE).await else {
        return;
    };
    browser.goto(&server.address("/")).await;
    browser.click("[name=bicycle][value=fields]").await;
    browser.click("[data-way=fields] summary").await;
    browser.fill("#bike_name", "whole").await;
    let fields = browser.run(NUMBERS).await;
    let mut expected = json!({"bike": "whole", "equal_axles": true});
    for field in fields.as_array().unwrap() {
        let field = field.as_str().unwrap();
        if field == "wheelbase_m" {
            continue;
        }
        let example = format!("return document.querySelector('#{field}').placeholder");
        let example = browser.run(&example).await;
        browser
            .fill(&format!("#{field}"), example.as_str().unwrap())
            .await;
        expected[field] = json!(example.as_str().unwrap().parse::<f64>().unwrap());
    }
    browser.click("[name=equal_axles]").await;
    be_quick(&browser).await;
    choose_file(&browser, &server).await;
    browser.sees("#rides", "20.0 s at 200 Hz").await;
    browser.click("button.primary").await;
    browser.sees("h1", "whole: ride.csv").await;
    let known = server.json("/v1/bikes/whole").await;
    for (key, value) in expected.as_object().unwrap() {
        assert_eq!(&known["document"][key], value, "{key}: {known}");
    }
    browser.stop().await;
}

/// What stands in the fields of another way is neither sent nor lost.
#[tokio::test]
async fn one_way_counts_at_a_time() {
    let server = Server::start();
    finished(&server, "1").await;
    let Some(browser) = Browser::start(Look::WIDE).await else {
        return;
    };
    browser.goto(&server.address("/?bike=lab-7")).await;
    let shown = "return [...document.querySelectorAll('.way')].filter((way) => way.checkVisibility()).map(({ dataset }) => dataset.way)";
    assert_eq!(browser.run(shown).await, json!(["fleet"]));
    browser.click("[name=bicycle][value=fields]").await;
    assert_eq!(browser.run(shown).await, json!(["fields"]));
    browser.fill("#mass_front_kg", "much").await;
    browser.sees("#mass_front_kg-fault", "'much'").await;
    browser.click("[name=bicycle][value=file]").await;
    assert_eq!(browser.run(shown).await, json!(["file"]));
    browser.fill("#bike", "{").await;
    browser.sees("#bike-fault", "invalid JSON").await;
    browser.click("[name=bicycle][value=fleet]").await;
    browser.sees("#bike-understood", "masses 23 kg front").await;
    be_quick(&browser).await;
    choose_file(&browser, &server).await;
    browser.click("button.primary").await;
    browser.sees("#rides", "before").await;
    browser.click("[name=bicycle][value=fields]").await;
    let kept = "return document.querySelector('#mass_front_kg').value";
    assert_eq!(browser.run(kept).await, "much");
    let violations = browser.run("return window.violations ?? []").await;
    assert_eq!(violations, Value::Array(Vec::new()));
    browser.stop().await;
}
