//! How fast a ride file is read: `cargo run --release -p veloid-engine --example parse_speed [FILE]`.
//! Without a file, a one-hour ride at 100 Hz with five columns (19 MB) is made up.

use std::fmt::Write;
use std::time::Instant;

use veloid_engine::bicycle::Bike;
use veloid_engine::ride::{ReadOptions, parse_only, read};

fn main() {
    let bytes = match std::env::args().nth(1) {
        Some(path) => std::fs::read(&path).unwrap_or_else(|e| panic!("{path}: {e}")),
        None => hour(),
    };
    let (bike, options) = (Bike::default(), ReadOptions::default());
    let before_mb = memory_mb();
    let parse = median(|| parse_only(&bytes, &options).is_ok());
    let whole = median(|| read(&bytes, "ride.csv", &bike, &options).is_ok());
    let mb = bytes.len() as f64 / 1e6;
    println!("file   {mb:.2} MB");
    println!("parse  {:.1} ms  {:.0} MB/s", parse * 1e3, mb / parse);
    println!(
        "read   {:.1} ms  {:.0} MB/s (with checks and SHA-256)",
        whole * 1e3,
        mb / whole
    );
    if let (Some(before), Some(peak)) = (before_mb, memory_mb()) {
        println!("memory {before:.0} MB before, {peak:.0} MB at the peak");
    }
}

/// Five columns with noise in the last digits.
fn hour() -> Vec<u8> {
    let mut text = String::from("t,u_f,z_f,u_r,z_r\n");
    for i in 0..360_000u64 {
        let r = (i.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40) as f64 * 1e-12;
        let (t, s) = (i as f64 * 0.01, (i as f64 * 0.03).sin() * 3e-3 + r);
        let _ = writeln!(
            text,
            "{t:.4},{s:.7},{:.7},{:.7},{:.7}",
            -s,
            1.1 * s,
            0.9 * s
        );
    }
    text.into_bytes()
}

/// Median of seven runs (s): on-processor time where the system tells it, so that a busy machine
/// does not count, else wall time.
fn median(mut work: impl FnMut() -> bool) -> f64 {
    let mut seconds: Vec<f64> = (0..7)
        .map(|_| {
            let (start, wall) = (processor_s(), Instant::now());
            assert!(work(), "the file cannot be read");
            let used = processor_s().zip(start).map(|(end, start)| end - start);
            used.unwrap_or_else(|| wall.elapsed().as_secs_f64())
        })
        .collect();
    seconds.sort_by(f64::total_cmp);
    seconds[3]
}

/// Time that this thread has spent on a processor (s).
fn processor_s() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    let nanoseconds: f64 = text.split_whitespace().next()?.parse().ok()?;
    Some(nanoseconds * 1e-9)
}

/// Largest resident size so far (MB), where the system tells.
fn memory_mb() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|l| l.starts_with("VmHWM:"))?;
    let kb: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kb / 1024.0)
}
