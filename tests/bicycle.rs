//! A bicycle told in single parts of an upload, as a form without JavaScript sends them.

use reqwest::multipart::{Form, Part};
use reqwest::{Response, redirect};
use serde_json::{Value, json};

use crate::harness::{Server, http};
use crate::ride;

/// A ride with these parts beside its quick settings, to an address.
async fn send(server: &Server, path: &str, parts: &[(&str, &str)]) -> Response {
    let file = Part::bytes(ride::example()).file_name("ride.csv");
    let parts = ride::QUICK.iter().chain(parts);
    let form = parts.fold(Form::new().part("file", file), |form, (part, text)| {
        form.text((*part).to_owned(), (*text).to_owned())
    });
    let client = http().redirect(redirect::Policy::none()).build().unwrap();
    let request = client.post(server.address(path)).multipart(form);
    request.send().await.unwrap()
}

const FIELDS: [(&str, &str); 4] = [
    ("bike_name", "lab-9"),
    ("mass_front_kg", "23.0"),
    ("mass_rear_kg", "63"),
    ("wheelbase_m", "1.1 m"),
];

#[tokio::test]
async fn parts_are_a_bike_file() {
    let server = Server::with(&["--workers", "0"]);
    let sent = send(&server, "/v1/rides", &FIELDS).await;
    assert_eq!(sent.status(), 202, "{}", sent.text().await.unwrap());
    let known = server.json("/v1/bikes/lab-9").await;
    let bike = &known["document"];
    assert_eq!(bike["mass_front_kg"], 23.0, "{known}");
    let length = bike["l_front_m"].as_f64().unwrap();
    assert!((length - 1.1 * 63.0 / 86.0).abs() < 1e-12);
    // The same as a file is the same request.
    let again = send(&server, "/v1/rides", &[("bike", &bike.to_string())]).await;
    assert_eq!(again.headers()["veloid-known"], "true");
    let query = "bike_name=lab-9&mass_front_kg=23&mass_rear_kg=63&wheelbase_m=1.1&name=ride.csv&trials=3&particles=12\
                 &iterations=8&diagnosis=false";
    let request = server
        .client
        .post(server.address(&format!("/v1/rides?{query}")));
    let raw = request.body(ride::example()).send().await.unwrap();
    assert_eq!(raw.headers()["veloid-known"], "true");
}

#[tokio::test]
async fn parts_that_are_no_bicycle_are_refused_by_name() {
    let server = Server::with(&["--workers", "0"]);
    for (parts, said) in [
        (
            &[("mass_front_kg", "23 lb")][..],
            "mass_front_kg: '23 lb', expected a number of kg",
        ),
        (
            &[("mass_front_kg", "23000")],
            "mass_front_kg is 23000.0, expected 0.1 to 1000",
        ),
        (
            &[("mass_front_kg", "23"), ("mass_front_kg", "23")],
            "mass_front_kg: given twice",
        ),
        (
            &[("mass_frnt_kg", "23")],
            "unknown part `mass_frnt_kg`, expected `file`, `bike`",
        ),
        (
            &[("mass_front_kg", "23"), ("bike", ride::BIKE)],
            "given by `bike` and by `mass_front_kg`",
        ),
        (
            &[("mass_front_kg", "23"), ("fleet", "x")],
            "given by `fleet` and by `mass_front_kg`",
        ),
        (
            &[("bicycle", "json"), ("bike", ride::BIKE)],
            "bicycle: 'json', expected fleet, fields, file",
        ),
        (
            &[("bicycle", "fields"), ("bike", ride::BIKE)],
            "no bike, expected",
        ),
        (
            &[("mass_front_kg", "x"), ("l_rear_m", "9")],
            "l_rear_m is 9.0",
        ),
    ] {
        let refused = send(&server, "/v1/rides", parts).await;
        assert_eq!(refused.status(), 422, "{parts:?}");
        let problem: Value = refused.json().await.unwrap();
        let detail = problem["detail"].as_str().unwrap();
        assert!(detail.contains(said), "{detail}");
    }
}

#[tokio::test]
async fn a_form_comes_back_as_it_was_filled_with_each_fault_at_its_field() {
    let server = Server::with(&["--workers", "0"]);
    let filled = send(&server, "/v1/rides", &FIELDS).await;
    assert_eq!(filled.status(), 202);
    // Without JavaScript the fields of every way are sent, most of them blank.
    let parts = [
        ("bicycle", "fields"),
        ("fleet", "lab-9"),
        ("bike", "{"),
        ("bike_name", "tandem \"two\""),
        ("mass_front_kg", "51 lb"),
        ("mass_rear_kg", "63"),
        ("l_front_m", ""),
        ("wheel_radius_rear_m", "0.34"),
    ];
    let refused = send(&server, "/", &parts).await;
    assert_eq!(refused.status(), 422);
    let page = refused.text().await.unwrap();
    for part in [
        "id=\"mass_front_kg-fault\" role=\"status\">mass_front_kg: &#39;51 lb&#39;, expected a number of kg",
        "value=\"51 lb\"",
        "value=\"tandem &#34;two&#34;\"",
        "value=\"0.34\"",
        "name=\"bicycle\" value=\"fields\" checked",
    ] {
        assert!(page.contains(part), "{part} is not in {page}");
    }
    let mended = parts.map(|part| match part.0 {
        "mass_front_kg" => ("mass_front_kg", "23"),
        _ => part,
    });
    assert_eq!(send(&server, "/", &mended).await.status(), 303);
    let known = server.json("/v1/bikes/tandem%20%22two%22").await;
    assert_eq!(known["document"]["wheel_radius_rear_m"], 0.34);
    let nothing = send(&server, "/", &[("bicycle", "fields")]).await;
    assert!(nothing.text().await.unwrap().contains("no bike, expected"));
}

#[tokio::test]
async fn a_bicycle_is_looked_at_without_being_kept() {
    let server = Server::with(&["--workers", "0"]);
    let look = async |parts: &[(&str, &str)]| -> (u16, Value) {
        let body = form_urlencoded::Serializer::new(String::new())
            .extend_pairs(parts)
            .finish();
        let request = server.client.post(server.address("/v1/rides/preview/bike"));
        let request = request.header("Content-Type", "application/x-www-form-urlencoded");
        let response = request.body(body).send().await.unwrap();
        (response.status().as_u16(), response.json().await.unwrap())
    };
    let (status, seen) = look(&FIELDS).await;
    assert_eq!((status, &seen["faults"]), (200, &json!([])), "{seen}");
    assert_eq!(seen["bike"]["mass_rear_kg"], 63.0);
    let (_, seen) = look(&[("mass_front_kg", "x"), ("l_rear_m", "9")]).await;
    let parts: Vec<&Value> = seen["faults"]
        .as_array()
        .unwrap()
        .iter()
        .map(|f| &f["part"])
        .collect();
    assert_eq!(parts, ["mass_front_kg", "l_rear_m"], "{seen}");
    assert!(seen["bike"].is_null());
    for (part, text, said) in [
        ("bike", "{", "invalid JSON"),
        ("bike", r#"{"owner": 1}"#, "unknown key 'owner'"),
        ("fleet", "lab-9", "is not a bike of the fleet"),
    ] {
        let (status, seen) = look(&[(part, text)]).await;
        assert_eq!((status, &seen["faults"][0]["part"]), (200, &json!(part)));
        let detail = seen["faults"][0]["detail"].as_str().unwrap();
        assert!(detail.contains(said), "{detail}");
    }
    for (parts, said) in [
        (&[][..], "no bike, expected"),
        (&[("bicycle", "fields")], "no bike, expected"),
        (&[("mass", "3")], "unknown part `mass`"),
    ] {
        let (status, problem) = look(parts).await;
        assert_eq!(status, 422, "{problem}");
        let detail = problem["detail"].as_str().unwrap();
        assert!(detail.contains(said), "{detail}");
    }
    assert_eq!(server.json("/v1/bikes").await["items"], json!([]));
}
