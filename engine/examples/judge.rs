//! Reads verdicts from stored scores, by the numbers of the table or by others, and counts how often experts agree:
//!
//! ```text
//! veloid identify RIDE --bike BIKE --scores scores.json
//! cargo run --example judge -- FOLDER [support=0.8] [share=0.3]
//! ```
//!
//! FOLDER holds the files of `tests/rigs/sweep.py --scores`: `name`, `part`, the ids `expected` and `acceptable`, and `scores`.

use std::collections::BTreeMap;
use std::error::Error;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use veloid_engine::bicycle::PerAxle;
use veloid_engine::diagnosis::judge::numbers::Numbers;
use veloid_engine::diagnosis::judge::scores::Scores;
use veloid_engine::diagnosis::judge::table::{Judgement, Rule, judge};

#[derive(Deserialize)]
struct Kept {
    name: String,
    part: [f64; 2],
    expected: Vec<String>,
    acceptable: Vec<String>,
    scores: Option<PerAxle<Scores>>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let folder = arguments
        .next()
        .ok_or("usage: judge FOLDER [number=value]")?;
    let mut numbers = Numbers::default();
    for argument in arguments {
        set(&mut numbers, &argument)?;
    }
    let mut tally = BTreeMap::<(&str, &str), usize>::new();
    for file in files(Path::new(&folder))? {
        let kept: Kept = serde_json::from_slice(&std::fs::read(&file)?)?;
        let Some(scores) = kept
            .scores
            .as_ref()
            .and_then(|scores| scores.front.as_ref())
        else {
            continue;
        };
        let judgement = judge(scores, &numbers);
        let answer = answer(&kept, scores, &judgement);
        let part = if kept.part == [0.0, 1.0] {
            "whole"
        } else {
            "cut"
        };
        *tally.entry((part, answer)).or_default() += 1;
        println!(
            "{answer:6} {} {:?} {}",
            kept.name,
            kept.part,
            words(scores, &judgement)
        );
    }
    println!("{tally:?}");
    Ok(())
}

fn set(numbers: &mut Numbers, argument: &str) -> Result<(), Box<dyn Error>> {
    let (name, value) = argument.split_once('=').ok_or("expected number=value")?;
    let number = match name {
        "support" => &mut numbers.support,
        "share" => &mut numbers.share,
        "strict_share" => &mut numbers.strict_share,
        "nameless_share" => &mut numbers.nameless_share,
        "floor" => &mut numbers.floor,
        "patience" => &mut numbers.patience,
        "occam" => &mut numbers.occam,
        "quiet" => &mut numbers.quiet,
        "outgrows" => &mut numbers.outgrows,
        _ => return Err(format!("no number {name}").into()),
    };
    *number = value.parse()?;
    Ok(())
}

fn files(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let entries = std::fs::read_dir(folder)?.map(|entry| Ok(entry?.path()));
    let mut files: Vec<PathBuf> = entries.collect::<std::io::Result<_>>()?;
    files.retain(|file| file.extension().is_some_and(|ending| ending == "json"));
    files.sort();
    Ok(files)
}

/// As ../shared/real/sweep.py counts: a tie is right where one of its sets is.
fn answer(kept: &Kept, scores: &Scores, judgement: &Judgement) -> &'static str {
    let nothing = matches!(judgement.rule, Rule::NothingMissed | Rule::NoiseLeft);
    let says = |id: &str| kept.expected.iter().any(|expected| expected == id);
    let may = |id: &str| says(id) || kept.acceptable.iter().any(|other| other == id);
    let ids = |set: &Vec<usize>| set.iter().map(|e| scores.effects[*e].clone()).collect();
    let sets: Vec<Vec<String>> = sets(judgement).iter().map(ids).collect();
    let none = sets.is_empty() && kept.expected.is_empty();
    let fits = |set: &Vec<String>| set.iter().all(|id| may(id)) && set.iter().any(|id| says(id));
    if nothing && says("nothing_missing") || none || sets.iter().any(fits) {
        "right"
    } else if !sets.is_empty() && sets.iter().all(|set| !set.iter().all(|id| may(id))) {
        "wrong"
    } else {
        "missed"
    }
}

/// The named effects, or the tied sets.
fn sets(judgement: &Judgement) -> Vec<Vec<usize>> {
    match judgement.rule {
        Rule::Supported => vec![judgement.named.clone()],
        _ => judgement.sets.clone(),
    }
}

fn words(scores: &Scores, judgement: &Judgement) -> String {
    let name = |e: &usize| {
        let support = &judgement.supports[*e];
        let share = support.share.iter().copied().fold(f64::INFINITY, f64::min);
        format!(
            "{} (weight {:.2}, share {share:.2})",
            scores.effects[*e], support.weight
        )
    };
    let set = |set: &Vec<usize>| set.iter().map(name).collect::<Vec<_>>().join(" + ");
    let sets: Vec<String> = sets(judgement).iter().map(set).collect();
    format!("{:?} {}", judgement.rule, sets.join(" | "))
}
