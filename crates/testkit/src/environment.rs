//! Settings of the tests, from the environment.

/// A number.
///
/// # Panics
/// When the variable is set to something else.
pub fn number(name: &str, default: u64) -> u64 {
    std::env::var(name).map_or(default, |text| {
        text.parse()
            .unwrap_or_else(|_| panic!("{name}={text} is no number"))
    })
}
