//! The road under each lane, where effects change it.

use std::ops::Range;

use super::axle::{AxleLanes, EffectLanes};
use crate::dataset::{Dataset, Track};
use crate::law::{Spot, Tap};
use veloid_core::numerics::lanes::{LANES, Lanes, widest};
use veloid_core::numerics::spline::cubic;

/// Heights (m) and slopes (m/s) at the samples from the first on.
pub(super) struct LaneRoad {
    first: usize,
    value: Vec<Lanes>,
    slope: Vec<Lanes>,
}

impl LaneRoad {
    /// Nothing where no effect changes what the sensor of the road has recorded.
    pub fn of(
        dataset: &Dataset,
        track: &Track,
        lanes: &AxleLanes,
        span: Range<usize>,
    ) -> Option<Self> {
        let on_road = |e: &&EffectLanes| e.kind.spec().on_road;
        let effects: Vec<&EffectLanes> = lanes.effects.iter().filter(on_road).collect();
        if effects.is_empty() {
            return None;
        }
        let mut road = Self {
            first: span.start,
            value: Vec::with_capacity(span.len()),
            slope: Vec::with_capacity(span.len()),
        };
        widest(
            #[inline(always)]
            || {
                for i in span {
                    road.read(dataset, track, &effects, i);
                }
            },
        );
        Some(road)
    }

    #[inline(always)]
    fn read(&mut self, dataset: &Dataset, track: &Track, effects: &[&EffectLanes], i: usize) {
        let spot = Spot {
            speed: dataset.speed[i],
            distance: dataset.distance[i],
        };
        let mut tap = Tap {
            shift: Lanes::ZERO,
            half_window: Lanes::ZERO,
            value: Lanes::ZERO,
            slope: Lanes::ZERO,
        };
        for e in effects {
            e.kind.road(&e.values, &spot, &track.scale, &mut tap);
        }
        let (mut value, mut slope) = (Lanes::ZERO, Lanes::ZERO);
        let place = |lane: usize| [tap.shift, tap.half_window].map(|x| x.0[lane]);
        for lane in 0..LANES {
            (value.0[lane], slope.0[lane]) = match place(lane) {
                [0.0, 0.0] => (track.input.road[i], track.input.road_slope[i]),
                again if lane > 0 && again == place(lane - 1) => {
                    (value.0[lane - 1], slope.0[lane - 1])
                }
                [shift, half_window] => track.road_before(i, shift, half_window),
            };
        }
        self.value.push(value + tap.value);
        self.slope.push(slope + tap.slope);
    }

    /// The cubic on the interval of `h` (s) after a sample.
    #[inline(always)]
    pub fn piece(&self, i: usize, h: f64) -> [Lanes; 4] {
        let i = i - self.first;
        let (d, a, b) = (
            self.value[i + 1] - self.value[i],
            self.slope[i] * h,
            self.slope[i + 1] * h,
        );
        [self.value[i], a, d * 3.0 - a * 2.0 - b, a + b - d * 2.0]
    }
}

/// The same of the road as it was recorded.
#[inline(always)]
pub(super) fn recorded(track: &Track, i: usize) -> [f64; 4] {
    let input = &track.input;
    let [value, slope] = [&input.road, &input.road_slope];
    cubic(value[i], value[i + 1], slope[i], slope[i + 1], input.step)
}
