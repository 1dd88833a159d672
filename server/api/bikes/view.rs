use serde::Serialize;
use utoipa::ToSchema;
use veloid_engine::bicycle::Bike;

use crate::store::bike::BikeRow;
use crate::time;

/// A bicycle of the fleet.
#[derive(Serialize, ToSchema)]
#[schema(as = FleetBike)]
pub struct BikeView {
    pub name: String,
    /// The bike file as it was last uploaded.
    pub document: Bike,
    /// Number of its jobs.
    pub jobs: i64,
    #[schema(format = DateTime)]
    pub created_at: String,
    #[schema(format = DateTime)]
    pub updated_at: String,
}

impl From<BikeRow> for BikeView {
    fn from(row: BikeRow) -> Self {
        Self {
            name: row.name,
            document: row.document.0,
            jobs: row.jobs,
            created_at: time::text(row.created_at),
            updated_at: time::text(row.updated_at),
        }
    }
}
