//! Simulation of the vertical model: exactly where it is linear, by Runge-Kutta where effects make
//! it nonlinear.

pub mod linear;
pub mod outing;
pub mod road;
pub mod sensitivity;
pub mod start;
