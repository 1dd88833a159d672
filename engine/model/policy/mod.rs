//! Thresholds of windows and of fits: their units, what they trade, and where they come from. Those of verdicts are in `diagnosis/policy`.

/// Share of the plain model's stiffness that stays beside an effect which takes a spring's place: a tyre does not relax to nothing.
pub const SPRING_STAYS: f64 = 0.15;
/// Standard errors by which a damping may be negative beside named effects.
pub const PUSHES: f64 = 3.0;
/// Share of the plain model's damping by which it may be in any case.
pub const PUSHES_A_LITTLE: f64 = 0.02;
/// Static over relaxing stiffness of a tyre, at least: branches of 20 to 80 % of k are usual (../shared/effects.md; Dressel & Sadauckas 2020,
/// Appl. Sci. 10:3156), and with next to no static stiffness it is a force that lags, and no tyre.
pub const STATIC: f64 = 0.1;
/// Periods of what resonates that a record shows at least: with fewer it is a drift (as Nyquist's limit, at the other end).
pub const PERIODS_SHOWN: f64 = 2.0;
/// Dominant periods in a window of ordinary length. With one, starting states absorb a hidden mass; in long windows phase comes back.
pub const DOMINANT_PERIODS: f64 = 4.0;
/// Natural periods in it, if that is longer.
pub const NATURAL_PERIODS: f64 = 2.0;
/// Windows in a record at least.
pub const FEWEST_WINDOWS: usize = 6;
/// Dominant periods that each of them holds at least; a record with no room for that is judged as a whole. Between two recordings of
/// ../shared/real: encoder_swing, whose windows would hold 1.1 and which is right as a whole, and emps, whose windows hold 1.4.
pub const SHORTEST_PERIODS: f64 = 1.25;
/// Part of the loudest window's deviation (RMS) below which a free decay has died away.
pub const SWINGS: f64 = 0.05;
