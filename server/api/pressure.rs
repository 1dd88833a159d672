//! What tyre pressure does to stiffness, in a sentence where the rides show it.

use std::collections::BTreeMap;

use super::Server;
use super::problem::Problem;
use crate::fleet::words::{capital, subject};
use crate::fleet::{DATE, Dependence, Question, influence};
use crate::memo::Memo;
use crate::store::dependence::{DependenceQuery, rides};

/// Latest rides that are looked at.
const RIDES: i64 = 1000;
/// Sentences of groups and bicycles.
static KNOWN: Memo<Option<String>> = Memo::new(1000);
const NAME: &str = "k_n_m";
const TEMPERATURE: &str = "temperature_c";
/// Of so many rides a further fact has to be known to be held constant, as a share.
const USUAL: f64 = 0.75;

/// "Front stiffness rises by 9 ± 1 kN/m per bar, from 36 rides", of each axle whose stiffness depends on its tyre's pressure; of one
/// bicycle, or of all of the group.
pub async fn of(server: &Server, group: &str, bike: Option<&str>) -> Result<Vec<String>, Problem> {
    let mut said = Vec::new();
    for axle in ["front", "rear"] {
        let asked = DependenceQuery {
            group,
            bike,
            axle,
            name: NAME,
            from_ms: None,
            to_ms: None,
        };
        let rows = rides(&server.db, &asked, RIDES).await?;
        let asked = format!("{axle} {rows:?}");
        let answer = move || {
            let pressure = format!("pressure_{axle}_bar");
            let mut on = vec![pressure.clone(), DATE.to_owned()];
            let rows: Vec<_> = rows
                .into_iter()
                .filter(|row| row.number(&pressure).is_some())
                .collect();
            let warm = rows.iter().filter(|row| row.number(TEMPERATURE).is_some());
            if warm.count() as f64 >= USUAL * rows.len() as f64 {
                on.push(TEMPERATURE.to_owned());
            }
            let question = Question {
                axle,
                name: NAME,
                on: Some(&on),
                at: &BTreeMap::new(),
            };
            sentence(&Dependence::of(&question, &rows), &pressure)
        };
        let found = tokio::task::spawn_blocking(move || KNOWN.get(asked.as_bytes(), answer));
        said.extend(found.await?);
    }
    Ok(said)
}

fn sentence(found: &Dependence, pressure: &str) -> Option<String> {
    let fact = found.facts.iter().find(|fact| fact.name == pressure)?;
    let moves = influence(fact, &found.unit)?;
    let subject = capital(&subject(&found.axle, &found.name));
    let bikes = match (found.bikes, fact.own.len()) {
        (1, _) => String::new(),
        (bikes, 0) => format!(" of {bikes} bicycles"),
        (bikes, _) => {
            let other: Vec<&str> = fact.own.iter().map(|own| own.bike.as_str()).collect();
            format!(" of {bikes} bicycles; {} differs", other.join(", "))
        }
    };
    Some(format!(
        "{subject} {moves}, from {} rides{bikes}.",
        found.rides
    ))
}
