//! What skips says so where it is heard.

use std::process::Command;

use crate::skips::{not_applicable, skip};

#[test]
fn whoever_skips_says_so_in_a_file() {
    if std::env::var_os("VELOID_SKIPS_PROBE").is_some() {
        skip("it is asked to");
        return not_applicable("it is asked to");
    }
    let path = std::env::temp_dir().join(format!("veloid-skips-{}", std::process::id()));
    // This test once more, in processes that have the variables. One thread alone would be called main.
    let name = "said::whoever_skips_says_so_in_a_file";
    for _ in 0..2 {
        let again = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", name, "--test-threads", "2"])
            .env("VELOID_SKIPS", &path)
            .env("VELOID_SKIPS_PROBE", "1")
            .output();
        assert!(again.unwrap().status.success());
    }
    let said = std::fs::read_to_string(&path).unwrap();
    std::fs::remove_file(path).unwrap();
    let once = format!("skipped\t{name}\tit is asked to\nnot applicable\t{name}\tit is asked to\n");
    assert_eq!(said, once.repeat(2));
}
