//! Simulation of the vertical model: exactly where it is linear, by Runge-Kutta where effects make
//! it nonlinear.

pub mod laser;
pub mod linear;
pub mod road;
mod sensed;
pub mod sensitivity;
pub mod sensor_noise;
pub mod simulated_ride;
pub mod start;
