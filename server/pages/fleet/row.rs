//! A bicycle as a row of the fleet's table.

use veloid_engine::document::format_number::{Quantity, fixed};

use super::sparkline;
use crate::fleet::{self, PooledBike, PooledParameter};
use crate::pages::bike::{day, label};
use crate::pages::words;

pub struct Row {
    pub name: String,
    /// Label and pooled value of k and B, front and rear.
    pub cells: Vec<(String, Option<Quantity>)>,
    /// Stiffness over the latest rides as an image, where there are several.
    pub sparkline: Option<String>,
    pub last: String,
    pub effects: Vec<(String, String)>,
    pub outliers: Vec<String>,
}

impl Row {
    pub fn of(bike: &PooledBike) -> Self {
        let cell = |(axle, name): (&str, &str)| {
            let mut parameters = bike.parameters.iter();
            let found = parameters.find(|p| p.axle == axle && p.name == name);
            let scale = if name == "k_n_m" { 1e-3 } else { 1.0 };
            let quantity = |p: &PooledParameter| {
                Quantity::new(scale * p.pooled.value, Some(scale * p.pooled.std_error), "")
            };
            (with_unit(axle, name), found.map(quantity))
        };
        let outliers = bike.parameters.iter().filter(|p| p.outlier);
        let outliers = outliers.filter_map(|p| {
            let deviations = p.deviations?;
            let side = if deviations > 0.0 { "above" } else { "below" };
            let far = fixed(deviations.abs(), 1);
            Some(format!(
                "{} {far} deviations {side}",
                label(&p.axle, &p.name)
            ))
        });
        Self {
            name: bike.bike.clone(),
            cells: fleet::FOLLOWED.into_iter().map(cell).collect(),
            sparkline: sparkline::of(bike),
            last: day(bike.last_ride_at.as_deref().unwrap_or_default()).to_owned(),
            effects: bike.effects.iter().map(|id| with_words(id)).collect(),
            outliers: outliers.collect(),
        }
    }
}

/// What a column holds: "k front (kN/m)".
fn with_unit(axle: &str, name: &str) -> String {
    let unit = if name == "k_n_m" {
        "kN/m"
    } else {
        "N\u{a0}s/m"
    };
    format!("{} ({unit})", label(axle, name))
}

pub fn with_words(effect: &str) -> (String, String) {
    (effect.to_owned(), words::plain(effect))
}
