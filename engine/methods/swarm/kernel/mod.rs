//! The swarm's cost, many particles at a time: the same sums as the plain form of `straight.rs`, with
//! particles in the lanes of vectors and one pass over the record for all three errors.

mod block;
mod correlations;
mod differences;
mod lags;
mod lanes;
mod states;
mod streams;

use super::target::Target;
use block::{MOST_LANES, SIDE_BY_SIDE};
use differences::Differences;
use lags::Lags;
use lanes::Lanes;
use states::States;
use veloid_core::settings::Objective;

/// One axle's cost, ready for many particles.
#[derive(Clone, Debug)]
pub struct Kernel {
    form: Form,
    width: Width,
}

#[derive(Clone, Debug)]
enum Form {
    Differences(Differences, Option<Lags>),
    States(States),
}

/// An instruction set with vectors of f64.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Width {
    Scalar,
    #[cfg(target_arch = "x86_64")]
    Avx2,
    #[cfg(target_arch = "x86_64")]
    Avx512,
    #[cfg(target_arch = "aarch64")]
    Neon,
}

impl Width {
    /// What this processor has, the widest last.
    pub fn available() -> Vec<Self> {
        let mut widths = vec![Self::Scalar];
        #[cfg(target_arch = "x86_64")]
        {
            if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
                widths.push(Self::Avx2);
            }
            if is_x86_feature_detected!("avx512f") {
                widths.push(Self::Avx512);
            }
        }
        #[cfg(target_arch = "aarch64")]
        if std::arch::is_aarch64_feature_detected!("neon") {
            widths.push(Self::Neon);
        }
        widths
    }

    pub fn widest() -> Self {
        Self::available().pop().unwrap_or(Self::Scalar)
    }
}

impl Kernel {
    /// `width` must be one of [`Width::available`].
    pub fn new(target: &Target, width: Width) -> Self {
        assert!(
            Width::available().contains(&width),
            "{width:?} on this processor"
        );
        let form = match target.objective {
            Objective::Consistent => Form::Differences(Differences::new(target), None),
            Objective::Paper | Objective::Gradient => Form::States(States::new(target)),
        };
        Self { form, width }
    }

    /// Takes the record's lagged products, where that makes costs cheaper; `middle`: parameters about which
    /// the particles will be.
    pub fn with_lags(mut self, middle: [f64; 3]) -> Self {
        if let Form::Differences(form, lags) = &mut self.form {
            *lags = Lags::new(form, middle);
        }
        self
    }

    /// Adds J_i of paper eq. (25) to the cost of every particle, `thetas` = [k/m, B/m, 1/m].
    pub fn add_costs(&self, thetas: &[[f64; 3]], costs: &mut [f64]) {
        match self.width {
            Width::Scalar => self.run::<f64>(thetas, costs),
            // SAFETY: `new` has made sure that this processor has the instruction set.
            #[cfg(target_arch = "x86_64")]
            Width::Avx2 => unsafe { self.run_avx2(thetas, costs) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Width::Avx512 => unsafe { self.run_avx512(thetas, costs) },
            // SAFETY: as above.
            #[cfg(target_arch = "aarch64")]
            Width::Neon => unsafe { self.run_neon(thetas, costs) },
        }
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx2,fma")]
    fn run_avx2(&self, thetas: &[[f64; 3]], costs: &mut [f64]) {
        self.run::<std::arch::x86_64::__m256d>(thetas, costs);
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx512f")]
    fn run_avx512(&self, thetas: &[[f64; 3]], costs: &mut [f64]) {
        self.run::<std::arch::x86_64::__m512d>(thetas, costs);
    }

    #[cfg(target_arch = "aarch64")]
    #[target_feature(enable = "neon")]
    fn run_neon(&self, thetas: &[[f64; 3]], costs: &mut [f64]) {
        self.run::<std::arch::aarch64::float64x2_t>(thetas, costs);
    }

    #[inline(always)]
    fn run<L: Lanes>(&self, thetas: &[[f64; 3]], costs: &mut [f64]) {
        let block = L::WIDTH * SIDE_BY_SIDE;
        if let Form::Differences(form, Some(lags)) = &self.form {
            return self.run_by_lags::<L>(form, lags, thetas, costs);
        }
        for (thetas, costs) in thetas.chunks(block).zip(costs.chunks_mut(block)) {
            let found = match &self.form {
                Form::Differences(form, _) => form.costs::<L>(thetas),
                Form::States(form) => form.costs::<L>(thetas),
            };
            for (cost, found) in costs.iter_mut().zip(found) {
                *cost += found;
            }
        }
    }

    /// Particles of like memory go together; those that remember too much go through the record.
    #[inline(always)]
    fn run_by_lags<L: Lanes>(
        &self,
        form: &Differences,
        lags: &Lags,
        thetas: &[[f64; 3]],
        costs: &mut [f64],
    ) {
        let mut order: Vec<(Option<usize>, usize)> = (thetas.iter().enumerate())
            .map(|(i, theta)| (lags.memory(form, *theta), i))
            .collect();
        order.sort_unstable();
        let short = order.partition_point(|(memory, _)| memory.is_none());
        let (through, by_lags) = order.split_at(short);
        let block = L::WIDTH * SIDE_BY_SIDE;
        for chunk in through.chunks(block).chain(by_lags.chunks(block)) {
            let mut of = [[0.0; 3]; MOST_LANES];
            for (of, (_, i)) in of.iter_mut().zip(chunk) {
                *of = thetas[*i];
            }
            let of = &of[..chunk.len()];
            let found = match chunk[chunk.len() - 1].0 {
                Some(memory) => lags.costs::<L>(form, of, memory),
                None => form.costs::<L>(of),
            };
            for ((_, i), found) in chunk.iter().zip(found) {
                costs[*i] += found;
            }
        }
    }
}

#[cfg(test)]
mod tests;
