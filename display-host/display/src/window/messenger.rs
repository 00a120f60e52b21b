//! Sender of the hand's messages, in a thread of its own. The window's thread sends nothing while
//! it draws. Without this thread, a picture that takes longer than half a second would let the
//! pedal go, because the emulated hand then counts the display as silent.

use std::sync::mpsc::{SyncSender, sync_channel};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use shared_mem::message::HandMsg;
use shared_mem::service::{HandSender, Station};

use super::refusal::Refusal;
use crate::latency::now_ns;

/// Interval between messages to the emulated hand while it is led.
pub(super) const SEND_EVERY: Duration = Duration::from_millis(8);
/// Time for which the last message is sent, so that it is delivered.
const LAST_WORD: Duration = Duration::from_millis(200);
/// Time for which an old message is repeated. The slowest picture that a trainee saw, on a computer
/// without a graphics card, took 3.3 s. A display that hangs for longer lets the pedal go.
const REPEATED: Duration = Duration::from_secs(4);

/// The message to send.
#[derive(Debug)]
struct Said {
    message: HandMsg,
    /// Time at which the window's thread gave it.
    at: Instant,
    /// True for the last message.
    is_last: bool,
}

impl Said {
    /// True while the message is sent.
    fn lasts(&self, now: Instant) -> bool {
        let limit = if self.is_last { LAST_WORD } else { REPEATED };
        now.saturating_duration_since(self.at) < limit
    }
}

/// The window's end of the thread. Dropping it releases the instrument.
#[derive(Debug)]
pub(super) struct Messenger {
    said: Arc<Mutex<Said>>,
}

impl Messenger {
    /// Takes the instrument with this first message.
    pub(super) fn begin(station: &Station, message: HandMsg) -> Result<Self, Refusal> {
        let said = Arc::new(Mutex::new(Said {
            message,
            at: Instant::now(),
            is_last: false,
        }));
        let (taken, answer) = sync_channel(1);
        let (station, own) = (station.clone(), Arc::clone(&said));
        let thread = std::thread::Builder::new().name("calot-hand".to_owned());
        // The answer follows from the sender, which belongs to the thread.
        let begun = thread.spawn(move || lead(&station, &own, &taken));
        if begun.is_err() {
            return Err(Refusal::NoHand);
        }
        answer.recv().unwrap_or(Err(Refusal::NoHand))?;
        Ok(Self { said })
    }

    /// Sends this message from now on.
    pub(super) fn say(&self, message: HandMsg) {
        let mut said = lock(&self.said);
        (said.message, said.at) = (message, Instant::now());
    }
}

impl Drop for Messenger {
    /// The pedal goes up at once, and the jaws stay as they are.
    fn drop(&mut self) {
        let mut said = lock(&self.said);
        said.message.switches = 0;
        (said.at, said.is_last) = (Instant::now(), true);
    }
}

fn lock(said: &Mutex<Said>) -> MutexGuard<'_, Said> {
    said.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Answers whether the instrument is taken, and sends messages until the last one is over.
fn lead(station: &Station, said: &Mutex<Said>, taken: &SyncSender<Result<(), Refusal>>) {
    let sender = match HandSender::open(station) {
        Ok(sender) => sender,
        Err(error) => {
            let _ = taken.send(Err(Refusal::Hand(error)));
            return;
        }
    };
    let send = |message: HandMsg| {
        sender.send(HandMsg {
            at_ns: now_ns(),
            ..message
        })
    };
    if !send(lock(said).message) {
        sender.forget_dead();
        let _ = taken.send(Err(Refusal::NoHand));
        return;
    }
    let _ = taken.send(Ok(()));
    loop {
        std::thread::sleep(SEND_EVERY);
        let message = {
            let said = lock(said);
            match (said.lasts(Instant::now()), said.is_last) {
                (true, _) => Some(said.message),
                (false, true) => return,
                (false, false) => None,
            }
        };
        if let Some(message) = message {
            send(message);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_outlasts_a_slow_picture_and_the_last_one_is_short() {
        let now = Instant::now();
        let said = |is_last| Said {
            message: bytemuck::Zeroable::zeroed(),
            at: now,
            is_last,
        };
        let after = |seconds: f64| now + Duration::from_secs_f64(seconds);
        assert!(said(false).lasts(after(3.4)), "the picture took 3.3 s");
        assert!(!said(false).lasts(after(4.1)), "the display hangs");
        assert!(said(true).lasts(after(0.1)));
        assert!(!said(true).lasts(after(0.3)));
    }
}
