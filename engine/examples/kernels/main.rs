//! Runs one kernel once, for counting its instructions: `kernels NAME`; without a name it lists them.
//! `.ci/instructions` does that under callgrind, which counts what happens inside `measured`.

mod work;

#[inline(never)]
fn measured(work: &dyn Fn()) {
    work();
}

fn main() {
    match std::env::args().nth(1) {
        Some(name) => measured(&*work::ready(&name)),
        None => println!("{}", work::NAMES.join("\n")),
    }
}
