//! Trial of the calls that the controller will make to Linux. Each call is made, judged by its
//! result, and undone. `calot check` reports the outcomes.

use std::sync::mpsc;

use rustix::io::Errno;

use crate::realtime;
use crate::refusal::{Call, Circumstances, Refusal};

/// Outcomes of a trial.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Trial {
    /// Taking `SCHED_FIFO` at the tick's priority.
    pub fifo: Result<(), Refusal>,
    /// Pinning to the tick's core.
    pub pinned: Result<(), Refusal>,
    /// Locking all memory, with room to grow.
    pub locked: Result<(), Refusal>,
}

impl Trial {
    /// Makes the calls. A separate thread takes the scheduler and the core, and then ends. Memory
    /// is unlocked again, but the settings of malloc stay.
    #[must_use]
    pub fn run(core: usize, priority: u8) -> Self {
        let (sender, receiver) = mpsc::channel();
        let thread = std::thread::Builder::new().spawn(move || {
            let _ = sender.send((realtime::pin_to(&[core]), realtime::take_fifo(priority)));
        });
        let outcome = receiver.recv();
        if let Ok(thread) = thread {
            let _ = thread.join();
        }
        let locked = realtime::lock_memory();
        realtime::unlock_memory();
        let none = |call| Err(Circumstances::read().judge(call, Errno::AGAIN));
        let (pinned, fifo) =
            outcome.unwrap_or_else(|_| (none(Call::Pin(vec![core])), none(Call::Fifo(priority))));
        Self {
            fifo,
            pinned,
            locked,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The trial agrees with the calls, whatever this machine grants, and keeps neither core nor
    /// scheduler.
    #[test]
    fn trial_predicts_the_calls_and_undoes_them() {
        let cores = realtime::allowed_cores();
        let trial = Trial::run(cores[0], 80);
        assert_eq!(realtime::allowed_cores(), cores);
        let thread = std::thread::spawn(|| realtime::take_fifo(80).is_ok());
        assert_eq!(trial.fifo.is_ok(), thread.join().unwrap());
        assert_eq!(trial.pinned, Ok(()));
        for refusal in [trial.fifo, trial.locked]
            .into_iter()
            .filter_map(Result::err)
        {
            assert!(
                !refusal.why.is_empty() && !refusal.mend.is_empty(),
                "{refusal}"
            );
        }
        let absent = Trial::run(1023, 80);
        assert!(absent.pinned.unwrap_err().mend.contains("--core"));
    }
}
