//! `veloid-truth make | prove`: rides with concealed effects, and the proof on them.
//!
//! `prove` keeps the outcome of every ride in its work folder as it comes. Stopped in whatever way, by `--budget 15m` for
//! example, the same command goes on with the rides that are missing, and its tables say how many are in. A folder that
//! holds outcomes of another seed is refused, and of another binary unless this one reproduces three of its reports.

mod options;

use std::path::PathBuf;
use std::process::ExitCode;

use veloid_truth::calibrate;
use veloid_truth::files;
use veloid_truth::misread::run::Trial;
use veloid_truth::no_road;
use veloid_truth::power;
use veloid_truth::prove::proof::Proof;
use veloid_truth::prove::times::Times;
use veloid_truth::prove::whole::{self, Whole};
use veloid_truth::refit::known;
use veloid_truth::studies;
use veloid_truth::suite::folder;
use veloid_truth::suite::order::Suite;

use options::Options;

const USAGE: &str = "usage:
  veloid-truth make --out DIR --seed N [--suite NAME] [--sample 1/6] [--count N]
  veloid-truth prove --suite NAME|all|timing|timing-slower|real --seed sealed --docs docs/proof.md [--nonce ../shared/nonce.txt]
                     [--binary PATH] [--real ../shared/real] [--work target/proof]
                     the seed is computed from the committed trees and the nonce, the run is listed in the document, and its
                     sections are written; needs a clean tree, the document aside; without --binary builds it, in release
  veloid-truth prove --binary PATH --seed N [--suite NAME] [--sample 1/6] [--count N] [--work target/proof] [--bounds PERCENT]
                     for development: prints the tables; fails where a row misses its demand by more than rides that meet it
                     would in this percentage of such runs
                     Each `prove` with --budget 90s|15m|2h begins no ride after that time, counted from its start; the same
                     command goes on. It fails then only where --bounds does, of the rides that are in.
  veloid-truth misread --binary PATH --seed N [--rides 20] [--clean 300] [--only WORDS] [--work DIR]
                     rides that are misread in one way each, and clean ones: what is noticed, as a table
  veloid-truth calibrate --binary PATH --seed N [--rides 40] [--work DIR] [--budget 10m]
                     clean rides by class: p values, false alarms and intervals against their names
  veloid-truth power --binary PATH --seed N [--rides 40] [--work DIR] [--budget 10m]
                     effects of the sizes that reports call detectable: how often they show
  veloid-truth studies --binary PATH --seed N [--count 30] [--work DIR] [--budget 10m]
                     sets of rides of one bicycle, identified as one: verdicts and intervals
  veloid-truth no_road --binary PATH --seed N [--sample 1/6] [--rides N] [--work DIR] [--budget 10m]
                     rides of two accelerometers and a speed, at most N of each class: verdicts and intervals;
                     rides on which the binary is wrong stay in the folder
                     These four keep outcomes in their folder as they come: another run with the same binary goes on.
  veloid-truth refit --rides DIR          plain model, noise floor and oracle of every ride, as JSON";

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match run(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("{message}");
            ExitCode::from(2)
        }
    }
}

fn run(arguments: &[String]) -> Result<(), String> {
    let options = Options::read(arguments)?;
    match arguments.first().map(String::as_str) {
        Some("make") => {
            let folder = options.path("--out")?.ok_or("make needs --out DIR")?;
            let digest = folder::make(
                &folder,
                &options.order(options.number("--seed", 1)? as u64)?,
            )
            .map_err(|e| e.to_string())?;
            println!("{digest}");
            Ok(())
        }
        Some("prove") => {
            println!("{}", prove(&options)?);
            Ok(())
        }
        Some("misread") => {
            let trial = Trial {
                binary: &options
                    .path("--binary")?
                    .ok_or("misread needs --binary PATH")?,
                work: &options.work()?.join("misread"),
                seed: options.number("--seed", 1)? as u64,
                rides: options.number("--rides", 20)? as u64,
                clean: options.number("--clean", 0)? as u64,
                only: options.get("--only").unwrap_or_default(),
            };
            println!("{}", trial.run().map_err(|e| e.to_string())?);
            Ok(())
        }
        Some(trial @ ("calibrate" | "power" | "studies" | "no_road")) => {
            println!("{}", further(trial, &options)?);
            Ok(())
        }
        Some("refit") => {
            let folder = options.path("--rides")?.ok_or("refit needs --rides DIR")?;
            let key_path = folder::key_path(&folder).map_err(|e| e.to_string())?;
            let key = files::read_json(&key_path).map_err(|e| e.to_string())?;
            let known = known::all(&folder, &key).map_err(|e| e.to_string())?;
            println!(
                "{}",
                serde_json::to_string(&known).map_err(|e| e.to_string())?
            );
            Ok(())
        }
        _ => Err(USAGE.to_owned()),
    }
}

fn further(trial: &str, options: &Options) -> Result<String, String> {
    let table = match trial {
        "calibrate" => calibrate::run::run(options.trial(trial, "--rides", 40)?),
        "power" => power::run::run(options.trial(trial, "--rides", 40)?),
        "studies" => studies::run::run(options.trial(trial, "--count", 30)?),
        _ => {
            let order = options.trial(trial, "--rides", usize::MAX)?;
            no_road::run::run(order, options.one_in()?)
        }
    };
    table.map_err(|e| e.to_string())
}

fn prove(options: &Options) -> Result<String, String> {
    let suite = options.get("--suite").unwrap_or("standard");
    let known = Suite::ALL.iter().any(|known| known.name() == suite);
    if options.is_sealed() {
        return sealed(options, suite, known);
    }
    if options.path("--docs")?.is_some() || !known {
        return Err(format!(
            "--docs and --suite {suite} need --seed sealed\n{USAGE}"
        ));
    }
    let binary = options
        .path("--binary")?
        .ok_or("prove needs --binary PATH")?;
    let proof = Proof {
        binary,
        order: options.order(options.number("--seed", 1)? as u64)?,
        work: options.work()?,
        register: None,
        budget: options.budget()?,
        doubt: options.share("--bounds")?,
    };
    let shown = proof.run().map_err(|e| e.to_string())?;
    Ok(shown.said(suite))
}

/// Runs on the seed that the committed trees and the nonce give, and writes into the document.
fn sealed(options: &Options, suite: &str, known: bool) -> Result<String, String> {
    let register = options.register()?;
    eprintln!("{}", register.seal);
    let budget = options.budget()?;
    let real = options.path("--real")?;
    let real = real.unwrap_or_else(|| PathBuf::from("../shared/real"));
    let text = match suite {
        "all" => Whole {
            register: &register,
            real,
            budget,
        }
        .run(),
        "timing" | "timing-slower" => {
            let times = Times {
                register: &register,
                section: suite,
                budget,
            };
            times.write().map(|shown| shown.said(suite))
        }
        "real" => whole::recordings(&register, &real),
        _ if known => {
            let proof = Proof {
                binary: register.origin.binary.clone(),
                order: options.order(register.seal.seed)?,
                work: register.work.clone(),
                register: Some(register),
                budget,
                doubt: options.share("--bounds")?,
            };
            proof.run().map(|shown| shown.said(suite))
        }
        _ => return Err(format!("--suite {suite}\n{USAGE}")),
    };
    text.map_err(|e| e.to_string())
}
