#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;

use serde_json::json;
use sqlx::types::Json;
use uuid::Uuid;

use super::{Dependence, Question};
use crate::facts::Facts;
use crate::store::dependence::RideRow;

const DAY_MS: i64 = 86_400_000;

/// A ride of these facts on a day.
fn ride(day: i64, value: f64, facts: serde_json::Value) -> RideRow {
    let facts = facts.as_object().unwrap().clone();
    RideRow {
        job_id: Uuid::from_u128(day as u128),
        bike: "lab-7".to_owned(),
        value,
        std_error: Some(0.05),
        unit: "N/m".to_owned(),
        dated_at: day * DAY_MS,
        facts: Some(Json(Facts::try_from(facts).unwrap())),
        front_kg: None,
        rear_kg: None,
    }
}

fn ask(on: &[&str], rows: &[RideRow]) -> Dependence {
    let on: Vec<String> = on.iter().map(|name| (*name).to_owned()).collect();
    let question = Question {
        axle: "front",
        name: "k_n_m",
        on: Some(&on),
        at: &BTreeMap::new(),
    };
    Dependence::of(&question, rows)
}

/// Of one bicycle with equal errors a category's effect is the difference of its mean from that of the most frequent one, and its
/// error that of the analysis of variance: the pooled variance within categories over the numbers of rides.
#[test]
fn effects_of_categories_are_differences_of_means() {
    let values = [
        ("slick", [100.0, 101.0, 99.5, 100.5, 99.0].as_slice()),
        ("knobby", &[91.0, 90.0, 89.5, 90.5]),
        ("touring", &[103.0, 104.5, 103.5]),
        ("borrowed", &[80.0]),
    ];
    let all = values
        .iter()
        .flat_map(|(tyres, values)| values.iter().map(move |v| (tyres, v)));
    // The days go round the categories, so that no category is a step.
    let mut rows: Vec<RideRow> = all
        .enumerate()
        .map(|(i, (tyres, value))| ride((i as i64 * 5) % 13, *value, json!({"tyres": tyres})))
        .collect();
    rows.sort_by_key(|row| row.dated_at);
    let found = ask(&["tyres"], &rows);
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let within: f64 = values[..3]
        .iter()
        .flat_map(|(_, v)| v.iter().map(|x| (x - mean(v)).powi(2)))
        .sum();
    let variance = within / 9.0;
    let tyres = &found.categories[0];
    assert_eq!(
        (tyres.reference.as_str(), found.left_out, found.rides),
        ("slick", 1, 12)
    );
    for (category, (name, values_of)) in tyres.categories.iter().zip(values).skip(1).take(2) {
        let effect = category.effect.unwrap();
        assert_eq!(category.name, name);
        let expected = mean(values_of) - mean(values[0].1);
        assert!((effect.value - expected).abs() < 1e-9, "{effect:?}");
        let error = (variance * (0.2 + 1.0 / values_of.len() as f64)).sqrt();
        assert!(
            (effect.std_error / error - 1.0).abs() < 1e-6,
            "{effect:?}, {error}"
        );
        // Student's t of nine degrees of freedom.
        assert!((effect.margin() / error - 2.2622).abs() < 1e-3);
    }
    assert!(tyres.categories[3].effect.is_none() && tyres.categories[3].reason.is_some());
    assert!(
        found
            .summary
            .starts_with("Tyres compared with 'slick': 'knobby' is 9.7 ± 1.1\u{a0}N/m below"),
        "{}",
        found.summary.replace('\u{a0}', " ")
    );
}

#[test]
fn a_category_that_goes_with_a_number_is_not_fitted() {
    let rows: Vec<RideRow> = (0..20)
        .map(|i| {
            let (bar, rider) = if i % 2 == 0 {
                (2.0, "Ada")
            } else {
                (3.0, "Bob")
            };
            let facts = json!({"pressure_front_bar": bar, "rider": rider});
            ride(i, 100.0 + 10.0 * bar + 0.1 * ((i * 7) % 5) as f64, facts)
        })
        .collect();
    let found = ask(&["pressure_front_bar", "rider"], &rows);
    let bob = &found.categories[0].categories[1];
    assert!(bob.effect.is_none(), "{bob:?}");
    assert!(bob.reason.as_ref().unwrap().contains("front tyre pressure"));
    let slope = found.facts[0].slope.unwrap();
    assert!((slope.value - 10.0).abs() < 0.2);
}
