//! A value that one thread writes and another thread reads. Neither thread waits, because a
//! sequence lock of atomic words guards the value.

use std::sync::atomic::{AtomicU32, Ordering, fence};

/// Attempts of a reader before it gives up. Two writes lie a thousand times as far apart as a copy
/// takes, so the second attempt usually succeeds.
const TRIES: u32 = 8;

/// `N` words, written together and read together.
#[derive(Debug)]
pub(crate) struct Slot<const N: usize> {
    /// Count of the sequence lock: odd during a write, 0 before the first write.
    version: AtomicU32,
    words: [AtomicU32; N],
}

impl<const N: usize> Slot<N> {
    pub(crate) const fn new() -> Self {
        Self {
            version: AtomicU32::new(0),
            words: [const { AtomicU32::new(0) }; N],
        }
    }

    /// Replaces the value. Only one thread may call this method.
    pub(crate) fn write(&self, words: [u32; N]) {
        let version = self.version.load(Ordering::Relaxed);
        self.version
            .store(version.wrapping_add(1), Ordering::Relaxed);
        fence(Ordering::Release);
        for (slot, word) in self.words.iter().zip(words) {
            slot.store(word, Ordering::Relaxed);
        }
        // Skip 0, which means "never written".
        self.version
            .store(version.wrapping_add(2).max(2), Ordering::Release);
    }

    /// Newest value and its sequence count. `None` before the first write, or when a write disturbs
    /// every attempt.
    pub(crate) fn read(&self) -> Option<(u32, [u32; N])> {
        for _ in 0..TRIES {
            let before = self.version.load(Ordering::Acquire);
            if before == 0 {
                return None;
            }
            if before & 1 != 0 {
                continue;
            }
            let words = std::array::from_fn(|at| self.words[at].load(Ordering::Relaxed));
            fence(Ordering::Acquire);
            if self.version.load(Ordering::Relaxed) == before {
                return Some((before, words));
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::atomic::AtomicBool;

    #[test]
    fn nothing_is_read_before_something_is_written() {
        let slot = Slot::<2>::new();
        assert!(slot.read().is_none());
        slot.write([1, 2]);
        assert_eq!(slot.read().unwrap().1, [1, 2]);
    }

    #[test]
    fn a_value_is_never_torn() {
        let slot = Slot::<8>::new();
        let stop = AtomicBool::new(false);
        std::thread::scope(|scope| {
            scope.spawn(|| {
                for value in 1..200_000u32 {
                    slot.write([value; 8]);
                }
                stop.store(true, Ordering::Relaxed);
            });
            while !stop.load(Ordering::Relaxed) {
                if let Some((_, words)) = slot.read() {
                    assert!(words.iter().all(|&word| word == words[0]), "{words:?}");
                }
            }
        });
    }
}
