//! How a command ends: its exit code, and what it says of a problem.

use crate::wire::Problem;

/// The mesh cannot be used, or a file cannot be read or written.
pub(super) const EXIT_INPUT: u8 = 1;
/// A flag cannot be used.
pub(super) const EXIT_USAGE: u8 = 2;
/// No force-closure grasp was found.
pub(super) const EXIT_NO_GRASP: u8 = 3;
/// Ended by a second Ctrl-C, as shells have it.
pub(super) const EXIT_INTERRUPTED: u8 = 130;

/// Says what a problem says.
pub(super) fn tell(problem: &Problem) {
    super::complain(format_args!(
        "graspd: {}: {}",
        problem.title, problem.detail
    ));
    for fault in &problem.errors {
        super::complain(format_args!("  {}: {}", fault.pointer, fault.detail));
    }
}

pub(super) fn input_problem(detail: String) -> Problem {
    Problem::new(400, "unreadable", "Unusable input", detail)
}
