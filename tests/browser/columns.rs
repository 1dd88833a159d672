//! Columns that are called otherwise than channels: guessed, marked, and chosen by drop-down.

use serde_json::json;

use super::chromium::{Browser, Look};
use crate::harness::Server;
use crate::ride;

/// The choice of each column.
const CHOSEN: &str = "return [...document.querySelectorAll('.column')].map((row) => [row.dataset.header, row.querySelector('select').value])";

async fn choose(browser: &Browser, header: &str, channel: &str) {
    let select = format!(".column[data-header='{header}'] select");
    browser.choose(&select, channel).await;
}

#[tokio::test]
async fn guessed_columns_are_marked_and_others_are_chosen() {
    let server = Server::start();
    for look in [Look::WIDE, Look::NARROW] {
        let Some(browser) = Browser::start(look).await else {
            return;
        };
        let headers = "Zeit [s],roadFront,Fahrbahn hinten [m],V4,Weg hinten [m]";
        let table = ride::table(2000, 200.0).replacen("t,u_f,u_r,z_f,z_r", headers, 1);
        let path = server.folder.write("logger.csv", table);
        browser.goto(&server.address("/")).await;
        browser.click("[name=bicycle][value=file]").await;
        browser.fill("#bike", ride::BIKE).await;
        let field = browser.find("#file").await;
        field.send_keys(path.to_str().unwrap()).await.unwrap();
        browser.sees(".columns", "Guessed from the header").await;
        let guessed = json!([
            ["Zeit [s]", ""],
            ["roadFront", "u_f"],
            ["Fahrbahn hinten [m]", ""],
            ["V4", ""],
            ["Weg hinten [m]", ""]
        ]);
        assert_eq!(browser.run(CHOSEN).await, guessed);
        let wide = "return document.documentElement.scrollWidth - innerWidth";
        assert!(browser.run(wide).await.as_f64() <= Some(0.0));
        choose(&browser, "V4", "u_f").await;
        browser.sees("#rides .fault", "u_f is given as").await;
        choose(&browser, "V4", "z_f").await;
        browser.sees("#rides", "z_f from V4 (m)").await;
        browser.sees("#rides", "10.0 s at 200 Hz").await;
        browser.click("#options > summary").await;
        for (field, value) in ride::QUICK {
            match field {
                "diagnosis" => browser.choose("#diagnosis", value).await,
                _ => browser.fill(&format!("#{field}"), value).await,
            }
        }
        browser.click("#options [name=again]").await;
        browser.click("button.primary").await;
        browser.sees("h1", "lab-7: logger.csv").await;
        browser.sees("#result", "axle").await;
        browser.stop().await;
    }
}

#[tokio::test]
async fn a_unit_at_the_end_of_a_header_is_chosen_with_it() {
    let server = Server::with(&["--workers", "0"]);
    let Some(browser) = Browser::start(Look::NARROW).await else {
        return;
    };
    let table = ride::table(2000, 200.0).replacen("z_f", "Weg vorne mm", 1);
    let path = server.folder.write("mm.csv", table);
    browser.goto(&server.address("/")).await;
    let field = browser.find("#file").await;
    field.send_keys(path.to_str().unwrap()).await.unwrap();
    browser.sees("#rides", "z_f from Weg vorne mm (mm)").await;
    let chosen = "return [...document.querySelectorAll(`.column[data-header='Weg vorne mm'] select`)].map(({ value }) => value)";
    // Its unit leaves no choice: it is read so without being chosen.
    assert_eq!(browser.run(chosen).await, json!(["", ""]));
    let natural = "return document.querySelector(`.column[data-header=z_r] option`).text";
    assert_eq!(browser.run(natural).await, "z_r (by name)");
    browser.stop().await;
}
