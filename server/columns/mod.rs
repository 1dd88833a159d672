//! Which channel a column may hold whose name is no channel's: a guess from its header, for a person to confirm.

mod choices;
mod files;

pub use choices::{Choice, choices};
pub use files::guesses;
pub use veloid_engine::ride::Guess;
