//! Several rides as one, at the command line and over HTTP; effects of some rides on all.

use std::path::Path;

use serde_json::{Value, json};

use crate::harness::{Folder, Server, veloid};

/// Three rides of half a minute that the program simulates, and their bike file.
fn rides(folder: &Folder) -> (Vec<String>, String) {
    let path = |name: &str| folder.0.join(name).to_str().unwrap().to_owned();
    let bike = path("bike.json");
    let rides: Vec<String> = (1..=3)
        .map(|seed| {
            let ride = path(&format!("ride{seed}.csv"));
            let seed = seed.to_string();
            let short = ["--duration", "30", "--noise", "2e-5"];
            let given = ["simulate", &ride, "--seed", &seed, "--bike", &bike];
            let output = veloid(&[&given[..], &short].concat());
            assert!(output.status.success(), "{output:?}");
            ride
        })
        .collect();
    (rides, bike)
}

fn studied(rides: &[String], more: &[&str]) -> std::process::Output {
    let mut given = vec!["study"];
    given.extend(rides.iter().map(String::as_str));
    given.extend(more);
    veloid(&given)
}

#[test]
fn rides_are_reported_as_one_and_each_by_its_name() {
    let folder = Folder::new();
    let (rides, bike) = rides(&folder);
    let json = folder.0.join("study.json");
    let output = studied(&rides, &["--bike", &bike, "--json", json.to_str().unwrap()]);
    assert!(output.status.success(), "{output:?}");
    let reported = String::from_utf8(output.stdout).unwrap();
    assert!(
        reported.contains("nothing is missing") && reported.contains("all together"),
        "{reported}"
    );
    let report: Value = serde_json::from_slice(&std::fs::read(Path::new(&json)).unwrap()).unwrap();
    let names: Vec<&str> = (report["rides"].as_array().unwrap().iter())
        .map(|r| r["name"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["ride1.csv", "ride2.csv", "ride3.csv"]);
    let k = |of: &Value| of["k_n_m"].as_f64().unwrap();
    let std = |of: &Value| of["k_std_n_m"].as_f64().unwrap();
    let whole = &report["axles"]["front"]["estimate"];
    assert!((k(whole) - 110e3).abs() < 4.0 * std(whole), "{whole}");
    let each = &report["rides"].as_array().unwrap();
    assert!(each.iter().all(|r| std(&r["axles"]["front"]) > std(whole)));
}

#[test]
fn a_ride_that_cannot_take_part_is_named_and_too_few_are_refused() {
    let folder = Folder::new();
    let (mut rides, bike) = rides(&folder);
    let flat = folder.0.join("flat.csv");
    let text = std::fs::read_to_string(&rides[2]).unwrap();
    let header = text
        .lines()
        .find(|l| l.starts_with("t,") || l.contains("z_f"))
        .unwrap();
    let still = (0..3000).map(|i| {
        let columns = header.split(',').count();
        format!("{}{}", f64::from(i) * 0.01, ",0".repeat(columns - 1))
    });
    let still: Vec<String> = still.collect();
    std::fs::write(&flat, format!("{header}\n{}\n", still.join("\n"))).unwrap();
    rides[2] = flat.to_str().unwrap().to_owned();
    let output = studied(&rides, &["--bike", &bike]);
    let reported = String::from_utf8_lossy(&output.stdout).into_owned();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    let left = reported.contains("excluded: flat.csv") || said.contains("flat.csv");
    assert!(left, "{reported}{said}");

    let few = studied(&rides[1..], &["--bike", &bike]);
    assert_eq!(few.status.code(), Some(2), "{few:?}");
    let bikes = studied(&rides, &["--bike", &bike, "--bike", &bike]);
    assert_eq!(bikes.status.code(), Some(2));
    let said = String::from_utf8_lossy(&bikes.stderr).into_owned();
    assert!(said.contains("2 bike files for 3 rides"), "{said}");
    let one = studied(&rides[..1], &["--bike", &bike]);
    assert_eq!(one.status.code(), Some(2));
}

/// A ride of the bicycle `lab-7` with so much friction (N) on its front axle, sent and identified; the address of its job.
async fn sent(server: &Server, folder: &Folder, friction: u32, day: usize) -> String {
    let effect = format!("coulomb_friction:front:friction={friction}");
    let effect: &[&str] = match friction {
        0 => &[],
        _ => &["--effect", &effect],
    };
    let more = [&["--noise", "5e-5", "--duration", "30"], effect].concat();
    simulated(server, folder, &more, day).await
}

/// A ride of the bicycle `lab-7` as `veloid simulate` makes it with these arguments, sent and identified; the address of its job.
async fn simulated(server: &Server, folder: &Folder, more: &[&str], day: usize) -> String {
    let path = |name: &str| folder.0.join(name).to_str().unwrap().to_owned();
    let [ride, bike] = [path(&format!("ride{day}.csv")), path("bike.json")];
    let seed = day.to_string();
    let given = [
        "simulate", &ride, "--bike", &bike, "--only", "front", "--seed", &seed,
    ];
    let output = veloid(&[&given[..], more].concat());
    assert!(output.status.success(), "{output:?}");
    let mut bike: Value = serde_json::from_slice(&std::fs::read(bike).unwrap()).unwrap();
    bike["bike"] = "lab-7".into();
    let facts = json!({"ridden_at": format!("2026-05-{day:02}T10:00:00Z")}).to_string();
    let parts = [
        ("trials", "1"),
        ("iterations", "5"),
        ("facts", facts.as_str()),
    ];
    let ride = std::fs::read(ride).unwrap();
    let response = server.upload(ride, &bike.to_string(), &parts).await;
    let job = response.headers()["location"].to_str().unwrap().to_owned();
    server.succeeded(&job).await;
    job
}

/// The course of the front axle's friction (N), once it has so many rides.
async fn friction_on(server: &Server, rides: usize) -> Vec<f64> {
    let mut found = Vec::new();
    for _ in 0..300 {
        let history = server.json("/v1/bikes/lab-7/course").await;
        let courses = history["courses"].as_array().unwrap().iter();
        let course = courses.filter(|c| c["name"] == "coulomb_friction.friction");
        found = course
            .flat_map(|c| c["points"].as_array().unwrap())
            .map(|point| point["value"].as_f64().unwrap())
            .collect();
        if found.len() == rides {
            return found;
        }
        tokio::time::sleep(std::time::Duration::from_millis(200)).await;
    }
    panic!("{found:?}");
}

#[tokio::test]
async fn an_effect_that_two_rides_name_is_fitted_to_all_rides_of_the_bicycle() {
    let (server, folder) = (Server::start(), Folder::new());
    sent(&server, &folder, 0, 1).await;
    sent(&server, &folder, 40, 2).await;
    let one = server.json("/v1/parameters?method=course").await;
    assert_eq!(one["items"], json!([]));
    let last = sent(&server, &folder, 40, 3).await;
    let found = friction_on(&server, 3).await;
    assert!(found[0].abs() < 4.0, "{found:?}");
    assert!(
        found[1..].iter().all(|f| (f - 40.0).abs() < 4.0),
        "{found:?}"
    );
    // k, B and the friction of the ride that does not name it.
    let refitted = server.json("/v1/parameters?method=course").await;
    assert_eq!(refitted["items"].as_array().unwrap().len(), 3);
    let on_bikes = server.json("/v1/fleet/effects/coulomb_friction").await;
    let on_bike = &on_bikes[0];
    assert_eq!(on_bike["rides"], 2, "{on_bikes:#}");
    assert_eq!(on_bike["parameters"][0]["pooled"]["rides"], 3);

    // Named on one ride alone, it is fitted to the others no longer.
    let ride = server.json(&last).await["ride"]["id"]
        .as_str()
        .unwrap()
        .to_owned();
    let deleted = server
        .client
        .delete(server.address(&format!("/v1/rides/{ride}")));
    assert!(deleted.send().await.unwrap().status().is_success());
    sent(&server, &folder, 0, 4).await;
    for _ in 0..300 {
        let left = server.json("/v1/parameters?method=course").await;
        if left["items"] == json!([]) {
            return;
        }
        tokio::time::sleep(std::time::Duration::from_millis(200)).await;
    }
    panic!("the rides keep the effect");
}

#[tokio::test]
async fn a_study_is_a_job_of_several_rides_with_a_report_and_a_page() {
    let (server, folder) = (Server::start(), Folder::new());
    let mut rides = Vec::new();
    for day in 1..=3 {
        let job = sent(&server, &folder, 15, day).await;
        rides.push(server.json(&job).await["ride"]["id"].clone());
    }
    let post = async |body: Value| {
        let request = server.client.post(server.address("/v1/studies"));
        let response = request.body(body.to_string()).send().await.unwrap();
        (
            response.status().as_u16(),
            response.json::<Value>().await.unwrap(),
        )
    };
    let (status, job) = post(json!({"rides": rides})).await;
    assert_eq!(
        (status, job["study"].as_array().unwrap().len()),
        (202, 3),
        "{job:#}"
    );
    let address = job["links"]["job"].as_str().unwrap();
    let job = server.succeeded(address).await;
    assert_eq!(
        (&job["verdict"], &job["trials"]["total"]),
        (&json!("named"), &json!(0))
    );
    let report = server.json(&format!("{address}/report")).await;
    assert_eq!(report["rides"].as_array().unwrap().len(), 3);
    let found = server
        .json("/v1/parameters?method=study&name=coulomb_friction.friction")
        .await;
    let friction = found["items"][0]["value"].as_f64().unwrap();
    assert!((friction - 15.0).abs() < 3.0, "{friction}");
    let page = server.get(job["links"]["page"].as_str().unwrap()).await;
    let page = page.text().await.unwrap();
    for part in [
        "3 rides as one",
        "all together",
        "ride.csv (3)",
        "Coulomb friction",
    ] {
        assert!(page.contains(part), "{part}: {page}");
    }
    // The ride's own identification stays its newest.
    let history = server.json("/v1/bikes/lab-7/course").await;
    assert_eq!(history["courses"][0]["points"].as_array().unwrap().len(), 3);

    let known = post(json!({"bike": "lab-7"})).await.1;
    let known = server
        .succeeded(known["links"]["job"].as_str().unwrap())
        .await;
    assert_eq!(known["study"].as_array().unwrap().len(), 3);
    let again = post(json!({"rides": rides})).await.1;
    assert_eq!(again["id"], job["id"]);
    for part in ["series", "model"] {
        let response = server.get(&format!("{address}/{part}")).await;
        assert_eq!(response.status(), 409, "{part}");
    }
    for (body, status) in [
        (json!({}), 400),
        (json!({"rides": [rides[0]]}), 400),
        (json!({"rides": [rides[0], rides[0]]}), 400),
        (
            json!({"rides": [rides[0], "0196b3c1-0000-7000-8000-000000000000"]}),
            404,
        ),
        (json!({"bike": "lab-8"}), 404),
        (json!({"bike": "lab-7", "last": 65}), 400),
        (json!({"bike": "lab-7", "rides": rides}), 400),
    ] {
        assert_eq!(post(body.clone()).await.0, status, "{body}");
    }
}

/// The studies of the server, newest first, once there are so many.
async fn studies(server: &Server, count: usize) -> Vec<Value> {
    let mut found = Vec::new();
    for _ in 0..300 {
        let jobs = server.json("/v1/jobs").await;
        let jobs = jobs["items"].as_array().unwrap().iter();
        found = jobs
            .filter(|job| job["study"].is_array())
            .cloned()
            .collect();
        if found.len() == count {
            return found;
        }
        tokio::time::sleep(std::time::Duration::from_millis(200)).await;
    }
    panic!("{found:#?}");
}

#[tokio::test]
async fn new_rides_of_a_bicycle_are_studied_by_themselves() {
    let (server, folder) = (Server::with(&["--study-after", "2"]), Folder::new());
    sent(&server, &folder, 15, 1).await;
    let jobs = server.json("/v1/jobs").await;
    assert_eq!(jobs["items"].as_array().unwrap().len(), 1);
    sent(&server, &folder, 15, 2).await;
    let [first] = &studies(&server, 1).await[..] else {
        unreachable!()
    };
    assert_eq!(first["study"].as_array().unwrap().len(), 2);
    server
        .succeeded(first["links"]["job"].as_str().unwrap())
        .await;
    sent(&server, &folder, 15, 3).await;
    sent(&server, &folder, 15, 4).await;
    let second = &studies(&server, 2).await[0];
    assert_eq!(second["study"].as_array().unwrap().len(), 4);
    assert_eq!(second["bike"], "lab-7");
}

#[tokio::test]
async fn a_proposed_ride_is_recognised_and_judged_with_the_one_that_asked() {
    let (server, folder) = (Server::start(), Folder::new());
    let weak = "progressive_stiffness:front:k2=4e6";
    let acts = ["--noise", "1e-4", "--duration", "20", "--effect", weak];
    let asking = simulated(&server, &folder, &acts, 3).await;
    let asking = server.json(&asking).await;
    assert_eq!(asking["verdict"], "ambiguous");
    let proposals = async || server.json("/v1/bikes/lab-7/proposals").await;
    let page = async || server.get("/bikes/lab-7").await.text().await.unwrap();
    let open = proposals().await;
    assert_eq!(open[0]["job"], asking["id"], "{open:#}");
    let what = open[0]["what"].as_str().unwrap();
    assert!(what.starts_with("ride a road twice as rough"), "{what}");
    assert_eq!(
        (&open[0]["study"], &open[0]["settled"]),
        (&Value::Null, &json!(false))
    );
    let shown = page().await;
    assert!(
        shown.contains("Ride a road twice as rough") && shown.contains("No ride yet"),
        "{shown}"
    );

    simulated(&server, &folder, &acts, 4).await;
    let rougher = simulated(&server, &folder, &[&acts[..], &["--road", "C"]].concat(), 5).await;
    let study = &studies(&server, 1).await[0];
    let rides = study["study"].as_array().unwrap();
    assert!(
        rides.contains(&asking["id"]) && rides.len() == 2,
        "{study:#}"
    );
    assert!(rides.contains(&server.json(&rougher).await["id"]));
    let study = server
        .succeeded(study["links"]["job"].as_str().unwrap())
        .await;
    assert_eq!(study["verdict"], "named");
    let settled = &proposals().await[0];
    assert_eq!(
        (&settled["study"], &settled["settled"]),
        (&study["id"], &json!(true))
    );
    assert_eq!(settled["rides"], 2);
    assert!(page().await.contains("Yes</a>: named"), "{}", page().await);
}
