use std::sync::Mutex;
use std::time::{Duration, Instant};

use veloid_engine::{Progress, Settings};

/// How often the search is spoken of.
const EVERY: Duration = Duration::from_secs(1);

/// Tells stderr how far it is.
pub struct ProgressLine {
    begin: Instant,
    trials: usize,
    iterations: usize,
    done: Mutex<usize>,
    /// When the search was last spoken of.
    spoke: Mutex<Instant>,
}

impl ProgressLine {
    pub fn new(settings: &Settings) -> Self {
        Self {
            begin: Instant::now(),
            trials: settings.trials,
            iterations: settings.iterations,
            done: Mutex::new(0),
            spoke: Mutex::new(Instant::now()),
        }
    }
}

impl Progress for ProgressLine {
    fn stage(&self, name: &str) {
        eprintln!("{:7.2} s  {name}", self.begin.elapsed().as_secs_f64());
    }

    fn iteration(&self, trial: usize, iteration: usize, best_cost: f64) {
        if iteration + 1 < self.iterations {
            return;
        }
        if let Ok(mut done) = self.done.lock() {
            *done += 1;
            eprintln!(
                "{:7.2} s  trial {trial}: best cost {best_cost:.6e} ({done} of {})",
                self.begin.elapsed().as_secs_f64(),
                self.trials
            );
        }
    }

    fn searched(&self, steps: u64, budget: u64) {
        let Ok(mut spoke) = self.spoke.lock() else {
            return;
        };
        if spoke.elapsed() > EVERY {
            *spoke = Instant::now();
            eprintln!(
                "{:7.2} s  searched {:.1} of at most {:.1} million steps",
                self.begin.elapsed().as_secs_f64(),
                1e-6 * steps as f64,
                1e-6 * budget as f64
            );
        }
    }
}
