//! Every form on a server with a history: each field filled and blank, each choice, back and reload.

use serde_json::{Value, json};
use veloid_engine::document::format_number::Number;

use super::chromium::{Browser, Look};
use super::finished;
use crate::harness::Server;
use crate::ride::{self, LONG};
use crate::season;

/// What is said of the bicycle as a whole.
const FAULT: &str = "return document.querySelector('#bike-fault').innerText";
const ENTER: &str = "\u{e007}";
/// Answers with a fault to whatever the page has fetched.
const REFUSED: &str = "return performance.getEntriesByType('resource') \
    .filter(({ responseStatus }) => responseStatus >= 400).map(({ name }) => name)";

#[tokio::test]
async fn a_ride_is_uploaded_however_bicycle_and_channels_are_reported() {
    let server = Server::start();
    let Some(browser) = Browser::start(Look::WIDE).await else {
        return;
    };
    finished(&server, "1").await;
    let other = ride::BIKE.replace("lab-7", "lab-8");
    // The page, the bicycle chosen, its file, columns of channels, and the bicycle that it is.
    for (seed, (page, chosen, file, maps, bike)) in [
        ("/", Some("lab-7"), "", ["", ""], "lab-7"),
        ("/", Some(""), other.as_str(), ["", ""], "lab-8"),
        ("/", Some("lab-7"), other.as_str(), ["", ""], "lab-8"),
        ("/?bike=lab-8", None, "", ["z_f=V2", ""], "lab-8"),
        ("/", Some("lab-7"), "", ["", "z_f=V2"], "lab-7"),
        ("/", Some(""), ride::BIKE, ["z_f=V2", "z_r=V4"], "lab-7"),
    ]
    .into_iter()
    .enumerate()
    {
        let mut table = ride::table(2000, 200.0);
        for (map, channel, column) in [(0, "z_f", "V2"), (1, "z_f", "V2"), (1, "z_r", "V4")] {
            if maps[map] == format!("{channel}={column}") {
                table = table.replacen(channel, column, 1);
            }
        }
        let name = format!("ride-{seed}.csv");
        let path = server.folder.write(&name, table);
        browser.goto(&server.address(page)).await;
        browser.click("#options > summary").await;
        for (field, value) in ride::QUICK {
            match field {
                "diagnosis" => browser.choose("#diagnosis", value).await,
                _ => browser.fill(&format!("#{field}"), value).await,
            }
        }
        browser.fill("#seed", &seed.to_string()).await;
        for (i, map) in maps.into_iter().enumerate() {
            browser.fill(&format!("#map{}", i + 1), map).await;
        }
        match file {
            "" => {
                if let Some(chosen) = chosen {
                    browser.choose("#fleet", chosen).await;
                }
            }
            file => {
                browser.click("[name=bicycle][value=file]").await;
                browser.fill("#bike", file).await;
            }
        }
        let field = browser.find("#file").await;
        field.send_keys(path.to_str().unwrap()).await.unwrap();
        browser.click("button.primary").await;
        browser.sees("h1", &format!("{bike}: {name}")).await;
        // The live page turns into the result by itself.
        browser.sees("#result", "axle").await;
        browser.client.refresh().await.unwrap();
        browser.sees("#result", "axle").await;
        browser.client.back().await.unwrap();
        browser.sees("h1", "Identify a ride").await;
        let ready = "return !document.querySelector('button.primary').disabled";
        assert_eq!(browser.run(ready).await, true);
    }
    browser.stop().await;
}

#[tokio::test]
async fn what_is_wrong_with_a_bicycle_is_said_beside_it_until_it_is_changed() {
    let server = Server::start();
    let Some(browser) = Browser::start(Look::NARROW).await else {
        return;
    };
    finished(&server, "1").await;
    const SENT: &str = "return performance.getEntriesByType('resource').filter(({ name }) => name.endsWith('/v1/rides')).length";
    browser.goto(&server.address("/")).await;
    let path = server.folder.write("none.csv", ride::example());
    let field = browser.find("#file").await;
    field.send_keys(path.to_str().unwrap()).await.unwrap();
    browser.click("button.primary").await;
    browser
        .sees("#bike-fault", "Choose a bicycle or enter its values.")
        .await;
    assert_eq!(browser.run(SENT).await, 0, "nothing is sent");
    browser.choose("#fleet", "lab-7").await;
    browser
        .sees("#bike-understood", "masses 23 kg front, 63 kg rear")
        .await;
    assert_eq!(browser.run(FAULT).await, "");
    // What was written comes back whole and stays within the page.
    browser.click("[name=bicycle][value=file]").await;
    let shown = "return document.querySelector('#bike').placeholder";
    let shown = browser.run(shown).await;
    assert!(shown.as_str().unwrap().contains("mass_front_kg"), "{shown}");
    browser.fill("#bike", &"1".repeat(300)).await;
    browser.sees("#bike-fault", "not a bike of the fleet").await;
    let wide = "return document.documentElement.scrollWidth - innerWidth";
    assert!(browser.run(wide).await.as_f64() <= Some(0.0));
    browser.fill("#bike", "{").await;
    browser.sees("#bike-fault", "invalid JSON").await;
    browser.fill("#bike", ride::BIKE).await;
    browser.until(FAULT, |fault| *fault == "").await;
    browser.stop().await;
}

#[tokio::test]
async fn any_number_of_channels_is_mapped_and_what_was_identified_before_is_reported() {
    let server = Server::start();
    let Some(browser) = Browser::start(Look::WIDE).await else {
        return;
    };
    finished(&server, "1").await;
    let mut table = ride::table(2000, 200.0);
    let channels = ["t", "u_f", "u_r", "z_f", "z_r"];
    table.replace_range(..channels.join(",").len(), "V1,V2,V3,V4,V5");
    let path = server.folder.write("named.csv", table);
    for before in [false, true] {
        browser.goto(&server.address("/")).await;
        browser.click("#options > summary").await;
        for (field, value) in ride::QUICK {
            match field {
                "diagnosis" => browser.choose("#diagnosis", value).await,
                _ => browser.fill(&format!("#{field}"), value).await,
            }
        }
        browser.click("#another").await;
        for (i, channel) in (1..).zip(channels) {
            browser
                .fill(&format!("#map{i}"), &format!("{channel}=V{i}"))
                .await;
        }
        browser.choose("#fleet", "lab-7").await;
        let field = browser.find("#file").await;
        field.send_keys(path.to_str().unwrap()).await.unwrap();
        browser.click("button.primary").await;
        if before {
            browser.sees("#rides", "identified before").await;
            browser.click("#rides a").await;
        }
        browser.sees("h1", "lab-7: named.csv").await;
        browser.sees("#result", "axle").await;
    }
    browser.stop().await;
}

#[tokio::test]
async fn several_rides_are_followed_to_their_end() {
    let server = Server::start();
    let Some(browser) = Browser::start(Look::NARROW).await else {
        return;
    };
    finished(&server, "1").await;
    browser.goto(&server.address("/")).await;
    browser.click("#options > summary").await;
    for (field, value) in ride::QUICK {
        match field {
            "diagnosis" => browser.choose("#diagnosis", value).await,
            _ => browser.fill(&format!("#{field}"), value).await,
        }
    }
    browser.choose("#fleet", "lab-7").await;
    let field = browser.find("#file").await;
    // The last one is the first under another name, so that both have one job.
    for (name, samples) in [("a.csv", 2000), ("b.csv", 2500), ("again.csv", 2000)] {
        let path = server.folder.write(name, ride::table(samples, 200.0));
        field.send_keys(path.to_str().unwrap()).await.unwrap();
    }
    browser.click("button.primary").await;
    for ride in 1..=3 {
        let said = format!("#rides li:nth-child({ride})");
        browser.sees(&said, "see the result").await;
        browser.sees(&said, "done").await;
    }
    let bars = "return document.querySelectorAll('#rides progress').length";
    assert_eq!(browser.run(bars).await, 0);
    assert_eq!(browser.run(REFUSED).await, json!([]));
    browser.click("#rides li:nth-child(2) a").await;
    browser.sees("h1", "lab-7: b.csv").await;
    browser.sees("#result", "axle").await;
    browser.stop().await;
}

#[tokio::test]
async fn lists_are_filtered_by_a_choice_of_every_field() {
    let server = Server::with(&["--workers", "0"]);
    season::write(&server, 4, 120).await;
    server.submit(&LONG).await;
    let Some(browser) = Browser::start(Look::WIDE).await else {
        return;
    };
    const ROWS: &str = "return document.querySelectorAll('tbody tr').length";
    for path in ["/jobs", "/parameters"] {
        let address = server.address(path);
        browser.goto(&address).await;
        let all = browser.run(ROWS).await;
        browser.click(".filter button").await;
        assert_eq!(browser.run(ROWS).await, all, "blank fields ask for nothing");
        let choices = "return [...document.querySelectorAll('.filter select')] \
            .map((field) => [field.id, [...field.options].at(-1).value])";
        for choice in browser.run(choices).await.as_array().unwrap() {
            let (field, value) = (choice[0].as_str().unwrap(), choice[1].as_str().unwrap());
            browser.goto(&address).await;
            browser.choose(&format!("#{field}"), value).await;
            browser.click(".filter button").await;
            // The page that was left holds the choice as well, so it is the address that tells the new one.
            let kept =
                format!("return new URLSearchParams(location.search).get('{field}') ?? 'none yet'");
            browser.until(&kept, |kept| *kept == value).await;
            let kept = format!("return document.querySelector('#{field}')?.value");
            assert_eq!(browser.run(&kept).await, value, "{path} {field}");
            let column = field[..1].to_uppercase() + &field[1..];
            let cells = format!(
                "return [...document.querySelectorAll('td[data-label={column}]')].map((cell) => cell.innerText)"
            );
            let said = match value {
                "output_error" => "output error".to_owned(),
                "swarm" => "particle swarm".to_owned(),
                "instrumental" => "instrumental variables".to_owned(),
                value => value.replace('_', " "),
            };
            for cell in browser.run(&cells).await.as_array().unwrap() {
                assert!(
                    cell.as_str().unwrap().contains(&said),
                    "{path} {choice} {cell}"
                );
            }
        }
        browser.goto(&address).await;
        browser.fill("#bike", " season-002 ").await;
        browser.click(".filter button").await;
        let bikes = "return [...new Set([...document.querySelectorAll('td a[href^=\"/bikes/\"]')].map((a) => a.innerText))]";
        browser
            .until(bikes, |seen| *seen == json!(["season-002"]))
            .await;
        browser.client.back().await.unwrap();
        browser.client.refresh().await.unwrap();
        browser.until(ROWS, |rows| *rows == all).await;
    }
    for (field, day, some) in [("from", "01-01-2020", true), ("to", "01-01-2020", false)] {
        browser.goto(&server.address("/parameters")).await;
        let field = browser.find(&format!("#{field}")).await;
        field.send_keys(day).await.unwrap();
        browser.click(".filter button").await;
        let rows = "return location.search ? document.querySelectorAll('tbody tr').length : null";
        browser
            .until(rows, |rows| {
                rows.as_f64().is_some_and(|rows| (rows > 0.0) == some)
            })
            .await;
    }
    browser.stop().await;
}

#[tokio::test]
async fn jobs_are_cancelled_and_retried_by_their_buttons_and_by_nothing_else() {
    let server = Server::start();
    finished(&server, "1").await;
    server.submit(&LONG).await;
    let Some(browser) = Browser::start(Look::WIDE).await else {
        return;
    };
    browser.goto(&server.address("/jobs")).await;
    // Enter in a form presses its first button: that must not be one that cancels.
    browser.press("input[name=job]", ENTER).await;
    browser.goto(&server.address("/jobs")).await;
    browser
        .sees("tbody tr:nth-child(1) .state", "running")
        .await;
    browser.click("button[aria-label^=Cancel]").await;
    browser.sees("#state", "cancelled").await;
    // The page of a job that has ended comes once more; who goes back before that goes nowhere.
    browser
        .sees("form[action$='/retry'] button", "Try again")
        .await;
    browser.client.back().await.unwrap();
    browser.client.refresh().await.unwrap();
    browser
        .sees("tbody tr:nth-child(1) .state", "cancelled")
        .await;
    browser.click("button[aria-label^=Retry]").await;
    browser.sees("#state", "running").await;
    browser.click("form[action$='/cancel'] button").await;
    browser.sees("#state", "cancelled").await;
    browser.stop().await;
}

#[tokio::test]
async fn a_browser_signs_in_and_out() {
    let (server, [key]) = Server::with_keys([&[]], &[]);
    let Some(browser) = Browser::start(Look::WIDE).await else {
        return;
    };
    for wrong in ["no key", " "] {
        browser.goto(&server.address("/sign-in?next=/bikes")).await;
        browser.fill("#key", wrong).await;
        browser.click("button.primary").await;
        browser.sees("[role=alert]", "Key not accepted").await;
    }
    browser.fill("#key", &key).await;
    browser.click("button.primary").await;
    browser.sees("h1", "Fleet").await;
    browser.client.refresh().await.unwrap();
    browser.sees("h1", "Fleet").await;
    browser.goto(&server.address("/sign-in")).await;
    browser.click("form[action='/sign-out'] button").await;
    browser.sees("h1", "Sign in").await;
    browser.stop().await;
}

/// A bench in the fleet whose mass nobody knows serves rides whose force was recorded, and no others.
#[tokio::test]
async fn a_preview_knows_the_bicycle_that_is_chosen_from_the_fleet() {
    let server = Server::with(&["--workers", "0"]);
    let Some(browser) = Browser::start(Look::WIDE).await else {
        return;
    };
    let forced = ride::table(2000, 200.0).replacen("t,u_f,u_r,z_f,z_r", "t,force_f,a,z_f,b", 1);
    let bench = r#"{"bike": "bench", "mass_front_kg": null}"#;
    let known = server.upload(forced.into_bytes(), bench, &[]).await;
    assert_eq!(known.status(), 202);
    let path = server.folder.write("ride.csv", ride::example());
    browser.goto(&server.address("/")).await;
    let field = browser.find("#file").await;
    field.send_keys(path.to_str().unwrap()).await.unwrap();
    browser.sees("#rides", "20.0 s at 200 Hz").await;
    browser.choose("#fleet", "bench").await;
    browser.sees("#rides .fault", "mass_front_kg is null").await;
    browser.choose("#fleet", "").await;
    browser.sees("#rides", "20.0 s at 200 Hz").await;
    browser.stop().await;
}

/// Two rides may be one job, and the second upload may end while the page asks after the first.
#[tokio::test]
async fn whoever_joins_while_a_job_is_asked_after_is_reported_its_end() {
    let server = Server::with(&["--workers", "0"]);
    let Some(browser) = Browser::start(Look::WIDE).await else {
        return;
    };
    browser.goto(&server.address("/")).await;
    let script = "const done = arguments[arguments.length - 1]; \
        const home = document.querySelector('script[src$=\"page.js\"]').src; \
        import(new URL('live.js', home)).then(({ watch }) => { \
          window.fetch = async () => { \
            watch('/v1/jobs/1', ({ state }) => done(state)); \
            return new Response('{\"state\": \"succeeded\"}'); }; \
          watch('/v1/jobs/1', () => {}); })";
    let reported = browser.client.execute_async(script, vec![]).await.unwrap();
    assert_eq!(reported, "succeeded");
    browser.stop().await;
}

/// Numbers are written by the pages' scripts as by the engine.
#[tokio::test]
async fn scripts_write_numbers_as_the_engine_does() {
    let server = Server::with(&["--workers", "0"]);
    let Some(browser) = Browser::start(Look::WIDE).await else {
        return;
    };
    browser.goto(&server.address("/")).await;
    let mut cases = vec![
        (0.0, None),
        (0.0, Some(0.3)),
        (23.0, None),
        (1e6, Some(3.0)),
    ];
    for power in -12..13 {
        for (mantissa, share) in [(1.2345678912, 3e-4), (-9.99996, 2.1e-2), (4.4449, 7.0)] {
            let value = mantissa * 10f64.powi(power);
            cases.push((value, None));
            cases.push((value, Some(share * value.abs())));
            cases.push((value, Some(1e-11 * value.abs())));
        }
    }
    let ours: Vec<String> = cases
        .iter()
        .map(|(value, error)| Number::measured(*value, *error).to_string())
        .collect();
    let script = format!(
        "const done = arguments[arguments.length - 1]; \
         const home = document.querySelector('script[src$=\"page.js\"]').src; \
         import(new URL('number.js', home)).then(({{ measured }}) => \
           done({}.map(([value, error]) => measured(value, error))))",
        json!(cases)
    );
    let theirs = browser.client.execute_async(&script, vec![]).await.unwrap();
    for ((case, ours), theirs) in cases.iter().zip(ours).zip(theirs.as_array().unwrap()) {
        assert_eq!(theirs, &Value::String(ours), "{case:?}");
    }
    browser.stop().await;
}
