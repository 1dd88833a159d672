//! The fields by which rides' facts and results are searched.

use crate::api::jobs::search::SearchParams;

/// A field of the form.
pub struct Field {
    pub name: &'static str,
    pub label: &'static str,
    pub value: String,
    pub hint: &'static str,
}

const RANGE: &str = "2.2 or 2:2.5";
const STIFFNESS: &str = "50000:60000";
const DAMPING: &str = "900:1200";
/// Labels and examples in the order in which fields stand.
const LABELS: [(&str, &str, &str); 14] = [
    ("rider", "Rider contains", ""),
    ("tyres", "Tyres contain", ""),
    ("road", "Road contains", ""),
    ("pressure_front_bar", "Front pressure (bar)", RANGE),
    ("pressure_rear_bar", "Rear pressure (bar)", RANGE),
    ("temperature_c", "Temperature (°C)", "10:20"),
    ("rider_mass_kg", "Rider's mass (kg)", "70:80"),
    ("fact", "Other facts", "stem_mm:80:100"),
    ("k_front", "k front (N/m)", STIFFNESS),
    ("b_front", "B front (N s/m)", DAMPING),
    ("mass_front", "Mass front (kg)", "20:25"),
    ("k_rear", "k rear (N/m)", STIFFNESS),
    ("b_rear", "B rear (N s/m)", DAMPING),
    ("mass_rear", "Mass rear (kg)", "60:65"),
];

/// The names of all fields.
pub fn names() -> impl Iterator<Item = &'static str> {
    LABELS.into_iter().map(|(name, ..)| name)
}

/// The fields with what stands in them.
pub fn fields(search: &SearchParams) -> Vec<Field> {
    let texts = search.texts().into_iter();
    let values = texts
        .chain(search.numbers())
        .chain([search.fact()])
        .chain(search.results());
    let values: Vec<(&str, Option<&str>)> = values.collect();
    let field = |(name, label, hint)| {
        let value = values.iter().find(|(known, _)| *known == name);
        Field {
            name,
            label,
            value: value
                .and_then(|(_, value)| *value)
                .unwrap_or_default()
                .to_owned(),
            hint,
        }
    };
    LABELS.into_iter().map(field).collect()
}
