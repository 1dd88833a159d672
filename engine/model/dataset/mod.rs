//! A ride as the extended model sees it: inputs, noise floors, dither, and rides that are only planned.

pub mod dither;
pub mod inputs;
pub mod planned;
pub mod speed;
mod track;
pub mod windows;
mod work;

pub use inputs::Dataset;
pub use track::Track;
pub use windows::Windows;
pub use work::Budget;
