//! Packs the plotting library, and records what the program is built with.

use std::env;
use std::error::Error;
use std::fs::File;
use std::io::Write;
use std::path::Path;

use flate2::Compression;
use flate2::write::GzEncoder;

const FEATURES: [&str; 5] = ["parquet", "postgres", "s3", "spreadsheets", "webhooks"];

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo::rerun-if-changed=build.rs");
    let built = |feature: &&str| {
        let variable = format!("CARGO_FEATURE_{}", feature.to_uppercase());
        env::var_os(variable).is_some()
    };
    let built: Vec<&str> = FEATURES.into_iter().filter(built).collect();
    let built = match built.is_empty() {
        true => "none".to_owned(),
        false => built.join(", "),
    };
    println!("cargo::rustc-env=VELOID_FEATURES={built}");

    let packed = Path::new(&env::var("OUT_DIR")?).join("plotly.js.gz");
    let mut packed = GzEncoder::new(File::create(packed)?, Compression::best());
    packed.write_all(plotly()?.as_bytes())?;
    packed.finish()?;
    Ok(())
}

/// Plotly's script, which its crate hands out between script tags, before MathJax.
fn plotly() -> Result<String, Box<dyn Error>> {
    let sources = plotly::Plot::offline_js_sources();
    let script = sources
        .split_once('>')
        .and_then(|(_, rest)| rest.split_once("</script>"));
    let (script, _) = script.ok_or("plotly's script does not stand between tags")?;
    Ok(script.to_owned())
}
