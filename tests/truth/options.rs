//! What stands after the command.

use std::path::{Path, PathBuf};

use veloid_truth::prove::begun::Register;
use veloid_truth::prove::budget::Budget;
use veloid_truth::prove::origin::Origin;
use veloid_truth::prove::seal::Seal;
use veloid_truth::suite::order::{Order, Suite};
use veloid_truth::trial::bench;

/// `--name value` pairs after the command.
pub struct Options<'a>(Vec<(&'a str, &'a str)>);

impl<'a> Options<'a> {
    pub fn read(arguments: &'a [String]) -> Result<Self, String> {
        let rest = arguments.get(1..).unwrap_or_default();
        rest.chunks(2)
            .map(|pair| match pair {
                [name, value] if name.starts_with("--") => Ok((name.as_str(), value.as_str())),
                _ => Err(format!("{}: expected --name value", pair[0])),
            })
            .collect::<Result<_, _>>()
            .map(Self)
    }

    pub fn get(&self, name: &str) -> Option<&'a str> {
        self.0.iter().find(|(n, _)| *n == name).map(|(_, v)| *v)
    }

    pub fn path(&self, name: &str) -> Result<Option<PathBuf>, String> {
        Ok(self.get(name).map(PathBuf::from))
    }

    pub fn work(&self) -> Result<PathBuf, String> {
        let given = self.path("--work")?;
        Ok(given.unwrap_or_else(|| PathBuf::from("target/proof")))
    }

    /// A percentage as a share.
    pub fn share(&self, name: &str) -> Result<Option<f64>, String> {
        let read = |text: &str| match text.parse::<f64>() {
            Ok(percent) if (0.0..=100.0).contains(&percent) => Ok(percent / 100.0),
            _ => Err(format!("{name} {text}: not a percentage")),
        };
        self.get(name).map(read).transpose()
    }

    /// How long may be begun, from now on.
    pub fn budget(&self) -> Result<Budget, String> {
        let Some(text) = self.get("--budget") else {
            return Ok(Budget::default());
        };
        Budget::from_now(text).ok_or_else(|| format!("--budget {text}: expected 90s, 15m or 2h"))
    }

    pub fn number(&self, name: &str, default: usize) -> Result<usize, String> {
        let Some(text) = self.get(name) else {
            return Ok(default);
        };
        text.parse()
            .map_err(|_| format!("{name} {text}: not a whole number"))
    }

    /// Whether nobody chose the seed.
    pub fn is_sealed(&self) -> bool {
        self.get("--seed") == Some("sealed")
    }

    /// The document, what seals the seed, and the binary.
    pub fn register(&self) -> Result<Register, String> {
        let docs = self.path("--docs")?;
        let docs = docs.ok_or("--seed sealed needs --docs PATH")?;
        let nonce = self.path("--nonce")?;
        let nonce = nonce.unwrap_or_else(|| PathBuf::from("../shared/nonce.txt"));
        let origin = Origin::of(self.path("--binary")?, &docs).map_err(|e| e.to_string())?;
        Ok(Register {
            work: self.work()?,
            seal: Seal::of(Path::new("."), &nonce).map_err(|e| e.to_string())?,
            docs,
            origin,
        })
    }

    /// What a further trial is run on, in a folder of its name.
    pub fn trial(&self, name: &str, count: &str, default: usize) -> Result<bench::Order, String> {
        let binary = self.path("--binary")?;
        Ok(bench::Order {
            binary: binary.ok_or_else(|| format!("{name} needs --binary PATH"))?,
            work: self.work()?.join(name),
            seed: self.number("--seed", 1)? as u64,
            count: self.number(count, default)? as u64,
            budget: self.budget()?,
        })
    }

    /// Of how many rides one is taken.
    pub fn one_in(&self) -> Result<usize, String> {
        match self
            .get("--sample")
            .map(|s| s.strip_prefix("1/").map(str::parse::<usize>))
        {
            None => Ok(1),
            Some(Some(Ok(n))) if n > 0 => Ok(n),
            _ => Err("--sample: expected 1/N".to_owned()),
        }
    }

    pub fn order(&self, seed: u64) -> Result<Order, String> {
        let name = self.get("--suite").unwrap_or("standard");
        let suite =
            (Suite::ALL.into_iter().find(|suite| suite.name() == name)).ok_or_else(|| {
                let names = Suite::ALL.map(Suite::name).join(", ");
                format!("--suite {name}: expected one of {names}")
            })?;
        Ok(Order {
            seed,
            one_in: self.one_in()?,
            count: self.number("--count", usize::MAX)?,
            suite,
        })
    }
}
