//! Emulated pipes of a trakSTAR: the bird's side of the protocol, one packet at a time.

use std::collections::VecDeque;
use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use crate::bird::device::Bird;
use crate::bird::wire::Record;
use crate::bird::{BulkPipe, PACKET_BYTES};

/// Pipes to emulated birds at rest.
#[derive(Debug)]
pub struct EmulatedBulk {
    birds: Bird,
    answers: VecDeque<Vec<u8>>,
    unplugged: Arc<AtomicBool>,
}

impl EmulatedBulk {
    /// Birds with these poses and the addresses 1, 2, …, and a flag that unplugs them.
    #[must_use]
    pub fn new(poses: &[Record]) -> (Self, Arc<AtomicBool>) {
        Self::of(Bird::flock(poses))
    }

    /// Pipes to birds in any state.
    #[must_use]
    pub fn of(birds: Bird) -> (Self, Arc<AtomicBool>) {
        let unplugged = Arc::new(AtomicBool::new(false));
        let pipe = Self {
            birds,
            answers: VecDeque::new(),
            unplugged: Arc::clone(&unplugged),
        };
        (pipe, unplugged)
    }

    fn check(&self) -> io::Result<()> {
        if self.unplugged.load(Ordering::Relaxed) {
            Err(io::ErrorKind::NotConnected.into())
        } else {
            Ok(())
        }
    }
}

impl BulkPipe for EmulatedBulk {
    fn write(&mut self, packet: &[u8]) -> io::Result<()> {
        self.check()?;
        let answers = &mut self.answers;
        // A packet holds one command; the rest is ignored.
        let first = packet.get(..Bird::command_len(packet)).unwrap_or(packet);
        self.birds.receive(first, |answer| {
            answers.extend(answer.chunks(PACKET_BYTES).map(<[u8]>::to_vec));
        });
        Ok(())
    }

    fn read(&mut self, packet: &mut [u8; PACKET_BYTES], wait: Duration) -> io::Result<usize> {
        self.check()?;
        let Some(answer) = self.answers.pop_front() else {
            thread::sleep(wait);
            return Ok(0);
        };
        for (slot, &byte) in packet.iter_mut().zip(&answer) {
            *slot = byte;
        }
        Ok(answer.len())
    }
}
