//! Style sheet, scripts and the plotting library, out of the binary. Their address holds a hash of
//! them all, so that browsers may keep them for ever and modules find each other beside themselves.

use std::io::{Read, Write};
use std::sync::LazyLock;

use axum::http::{HeaderMap, header};
use axum::response::{IntoResponse, Response};
use flate2::Compression;
use flate2::read::GzDecoder;
use flate2::write::GzEncoder;
use sha2::{Digest, Sha256};

use super::layout::{Fault, Path};
use crate::api::problem::Problem;
use crate::files::hex;

const SCRIPT: &str = "text/javascript; charset=utf-8";
const PLOTLY: &str = "plotly.js";

macro_rules! files {
    ($($name:literal $kind:expr),* $(,)?) => {
        [$(($name, $kind, include_str!(concat!("../web/", $name)))),*]
    };
}

static FILES: &[(&str, &str, &str)] = &files![
    "style.css" "text/css; charset=utf-8",
    "icon.svg" "image/svg+xml",
    "theme.js" SCRIPT,
    "page.js" SCRIPT,
    "plot.js" SCRIPT,
    "number.js" SCRIPT,
    "upload.js" SCRIPT,
    "bicycle.js" SCRIPT,
    "columns.js" SCRIPT,
    "jobs.js" SCRIPT,
    "job.js" SCRIPT,
    "figures.js" SCRIPT,
    "live.js" SCRIPT,
    "bike.js" SCRIPT,
    "compare.js" SCRIPT,
    "dependence.js" SCRIPT,
];

static VERSION: LazyLock<String> = LazyLock::new(|| {
    let mut hash = Sha256::new();
    for (name, _, text) in FILES {
        hash.update(name);
        hash.update(text);
    }
    hash.update(env!("CARGO_PKG_VERSION"));
    hex(&hash.finalize()[..6])
});

/// Plotly's script, compressed. The crate hands it out between script tags, before MathJax.
static PLOTLY_GZ: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let sources = plotly::Plot::offline_js_sources();
    let script = sources
        .split_once('>')
        .and_then(|(_, rest)| rest.split_once("</script>"))
        .map_or("", |(script, _)| script);
    let mut gz = GzEncoder::new(Vec::new(), Compression::default());
    // Writing to memory cannot fail.
    let _ = gz.write_all(script.as_bytes());
    gz.finish().unwrap_or_default()
});

/// Address of an asset.
pub fn asset(name: &str) -> String {
    format!("/assets/{}/{name}", *VERSION)
}

/// Compresses the plotting library, so that the first page need not wait for it.
pub fn prepare() {
    LazyLock::force(&PLOTLY_GZ);
}

/// The icon, where browsers look for it that were not told.
pub async fn icon() -> impl IntoResponse {
    let kind = [(header::CONTENT_TYPE, "image/svg+xml")];
    (kind, include_str!("../web/icon.svg"))
}

pub async fn serve(
    Path((version, name)): Path<(String, String)>,
    headers: HeaderMap,
) -> Result<Response, Fault> {
    let mut response = if name == PLOTLY {
        plotly_script(&headers).await?
    } else {
        let file = FILES.iter().find(|(file, ..)| *file == name);
        let (_, kind, text) = file.ok_or_else(|| Problem::not_found("the asset"))?;
        ([(header::CONTENT_TYPE, *kind)], *text).into_response()
    };
    let keep = match version == *VERSION {
        true => "public, max-age=31536000, immutable",
        false => "no-cache",
    };
    let headers = response.headers_mut();
    headers.insert(
        header::CACHE_CONTROL,
        keep.parse().map_err(Problem::internal)?,
    );
    Ok(response)
}

async fn plotly_script(headers: &HeaderMap) -> Result<Response, Problem> {
    let gzip = headers
        .get(header::ACCEPT_ENCODING)
        .and_then(|value| value.to_str().ok())
        .is_some_and(|value| value.contains("gzip"));
    let bytes = tokio::task::spawn_blocking(move || {
        let packed: &'static [u8] = &PLOTLY_GZ;
        if gzip {
            return Ok(packed.to_vec());
        }
        let mut plain = Vec::new();
        GzDecoder::new(packed)
            .read_to_end(&mut plain)
            .map(|_| plain)
    });
    let bytes = bytes.await??;
    let mut response = ([(header::CONTENT_TYPE, SCRIPT)], bytes).into_response();
    if gzip {
        let encoding = header::HeaderValue::from_static("gzip");
        response
            .headers_mut()
            .insert(header::CONTENT_ENCODING, encoding);
    }
    Ok(response)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn plotly_comes_whole_out_of_its_crate() {
        let mut script = String::new();
        GzDecoder::new(&PLOTLY_GZ[..])
            .read_to_string(&mut script)
            .unwrap();
        assert!(
            script.starts_with("/**\n* plotly.js v"),
            "{}",
            &script[..80]
        );
        assert!(
            (4_000_000..5_000_000).contains(&script.len()),
            "{}",
            script.len()
        );
    }
}
