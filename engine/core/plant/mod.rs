//! Base models: what an axle is where nothing is left out. What departs from one is an effect (`veloid-model`).
//!
//! Every one here has one degree of freedom and is linear ([`Coefficients`]), which is what the integrator and the exact
//! solution compute; a [`Plant`] says which of its numbers exist, which of them a fit may move and how far, and under which names and
//! units they are reported. A new one is a folder or file of its own and a line in `registry.rs` (docs/decisions/plant.md).

mod axle;
mod base_model;
mod coefficients;
mod damper;
mod quantity;
mod reference;
mod registry;

pub use axle::Axle;
pub use base_model::{Known, Plant, Sizes};
pub use coefficients::{Coefficient, Coefficients};
pub use damper::Damper;
pub use quantity::{Of, Quantity};
pub use reference::PlantRef;
pub use registry::by_id;
