//! The table of a trial without a road.

use super::class::Class;
use super::demand::{Demand, judged};
use super::mark::Mark;
use super::plan::SHOWN;
use super::score::Outcome;
use crate::simulate::effect::Effect;
use crate::trial::coverage::Covered;
use crate::trial::share::Share;

const HEAD: &str = "\
| class | rides | right | wrong | silent | demanded |
|---|---|---|---|---|---|
";

/// Share of named effects that must be on the right axle.
const AXLE: f64 = 0.98;
/// Between which shares 95 % intervals must contain the truth.
const COVERED: [f64; 2] = [0.90, 0.98];

/// The outcomes of rides with their classes, as a table and a line for each that is wrong.
pub fn table(outcomes: &[(Class, Outcome)]) -> String {
    let of = |is: &dyn Fn(Class) -> bool| -> Vec<&Outcome> {
        let found = outcomes.iter().filter(|(class, _)| is(*class));
        found.map(|(_, outcome)| outcome).collect()
    };
    let mut text = HEAD.to_owned();
    for class in Class::ALL {
        text += &marks(class.words(), &of(&|c| c == class), class.demand());
    }
    let effects = of(&Class::has_one_effect);
    for kind in SHOWN {
        let is =
            |o: &&&Outcome| Effect::from_json(&o.key["effects"][0]).is_some_and(|e| e.kind == kind);
        let own: Vec<&Outcome> = effects.iter().filter(is).copied().collect();
        text += &marks(
            &format!("of the effects: {}", kind.id()),
            &own,
            Demand::default(),
        );
    }
    text += &axle(&effects);
    let named: Vec<&Outcome> = effects.into_iter().filter(|o| o.is_named).collect();
    text += &coverage("clean", &of(&Class::is_clean_bicycle));
    text += &coverage("a named effect", &named);
    text += &coverage("an absorbed effect", &of(&|c| c == Class::Absorbed));
    text + &wrong(outcomes)
}

/// How many rides are right, wrong, neither.
fn marks(words: &str, outcomes: &[&Outcome], demand: Demand) -> String {
    let count = |mark| outcomes.iter().filter(|o| o.mark == mark).count();
    let of = outcomes.len();
    let share = |count| Share { count, of };
    let withheld = count(Mark::Withheld);
    let right = share(count(Mark::Right) + withheld);
    let wrong = share(count(Mark::Wrong));
    let counted = match withheld {
        0 => right.to_string(),
        _ => format!("{right}; {withheld} of them without a verdict"),
    };
    let silent = count(Mark::Silent);
    format!(
        "| {words} | {of} | {counted} | {wrong} | {silent} | {} |\n",
        demand.judged(right, wrong)
    )
}

/// Of rides of which something is named.
fn axle(effects: &[&Outcome]) -> String {
    let right = Share::of(effects.iter().filter_map(|o| o.axle));
    let wrong = rest(right);
    let demand = Demand {
        right: Some(AXLE),
        wrong: None,
    };
    format!(
        "| axle of a named effect | {} | {right} | {wrong} | | {} |\n",
        right.of,
        demand.judged(right, wrong)
    )
}

/// Two rows, of k and B, whose columns count intervals; those that are withheld are silent.
fn coverage(of: &str, outcomes: &[&Outcome]) -> String {
    let mut all = Covered::default();
    outcomes.iter().for_each(|o| all.add(&o.covered));
    let row = |quantity: &str, answers: &[Option<bool>]| {
        let right = Share::of(answers.iter().flatten().copied());
        let wrong = rest(right);
        format!(
            "| 95 % intervals of {quantity}, {of} | {} | {right} | {wrong} | {} | {} |\n",
            answers.len(),
            answers.len() - right.of,
            judged("90 to 98 %", right, COVERED)
        )
    };
    row("k", &all.stiffness) + &row("B", &all.damping)
}

fn rest(share: Share) -> Share {
    Share {
        count: share.of - share.count,
        ..share
    }
}

/// A line for each ride that is wrong.
fn wrong(outcomes: &[(Class, Outcome)]) -> String {
    let one = |(class, outcome): &(Class, Outcome)| {
        let ride = outcome.key["ride"].as_str().unwrap_or_default();
        let k = match outcome.covered.stiffness.contains(&Some(false)) {
            true => "; an interval of k leaves out the truth",
            false => "",
        };
        let (truth, said) = (truth(outcome), &outcome.said);
        format!("\n- {ride} ({}): {truth}; said {said}{k}", class.words())
    };
    let wrong = outcomes.iter().filter(|(_, o)| o.mark == Mark::Wrong);
    wrong.map(one).collect()
}

fn truth(outcome: &Outcome) -> String {
    let effects = outcome.key["effects"].as_array().into_iter().flatten();
    let all = effects.chain([&outcome.key["outside"]]);
    let words: Vec<String> = all
        .filter_map(|e| Some(format!("{} {}", e["id"].as_str()?, e["axle"].as_str()?)))
        .collect();
    match words.is_empty() {
        true => "clean".to_owned(),
        false => words.join(" and "),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn outcome(mark: Mark, id: &str, covered: bool) -> Outcome {
        Outcome {
            mark,
            is_named: true,
            axle: Some(mark == Mark::Right),
            said: "named x rear".to_owned(),
            covered: Covered {
                stiffness: vec![Some(covered), None],
                damping: vec![Some(true); 2],
            },
            key: json!({"ride": "ride_007", "effects": [
                {"id": id, "axle": "front", "parameters": {"friction": 1.0}}]}),
        }
    }

    fn row<'a>(text: &'a str, words: &str) -> &'a str {
        let begins = format!("| {words} |");
        let found = text.lines().find(|line| line.starts_with(&begins));
        found.unwrap_or_else(|| panic!("{words} is not in\n{text}"))
    }

    #[test]
    fn rows_count_marks_and_say_whether_demands_are_met() {
        let friction = |mark, covered| (Class::Effect, outcome(mark, "coulomb_friction", covered));
        let mut all = vec![friction(Mark::Right, true); 9];
        let met = table(&all);
        assert!(row(&met, Class::Effect.words()).contains("| 9 | 9 of 9, 100.0 %"));
        assert!(row(&met, Class::Effect.words()).ends_with("wrong at most 2 %: met |"));
        assert!(row(&met, Class::Clean.words()).ends_with("| right 97 % |"));
        all.push(friction(Mark::Wrong, false));
        let text = table(&all);
        assert!(
            row(&text, Class::Effect.words())
                .ends_with("wrong at most 2 %: not met, within chance |")
        );
        assert!(row(&text, "of the effects: coulomb_friction").contains("| 10 | 9 of 10"));
        assert!(
            row(&text, "axle of a named effect").ends_with("right 98 %: not met, within chance |")
        );
        let k = row(&text, "95 % intervals of k, a named effect");
        assert!(
            k.contains("| 20 | 9 of 10") && k.contains("| 10 | 90 to 98 %: met |"),
            "{k}"
        );
        let last = text.lines().last().unwrap_or_default();
        assert_eq!(
            last,
            "- ride_007 (an effect, tracks within 1 cm): coulomb_friction front; said named x rear; \
             an interval of k leaves out the truth"
        );
    }

    #[test]
    fn withheld_verdicts_are_right_and_counted_apart() {
        let marks = [
            Mark::Right,
            Mark::Withheld,
            Mark::Silent,
            Mark::Silent,
            Mark::Silent,
        ];
        let text = table(&marks.map(|mark| (Class::Clean, outcome(mark, "", true))));
        let row = row(&text, Class::Clean.words());
        let counted = "2 of 5, 40.0 % (5.3 to 85.3); 1 of them without a verdict";
        assert!(row.contains(counted), "{row}");
        assert!(row.ends_with("| 3 | right 97 %: not met |"), "{row}");
    }
}
