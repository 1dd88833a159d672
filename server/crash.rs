//! Points at which tests make this process die, panic or hang, where the code is built with debug
//! assertions; a release build has none of it. `VELOID_CRASH_AT=LABEL:N` ends the process, without
//! unwinding or flushing anything, when the point of this label is passed for the Nth time (`:1` may
//! be left out); `VELOID_PANIC_AT` panics there, `VELOID_HANG_AT` never returns and `VELOID_STOP_AT` stands
//! still until SIGCONT. It happens once a process: no other passage counts. `tests/crashes.rs` says what state each point leaves behind.
//!
//! `VELOID_POISON=KIND:STAGE:SEED,...` makes that stage of the jobs with that seed do harm wherever it is
//! computed: `abort`, `loop` (deaf), `memory` (10 GB), `stack` (endless recursion) or `kill`.

use std::sync::LazyLock;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use rustix::process::Signal;

/// What an environment variable asks for, and at which passage of which point.
struct Order {
    variable: &'static str,
    label: String,
    passages_left: AtomicU64,
}

impl Order {
    fn read(variable: &'static str) -> Option<Self> {
        let text = std::env::var(variable).ok()?;
        let (label, passage) = text.split_once(':').unwrap_or((&text, "1"));
        Some(Self {
            variable,
            label: label.to_owned(),
            passages_left: AtomicU64::new(passage.parse().unwrap_or(1)),
        })
    }
}

static ORDERS: LazyLock<Vec<Order>> = LazyLock::new(|| {
    let variables = [
        "VELOID_CRASH_AT",
        "VELOID_PANIC_AT",
        "VELOID_HANG_AT",
        "VELOID_STOP_AT",
    ];
    variables.into_iter().filter_map(Order::read).collect()
});

/// The process passes the point of this label.
pub fn point(label: &str) {
    if !cfg!(debug_assertions) {
        return;
    }
    for order in ORDERS.iter().filter(|order| order.label == label) {
        if order.passages_left.fetch_sub(1, Ordering::Relaxed) != 1 {
            continue;
        }
        match order.variable {
            "VELOID_CRASH_AT" => std::process::abort(),
            "VELOID_PANIC_AT" => panic!("asked to panic at {label}"),
            "VELOID_STOP_AT" => send(Signal::STOP),
            _ => loop {
                std::thread::sleep(Duration::from_secs(3600));
            },
        }
    }
}

/// A stage of a job with this seed begins to be computed.
pub fn poison(stage: &str, seed: u64) {
    if !cfg!(debug_assertions) {
        return;
    }
    static ORDERS: LazyLock<String> =
        LazyLock::new(|| std::env::var("VELOID_POISON").unwrap_or_default());
    let asked = |order: &&str| order.ends_with(&format!(":{stage}:{seed}"));
    match ORDERS
        .split(',')
        .find(asked)
        .and_then(|o| o.split(':').next())
    {
        Some("abort") => std::process::abort(),
        Some("loop") => loop {
            std::hint::spin_loop();
        },
        Some("memory") => hoard(),
        Some("stack") => _ = sink(0),
        Some("kill") => send(Signal::KILL),
        _ => {}
    }
}

/// Sends this process a signal.
fn send(signal: Signal) {
    let _ = rustix::process::kill_process(rustix::process::getpid(), signal);
}

/// Takes 10 GB and uses them.
fn hoard() {
    let blocks: Vec<Vec<u8>> = (0..10_000).map(|_| vec![1; 1_000_000]).collect();
    std::hint::black_box(blocks);
}

fn sink(depth: u64) -> u64 {
    let frame = std::hint::black_box([depth; 64]);
    match frame[0] {
        u64::MAX => 0,
        _ => sink(depth + 1) + frame[1],
    }
}
