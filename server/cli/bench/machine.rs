use std::fmt;

use serde::Serialize;

use crate::cli::worker::cores;

/// The machine on which something was measured.
#[derive(Serialize)]
pub struct Machine {
    processor: String,
    cores: usize,
    memory_gib: Option<f64>,
    system: String,
    vectors: &'static str,
    optimised: bool,
    /// Load of the last minute, in processes, before the measurement.
    load: Option<f64>,
}

impl Machine {
    pub fn this() -> Self {
        let read = |path| std::fs::read_to_string(path).unwrap_or_default();
        let after = |text: &str, key: &str| {
            let line = text.lines().find(|line| line.starts_with(key))?;
            Some(line.split_once(':')?.1.trim().to_owned())
        };
        let memory_kib = after(&read("/proc/meminfo"), "MemTotal").and_then(|text| {
            let number: f64 = text.split_whitespace().next()?.parse().ok()?;
            Some(number)
        });
        Self {
            processor: after(&read("/proc/cpuinfo"), "model name")
                .unwrap_or_else(|| std::env::consts::ARCH.to_owned()),
            cores: cores(),
            memory_gib: memory_kib.map(|kib| (kib / 1024.0 / 1024.0 * 10.0).round() / 10.0),
            system: format!(
                "{} {}",
                std::env::consts::OS,
                read("/proc/sys/kernel/osrelease").trim()
            ),
            vectors: vectors(),
            optimised: !cfg!(debug_assertions),
            load: read("/proc/loadavg")
                .split_whitespace()
                .next()
                .and_then(|load| load.parse().ok()),
        }
    }
}

/// Time (s) that a process has spent on all cores, where `/proc` shows.
pub fn processor_time(process: u32) -> Option<f64> {
    let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    // The name, in brackets, may hold anything.
    let fields = stat.rsplit_once(')')?.1.split_whitespace();
    let ticks = fields.skip(11).take(2).map(str::parse::<u64>);
    let ticks = ticks.collect::<Result<Vec<_>, _>>().ok()?;
    let per_second = rustix::param::clock_ticks_per_second();
    Some(ticks.iter().sum::<u64>() as f64 / per_second as f64)
}

fn vectors() -> &'static str {
    #[cfg(target_arch = "x86_64")]
    {
        if is_x86_feature_detected!("avx512f") {
            return "AVX-512";
        }
        if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
            return "AVX2";
        }
    }
    if cfg!(target_arch = "aarch64") {
        "NEON"
    } else {
        "none"
    }
}

impl fmt::Display for Machine {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{}, {} cores, {}, {}",
            self.processor, self.cores, self.vectors, self.system
        )?;
        if let Some(gib) = self.memory_gib {
            write!(f, ", {gib} GiB")?;
        }
        if let Some(load) = self.load {
            write!(f, ", load {load}")?;
        }
        if !self.optimised {
            write!(f, "; NOT an optimised build")?;
        }
        Ok(())
    }
}
