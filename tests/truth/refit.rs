//! Rides replayed from their logs, and refits of known structures to them: the plain model, the noise floor, the oracle.

pub mod fit;
pub mod known;
pub mod levenberg;
pub mod replay;
pub mod spline;
