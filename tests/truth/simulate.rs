//! The simulator: road and speed, excitation on a fine grid, force laws, vehicle, integrator, sensors.

pub mod contact;
pub mod drive;
pub mod effect;
pub mod integrate;
pub mod outside;
pub mod road;
pub mod sensors;
pub mod speed;
pub mod vehicle;
