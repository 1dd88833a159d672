//! What memory a job needs, estimated before it starts.

use serde::{Deserialize, Serialize};
use veloid_engine::Settings;
use veloid_engine::ride::Ride;

/// Memory of a process that computes (bytes): with hardly any samples, and for each sample of an axle or a sensor,
/// without and with a diagnosis. Measured: docs/performance.md.
const ANY: u64 = 45_000_000;
const IDENTIFIED: u64 = 250;
const DIAGNOSED: u64 = 1500;

/// Memory that one job may take (bytes).
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub struct Budget(pub u64);

#[derive(Debug, thiserror::Error, Serialize, Deserialize)]
#[error(
    "the ride needs about {:.1} GB of memory, {:.1} GB allowed; use part of it with `rows`, or omit the diagnosis",
    *.needed as f64 / 1e9, *.allowed as f64 / 1e9
)]
pub struct OverBudget {
    needed: u64,
    allowed: u64,
}

impl Budget {
    /// Refuses a ride that would take more.
    pub fn bears(self, ride: &Ride, settings: &Settings) -> Result<(), OverBudget> {
        self.bears_all([ride], settings)
    }

    /// Refuses rides that would take more together.
    pub fn bears_all<'r>(
        self,
        rides: impl IntoIterator<Item = &'r Ride>,
        settings: &Settings,
    ) -> Result<(), OverBudget> {
        let samples = |ride: &Ride| ride.samples * (ride.axles.iter().count() + ride.sensors.len());
        let samples: usize = rides.into_iter().map(samples).sum();
        let each = match settings.diagnosis {
            true => DIAGNOSED,
            false => IDENTIFIED,
        };
        let needed = ANY + each * samples as u64;
        let allowed = self.0;
        match needed <= allowed {
            true => Ok(()),
            false => Err(OverBudget { needed, allowed }),
        }
    }
}

#[cfg(test)]
mod tests {
    use veloid_engine::bicycle::PerAxle;
    use veloid_engine::ride::AxleRecord;

    use super::*;

    #[test]
    fn a_long_ride_is_refused_with_what_it_needs() {
        let record = AxleRecord {
            road: Vec::new(),
            force: None,
            displacement: Vec::new(),
            acceleration: None,
            valid: Vec::new(),
            prescribed: false,
            plant: veloid_engine::plant::PlantRef::default(),
            band: None,
        };
        let ride = Ride {
            samples: 1_000_000,
            axles: PerAxle {
                front: Some(record.clone()),
                rear: Some(record),
            },
            ..Ride::default()
        };
        let settings = Settings::default();
        let refused = Budget(1_000_000_000)
            .bears(&ride, &settings)
            .map_err(|e| e.to_string());
        assert_eq!(
            refused.err().as_deref(),
            Some(
                "the ride needs about 3.0 GB of memory, 1.0 GB allowed; use part of it with `rows`, or omit the diagnosis"
            )
        );
        assert!(Budget(4 << 30).bears(&ride, &settings).is_ok());
    }
}
