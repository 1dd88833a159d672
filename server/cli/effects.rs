use std::io::Write;

use clap::Args;

use super::CliError;
use crate::effects::{EffectView, library, preface};
use crate::pages::words::title;

/// Prints the diagnosis's library of effects as Markdown.
#[derive(Args)]
pub struct Effects {}

impl Effects {
    pub fn run(self) -> Result<(), CliError> {
        let (named, general): (Vec<_>, Vec<_>) = library().into_iter().partition(|e| e.is_named);
        writeln!(
            std::io::stdout(),
            "# Effects\n\n\
             The effects that the diagnosis can name, one file each in `engine/model/effects/`. This page is the output of \
             `veloid effects`, checked by a test; every server shows it under `/effects`.\n\n{}\n{}\n\
             # General laws\n\nNever named: general shapes that the named effects are compared with.\n{}",
            preface(),
            sections(&named),
            sections(&general).trim_end()
        )?;
        Ok(())
    }
}

fn sections(effects: &[EffectView]) -> String {
    let section = |effect: &EffectView| {
        let fact = |(what, fact): &(&str, String)| match *what {
            "Law" => format!("- {what}: `{fact}`\n"),
            _ => format!("- {what}: {fact}\n"),
        };
        let facts: String = effect.facts.iter().map(fact).collect();
        format!("\n## {}\n\n{}.\n\n{facts}", effect.id, title(effect.words))
    };
    effects.iter().map(section).collect()
}
