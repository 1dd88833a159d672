//! Signatures as standard-webhooks has them: HMAC-SHA256 over `id.timestamp.body`.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use hmac::{Hmac, KeyInit, Mac};
use sha2::Sha256;

const PREFIX: &str = "whsec_";
const BYTES: usize = 32;

/// What sender and receiver share: `whsec_` and the key in base64.
#[derive(Clone)]
pub struct Secret(String);

impl Secret {
    pub fn draw() -> Result<Self, getrandom::Error> {
        let mut bytes = [0; BYTES];
        getrandom::fill(&mut bytes)?;
        Ok(Self(format!("{PREFIX}{}", STANDARD.encode(bytes))))
    }

    /// As it is stored.
    pub fn stored(text: String) -> Self {
        Self(text)
    }

    pub fn text(&self) -> &str {
        &self.0
    }

    /// The header `webhook-signature`; nothing where the secret is none.
    pub fn signature(&self, id: &str, timestamp: i64, body: &str) -> Option<String> {
        let key = STANDARD.decode(self.0.strip_prefix(PREFIX)?).ok()?;
        let mut mac = Hmac::<Sha256>::new_from_slice(&key).ok()?;
        mac.update(format!("{id}.{timestamp}.{body}").as_bytes());
        Some(format!(
            "v1,{}",
            STANDARD.encode(mac.finalize().into_bytes())
        ))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// The example of the specification's reference implementations (github.com/standard-webhooks/standard-webhooks).
    #[test]
    fn val_the_signature_is_that_of_the_specification() {
        let secret = Secret::stored("whsec_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw".to_owned());
        let signature = secret.signature(
            "msg_p5jXN8AQM9LWM0D4loKWxJek",
            1_614_265_330,
            r#"{"test": 2432232314}"#,
        );
        assert_eq!(
            signature.unwrap(),
            "v1,g0hM9SsE+OTPJTGt/tmIKtSyZlE3uFJELVlNIOLJ1OE="
        );
    }

    #[test]
    fn secrets_differ_and_nonsense_signs_nothing() {
        let (a, b) = (Secret::draw().unwrap(), Secret::draw().unwrap());
        assert_ne!(a.text(), b.text());
        assert_ne!(a.signature("m", 1, "{}"), b.signature("m", 1, "{}"));
        assert_ne!(a.signature("m", 1, "{}"), a.signature("m", 2, "{}"));
        for text in ["", "whsec_", "whsec_?"] {
            let signed = Secret::stored(text.to_owned()).signature("m", 1, "{}");
            assert_eq!(signed.is_some(), text == "whsec_", "{text}");
        }
    }
}
