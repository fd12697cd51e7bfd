//! Signatures of Standard Webhooks (standardwebhooks.com): HMAC-SHA256 under a shared secret.

use std::convert::Infallible;
use std::fmt;
use std::str::FromStr;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use hmac::{Hmac, KeyInit, Mac};
use sha2::Sha256;

/// How many bytes a secret has.
const SECRET_BYTES: std::ops::RangeInclusive<usize> = 24..=64;
/// Most secrets that may sign at the same time.
const MAX_SECRETS: usize = 8;

/// Secrets as the operator wrote them. They never appear in what is printed of this type.
#[derive(Clone)]
pub struct SecretText(String);

impl FromStr for SecretText {
    type Err = Infallible;

    /// Takes any text: a refusal here would be printed along with the text.
    fn from_str(text: &str) -> Result<Self, Infallible> {
        Ok(Self(text.to_owned()))
    }
}

impl fmt::Debug for SecretText {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str("***")
    }
}

/// The keys that sign. A receiver accepts a message if any one of its signatures is right, so secrets can be replaced
/// one after the other.
#[derive(Clone, Default)]
pub struct Secrets(Vec<Vec<u8>>);

impl Secrets {
    /// Reads one or several secrets `whsec_BASE64` of 24 to 64 bytes, separated by spaces or commas. The error says what
    /// a secret must be, never what was given.
    pub fn parse(text: &SecretText) -> Result<Self, String> {
        let written = text.0.split([' ', ',']).filter(|one| !one.is_empty());
        let keys: Vec<Vec<u8>> = written
            .enumerate()
            .map(|(index, one)| {
                key(one).ok_or_else(|| {
                    format!(
                        "secret {} must be whsec_ and then {} to {} random bytes in base64, as in \
                         \"whsec_$(openssl rand -base64 32)\"",
                        index + 1,
                        SECRET_BYTES.start(),
                        SECRET_BYTES.end()
                    )
                })
            })
            .collect::<Result<_, _>>()?;
        match keys.len() {
            0 => Err("there is no secret in it".to_owned()),
            1..=MAX_SECRETS => Ok(Self(keys)),
            _ => Err(format!("at most {MAX_SECRETS} secrets are taken")),
        }
    }

    /// Returns the header `webhook-signature` of a message, with a signature for each secret. `timestamp` is in seconds
    /// since 1970.
    pub fn sign(&self, id: &str, timestamp: i64, body: &str) -> String {
        let signatures = self.0.iter().filter_map(|key| {
            let mut mac = Hmac::<Sha256>::new_from_slice(key).ok()?;
            mac.update(format!("{id}.{timestamp}.{body}").as_bytes());
            let code = BASE64_STANDARD.encode(mac.finalize().into_bytes());
            Some(format!("v1,{code}"))
        });
        signatures.collect::<Vec<_>>().join(" ")
    }
}

impl fmt::Debug for Secrets {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{} secrets", self.0.len())
    }
}

fn key(text: &str) -> Option<Vec<u8>> {
    let key = BASE64_STANDARD.decode(text.strip_prefix("whsec_")?).ok()?;
    SECRET_BYTES.contains(&key.len()).then_some(key)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn secrets(text: &str) -> Result<Secrets, String> {
        Secrets::parse(&text.parse().unwrap())
    }

    #[test]
    fn signs_as_others_do() {
        // The first is the example that the specification publishes; both are what
        // `printf MESSAGE | openssl dgst -sha256 -mac HMAC -macopt hexkey:KEY -binary | base64` prints.
        let (one, other) = (
            "v1,g0hM9SsE+OTPJTGt/tmIKtSyZlE3uFJELVlNIOLJ1OE=",
            "v1,O4Gjv1HqPqsMrjmczoggs/sWA8gZD0VyHG+fLh4+ktI=",
        );
        let first = "whsec_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw";
        let second = "whsec_AAECAwQFBgcICQoLDA0ODxAREhMUFRYXGBkaGxwdHh8=";
        let sign = |text: &str| {
            secrets(text).unwrap().sign(
                "msg_p5jXN8AQM9LWM0D4loKWxJek",
                1_614_265_330,
                r#"{"test": 2432232314}"#,
            )
        };
        assert_eq!(sign(first), one);
        assert_eq!(sign(second), other);
        for both in [format!("{first} {second}"), format!(" {first}, {second},")] {
            assert_eq!(sign(&both), format!("{one} {other}"));
        }
    }

    #[test]
    fn a_secret_that_cannot_be_used_is_refused_without_printing_it() {
        let bytes = |count| format!("whsec_{}", BASE64_STANDARD.encode(vec![7; count]));
        for good in [24, 32, 64] {
            assert!(secrets(&bytes(good)).is_ok(), "{good}");
        }
        let good = bytes(32);
        let nine = [good.as_str(); 9].join(",");
        let bare = good.trim_start_matches("whsec_").to_owned();
        for wrong in [
            bytes(23),
            bytes(65),
            bare,
            "whsec_hunter2".to_owned(),
            format!("{good},hunter2"),
            nine,
            String::new(),
            " , ".to_owned(),
        ] {
            let said = secrets(&wrong).unwrap_err();
            assert!(!said.contains("hunter2") && !said.contains(&good), "{said}");
        }
        let text: SecretText = good.parse().unwrap();
        let printed = format!("{text:?} {:?}", Secrets::parse(&text));
        assert!(
            !printed.contains("whsec_") && !printed.contains('7'),
            "{printed}"
        );
    }
}
