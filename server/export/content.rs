//! What a script simulates: the model of the diagnosis or, without one, the plain model.

use std::borrow::Cow;

use veloid_engine::bicycle::{Axle, PerAxle};
use veloid_engine::report::simulation::{AxleSimulation, Simulation};
use veloid_engine::report::{Estimate, Report};
use veloid_engine::result_of;

/// Why a report has no model that can be simulated.
#[derive(Debug, thiserror::Error)]
#[error("the ride has no model to simulate: {0}")]
pub struct NoModel(String);

/// Which model it is.
#[derive(Clone, Copy, PartialEq)]
pub enum Kind {
    /// The model of the diagnosis.
    Diagnosed,
    /// The plain model, which has an exact solution.
    Plain,
    /// The plain model as it was identified without a road: it is simulated on one that the user gives.
    Roadless,
}

/// A model with what is known of its ride.
pub struct Content<'a> {
    pub report: &'a Report,
    pub kind: Kind,
    pub simulation: Cow<'a, Simulation>,
}

impl<'a> Content<'a> {
    pub fn of(report: &'a Report) -> Result<Self, NoModel> {
        let diagnosed = report.diagnosis.as_ref().and_then(|d| d.model.as_ref());
        let (kind, simulation) = match diagnosed {
            Some(simulation) => (Kind::Diagnosed, Cow::Borrowed(simulation)),
            None if report.has_no_road() => {
                let axles = roadless(report)?;
                (Kind::Roadless, Cow::Owned(plain(report, &axles)))
            }
            None => (Kind::Plain, Cow::Owned(plain(report, &report.output_error))),
        };
        Ok(Self {
            report,
            kind,
            simulation,
        })
    }

    /// What a script reads.
    pub fn takes(&self) -> &'static str {
        match self.kind {
            Kind::Roadless => {
                "a road: a CSV with time stamps t (s) and heights u_f, u_r (m), since the ride recorded none"
            }
            _ => {
                "the ride's CSV, a CSV of another ride with the same headers, or a ride as veloid read it: /v1/jobs/ID/model?format=csv of the server, or veloid identify with --model ride.csv"
            }
        }
    }

    /// RMS error (m) of the plain model on its own ride.
    pub fn error(&self, axle: Axle) -> Option<f64> {
        let mut rows = self.report.comparison.rows.iter();
        let row = rows.find(|row| row.axle == axle && row.method == "output_error");
        row.filter(|_| self.kind == Kind::Plain)
            .map(|row| row.position_mse_m2.sqrt())
    }

    /// What the report says of the error on its own ride, in words.
    pub fn reported(&self, axle: Axle) -> String {
        if self.kind != Kind::Diagnosed {
            let known = |error| format!("in the report {error:?} m");
            let error = self
                .error(axle)
                .map_or("the report has none".to_owned(), known);
            return format!("over the whole ride; {error}");
        }
        let diagnosis = self.report.diagnosis.as_ref();
        let Some(held) = diagnosis.and_then(|d| d.held_out.get(axle)) else {
            return "the report has none".to_owned();
        };
        let unit = held.predicted.unit();
        match (held.extended_rms_m, held.horizon_s) {
            (None, _) => "the report has none: the model runs away".to_owned(),
            (Some(error), None) => format!("in the report {error:?} {unit}"),
            (Some(error), Some(horizon)) => format!(
                "in the report {error:?} {unit}, of predictions over {horizon:?} s each from a start of its own, which this is not"
            ),
        }
    }
}

/// Axles that were identified without a road.
fn roadless(report: &Report) -> Result<PerAxle<Estimate>, NoModel> {
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
        return Ok(axles);
    }
    let reason = Axle::BOTH.into_iter().find_map(withheld);
    let reason = reason.or_else(|| latent?.reason.as_deref());
    Err(NoModel(
        reason.unwrap_or("the road was not measured").to_owned(),
    ))
}

/// The plain model of each axle; a mass of 0 where a rig prescribes the motion.
fn plain(report: &Report, axles: &PerAxle<Estimate>) -> Simulation {
    let ride = &report.ride;
    Simulation {
        step_s: ride.duration_s / ride.samples.saturating_sub(1).max(1) as f64,
        samples: ride.samples,
        held_out: [0, ride.samples],
        axles: axles.map(|axle, e| plain_axle(report, axle, e)),
        pitch: None,
    }
}

fn plain_axle(report: &Report, axle: Axle, e: &Estimate) -> AxleSimulation {
    let has = |names: &[&str]| {
        let mut columns = report.ride.columns.iter();
        columns.any(|c| names.contains(&c.channel.as_str()))
    };
    // The rear axle's road may be the front's, later.
    let (road, force) = match axle {
        Axle::Front => (has(&["u_f", "d_f"]), has(&["force_f"])),
        Axle::Rear => (has(&["u_f", "d_f", "u_r", "d_r"]), has(&["force_r"])),
    };
    let prescribed = e.mass_kg == 0.0;
    AxleSimulation {
        prescribed,
        mass_kg: e.mass_kg,
        k_n_m: e.k_n_m,
        b_n_s_m: e.b_n_s_m,
        constant_n: 0.0,
        rest_m: 0.0,
        height_m: 0.0,
        velocity_m_s: 0.0,
        steps: 1,
        road: !prescribed && (road || report.has_no_road()),
        force: !prescribed && force,
        effects: Vec::new(),
        left_out: Vec::new(),
        measured_rms: 0.0,
    }
}
