//! One identified parameter, as the API shows it.

use serde::Serialize;
use utoipa::ToSchema;
use uuid::Uuid;
use veloid_engine::document::format_number::WIDE;

use crate::facts::Facts;
use crate::store::parameter::ParameterRow;
use crate::time;

/// One identified parameter.
#[derive(Serialize, ToSchema)]
#[schema(as = IdentifiedParameter)]
pub struct ParameterView {
    pub job: Uuid,
    pub ride: Uuid,
    /// Name of the ride's file.
    pub file: String,
    pub bike: String,
    #[schema(format = DateTime)]
    pub identified_at: String,
    pub method: String,
    pub axle: String,
    pub name: String,
    pub value: f64,
    pub std_error: Option<f64>,
    /// 95 % interval, where there is a standard error.
    pub low: Option<f64>,
    pub high: Option<f64>,
    pub unit: String,
    pub verdict: Option<String>,
    /// Version of veloid that identified it.
    pub version: String,
    /// Address of the job's page.
    pub page: String,
    /// Facts about the ride.
    pub facts: Facts,
}

impl From<ParameterRow> for ParameterView {
    fn from(row: ParameterRow) -> Self {
        let half = row.std_error.map(|error| WIDE * error);
        Self {
            job: row.job_id,
            ride: row.ride_id,
            file: row.file,
            bike: row.bike,
            identified_at: time::text(row.identified_at),
            method: row.method,
            axle: row.axle,
            name: row.name,
            value: row.value,
            std_error: row.std_error,
            low: half.map(|half| row.value - half),
            high: half.map(|half| row.value + half),
            page: format!("/jobs/{}", row.job_id),
            unit: row.unit,
            verdict: row.verdict,
            version: row.version,
            facts: row.facts.map(|json| json.0).unwrap_or_default(),
        }
    }
}

impl ParameterView {
    /// The ride's tags in one text.
    pub fn tags(&self) -> Option<String> {
        let tags = &self.facts.tags;
        (!tags.is_empty()).then(|| tags.join(", "))
    }

    /// The ride's further numbers as JSON.
    pub fn further(&self) -> Option<String> {
        let more = &self.facts.more;
        let json = (!more.is_empty()).then(|| serde_json::to_string(more));
        json.and_then(Result::ok)
    }
}
