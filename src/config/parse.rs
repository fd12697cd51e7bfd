//! Parses the values of settings.
//!
//! Sizes and times are read here and not by bytesize and humantime: their `64k` is 64,000 bytes and not 64 KiB,
//! and `1.5h` or `1M` would be new ways to write a time.

use std::time::Duration;

/// A hundred years, in seconds.
const MAX_RETENTION_S: u64 = 36_500 * 86_400;

/// How long something is valid or kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Period {
    For(Duration),
    Forever,
}

/// Reads a whole number from 1 to `max`.
pub fn count(max: usize) -> impl Fn(&str) -> Result<usize, String> + Clone + Send + Sync + 'static {
    count_from(1, max)
}

/// Reads a whole number from `min` to `max`.
pub fn count_from(
    min: usize,
    max: usize,
) -> impl Fn(&str) -> Result<usize, String> + Clone + Send + Sync + 'static {
    move |text| {
        text.parse()
            .ok()
            .filter(|count| (min..=max).contains(count))
            .ok_or_else(|| format!("must be a whole number from {min} to {max}"))
    }
}

/// Reads a number of seconds.
pub fn seconds(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|seconds| *seconds > 0.0 && *seconds <= 3600.0)
        .ok_or_else(|| "must be a number of seconds above 0, up to 3600".to_owned())
}

/// Reads a time with its unit, or `forever`.
pub fn period(text: &str) -> Result<Period, String> {
    let text = text.trim();
    if text == "forever" {
        return Ok(Period::Forever);
    }
    let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let unit = match &text[digits.len()..] {
        "s" => 1,
        "m" => 60,
        "h" => 3600,
        "d" => 86_400,
        _ => 0,
    };
    digits
        .parse::<u64>()
        .ok()
        .and_then(|number| number.checked_mul(unit))
        .filter(|seconds| (1..=MAX_RETENTION_S).contains(seconds))
        .map(|seconds| Period::For(Duration::from_secs(seconds)))
        .ok_or_else(|| {
            "must be a time such as 90s, 15m, 12h or 7d, up to 36500d, or forever".to_owned()
        })
}

/// Reads a size with or without its unit.
pub fn bytes(text: &str) -> Result<u64, String> {
    let text = text.trim();
    let digits = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let unit: u64 = match text[digits.len()..].to_ascii_lowercase().as_str() {
        "" | "b" => 1,
        "kb" => 1_000,
        "mb" => 1_000_000,
        "gb" => 1_000_000_000,
        "k" | "kib" => 1 << 10,
        "m" | "mib" => 1 << 20,
        "g" | "gib" => 1 << 30,
        _ => 0,
    };
    digits
        .trim_end()
        .parse::<u64>()
        .ok()
        .and_then(|number| number.checked_mul(unit))
        .filter(|bytes| *bytes > 0)
        .ok_or_else(|| "must be a size such as 1048576, 64MiB or 2GB".to_owned())
}

/// Reads a limit of memory: a server takes some tens of megabytes before it does anything.
pub fn memory(text: &str) -> Result<u64, String> {
    match bytes(text)? {
        bytes if bytes >= 64 << 20 => Ok(bytes),
        _ => Err("must be at least 64MiB".to_owned()),
    }
}

/// Reads a time with its unit, which may be zero.
pub fn pause(text: &str) -> Result<Duration, String> {
    match (text.trim(), period(text)) {
        ("0" | "0s", _) => Ok(Duration::ZERO),
        (_, Ok(Period::For(time))) if time <= Duration::from_secs(86_400) => Ok(time),
        _ => Err("must be a time such as 0s, 30s or 5m, up to 1d".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn retentions_are_read_with_their_unit() {
        assert_eq!(period("90s"), Ok(Period::For(Duration::from_secs(90))));
        assert_eq!(period("7d"), Ok(Period::For(Duration::from_secs(604_800))));
        assert_eq!(period("forever"), Ok(Period::Forever));
        for wrong in [
            "",
            "0s",
            "7",
            "-1d",
            "7 parsecs",
            "99999d",
            "1.5h",
            "99999999999999999999s",
        ] {
            assert!(period(wrong).is_err(), "{wrong:?}");
        }
    }

    #[test]
    fn sizes_are_read_with_and_without_unit() {
        assert_eq!(bytes("1048576"), Ok(1 << 20));
        assert_eq!(bytes("64MiB"), Ok(64 << 20));
        assert_eq!(bytes("2 GB"), Ok(2_000_000_000));
        for wrong in [
            "",
            "MiB",
            "-1",
            "5 parsecs",
            "99999999999999999999",
            "99999999999G",
        ] {
            assert!(bytes(wrong).is_err(), "{wrong:?}");
        }
    }
}
