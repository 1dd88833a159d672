//! `veloid-truth make | prove`: rides with concealed effects, and the proof on them.

use std::path::PathBuf;
use std::process::ExitCode;

use veloid_truth::prove::proof::Proof;
use veloid_truth::refit::known;
use veloid_truth::suite::files::{self, Order};

const USAGE: &str = "usage:
  veloid-truth make --out DIR --seed N [--suite standard|clean300] [--sample 1/6] [--count N]
  veloid-truth prove --binary PATH --seed N [--suite ..] [--sample 1/6] [--count N] [--docs docs/proof.md] [--work target/proof]
                     [--key-sha256 HEX]   refuses to run unless the key has the hash that was committed
                     [--least-right PERCENT] fails if fewer of the judged rides are right
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
        Some("prove") => {
            let proof = Proof {
                binary: options
                    .path("--binary")?
                    .ok_or("prove needs --binary PATH")?,
                order: options.order()?,
                work: options
                    .path("--work")?
                    .unwrap_or_else(|| PathBuf::from("target/proof")),
                docs: options.path("--docs")?,
                committed: options.get("--key-sha256").map(str::to_owned),
                least_right: options.number("--least-right", 0)?,
            };
            println!("{}", proof.run().map_err(|e| e.to_string())?);
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

/// `--name value` pairs after the command.
struct Options<'a>(Vec<(&'a str, &'a str)>);

impl<'a> Options<'a> {
    fn read(arguments: &'a [String]) -> Result<Self, String> {
        let rest = arguments.get(1..).unwrap_or_default();
        rest.chunks(2)
            .map(|pair| match pair {
                [name, value] if name.starts_with("--") => Ok((name.as_str(), value.as_str())),
                _ => Err(format!("{}: expected --name value\n{USAGE}", pair[0])),
            })
            .collect::<Result<_, _>>()
            .map(Self)
    }

    fn get(&self, name: &str) -> Option<&'a str> {
        self.0.iter().find(|(n, _)| *n == name).map(|(_, v)| *v)
    }

    fn path(&self, name: &str) -> Result<Option<PathBuf>, String> {
        Ok(self.get(name).map(PathBuf::from))
    }

    fn number(&self, name: &str, default: usize) -> Result<usize, String> {
        let Some(text) = self.get(name) else {
            return Ok(default);
        };
        text.parse()
            .map_err(|_| format!("{name} {text}: not a whole number"))
    }

    fn order(&self) -> Result<Order, String> {
        let one_in = match self
            .get("--sample")
            .map(|s| s.strip_prefix("1/").map(str::parse::<usize>))
        {
            None => 1,
            Some(Some(Ok(n))) if n > 0 => n,
            _ => return Err("--sample: expected 1/N".to_owned()),
        };
        let clean300 = match self.get("--suite") {
            None | Some("standard") => false,
            Some("clean300") => true,
            Some(other) => return Err(format!("--suite {other}: standard or clean300")),
        };
        Ok(Order {
            seed: self.number("--seed", 1)? as u64,
            one_in,
            count: self.number("--count", usize::MAX)?,
            clean300,
        })
    }
}
