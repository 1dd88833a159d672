//! A model on rides that it was not identified from.

use std::path::Path;

use serde_json::{Value, json};

use crate::harness::{Folder, Server, veloid};
use crate::ride;
use crate::skips::recording;

/// A ride of so many seconds that the program simulates, and its bike file.
fn simulated(folder: &Folder, name: &str, args: &[&str]) -> [String; 2] {
    let path = |name: &str| folder.0.join(name).to_str().unwrap().to_owned();
    let [ride, bike] = [path(&format!("{name}.csv")), path("bike.json")];
    let given = ["simulate", &ride, "--bike", &bike];
    let noise: &[&str] = match args.contains(&"--accelerometers") {
        true => &[],
        false => &["--noise", "5e-5"],
    };
    let output = veloid(&[&given[..], noise, args].concat());
    assert!(output.status.success(), "{output:?}");
    [ride, bike]
}

/// What `veloid validate` says of each ride, its summary and its exit status.
fn validated(folder: &Folder, model: &str, rides: &[&str], more: &[&str]) -> (Value, String, i32) {
    let json = folder.0.join("validation.json");
    let mut given = vec!["validate", model];
    given.extend(rides);
    given.extend(["--json", json.to_str().unwrap()]);
    given.extend(more);
    let output = veloid(&given);
    let said = String::from_utf8(output.stdout).unwrap() + &String::from_utf8_lossy(&output.stderr);
    let found = std::fs::read(json).map_or(Value::Null, |b| serde_json::from_slice(&b).unwrap());
    (found, said, output.status.code().unwrap())
}

fn identified(ride: &str, bike: &str, model: &Path, args: &[&str]) {
    let quick = ["--trials", "1", "--iterations", "5"];
    let model = model.to_str().unwrap();
    let written = ["identify", ride, "--bike", bike, "--model", model];
    let output = veloid(&[&written[..], &quick, args].concat());
    assert!(output.status.success(), "{output:?}");
}

/// The model of one rate and length holds on another ride, and friction that is larger there is found out.
#[test]
fn val_a_model_holds_on_other_rides_and_its_changed_number_is_named() {
    let folder = Folder::new();
    let friction = |size: u32| format!("coulomb_friction:front:friction={size}");
    let (same, more) = (friction(30), friction(60));
    let first = ["--seed", "1", "--duration", "40", "--effect", &same];
    let [own, bike] = simulated(&folder, "own", &first);
    let other = [
        "--seed",
        "2",
        "--duration",
        "25",
        "--rate",
        "250",
        "--effect",
    ];
    let [like, _] = simulated(&folder, "like", &[&other[..], &[&same]].concat());
    let [rubs, _] = simulated(&folder, "rubs", &[&other[..], &[&more]].concat());
    let model = folder.0.join("model.json");
    identified(&own, &bike, &model, &[]);
    let (found, said, status) = validated(&folder, model.to_str().unwrap(), &[&like, &rubs], &[]);
    assert_eq!(status, 0, "{said}");
    let on = |i: usize| &found[i]["validation"]["axles"]["front"];

    let front = on(0);
    let rms = front["model"]["rms"].as_f64().unwrap();
    assert!((rms / 5e-5 - 1.0).abs() < 0.1, "{rms}");
    assert_eq!(front["differs"], false, "{front}");
    assert_eq!(front["effects"][0]["id"], "coulomb_friction");
    let fit = front["model"]["fit_percent"].as_f64().unwrap();
    let spread = front["spread"].as_f64().unwrap();
    assert!((fit - 100.0 * (1.0 - rms / spread)).abs() < 1e-9);
    assert!(front["plain"]["rms"].as_f64().unwrap() > 2.0 * rms);

    let front = on(1);
    assert_eq!(front["differs"], true);
    let parameters = front["parameters"].as_array().unwrap();
    let one = |name: &str| parameters.iter().find(|p| p["name"] == name).unwrap();
    let friction = one("coulomb_friction.friction");
    assert_eq!(friction["differs"], true);
    let here = friction["ride"].as_f64().unwrap();
    let error = friction["ride_std_error"].as_f64().unwrap();
    assert!((here - 60.0).abs() < 4.0 * error, "{here} +- {error}");
    assert_eq!(one("k")["differs"], false, "{front}");
    assert!(said.contains("coulomb friction is"), "{said}");
    assert_eq!(found[1]["validation"]["axles"]["rear"]["differs"], false);
}

#[test]
fn what_cannot_be_compared_is_refused_with_its_reason() {
    let folder = Folder::new();
    let [own, bike] = simulated(&folder, "own", &["--duration", "20"]);
    let model = folder.0.join("model.json");
    identified(&own, &bike, &model, &["--no-diagnosis"]);
    let model = model.to_str().unwrap();
    let [blind, _] = simulated(&folder, "blind", &["--accelerometers", "0.03"]);
    let (found, said, status) = validated(&folder, model, &[&blind, &own], &[]);
    assert_eq!(status, 2, "{said}");
    let problem = found[0]["problem"].as_str().unwrap();
    assert!(
        problem.contains("no road, no force and no free decay"),
        "{problem}"
    );
    assert!(
        found[1]["validation"]["axles"]["front"].is_object(),
        "{said}"
    );

    let (_, said, status) = validated(&folder, &bike, &[&own], &[]);
    assert_eq!(status, 2);
    assert!(said.contains("neither a report nor a model"), "{said}");
}

#[tokio::test]
async fn the_server_compares_a_jobs_model_with_another_ride() {
    let server = Server::start();
    let job = server.submit(&[]).await;
    server.succeeded(&job).await;
    let other = server.upload(
        ride::table(3000, 100.0).into_bytes(),
        ride::BIKE,
        &ride::QUICK,
    );
    let other = other.await;
    let other = other.headers()["location"].to_str().unwrap().to_owned();
    server.succeeded(&other).await;
    let ride_of = |view: Value| view["ride"]["id"].clone();
    let ride = ride_of(server.json(&other).await);
    let model = job.rsplit('/').next().unwrap();

    let ask = async |body: Value| {
        let request = server.client.post(server.address("/v1/validations"));
        let response = request.body(body.to_string()).send().await.unwrap();
        (
            response.status().as_u16(),
            response.json::<Value>().await.unwrap(),
        )
    };
    let (status, found) = ask(json!({"model": model, "ride": ride})).await;
    assert_eq!(status, 200, "{found}");
    assert!(
        found["sentence"]
            .as_str()
            .unwrap()
            .starts_with("Front axle"),
        "{found}"
    );
    let unknown = "01a22453-e932-753d-80a1-000000000000";
    for body in [
        json!({"model": unknown, "ride": ride}),
        json!({"model": model, "ride": unknown}),
    ] {
        assert_eq!(ask(body).await.0, 404);
    }
    assert_eq!(ask(json!({"model": model})).await.0, 400);

    let id = ride.as_str().unwrap();
    let page = server
        .get(&format!("/jobs/{model}/validation?ride={id}"))
        .await;
    let page = page.text().await.unwrap();
    assert!(
        page.contains("Fitted to this ride") && page.contains("selected"),
        "{page}"
    );
    let empty = server.get(&format!("/jobs/{model}/validation")).await;
    assert!(empty.text().await.unwrap().contains(id));
}

/// docs/validation.md.
#[test]
fn regress_the_linear_model_of_the_silverbox_misses_the_arrow() {
    let Some(recording) = recording("silverbox/SNLS80mV.csv") else {
        return;
    };
    let folder = Folder::new();
    let bike = folder.write("bike.json", r#"{"bike": "silverbox", "kind": "bench"}"#);
    let recording = recording.to_str().unwrap();
    let columns = [
        "--map",
        "force_f=V1",
        "--map",
        "z_f=V2",
        "--rate",
        "610.35",
        "--rows",
    ];
    let model = folder.0.join("model.json");
    let of = |rows: &'static str| [&columns[..], &[rows]].concat();
    let args = [&of("40650:127400")[..], &["--no-diagnosis"]].concat();
    identified(recording, bike.to_str().unwrap(), &model, &args);
    let (found, said, status) = validated(
        &folder,
        model.to_str().unwrap(),
        &[recording],
        &of("0:40000"),
    );
    assert_eq!(status, 0, "{said}");
    let front = &found[0]["validation"]["axles"]["front"];
    let fit = front["model"]["fit_percent"].as_f64().unwrap();
    // The reference's linear model leaves 14.35 of 53.4 mV.
    assert!((fit - 70.0).abs() < 8.0, "{fit}");
}
