use std::time::Instant;

use serde_json::Value;

use crate::built::has;
use crate::harness::Server;
use crate::measured;
use crate::season;

#[tokio::test]
async fn every_parameter_of_a_finished_job_joins_the_fleet() {
    let server = Server::start();
    let job = server.submit(&[]).await;
    let view = server.succeeded(&job).await;
    let report = server.json(&format!("{job}/report")).await;

    let bikes = server.json("/v1/bikes").await;
    assert_eq!(bikes["items"][0]["name"], "lab-7");
    let bike = server.json("/v1/bikes/lab-7").await;
    assert_eq!(bike["jobs"], 1);
    assert_eq!(bike["document"]["mass_rear_kg"], 63.0);

    let all = server.json("/v1/parameters?limit=1000").await;
    // Of two axles: k, B, natural frequency and damping ratio of the result, k and B by four methods.
    assert_eq!(all["items"].as_array().unwrap().len(), 24);
    let one = server
        .json("/v1/parameters?method=output_error&axle=front&name=k_n_m")
        .await;
    let item = &one["items"][0];
    assert_eq!(item["job"], view["id"]);
    assert_eq!(item["unit"], "N/m");
    assert_eq!(item["value"], report["output_error"]["front"]["k_n_m"]);
    assert_eq!(
        item["std_error"],
        report["output_error"]["front"]["k_std_n_m"]
    );
    let number = |of: &str| item[of].as_f64().unwrap();
    let half = 1.96 * number("std_error");
    assert!(
        (number("high") - number("low") - 2.0 * half).abs() < 1e-3 * half,
        "{item}"
    );
    assert_eq!(item["page"], view["links"]["page"]);
    let history = server.json("/v1/bikes/lab-7/history?method=swarm").await;
    assert_eq!(history["items"].as_array().unwrap().len(), 4);

    let mut seen = Vec::new();
    let mut path = "/v1/parameters?limit=5".to_owned();
    loop {
        let page = server.json(&path).await;
        seen.extend(page["items"].as_array().unwrap().clone());
        let Some(next) = page["next"].as_str() else {
            break;
        };
        path = format!("/v1/parameters?limit=5&cursor={next}");
    }
    assert_eq!(
        Value::Array(seen),
        all["items"],
        "pages join without gap or overlap"
    );

    let csv = server.get("/v1/parameters?format=csv&method=swarm").await;
    assert_eq!(csv.headers()["content-type"], "text/csv; charset=utf-8");
    let text = csv.text().await.unwrap();
    assert_eq!(text.lines().count(), 5, "{text}");
    assert!(text.starts_with("job,bike,identified_at,method,axle,name,value"));

    let again = server.submit(&[("again", "true")]).await;
    let again = server.succeeded(&again).await;
    let newest = server.json("/v1/parameters?newest=true&limit=1000").await;
    let newest = newest["items"].as_array().unwrap();
    assert_eq!(newest.len(), 24);
    assert!(newest.iter().all(|row| row["job"] == again["id"]));
    let all = server.json("/v1/parameters?limit=1000").await;
    assert_eq!(all["items"].as_array().unwrap().len(), 48);
}

#[tokio::test]
async fn a_season_shows_what_wears_what_was_changed_and_what_stands_out() {
    let server = Server::with(&["--workers", "0"]);
    season::write(&server, 8, 400).await;

    let course = async |bike: &str, axle: &str| -> Value {
        let history = server.json(&format!("/v1/bikes/{bike}/course")).await;
        let courses = history["courses"].as_array().unwrap().clone();
        let own = |c: &&Value| c["axle"] == axle && c["name"] == "k_n_m";
        courses.iter().find(own).unwrap().clone()
    };
    let leaking = course("season-001", "front").await;
    assert!(leaking["development"]["per_day"].as_f64().unwrap() < 0.0);
    assert!(leaking["pooled"]["heterogeneity"].as_f64().unwrap() > 0.5);
    let changed = course("season-002", "rear").await;
    let development = &changed["development"];
    let [step, now] = ["step", "now"].map(|key| development[key].as_f64().unwrap());
    let ratio = now / (now - step);
    assert!((ratio - 1.12).abs() < 0.02, "{ratio}");
    let fleet = server.json("/v1/fleet").await;
    let of_fleet = fleet["bikes"].as_array().unwrap();
    let same = of_fleet.iter().find(|b| b["bike"] == "season-002").unwrap()["parameters"]
        .as_array()
        .unwrap();
    let same = same
        .iter()
        .find(|p| p["axle"] == "rear" && p["name"] == "k_n_m")
        .unwrap();
    assert_eq!(same["development"], *development);
    assert_eq!(same["pooled"], changed["pooled"]);

    let fleet = server.json("/v1/fleet").await;
    for bike in fleet["bikes"].as_array().unwrap() {
        let parameters = bike["parameters"].as_array().unwrap();
        let stands_out = parameters.iter().any(|p| p["outlier"] == true);
        if bike["bike"] == "season-003" {
            assert!(stands_out, "{bike:#}");
        }
        for p in parameters {
            let of = format!("{} {} {}", bike["bike"], p["axle"], p["name"]).replace('"', "");
            let expected = match of.as_str() {
                "season-001 front k_n_m" => "drift",
                "season-002 rear k_n_m" => "step",
                _ => "none",
            };
            let kind = p["development"]["kind"].as_str().unwrap_or("none");
            assert_eq!(kind, expected, "{of}: {p:#}");
        }
    }
    for (path, said) in [
        ("/bikes", "deviations below"),
        ("/bikes/season-001", "Front stiffness has been falling by"),
        ("/bikes/season-002", "Rear stiffness rose by"),
        ("/jobs?verdict=named", "named: "),
        ("/bikes", "front stiffness has been falling by"),
        ("/bikes", "rear stiffness rose by"),
        ("/bikes", "front stiffness over "),
        (
            "/parameters?effect=sensor_delay&from=&to=",
            "sensor delay: delay",
        ),
    ] {
        let page = server.get(path).await.text().await.unwrap();
        assert!(page.contains(said), "{path} does not say: {said}");
    }
}

#[tokio::test]
async fn parameters_are_found_by_every_filter_and_exported_whole() {
    let server = Server::with(&["--workers", "0"]);
    season::write(&server, 3, 120).await;
    let all = server.json("/v1/parameters?limit=100000").await["items"].take();
    let all = all.as_array().unwrap();
    let count = async |query: &str| {
        let page = server
            .json(&format!("/v1/parameters?limit=100000&{query}"))
            .await;
        page["items"].as_array().unwrap().len()
    };
    let of = |test: &dyn Fn(&Value) -> bool| all.iter().filter(|item| test(item)).count();
    let day = all[all.len() / 2]["identified_at"].as_str().unwrap();
    for (query, expected) in [
        ("bike=season-002", of(&|p| p["bike"] == "season-002")),
        (
            "method=swarm&axle=rear",
            of(&|p| p["method"] == "swarm" && p["axle"] == "rear"),
        ),
        ("verdict=named", of(&|p| p["verdict"] == "named")),
        (
            "effect=sensor_delay",
            of(&|p| p["name"] == "sensor_delay.delay"),
        ),
        (
            &format!("to={day}"),
            of(&|p| p["identified_at"].as_str() < Some(day)),
        ),
        (
            &format!("from={day}"),
            of(&|p| p["identified_at"].as_str() >= Some(day)),
        ),
        ("axle=both", 0),
    ] {
        assert_eq!(count(query).await, expected, "{query}");
    }
    let csv = server.get("/v1/parameters?format=csv&limit=100000").await;
    assert_eq!(csv.text().await.unwrap().lines().count(), all.len() + 1);
    if !has("parquet") {
        return;
    }
    let file = server
        .get("/v1/parameters?format=parquet&limit=100000")
        .await;
    assert_eq!(
        file.headers()["content-type"],
        "application/vnd.apache.parquet"
    );
    let bytes = file.bytes().await.unwrap();
    assert!(bytes.starts_with(b"PAR1") && bytes.ends_with(b"PAR1"));
}

#[tokio::test]
async fn an_effect_has_a_page_across_the_fleet_and_jobs_are_found_by_it_and_by_name() {
    let server = Server::with(&["--workers", "0"]);
    season::write(&server, 3, 150).await;
    let found = server.json("/v1/fleet/effects/coulomb_friction").await;
    let found = found.as_array().unwrap();
    let rides: u64 = found
        .iter()
        .map(|bike| bike["rides"].as_u64().unwrap())
        .sum();
    let jobs = server
        .json("/v1/jobs?effect=coulomb_friction&limit=1000")
        .await;
    assert_eq!(jobs["items"].as_array().unwrap().len() as u64, rides);
    assert!(rides > 5 && found[0]["rides"].as_u64() >= found[1]["rides"].as_u64());
    let pooled = &found[0]["parameters"][0];
    assert_eq!(
        (&pooled["name"], &pooled["unit"]),
        (&Value::from("friction"), &Value::from("N"))
    );
    assert!((pooled["pooled"]["value"].as_f64().unwrap() - 0.02).abs() < 0.005);
    let page = server
        .get("/effects/coulomb_friction")
        .await
        .text()
        .await
        .unwrap();
    assert!(
        page.contains(&format!("Named on {rides} rides")) && page.contains("season-00"),
        "{page}"
    );
    assert_eq!(
        server.json("/v1/fleet/effects/bump_stop").await,
        Value::Array(Vec::new())
    );
    for path in ["/v1/fleet/effects/none", "/effects/none", "/effects/a%00b"] {
        assert_eq!(server.get(path).await.status(), 404, "{path}");
    }

    // Rides of a season are called by their bicycles.
    for (name, count) in [
        ("SEASON-002", None),
        ("%", Some(0)),
        ("on_0", Some(0)),
        ("no such", Some(0)),
    ] {
        let query: String = form_urlencoded::byte_serialize(name.as_bytes()).collect();
        let jobs = server
            .json(&format!("/v1/jobs?limit=1000&name={query}"))
            .await;
        let jobs = jobs["items"].as_array().unwrap();
        assert!(jobs.iter().all(|job| job["bike"] == "season-002"), "{name}");
        assert_eq!(count.unwrap_or(jobs.len().max(1)), jobs.len(), "{name}");
    }
    let page = server
        .get("/jobs?effect=coulomb_friction&name=season")
        .await
        .text()
        .await
        .unwrap();
    assert!(
        page.contains("named: coulomb friction") && !page.contains("sensor delay ("),
        "{page}"
    );
}

/// Rides and jobs are found by pressure, rider, tyres, further facts and the numbers of their results.
#[tokio::test]
async fn jobs_are_found_by_facts_and_by_numbers() {
    let server = Server::with(&["--workers", "0"]);
    season::write(&server, 3, 90).await;
    let all = server.json("/v1/jobs?limit=1000").await["items"].take();
    let all = all.as_array().unwrap();
    for (job, patch) in [
        (
            &all[0],
            serde_json::json!({"rider": "Ada Lovelace", "stem_mm": 90}),
        ),
        (
            &all[1],
            serde_json::json!({"rider": "ada", "tyres": "Slick 32", "stem_mm": 110}),
        ),
    ] {
        let ride = format!("/v1/rides/{}", job["ride"]["id"].as_str().unwrap());
        let request = server.client.patch(server.address(&ride)).json(&patch);
        assert_eq!(request.send().await.unwrap().status(), 200);
    }
    let count = async |query: &str| {
        let page = server.json(&format!("/v1/jobs?limit=1000&{query}")).await;
        page["items"].as_array().unwrap().len()
    };
    let bar = |job: &Value| job["ride"]["facts"]["pressure_front_bar"].as_f64().unwrap();
    let within = all
        .iter()
        .filter(|job| (2.25..=2.35).contains(&bar(job)))
        .count();
    assert!(within > 5 && within < 85);
    for (query, expected) in [
        ("rider=ADA", 2),
        ("rider=lovelace", 1),
        ("tyres=slick&rider=ada", 1),
        ("rider=%25", 0),
        ("pressure_front_bar=2.25:2.35", within),
        ("pressure_front_bar=5:", 0),
        ("fact=stem_mm:80:100", 1),
        ("fact=stem_mm:90,stem_mm::100", 1),
        ("k_front=1:1000000000", 90),
        ("rider=&k_front=", 90),
    ] {
        assert_eq!(count(query).await, expected, "{query}");
    }
    for (query, said) in [
        (
            "pressure_front_bar=hard",
            "pressure_front_bar: 'hard', expected a number such as 2.2",
        ),
        ("k_front=6:5", "k_front: from 6 to 5"),
        ("fact=stem_mm", "fact: 'stem_mm', expected a name"),
        ("fact=stem_mm:", "fact: '', expected a number"),
        ("fact=x'y:1", "fact: 'x\\'y:1'"),
        ("riders=Ada", "unknown parameter `riders`"),
    ] {
        for path in ["/v1/jobs", "/jobs"] {
            let response = server.get(&format!("{path}?{query}")).await;
            assert_eq!(response.status(), 400, "{path}?{query}");
            if path == "/v1/jobs" {
                let problem: Value = response.json().await.unwrap();
                let detail = problem["detail"].as_str().unwrap();
                assert!(detail.contains(said), "{query}: {detail}");
            }
        }
    }
    let page = server
        .get("/jobs?rider=lovelace&verdict=")
        .await
        .text()
        .await
        .unwrap();
    assert!(
        page.contains("value=\"lovelace\"") && page.matches("data-label=\"Bike\"").count() == 1
    );
}

/// Events are marks in a bicycle's history, and a step beside one names it; they go and come back with the bicycle.
#[tokio::test]
async fn events_explain_steps_and_go_with_the_bicycle() {
    let server = Server::with(&["--workers", "0"]);
    season::write(&server, 3, 150).await;
    let events = "/v1/bikes/season-002/events";
    let course = async || server.json("/v1/bikes/season-002/course").await;
    let step = async || {
        let courses = course().await["courses"].take();
        let rear = |c: &&Value| c["axle"] == "rear" && c["name"] == "k_n_m";
        courses.as_array().unwrap().iter().find(rear).unwrap()["development"]["steps"][0].clone()
    };
    let before = step().await;
    assert_eq!(before["event"], Value::Null);
    let day = &before["at"].as_str().unwrap()[..10];
    let post = async |body: Value| {
        let request = server.client.post(server.address(events)).json(&body);
        request.send().await.unwrap()
    };
    let noted = post(serde_json::json!({"date": day, "text": " new tyre "})).await;
    assert_eq!(noted.status(), 201);
    let noted: Value = noted.json().await.unwrap();
    assert_eq!(
        (&noted["date"], &noted["text"]),
        (&day.into(), &"new tyre".into())
    );
    assert_eq!(
        post(serde_json::json!({"date": "2001-05-01", "text": "built"}))
            .await
            .status(),
        201
    );
    assert_eq!(step().await["event"], "the day of 'new tyre'");
    assert_eq!(course().await["events"].as_array().unwrap().len(), 2);
    let list = server.json(events).await;
    assert_eq!(list[0]["text"], "built", "the oldest first");
    for page in ["/bikes", "/bikes/season-002"] {
        let text = server.get(page).await.text().await.unwrap();
        assert!(text.contains("the day of &#39;new tyre&#39;"), "{page}");
    }

    for (body, status) in [
        (serde_json::json!({"date": "tomorrow", "text": "x"}), 400),
        (serde_json::json!({"date": "2999-01-01", "text": "x"}), 400),
        (serde_json::json!({"date": "2026-01-01", "text": " "}), 400),
        (serde_json::json!({"date": "2026-01-01"}), 400),
        (
            serde_json::json!({"date": "2026-01-01", "text": "x", "place": "y"}),
            400,
        ),
        (serde_json::json!([1]), 400),
    ] {
        assert_eq!(post(body.clone()).await.status(), status, "{body}");
    }
    let nobody = server.client.post(server.address("/v1/bikes/none/events"));
    let nobody = nobody.json(&serde_json::json!({"date": "2026-01-01", "text": "x"}));
    assert_eq!(nobody.send().await.unwrap().status(), 404);
    assert_eq!(server.get("/v1/bikes/none/events").await.status(), 404);

    // By the form, and its button.
    let form = async |path: &str, fields: &[(&str, &str)]| {
        let mut body = form_urlencoded::Serializer::new(String::new());
        let body = body.extend_pairs(fields).finish();
        let request = server.client.post(server.address(path)).body(body);
        let request = request.header("content-type", "application/x-www-form-urlencoded");
        request.send().await.unwrap().status()
    };
    let page = "/bikes/season-002/events";
    assert_eq!(
        form(page, &[("date", "2020-02-02"), ("text", "service")]).await,
        200
    );
    assert_eq!(
        form(page, &[("date", "2020-02-02"), ("text", "")]).await,
        400
    );
    let list = server.json(events).await;
    let service = list
        .as_array()
        .unwrap()
        .iter()
        .find(|e| e["text"] == "service")
        .unwrap();
    let id = service["id"].as_str().unwrap();
    assert_eq!(form(&format!("{page}/{id}/delete"), &[]).await, 200);
    let gone = server
        .client
        .delete(server.address(&format!("{events}/{id}")));
    assert_eq!(gone.send().await.unwrap().status(), 404);
    let trail = server.json("/v1/audit").await;
    let subject = trail["items"][0]["subject"].as_str().unwrap();
    assert_eq!(subject, format!("event {id} of bike season-002"));

    // Deleted with the bicycle, and back with it.
    let bike = server.address("/v1/bikes/season-002");
    assert_eq!(
        server.client.delete(&bike).send().await.unwrap().status(),
        204
    );
    assert_eq!(server.get(events).await.status(), 404);
    let back = server.client.post(format!("{bike}/restore")).send().await;
    assert_eq!(back.unwrap().status(), 200);
    assert_eq!(server.json(events).await.as_array().unwrap().len(), 2);
}

/// Requests of which the median is taken.
const REQUESTS: usize = 15;

#[tokio::test]
#[ignore = "measures"]
async fn the_fleet_of_100_000_rides() {
    measured::head();
    for bikes in [40, 1000] {
        let server = Server::start();
        season::write(&server, bikes, 100_000).await;
        for path in ["/v1/fleet", "/bikes"] {
            let mut seconds = Vec::new();
            for _ in 0..REQUESTS {
                let begin = Instant::now();
                assert_eq!(server.get(path).await.status(), 200);
                seconds.push(begin.elapsed().as_secs_f64());
            }
            let first = seconds[0];
            seconds.sort_by(f64::total_cmp);
            measured::row(
                &format!("`{path}`, {bikes} bicycles: first, then median and most"),
                format!(
                    "{:.3}, {:.3} and {:.3} s",
                    first,
                    seconds[REQUESTS / 2],
                    seconds[REQUESTS - 1]
                ),
                "0.1 s",
            );
        }
    }
}
