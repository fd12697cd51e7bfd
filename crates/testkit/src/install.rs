//! Programs that the tests need, from the distribution.

use std::path::Path;
use std::process::Command;

/// Installs something where it is missing, as `tests/install.sh` calls it.
///
/// # Panics
/// When that fails.
pub fn install(what: &str) {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/install.sh");
    let installed = Command::new("sh").arg(script).arg(what).output();
    let installed = installed.expect("sh");
    let errors = String::from_utf8_lossy(&installed.stderr);
    assert!(
        installed.status.success(),
        "{what} is not installed: {errors}"
    );
}
