//! Exit codes, and how a problem is printed.

use crate::wire::Problem;

/// The mesh cannot be used, or a file cannot be read or written.
pub(super) const EXIT_INPUT: u8 = 1;
/// A flag cannot be used.
pub(super) const EXIT_USAGE: u8 = 2;
/// No force-closure grasp was found.
pub(super) const EXIT_NO_GRASP: u8 = 3;
/// A second Ctrl-C ended the command; shells use this code for SIGINT.
pub(super) const EXIT_INTERRUPTED: u8 = 130;

/// Prints a problem with the errors of its fields.
pub(super) fn report_problem(problem: &Problem) {
    super::print_error(format_args!(
        "graspd: {}: {}",
        problem.title, problem.detail
    ));
    for fault in &problem.errors {
        super::print_error(format_args!("  {}: {}", fault.pointer, fault.detail));
    }
}

pub(super) fn input_problem(detail: String) -> Problem {
    Problem::new(400, "unreadable", "Unusable input", detail)
}
