//! Figures as a table of Markdown, as docs/performance.md holds it.

use std::fmt;

use serde::Serialize;
use veloid_engine::document::format_number::significant;

use super::figure::Figure;
use super::machine::Machine;

/// Everything that was measured.
#[derive(Serialize)]
pub struct Figures {
    pub veloid: &'static str,
    /// Commit of the build, where somebody said it.
    pub commit: Option<String>,
    /// Day of the measurement (UTC).
    pub date: String,
    pub machine: Machine,
    pub figures: Vec<Figure>,
}

impl fmt::Display for Figures {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.commit {
            Some(commit) => write!(f, "Commit `{commit}`")?,
            None => write!(f, "veloid {}", self.veloid)?,
        }
        writeln!(f, ", {}, {}\n", self.date, self.machine)?;
        writeln!(f, "| figure | median | best to worst | unit | runs |")?;
        writeln!(f, "|---|---|---|---|---|")?;
        for figure in &self.figures {
            let [median, best, worst] =
                [figure.median, figure.best, figure.worst].map(|value| significant(value, 3));
            let (name, unit, runs) = (&figure.name, figure.unit, figure.runs);
            writeln!(
                f,
                "| {name} | {median} | {best} to {worst} | {unit} | {runs} |"
            )?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use super::*;

    #[test]
    fn a_table_says_commit_and_day() {
        let times = [6.94, 5.77, 7.73].map(|ms| Duration::from_secs_f64(ms / 1e3));
        let figures = Figures {
            veloid: "0.1.0",
            commit: Some("38c913b".to_owned()),
            date: "2026-11-24".to_owned(),
            machine: Machine::this(),
            figures: vec![Figure::time("upload to 202", &times)],
        };
        let text = figures.to_string();
        assert!(text.starts_with("Commit `38c913b`, 2026-11-24, "), "{text}");
        let row = "| upload to 202 | 6.94 | 5.77 to 7.73 | ms | 3 |\n";
        assert!(text.ends_with(row), "{text}");
    }
}
