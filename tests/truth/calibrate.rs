//! Whether probabilities are what they say: clean rides of many classes, p values, alarms and intervals.

pub mod class;
pub mod outcome;
pub mod run;
pub mod table;
