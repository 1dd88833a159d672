//! The pages in a real browser: headless Chromium, driven through chromedriver. Where there is none
//! the tests say so and pass.

mod bicycle;
mod chromium;
mod columns;
mod first_try;
mod forms;
mod loggers;
mod outcomes;

use fantoccini::Locator;
use fantoccini::wd::PrintConfiguration;
use serde_json::{Value, json};

use crate::harness::Server;
use crate::ride::{self, LONG};
use crate::season;
use chromium::{Browser, Look};

/// A finished job's id; every `seed` another one.
async fn finished(server: &Server, seed: &str) -> String {
    let job = server.submit(&[("seed", seed)]).await;
    server.succeeded(&job).await;
    job.trim_start_matches("/v1/jobs/").to_owned()
}

#[tokio::test]
async fn rides_are_previewed_uploaded_and_followed() {
    let server = Server::start();
    let Some(browser) = Browser::start(Look::WIDE).await else {
        return;
    };
    browser.goto(&server.address("/")).await;
    let field = browser.find("#file").await;
    for (name, samples) in [("one.csv", 4000), ("two.csv", 3000)] {
        let path = server.folder.write(name, ride::table(samples, 200.0));
        field.send_keys(path.to_str().unwrap()).await.unwrap();
    }
    let broken = server.folder.write("broken.csv", "t,z_f\n0,1\n");
    field.send_keys(broken.to_str().unwrap()).await.unwrap();
    browser.sees("#rides", "15.0 s at 200 Hz").await;
    browser.sees("#rides li:nth-child(3) .fault", "").await;
    browser.click("[aria-label='Remove broken.csv']").await;

    browser.click("#options > summary").await;
    for (name, value) in ride::QUICK {
        if name != "diagnosis" {
            browser.fill(&format!("#{name}"), value).await;
        }
    }
    browser.click("[name=bicycle][value=file]").await;
    browser.fill("#bike", "no bike").await;
    browser.click("button.primary").await;
    browser.sees("#bike-fault", "not a bike of the fleet").await;
    browser.fill("#bike", ride::BIKE).await;
    browser.choose("#diagnosis", "false").await;
    browser.click("button.primary").await;
    for ride in 1..=2 {
        let link = format!("#rides li:nth-child({ride}) a");
        browser.sees(&link, "see the result").await;
    }
    browser.click("#rides li:nth-child(2) a").await;
    browser.sees("#result", "axle").await;
    browser.sees("h1", "lab-7: two.csv").await;
    browser.stop().await;
}

#[tokio::test]
async fn a_ride_is_dropped_on_the_form() {
    let server = Server::start();
    let Some(browser) = Browser::start(Look::WIDE).await else {
        return;
    };
    browser.goto(&server.address("/")).await;
    let ride = json!(ride::table(2000, 200.0));
    let drag = |kind: &str| {
        format!(
            "const dataTransfer = new DataTransfer(); \
             dataTransfer.items.add(new File([{ride}], 'dropped.csv', {{ type: 'text/csv' }})); \
             const event = new DragEvent('{kind}', {{ dataTransfer, bubbles: true, cancelable: true }}); \
             return document.querySelector('.drop').dispatchEvent(event)"
        )
    };
    const OVER: &str = "return document.querySelector('.drop').classList.contains('over')";
    // False: the page takes the file, instead of the browser leaving for it.
    assert_eq!(browser.run(&drag("dragover")).await, false);
    assert_eq!(browser.run(OVER).await, true);
    assert_eq!(browser.run(&drag("drop")).await, false);
    assert_eq!(browser.run(OVER).await, false);
    browser.sees("#rides", "10.0 s at 200 Hz").await;
    browser.sees("#rides li strong", "dropped.csv").await;
    browser.click("[name=bicycle][value=file]").await;
    browser.fill("#bike", ride::BIKE).await;
    browser.click("button.primary").await;
    // One ride alone leads to its job.
    browser.sees("h1", "lab-7: dropped.csv").await;
    browser.stop().await;
}

#[tokio::test]
async fn curves_grow_while_the_job_runs_come_back_after_a_reload_and_it_is_cancelled() {
    let server = Server::start();
    let Some(browser) = Browser::start(Look::WIDE).await else {
        return;
    };
    let job = server.submit(&LONG).await;
    let page = server.address(job.trim_start_matches("/v1"));
    browser.goto(&page).await;
    const POINTS: &str = "return Number(document.querySelector('#live .plot').dataset.points ?? 0)";
    let first = browser
        .until(POINTS, |points| points.as_f64() > Some(3.0))
        .await;
    let more = browser
        .until(POINTS, |points| points.as_f64() > first.as_f64())
        .await;
    browser.goto(&page).await;
    browser
        .until(POINTS, |points| points.as_f64() >= more.as_f64())
        .await;
    browser.sees("#early", "front").await;
    browser.sees("#stages .now", "swarm").await;
    browser.click("form[action$='/cancel'] button").await;
    browser.sees("#state", "cancelled").await;
    browser
        .sees("form[action$='/retry'] button", "Try again")
        .await;
    browser.stop().await;
}

#[tokio::test]
async fn plots_zoom_together_with_finer_data_and_have_tables() {
    let server = Server::start();
    let Some(browser) = Browser::start(Look::WIDE).await else {
        return;
    };
    let id = finished(&server, "1").await;
    browser.goto(&server.address(&format!("/jobs/{id}"))).await;
    let range = |figure: &str| {
        format!(
            "const plot = document.querySelector('#{figure} .plot'); return plot.layout?.xaxis?.range?.map(Number) ?? null"
        )
    };
    let width = |range: &Value| Some(range[1].as_f64()? - range[0].as_f64()?);
    for figure in ["displacement-front", "velocity-rear"] {
        browser.scroll(&format!("#{figure}")).await;
        browser
            .until(&range(figure), |range| width(range) > Some(15.0))
            .await;
    }
    const STEP: &str = "const x = document.querySelector('#displacement-front .plot').data[0].x; return x[1] - x[0]";
    let coarse = browser.run(STEP).await.as_f64().unwrap();
    browser.press("#displacement-front .plot", "+++").await;
    let near = browser
        .until(&range("displacement-front"), |range| {
            width(range) < Some(5.0)
        })
        .await;
    let same = browser
        .until(&range("velocity-rear"), |range| width(range) < Some(5.0))
        .await;
    assert_eq!(near, same, "one time axis");
    browser
        .until(STEP, |step| step.as_f64() < Some(coarse))
        .await;
    browser.press("#displacement-front .plot", "0").await;
    browser
        .until(&range("velocity-rear"), |range| width(range) > Some(15.0))
        .await;

    browser.click("#cost .tools button:nth-child(2)").await;
    browser.sees("#cost .data", "trial 1, seed 1").await;
    browser.stop().await;
}

#[tokio::test]
async fn tabs_show_the_model_from_inside_by_mouse_and_keyboard() {
    let server = Server::start();
    let Some(browser) = Browser::start(Look::NARROW).await else {
        return;
    };
    let id = finished(&server, "1").await;
    browser.goto(&server.address(&format!("/jobs/{id}"))).await;
    let shown = "return [...document.querySelectorAll('[role=tabpanel]')].filter((panel) => panel.checkVisibility()).map(({ id }) => id)";
    browser.until(shown, |ids| *ids == json!(["fit"])).await;
    browser.sees("#fit", "Autocorrelation").await;
    browser.click("#tab-response").await;
    browser.sees("#response", "Natural frequency").await;
    for figure in ["frequency-front", "step-rear"] {
        browser.scroll(&format!("#{figure}")).await;
        let drawn = format!("return document.querySelector('#{figure} .plot').data?.length ?? 0");
        browser
            .until(&drawn, |traces| traces.as_u64() > Some(0))
            .await;
    }
    let wide = "return document.documentElement.scrollWidth - innerWidth";
    assert!(browser.run(wide).await.as_f64() <= Some(0.0));
    browser.press("#tab-response", "\u{e014}").await;
    browser.until(shown, |ids| *ids == json!(["missing"])).await;
    browser.press("#tab-missing", "\u{e014}").await;
    browser.until(shown, |ids| *ids == json!(["fit"])).await;
    browser.stop().await;
}

#[tokio::test]
async fn a_comparison_lives_in_its_address() {
    let server = Server::start();
    let Some(browser) = Browser::start(Look::WIDE).await else {
        return;
    };
    for seed in ["1", "2"] {
        finished(&server, seed).await;
    }
    browser.goto(&server.address("/jobs")).await;
    for row in 1..=2 {
        browser
            .click(&format!("tbody tr:nth-child({row}) input"))
            .await;
    }
    browser.sees("#chosen", "Compare 2").await;
    browser.click("#chosen").await;
    browser.sees("h1", "Compare").await;
    browser.choose("#quantity", "velocity").await;
    browser
        .until(
            "return document.querySelector('#compare-front .plot').data?.length ?? 0",
            |n| n == 2,
        )
        .await;
    browser.press("#compare-front .plot", "++").await;
    browser
        .until("return location.search", |query| {
            query.as_str().is_some_and(|query| query.contains("t1="))
        })
        .await;
    let address = browser.run("return location.href").await;
    browser.goto(address.as_str().unwrap()).await;
    let shown = "const plot = document.querySelector('#compare-front .plot'); \
                 return plot.data ? [plot.layout.xaxis.range[1], document.querySelector('#quantity').value] : null";
    let shown = browser.until(shown, |shown| !shown.is_null()).await;
    assert!(
        shown[0].as_f64() < Some(19.0) && shown[1] == "velocity",
        "{shown}"
    );
    browser.stop().await;
}

#[tokio::test]
async fn no_page_has_a_serious_fault_of_access() {
    let server = Server::start();
    let Some(axe) = chromium::axe() else { return };
    season::write(&server, 6, 120).await;
    let [a, b] = [finished(&server, "1").await, finished(&server, "2").await];
    let long = server.submit(&LONG).await;
    let pages = [
        "/".to_owned(),
        "/jobs".to_owned(),
        format!("/jobs/{a}"),
        long.trim_start_matches("/v1").to_owned(),
        format!("/compare?job={a}&job={b}"),
        "/bikes".to_owned(),
        "/bikes/season-001".to_owned(),
        "/parameters".to_owned(),
        "/jobs/none".to_owned(),
        "/sign-in".to_owned(),
    ];
    for look in [Look::WIDE, Look::NARROW] {
        let Some(browser) = Browser::start(look).await else {
            return;
        };
        for theme in ["light", "dark"] {
            for path in &pages {
                let mark = if path.contains('?') { '&' } else { '?' };
                browser
                    .goto(&server.address(&format!("{path}{mark}theme={theme}")))
                    .await;
                browser.settled().await;
                let faults = browser.check(&axe).await;
                assert_eq!(faults, json!([]), "{path}, {theme}, {look:?}");
                let wide = browser
                    .run("return document.documentElement.scrollWidth - innerWidth")
                    .await;
                assert!(
                    wide.as_f64() <= Some(0.0),
                    "{path} scrolls sideways, {look:?}"
                );
            }
        }
        browser.stop().await;
    }
}

#[tokio::test]
async fn a_result_can_be_read_without_scripts_and_keeps_to_the_policy() {
    let server = Server::start();
    let Some(browser) = Browser::start(Look::WIDE).await else {
        return;
    };
    let id = finished(&server, "1").await;
    browser.goto(&server.address(&format!("/jobs/{id}"))).await;
    let result = browser.client.find(Locator::Css("#result")).await.unwrap();
    assert!(
        result.text().await.unwrap().contains("N/m"),
        "before any script has run"
    );
    browser.settled().await;
    let paper = browser
        .client
        .print(PrintConfiguration::default())
        .await
        .unwrap();
    let pages = |kind: &[u8]| {
        paper
            .windows(kind.len())
            .filter(|part| *part == kind)
            .count()
    };
    assert_eq!(pages(b"/Type /Page\n"), 1, "a report fits on one page");
    let violations = browser.run("return window.violations ?? []").await;
    assert_eq!(violations, json!([]));
    browser.stop().await;
}

#[tokio::test]
async fn the_fleet_leads_to_a_bicycles_history() {
    let server = Server::with(&["--workers", "0"]);
    season::write(&server, 8, 200).await;
    let Some(browser) = Browser::start(Look::NARROW).await else {
        return;
    };
    browser.goto(&server.address("/bikes")).await;
    browser
        .sees("tbody tr:nth-child(3)", "deviations below")
        .await;
    browser.click("tbody tr:nth-child(1) a").await;
    browser.sees("h1", "season-001").await;
    browser
        .sees("main", "Front stiffness has been falling by")
        .await;
    browser.scroll("#history-front").await;
    let drawn = "return document.querySelector('#history-front .plot').data?.map((trace) => trace.name) ?? []";
    let names = browser
        .until(drawn, |names| {
            names.as_array().is_some_and(|names| !names.is_empty())
        })
        .await;
    // Then the sizes of the effects that its rides name.
    assert_eq!(names.as_array().unwrap()[..3], ["k", "level", "B"]);
    assert!(names.as_array().unwrap().contains(&json!("friction")));
    browser.click("a[href*='format=csv']").await;
    browser.goto(&server.address("/parameters")).await;
    browser.click(".fold summary").await;
    browser.choose("#verdict", "unnamed").await;
    browser.click(".filter button").await;
    browser.sees("tbody tr:nth-child(1)", "unnamed").await;
    browser.stop().await;
}
