//! What rides there are: the plan of a suite, the sizes of effects, the making of one ride, and the files.

pub mod case;
pub mod circumstance;
pub mod disguise;
pub mod excitation;
pub mod folder;
pub mod made;
pub mod order;
pub mod plan;
pub mod ride;
pub mod sizes;
pub mod strange;
