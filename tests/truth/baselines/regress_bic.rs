//! Differentiate the recording, regress the acceleration on library terms, choose by BIC, forward.

use super::columns::groups;
use super::gram::Gram;
use super::signals::Signals;
use crate::prove::outcome::Name;

/// Effects taken at most per axle.
const MOST: usize = 3;

/// Force that the plain terms have to explain.
fn target(s: &Signals) -> Vec<f64> {
    s.z_bend
        .iter()
        .zip(&s.force)
        .map(|(a, f)| s.mass_kg * a - f)
        .collect()
}

/// k and B by regression on d and w alone.
pub fn plain(s: &Signals) -> (f64, f64) {
    let gram = Gram::new(&[s.deflection(), s.rate()], &target(s));
    gram.fit(&[0, 1]).map_or((1e5, 300.0), |(c, _)| {
        (c[0] / gram.scale(0), c[1] / gram.scale(1))
    })
}

pub fn choose(s: &Signals) -> Vec<Name> {
    let (k, b) = plain(s);
    let s = &Signals { k, b, ..s.clone() };
    let groups = groups(s, false);
    let mut columns = vec![s.deflection(), s.rate()];
    let mut index = Vec::new();
    for group in &groups {
        index.push((columns.len()..columns.len() + group.columns.len()).collect::<Vec<_>>());
        columns.extend(group.columns.iter().cloned());
    }
    let gram = Gram::new(&columns, &target(s));
    let n = gram.rows as f64;
    let bic = |subset: &[usize]| {
        gram.fit(subset)
            .map(|(_, rss)| n * (rss / n).ln() + subset.len() as f64 * n.ln())
    };
    let mut subset = vec![0, 1];
    let mut names: Vec<Name> = Vec::new();
    let Some(mut best) = bic(&subset) else {
        return names;
    };
    while names.len() < MOST {
        let with = |i: usize| [subset.clone(), index[i].clone()].concat();
        let next = (0..groups.len())
            .filter(|&i| !names.contains(&groups[i].name(s.axle)))
            .filter_map(|i| Some((i, bic(&with(i))?)))
            .min_by(|a, b| a.1.total_cmp(&b.1));
        match next {
            Some((i, score)) if score < best => {
                best = score;
                subset = with(i);
                names.push(groups[i].name(s.axle));
            }
            _ => break,
        }
    }
    names
}
