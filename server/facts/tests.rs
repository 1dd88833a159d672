#![allow(clippy::unwrap_used)]

use proptest::prelude::*;
use serde_json::{Map, Value, json};

use super::lines::of_lines;
use super::*;

fn document(value: Value) -> Map<String, Value> {
    value.as_object().unwrap().clone()
}

fn fault(value: Value) -> String {
    Facts::try_from(document(value)).unwrap_err().to_string()
}

#[test]
fn facts_are_read_and_patched() {
    let facts = Facts::try_from(document(json!({
        "ridden_at": "2026-05-01", "pressure_front_bar": 2.2, "tags": ["wet", " wet ", "race"],
        "rider": " Ada ", "road": "", "fork_clicks": 7, "notes": null
    })))
    .unwrap();
    assert_eq!(facts.tags, ["wet", "race"]);
    assert_eq!(
        (facts.rider.as_deref(), facts.road.as_deref()),
        (Some("Ada"), None)
    );
    assert_eq!(facts.more["fork_clicks"], 7.0);
    assert_eq!(facts.ridden_ms(), Some(1_777_593_600_000));
    let patch = document(
        json!({"rider": null, "fork_clicks": null, "pressure_front_bar": 1.9, "tags": []}),
    );
    let patched = facts.patched(patch).unwrap();
    let expected = json!({"ridden_at": "2026-05-01", "pressure_front_bar": 1.9});
    assert_eq!(Value::Object(patched.document()), expected);
    let stored = serde_json::to_value(&facts).unwrap();
    assert_eq!(serde_json::from_value::<Facts>(stored).unwrap(), facts);
}

#[test]
fn what_is_wrong_is_named_with_what_is_expected() {
    for (value, said) in [
        (
            json!({"pressure_front_bar": 220}),
            "pressure_front_bar: 220 bar, expected 0.1 to 20 bar",
        ),
        (
            json!({"temperature_c": "warm"}),
            "temperature_c: '\\\"warm\\\"', expected a number",
        ),
        (json!({"rider": 7}), "rider: '7', expected a text"),
        (
            json!({"rider": "x".repeat(201)}),
            "rider: 201 characters, expected at most 200",
        ),
        (
            json!({"road": "a\nb"}),
            "road: U+000A in the text, expected characters that can be seen",
        ),
        (
            json!({"tags": ["dry", "w\u{202e}te"]}),
            "tags: U+202E in the text, expected characters that can be seen",
        ),
        (
            json!({"notes": "a\nb\u{2028}c"}),
            "notes: U+2028 in the text, expected characters that can be seen",
        ),
        (
            json!({"tags": "wet"}),
            "tags: '\\\"wet\\\"', expected an array of texts",
        ),
        (
            json!({"tags": vec!["x"; 21]}),
            "tags: 21, expected at most 20",
        ),
        (
            json!({"ridden_at": "2999-01-01"}),
            "ridden_at: 2999-01-01, which is in the future",
        ),
    ] {
        assert_eq!(fault(value), said);
    }
    assert!(fault(json!({"ridden_at": "yesterday"})).contains("a day such as 2026-05-01"));
    for unknown in [
        json!({"colour": "red"}),
        json!({"Colour": 1}),
        json!({"a-b": 1}),
    ] {
        assert!(fault(unknown).starts_with("unknown fact `"));
    }
    let many: Map<_, _> = (0..51).map(|i| (format!("n{i}"), Value::from(i))).collect();
    let fault = Facts::try_from(many).unwrap_err();
    assert_eq!(
        fault.to_string(),
        "further numbers: 51, expected at most 50"
    );
}

#[test]
fn forms_and_comments_give_facts() {
    let mut form = Map::new();
    for (name, text) in [
        ("pressure_front_bar", "2,2"),
        ("tags", "wet, race,"),
        ("more", "fork_clicks: 7\n\nstem_mm: 90"),
    ] {
        from_form(&mut form, name, text).unwrap();
    }
    let facts = Facts::try_from(form.clone()).unwrap();
    assert_eq!(
        (facts.pressure_front_bar, facts.tags.len(), facts.more.len()),
        (Some(2.2), 2, 2)
    );
    for (name, text) in [
        ("tags", "wet"),
        ("more", "stem_mm: 80"),
        ("more", "much"),
        ("rider_mass_kg", "x"),
    ] {
        assert!(from_form(&mut form, name, text).is_err(), "{name}");
    }
    let lines = [
        "lab-7, 2.2 bar",
        "pressure_front_bar: 2.2",
        "at 10:30",
        "gain: 3",
        "road: A: wet",
        "who: me",
        "gain: 4",
    ];
    let numbered = || (1..).zip(lines.map(str::to_owned));
    let found = of_file(numbered().collect(), None, None).unwrap();
    assert_eq!(
        Value::Object(found),
        json!({"pressure_front_bar": 2.2, "gain": 3.0, "road": "A: wet"})
    );
    let stamped = of_file(Vec::new(), Some(1_777_628_400.7), None).unwrap();
    assert_eq!(
        Value::Object(stamped),
        json!({"ridden_at": "2026-05-01T09:40:00Z"})
    );
    let both = of_file(
        vec![(1, "ridden_at: 2026-05-02".to_owned())],
        Some(1_777_628_400.7),
        Some(14.0005 / 3.0),
    )
    .unwrap();
    assert_eq!(both["ridden_at"], "2026-05-02");
    assert_eq!(both["speed_m_s"], 4.667);
    let reported = vec![(1, "speed_m_s: 7".to_owned())];
    assert_eq!(
        of_file(reported, Some(0.0), Some(4.0)).unwrap()["speed_m_s"],
        7.0
    );
    assert!(
        of_file(Vec::new(), Some(4.0e9), Some(f64::NAN))
            .unwrap()
            .is_empty()
    );
    let odd = of_lines([(3, "temperature_c: warm".to_owned())]).unwrap_err();
    assert_eq!(
        odd.to_string(),
        "line 3: temperature_c: 'warm', expected a number"
    );
}

proptest! {
    #[test]
    fn any_lines_are_read_or_refused(lines in prop::collection::vec("[a-z_]{0,9}[: ]{0,2}\\PC{0,20}", 0..9)) {
        if let Ok(found) = of_lines((1..).zip(lines)) {
            let facts = Facts::try_from(found).unwrap();
            prop_assert_eq!(Facts::try_from(facts.document()).unwrap(), facts);
        }
    }
}
