//! Which channel a column may hold whose name is no channel's: a guess from its header, for a person to confirm.

mod choices;
mod files;
mod guess;
mod words;

pub use choices::{Choice, choices};
pub use files::guesses;
pub use guess::Guess;
