//! The body of an upload within its bounds. `multer` takes whatever is there each time it is asked, and
//! keeps what comes before the first part or in a part's head until that ends; so it is fed in small pieces,
//! one at a time, and only so many without a result.

use std::pin::Pin;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::task::{Context, Poll, ready};

use axum::body::{BodyDataStream, Bytes};
use futures_util::Stream;

use crate::api::problem::{Kind, Problem};
use crate::http::Unfinished;

/// What a form may hold besides the file (bytes).
pub const ALLOWANCE: u64 = 1 << 20;
/// Most that may come before the first part, or as the head of one (bytes).
const HEAD: u64 = 64 << 10;
/// Size of a piece (bytes).
const PIECE: usize = 64 << 10;

/// Why a body is not read on.
#[derive(Debug, thiserror::Error)]
pub enum BodyError {
    #[error("the form is larger than {0} bytes, the largest file plus {ALLOWANCE} bytes")]
    TooLarge(u64),
    #[error(
        "form: {HEAD} bytes without a part, expected the start of a part or the end of its header"
    )]
    Head,
    #[error(transparent)]
    Unfinished(Unfinished),
    #[error("the upload was interrupted: {0}")]
    Broken(axum::Error),
}

impl From<axum::Error> for BodyError {
    fn from(error: axum::Error) -> Self {
        match unfinished(&error) {
            Some(why) => BodyError::Unfinished(why),
            None => BodyError::Broken(error),
        }
    }
}

/// Why a body is not waited for any longer, if that ended it.
fn unfinished(error: &axum::Error) -> Option<Unfinished> {
    let mut cause: Option<&(dyn std::error::Error + 'static)> = Some(error);
    while let Some(error) = cause {
        if let Some(why) = error.downcast_ref::<Unfinished>() {
            return Some(*why);
        }
        cause = error.source();
    }
    None
}

impl From<&BodyError> for Problem {
    fn from(error: &BodyError) -> Self {
        let kind = match error {
            BodyError::TooLarge(_) => Kind::TooLarge,
            BodyError::Unfinished(Unfinished::Stops) => Kind::Unavailable,
            BodyError::Unfinished(_) => Kind::TooSlow,
            BodyError::Head | BodyError::Broken(_) => Kind::BadRequest,
        };
        Self::new(kind, error.to_string())
    }
}

impl From<BodyError> for Problem {
    fn from(error: BodyError) -> Self {
        Self::from(&error)
    }
}

impl From<multer::Error> for Problem {
    fn from(error: multer::Error) -> Self {
        if let multer::Error::StreamReadFailed(cause) = &error
            && let Some(cause) = cause.downcast_ref::<BodyError>()
        {
            return cause.into();
        }
        Self::new(Kind::BadRequest, format!("form: {error}"))
    }
}

/// Bytes that were given away since the last result.
#[derive(Clone, Default)]
pub struct Unparsed(Arc<AtomicU64>);

impl Unparsed {
    /// There is a result.
    pub fn clear(&self) {
        self.0.store(0, Ordering::Relaxed);
    }
}

/// The body of a form, in pieces.
pub struct Pieces<'a> {
    body: &'a mut BodyDataStream,
    rest: Bytes,
    came: u64,
    most: u64,
    unparsed: Unparsed,
    /// Each time there is something to look at before more comes.
    pause: bool,
}

impl<'a> Pieces<'a> {
    /// A form whose file may have `limit` bytes.
    pub fn new(body: &'a mut BodyDataStream, limit: u64, unparsed: Unparsed) -> Self {
        Self {
            body,
            rest: Bytes::new(),
            came: 0,
            most: limit.saturating_add(ALLOWANCE),
            unparsed,
            pause: false,
        }
    }
}

impl Stream for Pieces<'_> {
    type Item = Result<Bytes, BodyError>;

    fn poll_next(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<Option<Self::Item>> {
        let this = &mut *self;
        if std::mem::take(&mut this.pause) {
            context.waker().wake_by_ref();
            return Poll::Pending;
        }
        if this.unparsed.0.load(Ordering::Relaxed) >= HEAD {
            return Poll::Ready(Some(Err(BodyError::Head)));
        }
        while this.rest.is_empty() {
            match ready!(Pin::new(&mut *this.body).poll_next(context)) {
                Some(Ok(bytes)) => this.rest = bytes,
                Some(Err(error)) => return Poll::Ready(Some(Err(error.into()))),
                None => return Poll::Ready(None),
            }
            this.came += this.rest.len() as u64;
            if this.came > this.most {
                return Poll::Ready(Some(Err(BodyError::TooLarge(this.most))));
            }
        }
        let piece = this.rest.split_to(this.rest.len().min(PIECE));
        this.unparsed
            .0
            .fetch_add(piece.len() as u64, Ordering::Relaxed);
        this.pause = true;
        Poll::Ready(Some(Ok(piece)))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use axum::body::Body;
    use multer::Multipart;

    use super::*;

    /// Gives a form to multer as uploads are; its parts and how many bytes they have, or the problem.
    async fn parts(limit: u64, form: Vec<u8>) -> Result<Vec<(String, usize)>, Problem> {
        let mut body = Body::from(form).into_data_stream();
        let unparsed = Unparsed::default();
        let pieces = Pieces::new(&mut body, limit, unparsed.clone());
        let mut form = Multipart::new(pieces, "B");
        let mut parts = Vec::new();
        while let Some(mut field) = form.next_field().await? {
            unparsed.clear();
            let mut bytes = 0;
            while let Some(chunk) = field.chunk().await? {
                unparsed.clear();
                assert!(chunk.len() <= 4 * PIECE, "{} bytes at once", chunk.len());
                bytes += chunk.len();
            }
            parts.push((field.name().unwrap_or_default().to_owned(), bytes));
        }
        Ok(parts)
    }

    fn part(name: &str, header: usize, bytes: usize) -> Vec<u8> {
        let mut part = format!(
            "--B\r\nContent-Disposition: form-data; name=\"{name}\"\r\nX: {}\r\n\r\n",
            "x".repeat(header)
        )
        .into_bytes();
        part.resize(part.len() + bytes, b'1');
        part.extend(b"\r\n");
        part
    }

    fn form(preamble: usize, parts: &[Vec<u8>]) -> Vec<u8> {
        [&vec![b'-'; preamble], &parts.concat()[..], b"--B--\r\n"].concat()
    }

    #[tokio::test]
    async fn what_is_not_a_part_yet_is_bounded() {
        let (head, limit) = (HEAD as usize, 10 << 20);
        let large = form(0, &[part("a", 9, 5 << 20), part("b", 9, 3 << 20)]);
        let expected = [("a".to_owned(), 5 << 20), ("b".to_owned(), 3 << 20)];
        assert_eq!(parts(limit, large).await.unwrap(), expected);
        let sound = form(head / 4, &[part("a", head / 4, 9)]);
        assert_eq!(parts(limit, sound).await.unwrap(), [("a".to_owned(), 9)]);
        for endless in [
            form(3 * head, &[part("a", 9, 9)]),
            form(0, &[part("a", 3 * head, 9)]),
            form(0, &[part("a", 9, 9), part("b", 3 * head, 9)]),
        ] {
            let problem = parts(limit, endless).await.unwrap_err();
            assert_eq!(problem.kind, Kind::BadRequest, "{problem:?}");
            assert!(problem.detail.contains("65536 bytes without a part"));
        }
    }

    #[tokio::test]
    async fn a_form_is_bounded_by_its_file_and_an_allowance() {
        let limit = 1000;
        let sound = form(0, &[part("a", 9, ALLOWANCE as usize)]);
        assert!(parts(limit, sound).await.is_ok());
        let many = vec![part("a", 9, 1000); 2000];
        let problem = parts(limit, form(0, &many)).await.unwrap_err();
        assert_eq!(problem.kind, Kind::TooLarge, "{problem:?}");
        assert!(
            problem.detail.contains("1049576 bytes"),
            "{}",
            problem.detail
        );
    }
}
