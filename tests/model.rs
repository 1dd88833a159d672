use std::process::Command;

use serde_json::Value;

use crate::harness::{Server, VELOID};
use crate::ride;

#[tokio::test]
async fn the_model_comes_as_json_and_as_a_script_that_simulates_it() {
    let server = Server::start();
    let job = server.submit(&[]).await;
    server.succeeded(&job).await;
    let report = server.json(&format!("{job}/report")).await;
    let model = server.json(&format!("{job}/model")).await;
    assert_eq!(model["plain"], report["output_error"]);
    assert!(model["extended"].is_null(), "no diagnosis was asked for");

    let response = server.get(&format!("{job}/model?format=matlab")).await;
    assert_eq!(
        response.headers()["content-type"],
        "text/x-matlab; charset=utf-8"
    );
    let script = response.text().await.unwrap();
    assert!(
        script.contains("strcmp(strtrim(ride.colheaders), 'u_r')"),
        "{script}"
    );
    server.folder.write("ride.csv", ride::example());
    let Some(simulated) = octave(&server, script) else {
        return;
    };
    let series = server.json(&format!("{job}/series?points=100000")).await;
    for (column, axle) in ["front", "rear"].into_iter().enumerate() {
        let plain = series["axles"][axle]["plain"].as_array().unwrap();
        let own = simulated
            .lines()
            .map(|line| line.split(',').nth(column).unwrap());
        let far = |(own, plain): (&str, &Value)| {
            (own.parse::<f64>().unwrap() - plain.as_f64().unwrap()).abs() > 1e-9
        };
        assert_eq!(simulated.lines().count(), plain.len());
        assert_eq!(
            own.zip(plain).filter(|pair| far(*pair)).count(),
            0,
            "{axle}"
        );
    }
}

#[tokio::test]
async fn the_script_says_which_effects_it_leaves_out() {
    let server = Server::start();
    let [ride, bike] = ["ride.csv", "bike.json"].map(|name| server.folder.0.join(name));
    let mut simulate = Command::new(&*VELOID);
    simulate.arg("simulate").arg(&ride).arg("--bike").arg(&bike);
    let effect = [
        "--effect",
        "cubic_stiffness:front:k3=8e9",
        "--duration",
        "30",
    ];
    let simulated = simulate.args(effect).args(["--noise", "1e-5"]).output();
    assert!(simulated.unwrap().status.success());
    let [ride, bike] = [ride, bike].map(|path| std::fs::read(path).unwrap());
    let parts = [("trials", "1"), ("iterations", "2")];
    let bike = String::from_utf8(bike).unwrap();
    let response = server.upload(ride, &bike, &parts).await;
    let job = response.headers()["location"].to_str().unwrap().to_owned();
    server.succeeded(&job).await;

    let model = server.json(&format!("{job}/model")).await;
    let effect = &model["effects"][0];
    assert_eq!(
        (&effect["id"], &effect["axle"]),
        (&"cubic_stiffness".into(), &"front".into())
    );
    let script = server.get(&format!("{job}/model?format=matlab")).await;
    let script = script.text().await.unwrap();
    let head: Vec<&str> = script
        .lines()
        .skip(1)
        .take_while(|line| line.starts_with('%'))
        .collect();
    let said = |text: String| {
        assert!(
            head.iter().any(|line| line.contains(&text)),
            "{text}: {head:#?}"
        )
    };
    said("effects that are NOT in this script".to_owned());
    for (name, parameter) in effect["parameters"].as_object().unwrap() {
        let unit = parameter["unit"].as_str().unwrap();
        said(format!("cubic_stiffness (front): {name} = "));
        said(format!("{} {unit}", parameter["value"].as_f64().unwrap()));
    }
    let extended = &model["extended"]["front"];
    said(format!(
        "front: {}, {}",
        extended["k_n_m"].as_f64().unwrap(),
        extended["b_n_s_m"].as_f64().unwrap()
    ));
    if let Some(simulated) = octave(&server, script) {
        assert!(simulated.lines().count() > 1000, "{simulated}");
    }
}

/// What the script makes of ride.csv, where there is an Octave to run it.
fn octave(server: &Server, script: String) -> Option<String> {
    if Command::new("octave").arg("--version").output().is_err() {
        crate::skips::skip("no octave to run the script");
        return None;
    }
    server.folder.write("veloid_model.m", script);
    let call = "[t, z] = veloid_model('ride.csv'); dlmwrite('z.csv', z, 'precision', 12);";
    let mut octave = Command::new("octave");
    octave.args(["--no-gui", "--quiet", "--eval", call]);
    let output = octave.current_dir(&server.folder.0).output().unwrap();
    let simulated = std::fs::read_to_string(server.folder.0.join("z.csv"));
    Some(simulated.unwrap_or_else(|error| panic!("{error}: {output:?}")))
}
