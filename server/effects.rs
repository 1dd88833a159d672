//! The library of effects as the command line and the pages show it.

use veloid_engine::diagnosis::effects::catalogue::{Entry, catalogue, typical};
use veloid_engine::document::format_number::significant;
use veloid_engine::report::simulation::Law;

pub struct EffectView {
    pub id: &'static str,
    /// What it is, in plain words.
    pub words: &'static str,
    /// Law, parameters, needs and the like.
    pub facts: Vec<(&'static str, String)>,
    /// False for general laws.
    pub is_named: bool,
}

pub fn library() -> Vec<EffectView> {
    catalogue().into_iter().map(EffectView::of).collect()
}

/// How to read laws and limits.
pub fn preface() -> String {
    format!(
        "d = u - z is the deflection, w = u' - z' its rate, V the speed, t the time from the first sample. Unless stated \
         otherwise, a law is a force added to the tyre's k d + B w. Limits are those of the fit for a typical bicycle, {}; they \
         depend on the ride.",
        typical()
    )
}

impl EffectView {
    fn of(entry: Entry) -> Self {
        let parameters: Vec<String> = entry.parameters.iter().map(parameter).collect();
        let others = entry.confused_with.iter();
        let others: Vec<String> = others.map(|id| id.replace('_', " ")).collect();
        let mut facts = vec![
            ("Law", entry.law.to_owned()),
            ("In exports", expressions(&entry.written)),
            ("Acts on", entry.acts.to_owned()),
            ("Parameters", parameters.join("; ")),
            ("Needs", entry.needs.join(", ")),
            ("Confused with", others.join(", ")),
            ("Source", entry.source.to_owned()),
        ];
        facts.retain(|(_, fact)| !fact.is_empty());
        Self {
            id: entry.id,
            words: entry.words,
            facts,
            is_named: entry.is_named,
        }
    }
}

/// A law as the scripts compute it.
fn expressions(law: &Law) -> String {
    let hooks = [
        ("tyre +", &law.tyre),
        ("body +", &law.body),
        ("acceleration =", &law.acceleration),
        ("shift +", &law.shift),
        ("half_window +", &law.half_window),
        ("height +", &law.height),
        ("slope +", &law.slope),
        ("delay +", &law.delay),
        ("gain *", &law.gain),
        ("offset +", &law.offset),
        ("lag +", &law.lag),
    ];
    let hooks = hooks.into_iter().filter(|(_, text)| !text.is_empty());
    let hooks = hooks.map(|(name, text)| format!("`{name} {text}`"));
    let states = law.states.iter();
    let states = states.map(|state| format!("`{}' = {}`", state.name, state.rate));
    hooks.chain(states).collect::<Vec<_>>().join("; ")
}

fn parameter((name, unit, limits): &(String, String, Option<[f64; 2]>)) -> String {
    let unit = match unit.as_str() {
        "" | "-" => String::new(),
        unit => format!(" ({unit})"),
    };
    match limits {
        Some([low, high]) => {
            let [low, high] = [low, high].map(|x| significant(*x, 3));
            format!("{name}{unit}, {low} to {high}")
        }
        None => format!("{name}{unit}"),
    }
}
