//! Forms with files (`multipart/form-data`, RFC 7578).

use uuid::Uuid;

pub struct Form {
    /// What no part contains.
    boundary: String,
    body: Vec<u8>,
}

impl Form {
    pub fn new() -> Self {
        let [a, b] = [(); 2].map(|()| Uuid::now_v7().simple());
        Self {
            boundary: format!("veloid-{a}{b}"),
            body: Vec::new(),
        }
    }

    pub fn text(self, name: &str, value: &str) -> Self {
        self.part(&format!("name=\"{name}\""), value.as_bytes())
    }

    /// Names are the program's own, and need no escapes.
    pub fn file(self, name: &str, file: &str, bytes: &[u8]) -> Self {
        self.part(&format!("name=\"{name}\"; filename=\"{file}\""), bytes)
    }

    fn part(mut self, named: &str, bytes: &[u8]) -> Self {
        let boundary = &self.boundary;
        let head = format!("--{boundary}\r\nContent-Disposition: form-data; {named}\r\n\r\n");
        for piece in [head.as_bytes(), bytes, b"\r\n"] {
            self.body.extend_from_slice(piece);
        }
        self
    }

    pub fn content_type(&self) -> String {
        format!("multipart/form-data; boundary={}", self.boundary)
    }

    pub fn body(mut self) -> Vec<u8> {
        let end = format!("--{}--\r\n", self.boundary);
        self.body.extend_from_slice(end.as_bytes());
        self.body
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use futures_util::stream;

    #[tokio::test]
    async fn a_form_is_read_as_it_was_written() {
        let file = b"t,z_f\r\n--0,1\r\n";
        let form = Form::new()
            .text("bike", "{\"bike\": \"b\"}")
            .file("file", "ride.csv", file);
        let boundary = multer::parse_boundary(form.content_type()).unwrap();
        let body = form.body();
        let whole = stream::once(async move { Ok::<_, std::io::Error>(body) });
        let mut read = multer::Multipart::new(Box::pin(whole), boundary);
        let part = read.next_field().await.unwrap().unwrap();
        assert_eq!(part.name(), Some("bike"));
        assert_eq!(part.text().await.unwrap(), "{\"bike\": \"b\"}");
        let part = read.next_field().await.unwrap().unwrap();
        assert_eq!(part.file_name(), Some("ride.csv"));
        assert_eq!(&part.bytes().await.unwrap()[..], file);
        assert!(read.next_field().await.unwrap().is_none());
    }
}
