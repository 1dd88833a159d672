//! `veloid-truth make | prove`: rides with concealed effects, and the proof on them.
//!
//! `prove` keeps the outcome of every ride in its work folder as it comes. Stopped in whatever way, by `--budget 15m` for
//! example, the same command goes on with the rides that are missing, and its tables say how many are in. A folder that
//! holds outcomes of another binary or seed is refused.

mod options;

use std::path::PathBuf;
use std::process::ExitCode;

use veloid_truth::prove::origin::Origin;
use veloid_truth::prove::proof::Proof;
use veloid_truth::prove::times::Times;
use veloid_truth::prove::whole::{self, Whole};
use veloid_truth::refit::known;
use veloid_truth::suite::case::Suite;
use veloid_truth::suite::files;

use options::Options;

const USAGE: &str = "usage:
  veloid-truth make --out DIR --seed N [--suite standard|clean300|beside|quiet] [--sample 1/6] [--count N]
  veloid-truth seal --seed N --docs docs/proof.md [--work target/proof]
                     writes the keys' SHA-256 into the document, to be committed alone before `prove`
  veloid-truth prove --suite all --seed N --docs docs/proof.md [--binary PATH] [--real ../shared/real] [--work target/proof]
                     everything that the document shows; without --binary builds it, in release
  veloid-truth prove --binary PATH --seed N [--suite standard|clean300|beside|quiet] [--sample 1/6] [--count N] [--docs docs/proof.md]
                     [--work target/proof] [--bounds PERCENT]   fails where a row misses its demand by more than
                     rides that meet it would in this percentage of such runs
  veloid-truth prove --suite timing|timing-slower|real --seed N --docs docs/proof.md [--binary PATH]
                     one of its sections; timing-slower on another machine
                     Each `prove` with --budget 90s|15m|2h begins no ride after that time, counted from its start; the same
                     command goes on. It fails then only where --bounds does, of the rides that are in.
                     Whatever goes into a document needs a clean tree, and keys that were sealed.
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
            let digest = files::make(&folder, &options.order()?).map_err(|e| e.to_string())?;
            println!("{digest}");
            Ok(())
        }
        Some("seal") => {
            let docs = options.path("--docs")?.ok_or("seal needs --docs PATH")?;
            let seed = options.number("--seed", 1)? as u64;
            let text = whole::seal(seed, &options.work()?, &docs).map_err(|e| e.to_string())?;
            println!("{text}");
            Ok(())
        }
        Some("prove") => {
            println!("{}", prove(&options)?);
            Ok(())
        }
        Some("refit") => {
            let folder = options.path("--rides")?.ok_or("refit needs --rides DIR")?;
            let key_path = files::key_path(&folder).map_err(|e| e.to_string())?;
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

fn prove(options: &Options) -> Result<String, String> {
    let (work, docs) = (options.work()?, options.path("--docs")?);
    let binary = options.path("--binary")?;
    let real = options.path("--real")?;
    let real = real.unwrap_or_else(|| PathBuf::from("../shared/real"));
    let budget = options.budget()?;
    let seed = options.number("--seed", 1)? as u64;
    let suite = options.get("--suite").unwrap_or("standard");
    if Suite::ALL.iter().any(|known| known.name() == suite) {
        let origin = match &docs {
            Some(docs) => Some(Origin::of(binary.clone(), docs).map_err(|e| e.to_string())?),
            None => None,
        };
        let built = origin.as_ref().map(|origin| origin.binary.clone());
        let proof = Proof {
            binary: built.or(binary).ok_or("prove needs --binary PATH")?,
            order: options.order()?,
            work,
            docs,
            origin,
            budget,
            doubt: options.share("--bounds")?,
        };
        let shown = proof.run().map_err(|e| e.to_string())?;
        return Ok(shown.said(suite));
    }
    let docs = docs.ok_or_else(|| format!("--suite {suite} needs --docs PATH"))?;
    if suite == "all" {
        let whole = Whole {
            binary,
            seed,
            work,
            docs,
            real,
            budget,
        };
        return whole.run().map_err(|e| e.to_string());
    }
    let origin = Origin::of(binary, &docs).map_err(|e| e.to_string())?;
    let text = match suite {
        "timing" | "timing-slower" => {
            let times = Times {
                origin: &origin,
                seed,
                work: &work,
                docs: &docs,
                section: suite,
                budget,
            };
            times.write().map(|shown| shown.said(suite))
        }
        "real" => whole::recordings(&origin, &real, &work, &docs),
        _ => return Err(format!("--suite {suite}\n{USAGE}")),
    };
    text.map_err(|e| e.to_string())
}
