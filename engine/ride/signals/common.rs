//! The common clock, and channels brought to it.

use crate::ReadOptions;
use crate::channels::channel::Channel;
use crate::channels::values::is_constant;
use crate::clocks::clock::{Clock, Grid};
use crate::clocks::resample::{convert, offset, spline_at, to_own_grid};
use crate::error::{Problem, ReadError};
use crate::recording::{Recording, Track, list, short};
use crate::signals::checks;
use veloid_core::bicycle::Axle;

/// Runs of missing samples up to this long leave no trace once they are over.
const SHORT_GAP: usize = 3;
/// Displacement made from acceleration is not kept faster than this (Hz): it holds nothing there.
const MOST_MADE_HZ: f64 = 1000.0;
/// Below this rate (Hz) a bicycle's vertical mode, near 11 Hz, has fewer than five samples a swing.
const WEAK_RATE_HZ: f64 = 50.0;

/// The channel that the displacement of `axle` stands on; `None`: too little was recorded there. A force beside nothing but a
/// deflection or a road is a rig's, which prescribes that motion.
pub fn basis(has: impl Fn(Channel) -> bool, axle: Axle) -> Option<Channel> {
    let (z, a) = (Channel::Displacement(axle), Channel::Acceleration(axle));
    let d = Channel::Deflection(axle);
    let road = has(Channel::Road(axle)) || axle == Axle::Rear && has(Channel::Road(Axle::Front));
    if has(z) {
        Some(z)
    } else if has(a) && (has(d) || road || has(Channel::Force(axle))) {
        Some(a)
    } else if has(d) && (road || has(Channel::Force(axle))) {
        Some(d)
    } else {
        let own = Channel::Road(axle);
        (has(own) && has(Channel::Force(axle))).then_some(own)
    }
}

/// Whether no axle's displacement can be reported, but accelerometers and the speed can determine k and B without it.
pub fn has_only_accelerometers(has: impl Fn(Channel) -> bool) -> bool {
    let axles = Axle::BOTH.into_iter();
    has(Channel::Speed)
        && axles.clone().any(|axle| has(Channel::Acceleration(axle)))
        && axles.clone().all(|axle| basis(&has, axle).is_none())
}

/// A stretch of a channel that is not to be trusted, ends included (s).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lapse {
    pub from_s: f64,
    pub to_s: f64,
    /// Whether what the channel drives is still off when it is over.
    pub lasting: bool,
    /// Whether it is so short that its samples were interpolated from their neighbours.
    pub bridged: bool,
}

pub struct Common<'a> {
    pub grid: Grid,
    pub recording: &'a mut Recording,
    clipped: Vec<(Channel, Vec<(f64, f64)>)>,
}

impl<'a> Common<'a> {
    /// Chooses the clock: that of the displacement channels, the faster one if they differ, over
    /// the time that every channel in use covers.
    pub fn new(recording: &'a mut Recording, options: &ReadOptions) -> Result<Self, ReadError> {
        let clipped = checks::examine(recording);
        let has = |c: Channel| recording.tracks.contains_key(&c);
        let mut bases: Vec<Channel> = Axle::BOTH.iter().filter_map(|a| basis(has, *a)).collect();
        if has_only_accelerometers(has) {
            let sensors = Axle::BOTH.map(Channel::Acceleration);
            bases.extend(sensors.into_iter().filter(|c| has(*c)));
        }
        let clock = |c: &Channel| {
            let own = recording.clocks[recording.tracks.get(c)?.clock].grid;
            let thin = match c {
                Channel::Acceleration(_) => (own.rate_hz() / MOST_MADE_HZ).ceil().max(1.0) as usize,
                _ => 1,
            };
            Some(Grid {
                step_s: own.step_s * thin as f64,
                count: own.count.div_ceil(thin),
                ..own
            })
        };
        let clocks = bases.iter().filter_map(clock);
        let Some(master) = clocks.min_by(|a, b| a.step_s.total_cmp(&b.step_s)) else {
            let headers = recording.columns.iter().map(|c| &c.header);
            let found = list(headers.chain(&recording.ignored));
            return Err(Problem::AxleMissing { found }.into());
        };
        let (mut from, mut to) = (f64::NEG_INFINITY, f64::INFINITY);
        for (channel, track) in &recording.tracks {
            let used = channel.is_essential() && !is_constant(&track.values);
            if used {
                let own = recording.clocks[track.clock].grid;
                let slack = if own.step_s > 1.5 * master.step_s {
                    0.5 * own.step_s
                } else {
                    0.0
                };
                from = from.max(own.start_s - slack);
                to = to.min(own.end_s() + slack);
            }
        }
        let index = |time: f64| (time - master.start_s) / master.step_s;
        let first = (index(from) - 1e-3).ceil().max(0.0) as usize;
        let last = (index(to) + 1e-3)
            .floor()
            .clamp(-1.0, master.count as f64 - 1.0);
        let grid = Grid {
            start_s: master.at(first),
            step_s: master.step_s,
            count: (last + 1.0 - first as f64).max(0.0) as usize,
        };
        let least = options.limits.least_samples.max(4);
        if grid.count < least {
            let samples = grid.count;
            return Err(Problem::TooShort { samples, least }.into());
        }
        let mut common = Self {
            grid,
            recording,
            clipped,
        };
        common.note_rates();
        Ok(common)
    }

    pub fn has(&self, channel: Channel) -> bool {
        self.recording.tracks.contains_key(&channel)
    }

    pub fn warn(&mut self, warning: String) {
        self.recording.warnings.push(warning);
    }

    /// The clock that a channel was recorded on.
    pub fn clock(&self, channel: Channel) -> Option<&Clock> {
        let track = self.recording.tracks.get(&channel)?;
        self.recording.clocks.get(track.clock)
    }

    /// A channel on the common clock; its own record is given up.
    pub fn take(&mut self, channel: Channel) -> Option<Vec<f64>> {
        let track = self.recording.tracks.get_mut(&channel)?;
        let values = std::mem::take(&mut track.values);
        if values.is_empty() {
            return None;
        }
        let clock = &self.recording.clocks[track.clock];
        Some(bring(values, clock, self.grid, channel))
    }

    /// A channel on the common clock; its own record stays.
    pub fn look(&self, channel: Channel) -> Option<Vec<f64>> {
        let track = self.recording.tracks.get(&channel)?;
        let clock = &self.recording.clocks[track.clock];
        let values = track.values.clone();
        (!values.is_empty()).then(|| bring(values, clock, self.grid, channel))
    }

    /// Gives back a channel taken, now on the common clock.
    pub fn put(&mut self, channel: Channel, values: Vec<f64>) {
        let grid = self.grid;
        let recording = &mut *self.recording;
        if let Some(track) = recording.tracks.get_mut(&channel) {
            recording.clocks.push(Clock {
                grid,
                ..Clock::regular(1.0, grid.count)
            });
            track.clock = recording.clocks.len() - 1;
            track.values = values;
        }
    }

    /// Where `channel` was missing or clipped.
    pub fn lapses(&self, channel: Channel) -> Vec<Lapse> {
        let gaps = self
            .clock(channel)
            .map(|c| c.gaps.as_slice())
            .unwrap_or_default();
        let gaps = gaps.iter().map(|gap| {
            // Strictly between the samples that are there.
            let rim = 0.01 * self.grid.step_s;
            Lapse {
                from_s: gap.from_s + rim,
                to_s: gap.to_s - rim,
                lasting: gap.missing > SHORT_GAP,
                bridged: gap.missing <= SHORT_GAP,
            }
        });
        let clipped = self
            .clipped
            .iter()
            .filter(|(c, _)| *c == channel)
            .flat_map(|(_, s)| s);
        let clipped = clipped.map(|(from_s, to_s)| Lapse {
            from_s: *from_s,
            to_s: *to_s,
            lasting: false,
            bridged: false,
        });
        gaps.chain(clipped).collect()
    }

    pub fn blame(&self, channel: Channel, problem: Problem) -> ReadError {
        match self.recording.tracks.get(&channel) {
            Some(track) => track.blame(problem),
            None => problem.into(),
        }
    }

    /// Says which channels were slower or faster, and what that costs.
    fn note_rates(&mut self) {
        let rate = self.grid.rate_hz();
        let mut notes = Vec::new();
        for (channel, Track { clock, values, .. }) in &self.recording.tracks {
            let own = self.recording.clocks[*clock].grid.rate_hz();
            let name = channel.name();
            if values.len() < 2 || !channel.is_essential() {
                continue;
            }
            if own > 1.05 * rate {
                notes.push(format!(
                    "{name}: low-passed from {} Hz to the common clock's {} Hz",
                    short(own),
                    short(rate)
                ));
            } else if own < 0.95 * rate {
                let folding = match channel {
                    Channel::Road(_) | Channel::Deflection(_) if own < WEAK_RATE_HZ => format!(
                        "; a bicycle's vertical mode, near 11 Hz, has {:.1} samples per cycle there, \
                         and higher frequencies are aliased",
                        own / 11.0
                    ),
                    _ => String::new(),
                };
                notes.push(format!(
                    "{name}: resampled from {} Hz to the common clock's {} Hz: it contains nothing above \
                     {} Hz{folding}",
                    short(own),
                    short(rate),
                    short(0.5 * own)
                ));
            }
        }
        let road = |c: &Channel| matches!(c, Channel::Road(_) | Channel::Deflection(_));
        let moving = |t: &Track| !is_constant(&t.values);
        if rate < WEAK_RATE_HZ
            && self
                .recording
                .tracks
                .iter()
                .any(|(c, t)| road(c) && moving(t))
        {
            notes.push(format!(
                "{} Hz is a low rate for a ride: a bicycle's vertical mode, near 11 Hz, has \
                 {:.1} samples per cycle",
                short(rate),
                rate / 11.0
            ));
        }
        self.recording.warnings.append(&mut notes);
    }
}

/// Values on `grid`, from samples on their own clock.
fn bring(values: Vec<f64>, clock: &Clock, grid: Grid, channel: Channel) -> Vec<f64> {
    if is_constant(&values) {
        return vec![values[0]; grid.count];
    }
    let own = clock.grid;
    let faster = own.step_s < 0.95 * grid.step_s;
    // Speeds and angles vary slowly beside their rate; a spline follows them through any gap.
    if !channel.is_essential() && (!faster || clock.missing() > values.len()) {
        if clock.knots.is_none()
            && let Some(from) = offset(own, grid)
        {
            return part(values, from, grid.count);
        }
        let instants = (0..grid.count).map(|k| (grid.at(k) - own.start_s) / own.step_s);
        return match &clock.knots {
            Some(knots) => spline_at(knots, &values, instants),
            None => {
                let knots: Vec<f64> = (0..values.len()).map(|k| k as f64).collect();
                spline_at(&knots, &values, instants)
            }
        };
    }
    let values = to_own_grid(values, clock.knots.as_deref(), own.count);
    match offset(own, grid) {
        Some(from) => part(values, from, grid.count),
        None => convert(&values, own, grid),
    }
}

fn part(mut values: Vec<f64>, from: usize, count: usize) -> Vec<f64> {
    values.drain(..from);
    values.truncate(count);
    values
}
