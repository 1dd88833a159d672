//! Tables of Markdown for docs/, as tests that measure print them (`--nocapture`).

use jiff::Timestamp;

/// Commit of the program (`VELOID_COMMIT`), day, processor and load, and the head of the table.
pub fn head() {
    let read = |path| std::fs::read_to_string(path).unwrap_or_default();
    let commit = std::env::var("VELOID_COMMIT").unwrap_or_else(|_| "unknown".to_owned());
    let date = Timestamp::now().strftime("%F");
    let processor = read("/proc/cpuinfo");
    let processor = processor
        .lines()
        .find_map(|line| line.strip_prefix("model name"));
    let processor = processor.unwrap_or_default().trim_matches(['\t', ':', ' ']);
    let cores = std::thread::available_parallelism().map_or(0, usize::from);
    let load = read("/proc/loadavg");
    let load = load.split(' ').next().unwrap_or_default();
    println!("\nCommit `{commit}`, {date}, {processor}, {cores} cores, load before {load}\n");
    println!("| | measured | demanded |\n|---|---|---|");
}

pub fn row(what: &str, measured: String, demanded: &str) {
    println!("| {what} | {measured} | {demanded} |");
}
