//! What each axle did, on the common clock: measured, or made from what was measured.

use crate::AxleRecord;
use crate::band::Band;
use crate::channels::channel::Channel;
use crate::channels::values::is_constant;
use crate::clocks::rates::USUAL_HZ;
use crate::clocks::resample::FLAT;
use crate::error::{Problem, ReadError};
use crate::options::ReadOptions;
use crate::signals::checks::is_free_motion;
use crate::signals::common::{Common, Lapse, basis};
use crate::signals::delay::delayed;
use crate::signals::prescribed::{answer, power};
use veloid_core::bicycle::{Axle, Bike, PerAxle};
use veloid_core::document::format_number::significant;
use veloid_core::plant::PlantRef;

/// Lowest frequency (Hz) that an accelerometer integrated twice is trusted at.
const LOWEST_HZ: f64 = 0.5;
/// How long (s) a lapse of the input is felt: several time constants of a bicycle's mode.
const SETTLE_S: f64 = 0.5;

/// Builds both axles, giving up their channels.
pub fn build(
    common: &mut Common<'_>,
    bike: &Bike,
    options: &ReadOptions,
) -> Result<PerAxle<AxleRecord>, ReadError> {
    let mut axles = PerAxle::default();
    // The road that the rear wheel meets later, and the band it is known in.
    let mut ahead: Option<(Vec<f64>, Option<Band>)> = None;
    let shared = needs_front_road(common);
    for axle in Axle::BOTH {
        let Some(basis) = basis(|c| common.has(c), axle) else {
            if axle == Axle::Front && shared {
                ahead = common.take(Channel::Road(axle)).map(|road| (road, None));
            }
            continue;
        };
        let mut parts = Parts::take(common, axle, options);
        if axle == Axle::Rear
            && let Some((road, band)) = ahead.take()
        {
            if is_constant(&road) {
                parts.road = Some(road);
            } else {
                let late = delayed(&road, common, bike)?;
                parts.unknown_until = late.known_from;
                parts.road = Some(late.road);
            }
            if let Some(band) = band {
                parts.keep_without_road(band, common.grid.rate_hz());
            }
        }
        parts.complete(basis, common, options);
        if axle == Axle::Front && shared {
            ahead = parts.road.clone().map(|road| (road, parts.band));
        }
        let mut record = parts.finish(basis, common, options)?;
        settle(&mut record, axle, common, bike);
        axles.set(axle, record);
    }
    Ok(axles)
}

/// Whether the rear axle's road is the front's, later.
fn needs_front_road(common: &Common<'_>) -> bool {
    let has = |c| common.has(c);
    let rear = Axle::Rear;
    basis(has, rear).is_some()
        && !has(Channel::Road(rear))
        && !has(Channel::Deflection(rear))
        && (has(Channel::Road(Axle::Front)) || has(Channel::Deflection(Axle::Front)))
}

/// An axle's channels while they are put together.
struct Parts {
    axle: Axle,
    road: Option<Vec<f64>>,
    force: Option<Vec<f64>>,
    acceleration: Option<Vec<f64>>,
    deflection: Option<Vec<f64>>,
    displacement: Option<Vec<f64>>,
    /// What everything but the measured acceleration was limited to.
    band: Option<Band>,
    /// First sample at which the delayed road is known.
    unknown_until: usize,
}

impl Parts {
    fn take(common: &mut Common<'_>, axle: Axle, options: &ReadOptions) -> Self {
        let mut deflection = common.take(Channel::Deflection(axle));
        if let Some(d) = &mut deflection {
            let mean = d.iter().sum::<f64>() / d.len() as f64;
            d.iter_mut()
                .for_each(|d| *d = options.deflection_sign * (*d - mean));
        }
        Self {
            axle,
            road: common.take(Channel::Road(axle)),
            force: common.take(Channel::Force(axle)),
            acceleration: common.take(Channel::Acceleration(axle)),
            deflection,
            displacement: common.take(Channel::Displacement(axle)),
            band: None,
            unknown_until: 0,
        }
    }

    /// Makes road and displacement where they were not measured. As the model is linear and does
    /// not change with time, limiting all its channels by one filter leaves its equation true.
    fn complete(&mut self, basis: Channel, common: &mut Common<'_>, options: &ReadOptions) {
        let rate = common.grid.rate_hz();
        let own_rate = |c| common.clock(c).map_or(rate, |clock| clock.grid.rate_hz());
        let slowest =
            (self.inputs().into_iter().map(own_rate)).fold(rate.min(own_rate(basis)), f64::min);
        let slow = Band {
            low_hz: None,
            high_hz: (slowest < 0.95 * rate).then_some(FLAT * slowest),
        };
        match basis {
            Channel::Acceleration(_) => {
                let (low, high) = options.band_hz.unwrap_or((LOWEST_HZ, FLAT * slowest));
                let band = Band {
                    low_hz: Some(low),
                    high_hz: Some(high.min(0.5 * rate)),
                };
                self.integrate(band, common);
            }
            Channel::Deflection(_) if self.road.is_none() => {
                self.keep(slow, rate);
                self.displacement = self.deflection.take();
            }
            Channel::Deflection(_) => self.displacement_from_road(slow, common),
            Channel::Road(_) => {
                self.keep(slow, rate);
                self.displacement = self.road.take();
            }
            _ if self.road.is_none() && self.deflection.is_some() => {
                self.keep(slow, rate);
                self.road_from_displacement(&slow, basis.name(), common);
            }
            _ => {}
        }
    }

    fn inputs(&self) -> [Channel; 3] {
        [
            Channel::Deflection(self.axle),
            Channel::Road(self.axle),
            Channel::Force(self.axle),
        ]
    }

    /// z from a, and u from both where d is there.
    fn integrate(&mut self, band: Band, common: &mut Common<'_>) {
        let rate = common.grid.rate_hz();
        let Some(measured) = &self.acceleration else {
            return;
        };
        let (z, a) = (
            band.integrate_twice(measured, rate),
            band.keep(measured, rate),
        );
        self.keep(band, rate);
        self.displacement = Some(z);
        let name = Channel::Displacement(self.axle).name();
        let from = Channel::Acceleration(self.axle).name();
        common.warn(made(name, from, &band));
        if let Some(d) = &self.deflection
            && correlation(&a, d) < -0.3
        {
            common.warn(format!(
                "{} falls where {from} rises, as if the spring pushed the wrong way: is its sign \
                 right (deflection_sign)?",
                Channel::Deflection(self.axle).name()
            ));
        }
        if self.road.is_none() {
            self.road_from_displacement(&band, from, common);
        }
    }

    /// u = z + d.
    fn road_from_displacement(&mut self, band: &Band, from: &str, common: &mut Common<'_>) {
        if let (Some(z), Some(d)) = (&self.displacement, &self.deflection) {
            self.road = Some(z.iter().zip(d).map(|(z, d)| z + d).collect());
            let name = Channel::Road(self.axle).name();
            let d = Channel::Deflection(self.axle).name();
            common.warn(made(name, &format!("{from} and {d}"), band));
        }
    }

    /// z = u - d.
    fn displacement_from_road(&mut self, band: Band, common: &mut Common<'_>) {
        self.keep(band, common.grid.rate_hz());
        if let (Some(u), Some(d)) = (&self.road, &self.deflection) {
            self.displacement = Some(u.iter().zip(d).map(|(u, d)| u - d).collect());
            let d = Channel::Deflection(self.axle).name();
            let name = Channel::Displacement(self.axle).name();
            common.warn(made(name, &format!("the road and {d}"), &band));
        }
    }

    fn keep(&mut self, band: Band, rate_hz: f64) {
        if band.is_everything() {
            return;
        }
        if let Some(road) = &mut self.road {
            *road = band.keep(road, rate_hz);
        }
        self.keep_without_road(band, rate_hz);
    }

    fn keep_without_road(&mut self, band: Band, rate_hz: f64) {
        let channels = [
            &mut self.force,
            &mut self.deflection,
            &mut self.displacement,
        ];
        for values in channels.into_iter().flatten() {
            *values = band.keep(values, rate_hz);
        }
        self.band = Some(self.band.map_or(band, |other| band.within(other)));
    }

    fn finish(
        mut self,
        basis: Channel,
        common: &Common<'_>,
        options: &ReadOptions,
    ) -> Result<AxleRecord, ReadError> {
        let valid = self.trusted(basis, common);
        let blame = |problem| common.blame(basis, problem);
        let displacement = self.displacement.take().unwrap_or_default();
        let channel = Channel::Displacement(self.axle).name();
        if is_constant(&displacement) {
            let value = displacement[0];
            return Err(blame(Problem::Constant { channel, value }));
        }
        let prescribed = match basis {
            Channel::Road(_) => true,
            Channel::Deflection(_) => self.road.is_none(),
            _ => false,
        };
        if let (true, Some(force)) = (prescribed, &self.force)
            && is_constant(force)
        {
            let (channel, value) = (Channel::Force(self.axle).name(), force[0]);
            return Err(blame(Problem::Constant { channel, value }));
        }
        let still = |values: &Option<Vec<f64>>| values.as_deref().is_none_or(is_constant);
        if still(&self.road) && still(&self.force) && !is_free_motion(&displacement) {
            return Err(blame(Problem::NotExcited { channel }));
        }
        let samples = valid.iter().filter(|v| **v).count();
        let least = options.limits.least_samples.min(common.grid.count);
        if samples < least {
            let rates = common.recording.clocks.iter().map(|c| c.grid.rate_hz());
            let unusual = rates.into_iter().find(|rate| !USUAL_HZ.contains(rate));
            return Err(blame(Problem::Untrusted {
                channel,
                samples,
                least,
                doubt: unusual.map_or(String::new(), |rate| {
                    format!(
                        "; a clock has {} samples a second: is the unit of the times right?",
                        significant(rate, 3)
                    )
                }),
            }));
        }
        Ok(AxleRecord {
            road: self.road.unwrap_or_else(|| vec![0.0; displacement.len()]),
            force: self.force,
            displacement,
            acceleration: self.acceleration,
            valid,
            prescribed,
            plant: PlantRef::default(),
            band: self.band,
        })
    }

    /// False where the displacement was not measured, or what drives it was not known just before.
    fn trusted(&self, basis: Channel, common: &Common<'_>) -> Vec<bool> {
        let grid = common.grid;
        let memory = self.band.map_or(0.0, |b| b.memory_s());
        // Stretches that begin, less those that end, at each sample: they may be many, long and overlap.
        let mut begun = vec![0_i32; grid.count + 1];
        let mut distrust = |from_s: f64, to_s: f64| {
            let first = ((from_s - grid.start_s) / grid.step_s).ceil().max(0.0);
            let last = ((to_s - grid.start_s) / grid.step_s).floor();
            let last = last.min(grid.count as f64 - 1.0);
            if last >= first {
                begun[first as usize] += 1;
                begun[last as usize + 1] -= 1;
            }
        };
        for Lapse { from_s, to_s, .. } in common.lapses(basis) {
            distrust(from_s - memory, to_s + memory);
        }
        for channel in self.inputs() {
            for lapse in common.lapses(channel) {
                // A sample or two are bridged: what is wrong with them is not integrated, as an acceleration is.
                let memory = match lapse.bridged {
                    true => self.band.map_or(0.0, |b| b.resolution_s()),
                    false => memory,
                };
                let after = if lapse.lasting { SETTLE_S } else { 0.0 };
                distrust(lapse.from_s - memory, lapse.to_s + memory + after);
            }
        }
        if self.unknown_until > 0 {
            let known = grid.at(self.unknown_until - 1);
            distrust(grid.start_s, known + SETTLE_S);
        }
        if memory > 0.0 {
            distrust(grid.start_s, grid.start_s + memory);
            distrust(grid.end_s() - memory, grid.end_s());
        }
        let mut distrusted = 0;
        (begun.iter().take(grid.count))
            .map(|change| {
                distrusted += change;
                distrusted == 0
            })
            .collect()
    }
}

/// Says whether the force answers to a prescribed motion, where that is open or shown by the channels, and which way it counts.
fn settle(record: &mut AxleRecord, axle: Axle, common: &mut Common<'_>, bike: &Bike) {
    let Some(force) = record.force.as_mut().filter(|f| !is_constant(f)) else {
        return;
    };
    let named = Channel::Force(axle).name();
    let Some(found) = answer(&record.displacement, force, &record.valid) else {
        return;
    };
    if !record.prescribed {
        if !is_constant(&record.road) || !found.is_prescribed() {
            return;
        }
        record.prescribed = true;
        common.warn(format!(
            "{axle} axle: {named} is treated as the response to a motion prescribed by a rig, F = k d + B d': spring and damper \
             explain {:.0} % of it and inertia {:.0} % of the rest{}",
            100.0 * found.explained,
            100.0 * found.inertia,
            bike.mass(axle).map_or(String::new(), |mass| format!(
                ", so the {mass} kg of the bike file are not used"
            ))
        ));
    }
    if found.is_an_answer() && power(&record.displacement, force, &record.valid) < 0.0 {
        force.iter_mut().for_each(|f| *f = -*f);
        common.warn(format!(
            "{axle} axle: {named} takes power out of the motion, as a reaction force does; its sign is inverted so that k and B \
             are positive"
        ));
    }
}

fn made(what: &str, from: &str, band: &Band) -> String {
    format!(
        "{what} was computed from {from}: it contains {}",
        band.describe()
    )
}

/// Correlation of two records without mean.
fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let size = (dot(a, a) * dot(b, b)).sqrt();
    if size > 0.0 { dot(a, b) / size } else { 0.0 }
}
