//! The plain model of a report, and the road along which it can be simulated.

use veloid_engine::bicycle::{Axle, PerAxle};
use veloid_engine::report::{Estimate, Report};
use veloid_engine::result_of;

use super::facts::AS_READ;

/// Why a report has no model that can be simulated.
#[derive(Debug, thiserror::Error)]
#[error("the ride has no model to simulate: {0}")]
pub struct NoModel(String);

/// The plain model.
pub struct Plain {
    pub axles: PerAxle<Estimate>,
    /// Whether it was identified without a road: it is then simulated on a road that the user gives.
    pub needs_a_road: bool,
}

impl Plain {
    pub fn of(report: &Report) -> Result<Self, NoModel> {
        if !report.has_no_road() {
            return Ok(Self {
                axles: report.output_error.clone(),
                needs_a_road: false,
            });
        }
        let latent = report.latent_road.as_ref();
        let results = result_of(report);
        let withheld = |axle: Axle| {
            let result = results.get(axle)?;
            ["k", "B"]
                .into_iter()
                .find_map(|name| result.withheld(name))
        };
        let axles = latent.map(|latent| latent.axles()).unwrap_or_default();
        let axles = axles.filter_map(|axle, e| withheld(axle).is_none().then(|| e.clone()));
        if axles.iter().next().is_some() {
            return Ok(Self {
                axles,
                needs_a_road: true,
            });
        }
        let reason = Axle::BOTH.into_iter().find_map(withheld);
        let reason = reason.or_else(|| latent?.reason.as_deref());
        Err(NoModel(
            reason.unwrap_or("the road was not measured").to_owned(),
        ))
    }

    /// What a script reads.
    pub fn input(&self) -> &'static str {
        match self.needs_a_road {
            true => {
                "a road: a CSV with even time stamps t (s) and heights u_f, u_r (m), since the ride recorded none"
            }
            false => AS_READ,
        }
    }
}
