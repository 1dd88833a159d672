//! `veloid-truth make | prove`: rides with concealed effects, and the proof on them.

use std::path::PathBuf;
use std::process::ExitCode;

use veloid_truth::prove::origin::Origin;
use veloid_truth::prove::proof::Proof;
use veloid_truth::prove::whole::{self, Whole};
use veloid_truth::refit::known;
use veloid_truth::suite::files::{self, Order};

const USAGE: &str = "usage:
  veloid-truth make --out DIR --seed N [--suite standard|clean300] [--sample 1/6] [--count N]
  veloid-truth seal --seed N --docs docs/proof.md [--work target/proof]
                     writes the keys' SHA-256 into the document, to be committed alone before `prove`
  veloid-truth prove --suite all --seed N --docs docs/proof.md [--binary PATH] [--real ../shared/real] [--work target/proof]
                     everything that the document shows; without --binary builds it, in release
  veloid-truth prove --binary PATH --seed N [--suite standard|clean300] [--sample 1/6] [--count N] [--docs docs/proof.md]
                     [--work target/proof] [--bounds PERCENT]   fails where a row misses its demand by more than
                     rides that meet it would in this percentage of such runs
  veloid-truth prove --suite timing|timing-slower|real --seed N --docs docs/proof.md [--binary PATH]
                     one of its sections; timing-slower on another machine
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
    let seed = options.number("--seed", 1)? as u64;
    let suite = options.get("--suite").unwrap_or("standard");
    if ["standard", "clean300"].contains(&suite) {
        let origin = match docs {
            Some(_) => Some(Origin::of(binary.clone()).map_err(|e| e.to_string())?),
            None => None,
        };
        let built = origin.as_ref().map(|origin| origin.binary.clone());
        let proof = Proof {
            binary: built.or(binary).ok_or("prove needs --binary PATH")?,
            order: options.order()?,
            work,
            docs,
            origin,
            doubt: options.share("--bounds")?,
        };
        return proof.run().map_err(|e| e.to_string());
    }
    let docs = docs.ok_or_else(|| format!("--suite {suite} needs --docs PATH"))?;
    if suite == "all" {
        let whole = Whole {
            binary,
            seed,
            work,
            docs,
            real,
        };
        return whole.run().map_err(|e| e.to_string());
    }
    let origin = Origin::of(binary).map_err(|e| e.to_string())?;
    let text = match suite {
        "timing" | "timing-slower" => whole::timing(&origin, seed, &work, &docs, suite),
        "real" => whole::recordings(&origin, &real, &work, &docs),
        _ => return Err(format!("--suite {suite}\n{USAGE}")),
    };
    text.map_err(|e| e.to_string())
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

    fn work(&self) -> Result<PathBuf, String> {
        let given = self.path("--work")?;
        Ok(given.unwrap_or_else(|| PathBuf::from("target/proof")))
    }

    /// A percentage as a share.
    fn share(&self, name: &str) -> Result<Option<f64>, String> {
        let read = |text: &str| match text.parse::<f64>() {
            Ok(percent) if (0.0..=100.0).contains(&percent) => Ok(percent / 100.0),
            _ => Err(format!("{name} {text}: not a percentage")),
        };
        self.get(name).map(read).transpose()
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
