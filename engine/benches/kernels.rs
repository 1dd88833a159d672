//! Times of the kernels whose instructions `.ci/instructions` counts: `cargo bench -p veloid-engine`.

#[path = "../examples/kernels/work.rs"]
mod work;

fn main() {
    divan::main();
}

#[divan::bench(args = work::NAMES)]
fn kernel(bencher: divan::Bencher, name: &str) {
    let work = work::ready(name);
    bencher.bench_local(work);
}
