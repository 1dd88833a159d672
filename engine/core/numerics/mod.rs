//! Numerical tools that know nothing of bicycles.

pub mod autoregressive;
pub mod elementary;
#[doc(hidden)]
pub mod example;
pub mod filter;
pub mod finite;
pub mod lanes;
pub mod levenberg_marquardt;
pub mod modulating;
pub mod projection;
pub mod random;
pub mod spectrum;
pub mod spline;
pub mod statistics;
