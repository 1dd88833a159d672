//! Which channel a column may hold that is called otherwise: a guess from its header, for a person to confirm.

mod guess;
mod words;

pub use guess::{Guess, guesses};
