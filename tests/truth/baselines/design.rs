//! The plain terms and every candidate of one axle as columns, and the order in which they are worth taking.

use super::columns::{Group, groups};
use super::gram::{Gram, Model, to_unit};
use super::signals::Signals;
use crate::outcome::Name;
use crate::refit::fit::FITTED;

/// Effects taken at most per axle.
pub const MOST: usize = 3;
/// Contiguous parts of the fitted part.
const BLOCKS: usize = 8;

pub struct Design {
    pub groups: Vec<Group>,
    /// Columns of each group.
    index: Vec<Vec<usize>>,
    base: usize,
    pub blocks: Vec<Gram>,
    axle: usize,
}

impl Design {
    /// Regression of the acceleration on differentiated series.
    pub fn measured(s: &Signals) -> Self {
        let (k, b) = plain(s);
        let s = &Signals { k, b, ..s.clone() };
        let groups = groups(s, false);
        let mut columns = vec![s.deflection(), s.rate()];
        columns.extend(groups.iter().flat_map(|group| group.columns.clone()));
        to_unit(&mut columns);
        let rows = (s.t.len() as f64 * FITTED) as usize;
        let blocks = Gram::blocks(&columns, &target(s), 0..rows, BLOCKS);
        Self::new(groups, 2, blocks, s.axle)
    }

    pub fn new(groups: Vec<Group>, base: usize, blocks: Vec<Gram>, axle: usize) -> Self {
        let mut next = base;
        let take = |group: &Group| {
            let from = next;
            next += group.columns.len();
            (from..next).collect()
        };
        Self {
            index: groups.iter().map(take).collect(),
            groups,
            base,
            blocks,
            axle,
        }
    }

    pub fn plain(&self) -> Vec<usize> {
        (0..self.base).collect()
    }

    pub fn with(&self, subset: &[usize], group: usize) -> Vec<usize> {
        [subset, &self.index[group]].concat()
    }

    pub fn name(&self, group: usize) -> Name {
        self.groups[group].name(self.axle)
    }

    /// The effects of which a model has columns.
    pub fn names(&self, model: &Model) -> Vec<Name> {
        let has = |group: &usize| self.index[*group].iter().any(|c| model.subset.contains(c));
        let named = (0..self.groups.len()).filter(has);
        let mut names: Vec<Name> = named.map(|group| self.name(group)).collect();
        names.dedup();
        names
    }

    /// The candidate that leaves least beside a subset, of effects that are not in `names`.
    pub fn next(&self, gram: &Gram, subset: &[usize], names: &[Name]) -> Option<(usize, Model)> {
        (0..self.groups.len())
            .filter(|&group| !names.contains(&self.name(group)))
            .filter_map(|group| Some((group, gram.fit(&self.with(subset, group))?)))
            .min_by(|a, b| gram.error(&a.1).total_cmp(&gram.error(&b.1)))
    }

    /// The plain model and those with one more effect each, by what they leave.
    pub fn forward(&self, gram: &Gram) -> Vec<Model> {
        let mut path: Vec<Model> = gram.fit(&self.plain()).into_iter().collect();
        let mut names = Vec::new();
        while let Some(last) = path.last().filter(|_| path.len() <= MOST) {
            let Some((group, model)) = self.next(gram, &last.subset, &names) else {
                break;
            };
            names.push(self.name(group));
            path.push(model);
        }
        path
    }
}

/// Force that the plain terms have to explain.
fn target(s: &Signals) -> Vec<f64> {
    let pairs = s.z_bend.iter().zip(&s.force);
    pairs.map(|(a, f)| s.mass_kg * a - f).collect()
}

/// k and B by regression on d and w alone.
pub fn plain(s: &Signals) -> (f64, f64) {
    let mut columns = [s.deflection(), s.rate()];
    let scale = to_unit(&mut columns);
    let rows = (s.t.len() as f64 * FITTED) as usize;
    let fit = Gram::new(&columns, &target(s), 0..rows).fit(&[0, 1]);
    fit.map_or((1e5, 300.0), |model| {
        (
            model.coefficients[0] / scale[0],
            model.coefficients[1] / scale[1],
        )
    })
}
