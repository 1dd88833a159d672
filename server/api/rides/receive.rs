//! Takes an upload in: the file straight to disk, the small parts into memory.

use std::io;
use std::time::Duration;

use axum::body::{BodyDataStream, Bytes};
use axum::extract::Request;
use axum::http::{HeaderMap, header};
use futures_util::{Stream, StreamExt, TryStreamExt};
use multer::Multipart;
use serde_json::{Map, Value};
use veloid_engine::seen;

use super::body::{ALLOWANCE, BodyError, Pieces, Unparsed};
use crate::api::Server;
use crate::api::access::Caller;
use crate::api::problem::{Kind, Problem};
use crate::bicycle::Given;
use crate::facts;
use crate::files::{Files, Incoming};
use crate::jobs::Source;
use crate::options::{Options, OptionsError, boolean};

/// Most that a part other than the file may hold (bytes).
const SMALL: usize = 64 << 10;
/// Most parts of a form.
const PARTS: usize = 128;
/// Most of a part's name that a problem repeats (characters).
const SHOWN: usize = 80;
/// For how long a body that is refused is still read.
const DRAIN_TIME: Duration = Duration::from_secs(20);
/// Bytes of it that are read at least, however little the caller may send: with less, who sends a few hundred kilobytes where
/// a thousand bytes are allowed met a closed connection in place of the answer.
const DRAINED: u64 = 4 << 20;

/// An upload that has arrived but is not kept yet.
pub struct Received {
    /// The ride's files, each with its name as its sender calls it.
    pub files: Vec<(String, Incoming)>,
    /// What is said of the bicycle.
    pub bicycle: Given,
    pub options: Map<String, Value>,
    /// What its sender says of the ride.
    pub facts: Map<String, Value>,
    /// Identify again even where the same request has a job.
    pub again: bool,
}

impl Received {
    /// Name of the ride: its file's, or those of all.
    pub fn name(&self) -> String {
        let names: Vec<&str> = self.files.iter().map(|(name, _)| name.as_str()).collect();
        names.join(", ")
    }

    pub fn bytes(&self) -> u64 {
        self.files.iter().map(|(_, file)| file.bytes()).sum()
    }

    /// Names, and where the files lie until this goes.
    pub async fn sources(&mut self) -> io::Result<Vec<Source>> {
        let mut sources = Vec::new();
        for (name, file) in &mut self.files {
            sources.push(Source::new(name.clone(), file.path().await?.to_owned()));
        }
        Ok(sources)
    }
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
    let outcome = match server.db.condition().check() {
        Ok(()) => parts(&server.files, limit, headers, query, &mut body).await,
        Err(exchanged) => Err(Problem::from(&exchanged)),
    };
    if outcome.is_err() {
        // The client may still be sending; closing on it now could cost it the answer. A refused body
        // costs no more than one that is taken.
        tokio::spawn(tokio::time::timeout(DRAIN_TIME, drain(body, limit)));
    }
    outcome?.done()
}

async fn drain(mut body: BodyDataStream, limit: u64) {
    let mut read = 0;
    while let Some(Ok(chunk)) = body.next().await {
        read += chunk.len() as u64;
        if read > limit.max(DRAINED) {
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
    if length.is_some_and(|length| length > limit.saturating_add(ALLOWANCE)) {
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
        from_form(files, limit, body, boundary, &mut parts).await?;
    } else {
        let body = body.map_err(BodyError::from);
        let file = store(files, limit, body).await?;
        parts.files.push((None, file));
    }
    Ok(parts)
}

async fn from_form(
    files: &Files,
    limit: u64,
    body: &mut BodyDataStream,
    boundary: String,
    parts: &mut Parts,
) -> Result<(), Problem> {
    let unparsed = Unparsed::default();
    let mut form = Multipart::new(Pieces::new(body, limit, unparsed.clone()), boundary);
    let mut count = 0;
    while let Some(field) = form.next_field().await? {
        unparsed.clear();
        count += 1;
        if count > PARTS {
            let detail = format!("the form has more than {PARTS} parts");
            return Err(Problem::new(Kind::TooLarge, detail));
        }
        let key = field.name().unwrap_or_default().to_owned();
        let file_name = field.file_name().map(str::to_owned);
        let chunks = field.inspect(|_| unparsed.clear());
        if key != "file" {
            // Before it is read: nobody could use it.
            if !is_known(&key) {
                return Err(unknown(&key));
            }
            let value = small(&key, chunks).await?;
            parts.add(&key, &value)?;
            continue;
        }
        let before: u64 = parts.files.iter().map(|(_, file)| file.bytes()).sum();
        let file = store(files, limit.saturating_sub(before), chunks).await;
        let file = file.map_err(|problem| match problem.kind {
            Kind::TooLarge if before > 0 => too_large(limit),
            _ => problem,
        })?;
        parts.files.push((file_name, file));
    }
    Ok(())
}

/// Writes a stream to disk as it comes, up to the limit.
async fn store<S, E>(files: &Files, limit: u64, stream: S) -> Result<Incoming, Problem>
where
    S: Stream<Item = Result<Bytes, E>>,
    Problem: From<E>,
{
    let mut incoming = files.begin().await?;
    let mut stream = std::pin::pin!(stream);
    while let Some(chunk) = stream.next().await {
        let chunk = chunk?;
        if incoming.bytes() + chunk.len() as u64 > limit {
            return Err(too_large(limit));
        }
        incoming.write(&chunk).await?;
    }
    Ok(incoming)
}

async fn small<S>(key: &str, stream: S) -> Result<String, Problem>
where
    S: Stream<Item = multer::Result<Bytes>>,
{
    let (mut bytes, mut stream) = (Vec::new(), std::pin::pin!(stream));
    while let Some(chunk) = stream.next().await {
        let chunk = chunk?;
        if bytes.len() + chunk.len() > SMALL {
            return Err(Problem::new(
                Kind::TooLarge,
                format!("part `{key}` is larger than {SMALL} bytes"),
            ));
        }
        bytes.extend_from_slice(&chunk);
    }
    String::from_utf8(bytes)
        .map_err(|_| Problem::new(Kind::BadRequest, format!("part `{key}` is not UTF-8")))
}

/// What an upload may hold besides the file, the bicycle, the options and the facts in single parts.
const OWN: [&str; 4] = ["name", "again", "options", "facts"];

fn is_known(key: &str) -> bool {
    OWN.contains(&key) || is_of_bicycle(key) || Options::is_known(key) || is_fact(key)
}

fn is_of_bicycle(key: &str) -> bool {
    Given::names().any(|name| name == key)
}

fn is_fact(key: &str) -> bool {
    facts::names().any(|name| name == key)
}

fn unknown(key: &str) -> Problem {
    let mut shown: String = key.chars().take(SHOWN).collect();
    if shown.len() < key.len() {
        shown.push_str("...");
    }
    let known: Vec<&str> = Given::names()
        .chain(OWN)
        .chain(Options::names())
        .chain(facts::names())
        .collect();
    let known = known.join("`, `");
    Problem::new(
        Kind::BadOption,
        format!("unknown part `{shown}`, expected `file`, `{known}`"),
    )
}

fn too_large(limit: u64) -> Problem {
    Problem::new(
        Kind::TooLarge,
        format!("the file is larger than {limit} bytes"),
    )
}

#[derive(Default)]
struct Parts {
    /// Names as the files' parts have them.
    files: Vec<(Option<String>, Incoming)>,
    /// As the sender calls the only file instead.
    name: Option<String>,
    bicycle: Given,
    options: Map<String, Value>,
    facts: Map<String, Value>,
    again: Option<bool>,
}

impl Parts {
    /// A part of the form, a query parameter. Blank ones are left out, as forms send them; others come
    /// once.
    fn add(&mut self, key: &str, value: &str) -> Result<(), Problem> {
        let value = value.trim();
        let before = match key {
            _ if value.is_empty() => return Ok(()),
            _ if is_of_bicycle(key) => {
                let fresh = self.bicycle.add(key, value);
                !fresh.map_err(|detail| Problem::new(Kind::BadBike, detail))?
            }
            "name" => self.name.replace(value.to_owned()).is_some(),
            "again" => self.again.replace(boolean(key, value)?).is_some(),
            "options" => return Ok(Options::add_document(&mut self.options, value)?),
            "facts" => return Ok(facts::from_json(&mut self.facts, value)?),
            _ if is_fact(key) => return Ok(facts::from_form(&mut self.facts, key, value)?),
            _ => return Ok(Options::add_pair(&mut self.options, key, value)?),
        };
        if before {
            return Err(OptionsError::Twice(key.to_owned()).into());
        }
        Ok(())
    }

    /// `Veloid-Bike` and `Veloid-Options`, for whoever sends the file as the body.
    fn add_headers(&mut self, headers: &HeaderMap) -> Result<(), Problem> {
        for (header, key) in [("veloid-bike", "bike"), ("veloid-options", "options")] {
            for value in headers.get_all(header) {
                let value = value.to_str().map_err(|_| {
                    Problem::new(Kind::BadRequest, format!("header {header} is not ASCII"))
                })?;
                self.add(key, value)?;
            }
        }
        Ok(())
    }

    fn done(self) -> Result<Received, Problem> {
        let malformed = |detail: String| Err(Problem::new(Kind::BadRequest, detail));
        if self.files.is_empty() {
            return malformed("no part named `file`, expected the ride file".to_owned());
        }
        if self.files.len() > 1 && self.name.is_some() {
            return malformed(
                "`name` with several files, expected each file to have its own name".to_owned(),
            );
        }
        let mut files: Vec<(String, Incoming)> = Vec::new();
        for (own, file) in self.files {
            let name = self.name.clone().or(own);
            let name = name.map_or_else(|| "ride".to_owned(), |name| tidy(&name));
            if files.iter().any(|(other, _)| *other == name) {
                return malformed(format!(
                    "two files have the name '{name}', expected different names"
                ));
            }
            files.push((name, file));
        }
        Ok(Received {
            files,
            bicycle: self.bicycle,
            options: self.options,
            facts: self.facts,
            again: self.again.unwrap_or_default(),
        })
    }
}

/// A file name fit to be shown: its last component without what cannot be seen.
fn tidy(name: &str) -> String {
    let last = name.rsplit(['/', '\\']).next().unwrap_or_default();
    let shown: String = seen(last).take(200).collect();
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
            assert_eq!((received.name().as_str(), received.bytes()), ("a.csv", 10));
            assert_eq!(received.bicycle.file.as_deref(), Some("{\"bike\": \"x\"}"));
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
