//! The program `veloid`; see `lib.rs`.

use std::process::ExitCode;

fn main() -> ExitCode {
    veloid::run()
}
