//! Rides by what is known of them, and jobs by their results.

/// What is asked for; nothing means any.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Search {
    /// Facts in words and a part of each, capitals or not.
    pub texts: Vec<(&'static str, String)>,
    /// Facts that are numbers.
    pub numbers: Vec<(String, Range)>,
    /// Results by axle and name.
    pub results: Vec<(&'static str, &'static str, Range)>,
}

/// Numbers from one to another, both of them included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    pub from: f64,
    pub to: f64,
}

/// Adds the conditions of a search to a query over jobs and their rides; both databases read the same text.
macro_rules! search {
    ($query:ident, $search:expr) => {
        for (fact, part) in &$search.texts {
            $query.push(" AND REPLACE(LOWER(ride.facts ->> ").push_bind(*fact);
            $query.push("), LOWER(").push_bind(part);
            $query.push("), '') <> LOWER(ride.facts ->> ").push_bind(*fact).push(")");
        }
        for (fact, range) in &$search.numbers {
            $query.push(" AND CAST(ride.facts ->> ").push_bind(fact);
            $query.push(" AS DOUBLE PRECISION) BETWEEN ").push_bind(range.from);
            $query.push(" AND ").push_bind(range.to);
        }
        for (axle, name, range) in &$search.results {
            $query.push(" AND EXISTS (SELECT 1 FROM parameter WHERE job_id = job.id AND method = 'result' AND axle = ");
            $query.push_bind(*axle).push(" AND parameter.name = ").push_bind(*name);
            $query.push(" AND value BETWEEN ").push_bind(range.from);
            $query.push(" AND ").push_bind(range.to).push(")");
        }
    };
}
pub(super) use search;
