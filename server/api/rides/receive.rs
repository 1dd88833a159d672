//! Takes an upload in: the file straight to disk, the small parts into memory.

use std::time::Duration;

use axum::body::{BodyDataStream, Bytes};
use axum::extract::Request;
use axum::http::{HeaderMap, header};
use futures_util::{Stream, StreamExt};
use multer::{Field, Multipart};
use serde_json::{Map, Value};

use crate::api::Server;
use crate::api::access::Caller;
use crate::api::problem::{Kind, Problem};
use crate::files::{Files, Incoming};
use crate::options::Options;

/// Most that a part other than the file may hold (bytes).
const SMALL: usize = 64 << 10;
/// What is still read, and for how long, of a body that is refused (bytes).
const DRAIN: usize = 1 << 30;
const DRAIN_TIME: Duration = Duration::from_secs(20);

/// An upload that has arrived but is not kept yet.
pub struct Received {
    pub incoming: Incoming,
    /// Name of the file as its sender calls it.
    pub name: String,
    /// The bike file, or the name of a bike of the fleet.
    pub bike: Option<String>,
    pub options: Map<String, Value>,
    /// Identify again even where the same request has a job.
    pub again: bool,
}

/// Receives a multipart form or a raw body.
pub async fn receive(
    server: &Server,
    caller: &Caller,
    request: Request,
) -> Result<Received, Problem> {
    let limit = caller.max_upload(server.max_upload);
    let (head, body) = request.into_parts();
    let mut body = body.into_data_stream();
    let (headers, query) = (&head.headers, head.uri.query());
    let outcome = parts(&server.files, limit, headers, query, &mut body).await;
    if outcome.is_err() {
        // The client may still be sending; closing on it now could cost it the answer.
        tokio::spawn(tokio::time::timeout(DRAIN_TIME, drain(body)));
    }
    outcome?.done()
}

async fn drain(mut body: BodyDataStream) {
    let mut read = 0;
    while let Some(Ok(chunk)) = body.next().await {
        read += chunk.len();
        if read > DRAIN {
            return;
        }
    }
}

async fn parts(
    files: &Files,
    limit: u64,
    headers: &HeaderMap,
    query: Option<&str>,
    body: &mut BodyDataStream,
) -> Result<Parts, Problem> {
    let text = |name| headers.get(name).and_then(|value| value.to_str().ok());
    let length: Option<u64> = text(header::CONTENT_LENGTH).and_then(|text| text.parse().ok());
    if length.is_some_and(|length| length > limit + SMALL as u64 * 4) {
        return Err(too_large(limit));
    }
    let mut parts = Parts::default();
    for (key, value) in form_urlencoded::parse(query.unwrap_or_default().as_bytes()) {
        parts.add(&key, &value)?;
    }
    parts.add_headers(headers)?;
    let kind = text(header::CONTENT_TYPE).unwrap_or_default();
    if kind.starts_with("multipart/form-data") {
        let boundary = multer::parse_boundary(kind)?;
        from_form(files, limit, Multipart::new(body, boundary), &mut parts).await?;
    } else {
        parts.incoming = Some(store(files, limit, body).await?);
    }
    Ok(parts)
}

async fn from_form(
    files: &Files,
    limit: u64,
    mut form: Multipart<'_>,
    parts: &mut Parts,
) -> Result<(), Problem> {
    while let Some(field) = form.next_field().await? {
        let key = field.name().unwrap_or_default().to_owned();
        if key != "file" {
            let value = small(&key, field).await?;
            parts.add(&key, &value)?;
            continue;
        }
        if parts.incoming.is_some() {
            return Err(Problem::new(
                Kind::BadRequest,
                "two parts named `file`, expected one; send one request per ride",
            ));
        }
        if let Some(name) = field.file_name() {
            parts.name = Some(name.to_owned());
        }
        parts.incoming = Some(store(files, limit, field).await?);
    }
    Ok(())
}

/// Writes a stream to disk as it comes, up to the limit.
async fn store<S, E>(files: &Files, limit: u64, stream: S) -> Result<Incoming, Problem>
where
    S: Stream<Item = Result<Bytes, E>>,
    E: std::fmt::Display,
{
    let mut incoming = files.begin().await?;
    let mut stream = std::pin::pin!(stream);
    while let Some(chunk) = stream.next().await {
        let chunk = chunk.map_err(|error| {
            Problem::new(Kind::BadRequest, format!("the upload broke off: {error}"))
        })?;
        if incoming.bytes() + chunk.len() as u64 > limit {
            return Err(too_large(limit));
        }
        incoming.write(&chunk).await?;
    }
    Ok(incoming)
}

async fn small(key: &str, mut field: Field<'_>) -> Result<String, Problem> {
    let mut bytes = Vec::new();
    while let Some(chunk) = field.chunk().await? {
        if bytes.len() + chunk.len() > SMALL {
            return Err(Problem::new(
                Kind::TooLarge,
                format!("part `{key}` is larger than {SMALL} bytes"),
            ));
        }
        bytes.extend_from_slice(&chunk);
    }
    String::from_utf8(bytes)
        .map_err(|_| Problem::new(Kind::BadRequest, format!("part `{key}` is not UTF-8 text")))
}

fn too_large(limit: u64) -> Problem {
    Problem::new(
        Kind::TooLarge,
        format!("the file is larger than {limit} bytes"),
    )
}

#[derive(Default)]
struct Parts {
    incoming: Option<Incoming>,
    name: Option<String>,
    bike: Option<String>,
    options: Map<String, Value>,
    again: bool,
}

impl Parts {
    /// A part of the form, a query parameter. Blank ones are left out, as forms send them.
    fn add(&mut self, key: &str, value: &str) -> Result<(), Problem> {
        let value = value.trim();
        match key {
            _ if value.is_empty() => {}
            "bike" => self.bike = Some(value.to_owned()),
            "name" => self.name = Some(value.to_owned()),
            "again" => self.again = value != "false",
            "options" => self.options.extend(Options::document(value)?),
            _ => Options::add_pair(&mut self.options, key, value)?,
        }
        Ok(())
    }

    /// `Veloid-Bike` and `Veloid-Options`, for whoever sends the file as the body.
    fn add_headers(&mut self, headers: &HeaderMap) -> Result<(), Problem> {
        for (header, key) in [("veloid-bike", "bike"), ("veloid-options", "options")] {
            if let Some(value) = headers.get(header) {
                let value = value.to_str().map_err(|_| {
                    Problem::new(Kind::BadRequest, format!("header {header} is not ASCII"))
                })?;
                self.add(key, value)?;
            }
        }
        Ok(())
    }

    fn done(self) -> Result<Received, Problem> {
        let Some(incoming) = self.incoming else {
            return Err(Problem::new(
                Kind::BadRequest,
                "no part named `file`, expected the ride file",
            ));
        };
        Ok(Received {
            incoming,
            name: self
                .name
                .map_or_else(|| "ride".to_owned(), |name| tidy(&name)),
            bike: self.bike,
            options: self.options,
            again: self.again,
        })
    }
}

/// A file name fit to be shown: its last component without control characters.
fn tidy(name: &str) -> String {
    let last = name.rsplit(['/', '\\']).next().unwrap_or_default();
    let shown: String = last.chars().filter(|c| !c.is_control()).take(200).collect();
    if shown.is_empty() {
        "ride".to_owned()
    } else {
        shown
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use axum::body::Body;
    use futures_util::stream;
    use proptest::prelude::*;
    use proptest::sample::Index;

    use super::*;

    #[test]
    fn names_are_only_shown() {
        assert_eq!(tidy("../../etc/passwd"), "passwd");
        assert_eq!(tidy("C:\\rides\\a b.csv"), "a b.csv");
        assert_eq!(tidy("x\0y\u{7f}\n"), "xy");
        assert_eq!(tidy("/"), "ride");
    }

    const FORM: &str = "--B\r\nContent-Disposition: form-data; name=\"file\"; filename=\"a.csv\"\r\n\
        Content-Type: text/csv\r\n\r\nt,z_f\n0,1\n\r\n\
        --B\r\nContent-Disposition: form-data; name=\"bike\"\r\n\r\n{\"bike\": \"x\"}\r\n\
        --B\r\nContent-Disposition: form-data; name=\"options\"\r\n\r\n{\"seed\": 7, \"map\": {\"z_f\": \"2\"}}\r\n\
        --B\r\nContent-Disposition: form-data; name=\"rows\"\r\n\r\n0:9\r\n--B--\r\n";

    /// Receives a body in pieces as uploads are received, into a folder of its own.
    fn outcome(kind: &str, query: &str, bytes: &[u8], piece: usize) -> Result<Received, Problem> {
        let runtime = tokio::runtime::Builder::new_current_thread()
            .build()
            .unwrap();
        runtime.block_on(async {
            let root =
                std::env::temp_dir().join(format!("veloid-receive-{}", uuid::Uuid::now_v7()));
            let files = Files::in_folder(&root).await.unwrap();
            let headers = [(header::CONTENT_TYPE, kind.parse().unwrap())]
                .into_iter()
                .collect();
            let pieces: Vec<_> = bytes
                .chunks(piece)
                .map(|chunk| Ok::<_, std::io::Error>(chunk.to_vec()))
                .collect();
            let mut body = Body::from_stream(stream::iter(pieces)).into_data_stream();
            let parts = parts(&files, 1 << 10, &headers, Some(query), &mut body).await;
            let received = parts.and_then(Parts::done);
            std::fs::remove_dir_all(root).unwrap();
            received
        })
    }

    #[test]
    fn a_form_is_received_whole_however_it_is_cut() {
        for piece in [1, 7, 10_000] {
            let received = outcome(
                "multipart/form-data; boundary=B",
                "",
                FORM.as_bytes(),
                piece,
            );
            let received = received.unwrap_or_else(|problem| panic!("{problem:?}"));
            assert_eq!(
                (received.name.as_str(), received.incoming.bytes()),
                ("a.csv", 10)
            );
            assert_eq!(received.bike.as_deref(), Some("{\"bike\": \"x\"}"));
            assert_eq!(received.options["seed"], 7);
            assert_eq!(received.options["map"]["z_f"], "2");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(128))]

        #[test]
        fn any_form_is_received_or_refused(
            hits in prop::collection::vec((any::<Index>(), any::<u8>()), 0..8),
            cut in any::<Index>(),
            doubled in any::<bool>(),
            piece in 1usize..400,
        ) {
            let mut bytes = FORM.as_bytes().to_vec();
            for (at, byte) in hits {
                let at = at.index(bytes.len());
                bytes[at] = byte;
            }
            let cut = cut.index(bytes.len());
            if doubled {
                bytes.extend_from_within(cut..);
            } else {
                bytes.truncate(cut);
            }
            if let Err(problem) = outcome("multipart/form-data; boundary=B", "", &bytes, piece) {
                prop_assert!((400..500).contains(&problem.status), "{:?}", problem);
            }
        }

        #[test]
        fn any_body_is_received_or_refused(
            boundary in "[ -~]{0,80}",
            query in "[a-z_=&%0-9:\\{\\}\"]{0,60}",
            bytes in prop::collection::vec(any::<u8>(), 0..3000),
        ) {
            let form = format!("multipart/form-data; boundary={boundary}");
            for kind in [form.as_str(), "text/csv"] {
                if let Err(problem) = outcome(kind, &query, &bytes, 512) {
                    prop_assert!((400..500).contains(&problem.status), "{:?}", problem);
                }
            }
        }
    }
}
