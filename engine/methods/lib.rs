//! The exact solution of the vertical model, paper eq. (1), and the methods of identification that share it.

pub mod least_squares;
pub mod observer;
pub mod output_error;
pub mod roll;
pub mod simulate;
pub mod swarm;
pub mod uncertainty;
