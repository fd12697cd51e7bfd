//! How long work is stopped from outside.
//!
//! Functions that may take long are given an [`Interrupt`] and check it between blocks of work, many times a
//! second, with `interrupt.check()?`. Whoever starts the work decides what the check looks at: a flag, a clock,
//! both or neither. The planner itself reads no clock.

/// Why work was stopped before its end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum Interrupted {
    /// The result is not wanted any more, or only as far as it has come.
    #[error("the work was cancelled")]
    Cancelled,
    /// The time allowed for the work is over.
    #[error("the time limit was reached")]
    TimeLimit,
}

/// Asks whether to go on.
///
/// ```
/// use std::sync::atomic::{AtomicBool, Ordering};
///
/// use graspd_core::{Interrupt, Interrupted};
///
/// let cancelled = AtomicBool::new(false);
/// let ask = || cancelled.load(Ordering::Relaxed).then_some(Interrupted::Cancelled);
/// let interrupt = Interrupt::new(&ask);
/// assert_eq!(interrupt.check(), Ok(()));
/// // From another thread, for instance:
/// cancelled.store(true, Ordering::Relaxed);
/// assert_eq!(interrupt.check(), Err(Interrupted::Cancelled));
/// ```
#[derive(Clone, Copy)]
pub struct Interrupt<'a> {
    /// `None` when nothing ever stops the work.
    ask: Option<&'a (dyn Fn() -> Option<Interrupted> + Sync)>,
    ignores_time_limit: bool,
}

impl<'a> Interrupt<'a> {
    /// An interrupt that comes when `ask` returns a reason. `ask` is called many times a second and from any
    /// thread, so it should take well below a microsecond.
    pub fn new(ask: &'a (dyn Fn() -> Option<Interrupted> + Sync)) -> Self {
        Self {
            ask: Some(ask),
            ignores_time_limit: false,
        }
    }

    /// An interrupt that never comes.
    pub const fn never() -> Self {
        Self {
            ask: None,
            ignores_time_limit: false,
        }
    }

    /// The same for work that is short and is to be finished although the time is over: only a cancellation
    /// stops it.
    pub fn ignoring_time_limit(self) -> Self {
        Self {
            ignores_time_limit: true,
            ..self
        }
    }

    /// Fails when the work is to stop.
    pub fn check(self) -> Result<(), Interrupted> {
        match self.ask.and_then(|ask| ask()) {
            None => Ok(()),
            Some(Interrupted::TimeLimit) if self.ignores_time_limit => Ok(()),
            Some(why) => Err(why),
        }
    }
}

/// Carries out work that nothing interrupts.
pub(crate) fn uninterrupted<T>(
    work: impl FnOnce(Interrupt<'static>) -> Result<T, Interrupted>,
) -> T {
    match work(Interrupt::never()) {
        Ok(done) => done,
        Err(why) => unreachable!("nothing was to interrupt this: {why}"),
    }
}

/// An interrupt for tests that comes at the check of this number, counted from 1, and stays.
#[cfg(test)]
pub(crate) fn at_check(number: usize) -> impl Fn() -> Option<Interrupted> + Sync {
    let checks = std::sync::atomic::AtomicUsize::new(1);
    move || {
        let check = checks.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        (check >= number).then_some(Interrupted::Cancelled)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_work_is_finished_after_its_time_but_not_when_cancelled() {
        let late = || Some(Interrupted::TimeLimit);
        let late = Interrupt::new(&late);
        assert_eq!(late.check(), Err(Interrupted::TimeLimit));
        assert_eq!(late.ignoring_time_limit().check(), Ok(()));
        let cancelled = || Some(Interrupted::Cancelled);
        let cancelled = Interrupt::new(&cancelled).ignoring_time_limit();
        assert_eq!(cancelled.check(), Err(Interrupted::Cancelled));
        assert_eq!(Interrupt::never().check(), Ok(()));
    }
}
