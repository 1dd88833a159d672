use serde_json::Value;

use crate::built::has;
use crate::harness::Server;
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
    // Four methods, two axles, k and B.
    assert_eq!(all["items"].as_array().unwrap().len(), 16);
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
    assert!(leaking["trend"]["per_day"].as_f64().unwrap() < 0.0);
    assert!(leaking["trend"]["p_value"].as_f64().unwrap() < 1e-3);
    assert!(leaking["pooled"]["heterogeneity"].as_f64().unwrap() > 0.5);
    let changed = course("season-002", "rear").await;
    assert!(changed["change"]["p_value"].as_f64().unwrap() < 0.01);
    let (before, after) = (&changed["change"]["before"], &changed["change"]["after"]);
    let step = after.as_f64().unwrap() / before.as_f64().unwrap();
    assert!((step - 1.12).abs() < 0.02, "{step}");
    let steady = course("season-005", "front").await;
    assert!(
        steady["trend"]["p_value"].as_f64().unwrap() > 1e-3,
        "{steady:#}"
    );

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
            assert_eq!(p["development"]["kind"], expected, "{of}: {p:#}");
        }
    }
    for (path, said) in [
        ("/bikes", "deviations below"),
        ("/bikes/season-001", "k front drifts by"),
        ("/bikes/season-002", "k rear changed by"),
        ("/jobs?verdict=named", "named: "),
        ("/bikes", "k front drifts by"),
        ("/bikes", "k rear changed by"),
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
