//! Style sheet, scripts and the plotting library, out of the binary. Their address holds a hash of
//! them all, so that browsers may keep them for ever and modules find each other beside themselves.

use std::io::Read;
use std::sync::LazyLock;

use axum::http::{HeaderMap, HeaderValue, header};
use axum::response::{IntoResponse, Response};
use flate2::read::GzDecoder;
use sha2::{Digest, Sha256};
use tokio::task::spawn_blocking;

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
    "layout.js" SCRIPT,
    "logs.js" SCRIPT,
    "kept.js" SCRIPT,
    "preview.js" SCRIPT,
    "send.js" SCRIPT,
    "outcome.js" SCRIPT,
    "jobs.js" SCRIPT,
    "job.js" SCRIPT,
    "figures.js" SCRIPT,
    "inside.js" SCRIPT,
    "tabs.js" SCRIPT,
    "live.js" SCRIPT,
    "bike.js" SCRIPT,
    "compare.js" SCRIPT,
    "dependence.js" SCRIPT,
    "validation.js" SCRIPT,
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

/// Plotly's script, compressed by `build.rs`.
static PLOTLY_GZ: &[u8] = include_bytes!(concat!(env!("OUT_DIR"), "/plotly.js.gz"));

/// Address of an asset.
pub fn asset(name: &str) -> String {
    format!("/assets/{}/{name}", *VERSION)
}

/// The icon, where browsers look for it without a link.
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
    let accepted = headers.get_all(header::ACCEPT_ENCODING);
    let gzip = accepted
        .iter()
        .filter_map(|value| value.to_str().ok())
        .any(accepts_gzip);
    let mut response = match gzip {
        true => ([(header::CONTENT_ENCODING, "gzip")], PLOTLY_GZ).into_response(),
        false => spawn_blocking(plain).await??.into_response(),
    };
    let kind = HeaderValue::from_static(SCRIPT);
    response.headers_mut().insert(header::CONTENT_TYPE, kind);
    let vary = HeaderValue::from_static("accept-encoding");
    response.headers_mut().insert(header::VARY, vary);
    Ok(response)
}

/// Whether a list of encodings holds gzip, and not as one that is refused.
fn accepts_gzip(list: &str) -> bool {
    list.split(',').any(|encoding| {
        let (name, weight) = encoding.split_once(';').unwrap_or((encoding, ""));
        let weight = weight.trim().strip_prefix("q=").unwrap_or("1");
        ["gzip", "x-gzip", "*"].contains(&name.trim()) && weight.trim().parse() != Ok(0.0)
    })
}

fn plain() -> std::io::Result<Vec<u8>> {
    let mut plain = Vec::new();
    GzDecoder::new(PLOTLY_GZ).read_to_end(&mut plain)?;
    Ok(plain)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn gzip_is_for_those_who_accept_it() {
        for (list, accepts) in [
            ("gzip", true),
            ("br, gzip;q=0.8", true),
            ("deflate,*", true),
            ("", false),
            ("br", false),
            ("gzip;q=0", false),
            ("gzip; q=0.0, br", false),
            ("gzipped", false),
        ] {
            assert_eq!(accepts_gzip(list), accepts, "{list}");
        }
    }

    #[test]
    fn plotly_comes_whole_out_of_its_crate() {
        let mut script = String::new();
        GzDecoder::new(PLOTLY_GZ)
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
