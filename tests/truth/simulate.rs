//! The simulator: road and speed, excitation on a fine grid, force laws, vehicle, integrator, sensors.

pub mod bessel;
pub mod contact;
pub mod drive;
pub mod effect;
pub mod fourier;
pub mod integrate;
pub mod lowpass;
pub mod outside;
pub mod road;
pub mod sensors;
pub mod speed;
pub mod tracks;
pub mod vehicle;
