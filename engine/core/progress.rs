//! How whoever asked for an identification hears of it.

/// Hears how an identification advances and may stop it. Called from several threads.
pub trait Progress: Sync {
    /// A stage begins: `observe`, `trials`, `conclude` or `diagnose`.
    fn stage(&self, _name: &str) {}
    /// A swarm iteration is done.
    fn iteration(&self, _trial: usize, _iteration: usize, _best_cost: f64) {}
    /// The search for missing physics has taken so many of the steps that it may take (see `Settings::search_budget`).
    fn searched(&self, _steps: u64, _budget: u64) {}
    /// Asked at least once per swarm iteration and per fit of the diagnosis.
    fn cancelled(&self) -> bool {
        false
    }
}

/// Hears nothing, stops nothing.
pub struct Silent;

impl Progress for Silent {}
