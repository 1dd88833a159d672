//! What k and B depend on, asked of a made-up season whose truth is known: k changes by 12 % per bar and -0.03 % per degree, B by
//! -0.2 % per degree, and rides differ by 1 and 2 % beyond that.

use serde_json::Value;

use crate::harness::Server;
use crate::season;

async fn ask(server: &Server, query: &str) -> Value {
    server.json(&format!("/v1/fleet/dependence?{query}")).await
}

fn fact<'a>(found: &'a Value, name: &str) -> &'a Value {
    let mut facts = found["facts"].as_array().unwrap().iter();
    facts.find(|fact| fact["name"] == name).unwrap()
}

/// Standard errors between a slope and a share of the level.
fn off(found: &Value, name: &str, share: f64) -> f64 {
    let slope = &fact(found, name)["slope"];
    let truth = share * found["level"]["value"].as_f64().unwrap();
    (slope["value"].as_f64().unwrap() - truth) / slope["std_error"].as_f64().unwrap()
}

#[tokio::test]
async fn a_season_tells_what_pressure_and_warmth_do() {
    let server = Server::with(&["--workers", "0"]);
    season::write(&server, 8, 800).await;

    let one = ask(
        &server,
        "bike=season-005&on=pressure_front_bar,temperature_c,pressure_rear_bar",
    )
    .await;
    assert_eq!(
        (&one["bikes"], &one["between_bikes"]),
        (&Value::from(1), &Value::Null)
    );
    assert!(off(&one, "pressure_front_bar", 0.12).abs() < 3.0, "{one:#}");
    assert!(off(&one, "pressure_rear_bar", 0.0).abs() < 3.0, "{one:#}");
    let summary = one["summary"].as_str().unwrap();
    assert!(
        summary.contains("Front stiffness rises by ")
            && summary.contains("kN/m per bar of front tyre pressure"),
        "{summary}"
    );
    assert_eq!(
        one["points"].as_array().unwrap().len() as u64,
        one["rides"].as_u64().unwrap()
    );
    assert_eq!(one["development"]["kind"], "none");

    // Sizes of effects have influences too.
    let friction = ask(
        &server,
        "axle=front&name=coulomb_friction.friction&on=temperature_c",
    )
    .await;
    assert!(friction["rides"].as_u64().unwrap() > 10, "{friction:#}");

    // The bicycle that leaks drifts beside what its pressure explains, and so does what is left of it.
    let leaking = ask(&server, "bike=season-001&on=pressure_front_bar").await;
    assert_eq!(leaking["development"]["kind"], "drift");
    let dated = ask(&server, "bike=season-001&on=pressure_front_bar,date").await;
    assert!(
        off(&dated, "pressure_front_bar", 0.12).abs() < 3.0,
        "{dated:#}"
    );
    assert!(fact(&dated, "date")["slope"]["high"].as_f64().unwrap() < 0.0);
    assert_eq!(dated["development"], Value::Null);

    let all = ask(
        &server,
        "axle=rear&name=b_n_s_m&on=temperature_c,pressure_rear_bar",
    )
    .await;
    assert_eq!(
        (all["bikes"].as_u64(), all["rides"].as_u64()),
        (Some(8), Some(800))
    );
    assert!(off(&all, "temperature_c", -0.002).abs() < 3.0, "{all:#}");
    assert!(all["between_bikes"].as_f64().unwrap() > 0.0);

    // Asked by nothing but the bicycle, all that most rides have is looked at.
    let usual = ask(&server, "bike=season-005").await;
    assert_eq!(usual["facts"].as_array().unwrap().len(), 5, "{usual:#}");
    let reason = fact(&usual, "temperature_c")["reason"].clone();
    assert_eq!(reason, Value::Null);

    let at = ask(
        &server,
        "bike=season-005&on=pressure_front_bar&at=pressure_front_bar:2.4",
    )
    .await;
    let prediction = &at["prediction"];
    let expected = at["level"]["value"].as_f64().unwrap()
        + fact(&at, "pressure_front_bar")["slope"]["value"]
            .as_f64()
            .unwrap()
            * (2.4 - fact(&at, "pressure_front_bar")["mean"].as_f64().unwrap());
    assert!((prediction["value"].as_f64().unwrap() / expected - 1.0).abs() < 1e-9);
    let said = prediction["summary"].as_str().unwrap();
    assert!(
        said.starts_with("Front stiffness at 2.4\u{a0}bar (front tyre pressure): ")
            && said.contains(" ± "),
        "{said}"
    );
    assert_eq!(prediction["beyond"], Value::Array(Vec::new()));
    let far = ask(
        &server,
        "bike=season-005&on=pressure_front_bar&at=pressure_front_bar:9",
    )
    .await;
    assert_eq!(far["prediction"]["beyond"][0], "pressure_front_bar");
}

#[tokio::test]
async fn facts_that_go_together_are_said_and_not_fitted() {
    let server = Server::with(&["--workers", "0"]);
    season::write(&server, 2, 60).await;
    // A lab that writes the pressure in psi too, and the same gain on all rides.
    for job in server.json("/v1/jobs?bike=season-002&limit=1000").await["items"]
        .as_array()
        .unwrap()
    {
        let bar = job["ride"]["facts"]["pressure_front_bar"].as_f64().unwrap();
        let patch = serde_json::json!({"front_psi": 14.5 * bar, "gain": 2});
        let ride = format!("/v1/rides/{}", job["ride"]["id"].as_str().unwrap());
        let request = server.client.patch(server.address(&ride)).json(&patch);
        assert_eq!(request.send().await.unwrap().status(), 200);
    }
    let found = ask(
        &server,
        "bike=season-002&on=pressure_front_bar,front_psi,gain",
    )
    .await;
    assert!(fact(&found, "pressure_front_bar")["slope"]["value"].is_number());
    let twice = fact(&found, "front_psi");
    assert_eq!(
        (&twice["slope"], &twice["goes_with"]),
        (&Value::Null, &Value::from("pressure_front_bar"))
    );
    assert_eq!(
        fact(&found, "gain")["reason"],
        "it is the same on all of these rides"
    );
    let summary = found["summary"].as_str().unwrap();
    assert!(
        summary.contains("Front psi is not fitted: it goes with front tyre pressure"),
        "{summary}"
    );
    // Over both bicycles half of the rides lack it.
    let all = ask(&server, "on=front_psi").await;
    assert_eq!(
        all["rides"].as_u64().unwrap() + all["left_out"].as_u64().unwrap(),
        60
    );

    for (query, status, said) in [
        ("on=colour", 404, "on: 'colour', expected one of date, "),
        (
            "on=gain&at=date:2026-05-01",
            404,
            "at: 'date', expected one of gain",
        ),
        ("on=gain&at=gain:much", 400, "at: 'gain:much'"),
        ("name=k", 400, "name: 'k', expected one of k_n_m"),
        ("axle=left", 400, "axle: 'left'"),
        ("onn=gain", 400, "unknown parameter `onn`"),
    ] {
        let response = server.get(&format!("/v1/fleet/dependence?{query}")).await;
        assert_eq!(response.status(), status, "{query}");
        let problem: Value = response.json().await.unwrap();
        assert!(
            problem["detail"].as_str().unwrap().contains(said),
            "{query}: {problem}"
        );
    }
    assert_eq!(
        server.get("/v1/fleet/dependence?bike=none").await.status(),
        404
    );
    let none = ask(&server, "name=coulomb_friction.friction&axle=rear").await;
    assert_eq!(none["level"], Value::Null);
    assert!(none["summary"].as_str().unwrap().contains("too few"));
}

#[tokio::test]
async fn the_page_asks_and_answers() {
    let server = Server::with(&["--workers", "0"]);
    season::write(&server, 2, 60).await;
    for (path, said) in [
        ("/dependence", "From 60 rides of 2 bicycles"),
        ("/dependence?bike=season-001&axle=&name=", "From "),
        (
            "/dependence?bike=season-002&on=pressure_front_bar&at.pressure_front_bar=2.5",
            "Front stiffness at 2.5",
        ),
        (
            "/dependence?on=date&at.date=2026-05-01&at.temperature_c=20",
            "at 2026-05-01",
        ),
        ("/bikes/season-001", "/dependence?bike=season-001"),
    ] {
        let page = server.get(path).await.text().await.unwrap();
        assert!(page.contains(said), "{path} does not say: {said}");
    }
    assert_eq!(server.get("/dependence?bycicle=x").await.status(), 400);
}

/// One bicycle of ten loses stiffness with time: the fleet does not, and the page names the one.
#[tokio::test]
async fn the_one_bicycle_that_drifts_is_named() {
    let server = Server::with(&["--workers", "0"]);
    season::write(&server, 10, 600).await;
    let found = ask(&server, "on=date,pressure_front_bar").await;
    let date = fact(&found, "date");
    let own = date["own"].as_array().unwrap();
    assert_eq!(own.len(), 1, "{own:#?}");
    assert_eq!(own[0]["bike"], "season-001");
    assert!(
        own[0]["slope"]["high"].as_f64().unwrap() < -50.0,
        "{own:#?}"
    );
    let (low, high) = (&date["slope"]["low"], &date["slope"]["high"]);
    assert!(
        low.as_f64().unwrap() < 0.0 && high.as_f64().unwrap() > 0.0,
        "{date:#}"
    );
    assert_eq!(
        fact(&found, "pressure_front_bar")["own"],
        Value::Array(Vec::new())
    );
    let summary = found["summary"].as_str().unwrap();
    assert!(
        summary.contains("shows no dependence on date")
            && summary.contains("season-001 differs: it falls by "),
        "{summary}"
    );
    let page = server
        .get("/dependence?on=date")
        .await
        .text()
        .await
        .unwrap();
    assert!(page.contains("date, season-001 only"), "{page}");
    // Two bicycles that differ have no slope in common.
    let two = ask(&server, "on=date&from=2999-01-01").await;
    assert_eq!(two["rides"], 0);
}

/// Facts in words are categories, each with its effect beside that of the most frequent one.
#[tokio::test]
async fn riders_and_tyres_are_categories() {
    let server = Server::with(&["--workers", "0"]);
    season::write(&server, 2, 60).await;
    let jobs = server.json("/v1/jobs?bike=season-002&limit=1000").await;
    let jobs = jobs["items"].as_array().unwrap().clone();
    for (i, job) in jobs.iter().enumerate() {
        let rider = ["Ada", "Bob", "Ada"][i % 3];
        let rider = if i == 1 { "Guest" } else { rider };
        let ride = format!("/v1/rides/{}", job["ride"]["id"].as_str().unwrap());
        let patch = serde_json::json!({"rider": rider, "tyres": "slick"});
        let request = server.client.patch(server.address(&ride)).json(&patch);
        assert_eq!(request.send().await.unwrap().status(), 200);
    }
    let found = ask(&server, "bike=season-002&on=pressure_front_bar,rider").await;
    let rider = &found["categories"][0];
    assert_eq!(
        (&rider["fact"], &rider["reference"]),
        (&"rider".into(), &"Ada".into())
    );
    let names: Vec<&str> = rider["categories"]
        .as_array()
        .unwrap()
        .iter()
        .map(|c| c["name"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["Ada", "Bob", "Guest"]);
    assert!(rider["categories"][0]["effect"].is_null());
    let bob = &rider["categories"][1]["effect"];
    let off = bob["value"].as_f64().unwrap() / bob["std_error"].as_f64().unwrap();
    assert!(off.abs() < 3.5, "{bob:#}");
    assert!(
        rider["categories"][2]["reason"]
            .as_str()
            .unwrap()
            .contains("fewer than 3 rides")
    );
    assert_eq!(found["left_out"], 1);
    assert!(
        found["summary"]
            .as_str()
            .unwrap()
            .contains("Rider compared with 'Ada': 'Bob' is "),
        "{}",
        found["summary"]
    );
    let tyres = ask(&server, "bike=season-002&on=tyres").await;
    assert!(
        tyres["summary"]
            .as_str()
            .unwrap()
            .contains("Tyres is not fitted: fewer than two"),
        "{}",
        tyres["summary"]
    );
    let known = tyres["known_categories"].as_array().unwrap();
    assert_eq!(known.len(), 2);
    let page = server
        .get("/dependence?bike=season-002&on=rider")
        .await
        .text()
        .await
        .unwrap();
    assert!(
        page.contains("rider: Bob") && page.contains("compared with &#39;Ada&#39;"),
        "{page}"
    );
}
