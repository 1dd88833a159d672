//! Drives the real binary from outside: over HTTP and from the command line.
#![allow(clippy::unwrap_used)]

mod access;
mod api_guide;
mod backup;
mod bad_days;
mod bad_input;
mod bench;
mod browser;
mod crashes;
mod dashboard;
mod events;
mod fleet;
mod harness;
mod hostile;
mod hosts;
mod jobs;
mod kills;
mod load;
mod model;
mod object_storage;
mod openapi;
mod oracle;
mod pages;
mod process;
mod real;
mod report_equality;
mod ride;
mod said;
mod scale;
mod simulate;
mod skips;
mod strangers;
mod structure;
mod takeover;
mod upload;
