//! What stands after the command.

use std::path::PathBuf;

use veloid_truth::prove::budget::Budget;
use veloid_truth::suite::case::Suite;
use veloid_truth::suite::files::Order;

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

    pub fn order(&self) -> Result<Order, String> {
        let one_in = match self
            .get("--sample")
            .map(|s| s.strip_prefix("1/").map(str::parse::<usize>))
        {
            None => 1,
            Some(Some(Ok(n))) if n > 0 => n,
            _ => return Err("--sample: expected 1/N".to_owned()),
        };
        let name = self.get("--suite").unwrap_or("standard");
        let suite = (Suite::ALL.into_iter().find(|suite| suite.name() == name))
            .ok_or_else(|| format!("--suite {name}: standard, clean300, beside or quiet"))?;
        Ok(Order {
            seed: self.number("--seed", 1)? as u64,
            one_in,
            count: self.number("--count", usize::MAX)?,
            suite,
        })
    }
}
