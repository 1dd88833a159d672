//! What widens the intervals of a ride beyond the fit's own errors, found once and applied to the estimates of every method.

use veloid_core::EngineError;
use veloid_core::bicycle::{Axle, Bike, PerAxle};
use veloid_core::settings::Settings;
use veloid_methods::uncertainty::interpolation::interpolation_error;
use veloid_methods::uncertainty::laser::{notes, widened};
use veloid_methods::uncertainty::laser_clock::laser_error;
use veloid_methods::uncertainty::mass::mass_error;
use veloid_methods::uncertainty::road_noise::{borne, road_noise_error, worth_reporting};
use veloid_report::stages::Conclusion;
use veloid_report::{Estimate, Parameters};
use veloid_ride::Ride;

/// By how much each error moves k and B of each axle.
pub struct Widening {
    pub laser: PerAxle<Parameters>,
    pub mass: PerAxle<Parameters>,
    pub road_noise: PerAxle<Parameters>,
    pub interpolation: PerAxle<Parameters>,
}

impl Widening {
    /// Of a ride whose output error gave these estimates.
    pub fn find(
        ride: &Ride,
        bike: &Bike,
        settings: &Settings,
        output_error: &PerAxle<Estimate>,
    ) -> Result<Self, EngineError> {
        Ok(Self {
            laser: laser_error(ride, bike, settings, output_error),
            mass: mass_error(ride, bike, settings, output_error)?,
            road_noise: road_noise_error(ride, bike, settings, output_error),
            interpolation: interpolation_error(ride, bike, settings, output_error),
        })
    }

    /// As stage `conclude` stored it.
    pub fn stored(conclusion: &Conclusion) -> Self {
        Self {
            laser: conclusion.laser_error.clone(),
            mass: conclusion.mass_error.clone(),
            road_noise: conclusion.road_noise_error.clone(),
            interpolation: conclusion.interpolation_error.clone(),
        }
    }

    /// Estimates of any method that compares motion and road. Noise of the road is not among it: methods differ in what it does to them.
    pub fn of_any(&self, estimates: &PerAxle<Estimate>) -> PerAxle<Estimate> {
        let errors = [&self.laser, &self.mass, &self.interpolation];
        let wider = |estimates: PerAxle<Estimate>, by| widened(&estimates, by);
        errors.into_iter().fold(estimates.clone(), wider)
    }

    /// Estimates of output error, withheld where noise of the road decides them.
    pub fn of_output_error(&self, estimates: &PerAxle<Estimate>) -> PerAxle<Estimate> {
        borne(&self.of_any(estimates), &self.road_noise)
    }

    /// Estimates of the diagnosis. Those beside effects are corrected for noise of the road, those of plain axles are not.
    pub fn of_extended(
        &self,
        ride: &Ride,
        estimates: &PerAxle<Estimate>,
        is_plain: impl Fn(Axle) -> bool,
    ) -> PerAxle<Estimate> {
        let extended = self.of_any(estimates);
        let extended = extended.map(|_, e| e.clone().within_reach(ride.step_s));
        let noise = (self.road_noise).filter_map(|axle, by| is_plain(axle).then(|| by.clone()));
        widened(&extended, &noise)
    }

    /// Estimates from the axles' response to an unknown road.
    pub fn of_latent_road(&self, estimates: &PerAxle<Estimate>) -> PerAxle<Estimate> {
        widened(estimates, &self.mass)
    }

    /// What each of it makes of the intervals, in words.
    pub fn notes(&self, output_error: &PerAxle<Estimate>) -> Vec<String> {
        let reported = [
            notes(
                output_error,
                &self.laser,
                "the laser from which the road was computed",
                "its clock error and noise",
            ),
            notes(
                output_error,
                &worth_reporting(output_error, &self.road_noise),
                "noise in the road channel",
                "output error treats it as road",
            ),
            notes(
                output_error,
                &worth_reporting(output_error, &self.interpolation),
                "interpolation of the road between its samples",
                "the axle moves fast compared with the sampling rate",
            ),
            notes(
                output_error,
                &self.mass,
                "the mass's standard deviation",
                "from the bike file",
            ),
        ];
        reported.concat()
    }
}
