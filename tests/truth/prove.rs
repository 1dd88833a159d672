//! The proof: runs a binary on concealed rides as a user would, opens the key, scores, writes the tables.

pub mod begun;
pub mod budget;
pub mod conditions;
pub mod document;
pub mod figure;
pub mod identify;
pub mod kept;
pub mod origin;
pub mod proof;
pub mod real;
pub mod rebuilt;
pub mod rows;
pub mod run;
pub mod score;
pub mod seal;
pub mod tables;
pub mod time;
pub mod times;
pub mod whole;
