//! Loan handover: the publishing thread lends shared-memory samples to the tick as plain memory.
//!
//! ```text
//! publishing thread                      tick
//! loan, touch ── slot ──► free ──────►  fill in place
//! send, loan again ◄───── full ◄──────  give back
//! ```
//!
//! The tick never calls iceoryx2. It takes a slot, fills it and gives it back. It neither allocates
//! nor blocks. It causes no page fault, because the publishing thread has already written to the
//! pages. If no slot is free, the tick skips the frame and reports that.
#![expect(
    unsafe_code,
    reason = "loaned samples cross to the tick as pointers: iceoryx2's types are not Send"
)]

use core::mem::ManuallyDrop;
use core::ptr::NonNull;

use bytemuck::Pod;
use heapless::spsc::{Consumer, Producer, Queue};

/// Number of samples of one service that circulate between the two threads.
pub(crate) const SLOTS: usize = 5;
const QUEUE: usize = SLOTS + 1;

/// Source of the lent memory: a publisher, or boxes in tests.
///
/// # Safety
/// A loan's memory is initialised and stays in place. Nobody but the loan's holder writes it until
/// the loan is sent or dropped. Any thread may write it.
pub(crate) unsafe trait Lender<T> {
    /// A loan: the exclusive right to use one sample's memory.
    type Loan;
    /// Lends a free sample; `None` if no sample is free now.
    fn loan(&mut self) -> Option<Self::Loan>;
    /// The memory that was lent.
    fn memory(loan: &mut Self::Loan) -> NonNull<T>;
    /// Publishes the sample.
    fn send(&mut self, loan: Self::Loan);
}

/// A lent sample in one of the queues or in the tick. Only its holder may use the memory.
struct Slot<T> {
    index: usize,
    memory: NonNull<T>,
}

// SAFETY: while the slot exists, nobody reaches its memory in another way. `Lender` promises that
// any thread may write the memory. Every function that uses it requires `T: Pod`.
unsafe impl<T: Send> Send for Slot<T> {}

/// The tick's end.
pub(crate) struct Filler<T: 'static> {
    free: Consumer<'static, Slot<T>>,
    full: Producer<'static, Slot<T>>,
}

/// The publishing thread's end, which owns the loans.
pub(crate) struct Sender<T: 'static, L: Lender<T>> {
    lender: L,
    /// The loans must not be dropped while the tick may still write: see [`Sender::finish`].
    loans: [Option<ManuallyDrop<L::Loan>>; SLOTS],
    free: Producer<'static, Slot<T>>,
    full: Consumer<'static, Slot<T>>,
}

/// Both ends of a handover. Its queues are allocated and leaked, so that each thread can own an end
/// that is `'static`.
pub(crate) struct Handover<T: 'static> {
    to_tick: (Producer<'static, Slot<T>>, Consumer<'static, Slot<T>>),
    from_tick: (Producer<'static, Slot<T>>, Consumer<'static, Slot<T>>),
}

impl<T: Pod + Send> Handover<T> {
    pub(crate) fn new() -> Self {
        let queue = || Box::leak(Box::new(Queue::<Slot<T>, QUEUE>::new())).split();
        Self {
            to_tick: queue(),
            from_tick: queue(),
        }
    }

    /// Splits the handover into the tick's end and the queues of the publishing thread.
    /// [`SenderEnds::lend`] makes these a [`Sender`].
    pub(crate) fn split(self) -> (Filler<T>, SenderEnds<T>) {
        let (free_in, free_out) = self.to_tick;
        let (full_in, full_out) = self.from_tick;
        let filler = Filler {
            free: free_out,
            full: full_in,
        };
        let ends = SenderEnds {
            free: free_in,
            full: full_out,
        };
        (filler, ends)
    }
}

/// The publishing thread's queues before its publisher is open.
pub(crate) struct SenderEnds<T: 'static> {
    free: Producer<'static, Slot<T>>,
    full: Consumer<'static, Slot<T>>,
}

impl<T: Pod + Send> SenderEnds<T> {
    /// Lends the first samples to the tick, after a write to each of their pages.
    pub(crate) fn lend<L: Lender<T>>(self, lender: L) -> Sender<T, L> {
        let mut sender = Sender {
            lender,
            loans: [const { None }; SLOTS],
            free: self.free,
            full: self.full,
        };
        sender.refill();
        sender
    }
}

impl<T: Pod + Send> Filler<T> {
    /// Lets `fill` write the next free sample, then gives the sample back for sending. The memory
    /// may hold an earlier frame. If no sample is free, returns false and does not call `fill`.
    pub(crate) fn fill(&mut self, fill: impl FnOnce(&mut T)) -> bool {
        let Some(mut slot) = self.free.dequeue() else {
            return false;
        };
        // SAFETY: the sender lent this memory and does not touch it until the slot is back. The
        // memory is initialised (`Lender`), and any content is valid (`Pod`).
        fill(unsafe { slot.memory.as_mut() });
        // The queue has room for all slots.
        self.full.enqueue(slot).is_ok()
    }
}

impl<T: Pod + Send, L: Lender<T>> Sender<T, L> {
    /// Publishes the filled samples, oldest first, and lends new ones. Returns how many were
    /// published.
    pub(crate) fn send_filled(&mut self) -> usize {
        let mut sent = 0;
        while let Some(slot) = self.full.dequeue() {
            if let Some(loan) = self.loans.get_mut(slot.index).and_then(Option::take) {
                self.lender.send(ManuallyDrop::into_inner(loan));
                sent += 1;
            }
        }
        self.refill();
        sent
    }

    fn refill(&mut self) {
        for (index, place) in self.loans.iter_mut().enumerate() {
            if place.is_some() {
                continue;
            }
            let Some(mut loan) = self.lender.loan() else {
                return;
            };
            let memory = L::memory(&mut loan);
            touch(memory);
            *place = Some(ManuallyDrop::new(loan));
            // The queue has room for all slots.
            let _ = self.free.enqueue(Slot { index, memory });
        }
    }

    /// Publishes what is filled and returns all other loans. Call it only after the tick's thread
    /// has ended. A sender that is dropped without this call (in a panic) leaks its loans, because
    /// the tick may still write them.
    pub(crate) fn finish(mut self) {
        self.send_filled();
        for loan in self.loans.iter_mut().filter_map(Option::take) {
            drop(ManuallyDrop::into_inner(loan));
        }
    }
}

/// Writes one byte in every 4096, from the first on, so that the tick's first write to these pages
/// causes no page fault.
fn touch<T>(memory: NonNull<T>) {
    let start = memory.cast::<u8>();
    for offset in (0..size_of::<T>()).step_by(4096) {
        // SAFETY: inside the sample's memory, which this thread owns until it lends it.
        unsafe {
            let byte = start.add(offset);
            byte.write_volatile(byte.read_volatile());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::RefCell;
    use std::rc::Rc;

    /// Lends boxes, at most `left` at a time, and stores those that are sent.
    struct Boxes {
        left: usize,
        sent: Rc<RefCell<Vec<[u64; 1024]>>>,
    }

    // SAFETY: a box's memory is initialised, stays in place and has one owner.
    unsafe impl Lender<[u64; 1024]> for Boxes {
        type Loan = Box<[u64; 1024]>;
        fn loan(&mut self) -> Option<Self::Loan> {
            self.left = self.left.checked_sub(1)?;
            Some(Box::new([0; 1024]))
        }
        fn memory(loan: &mut Self::Loan) -> NonNull<[u64; 1024]> {
            NonNull::from(&mut **loan)
        }
        fn send(&mut self, loan: Self::Loan) {
            self.sent.borrow_mut().push(*loan);
            self.left += 1;
        }
    }

    fn pair(left: usize) -> (Filler<[u64; 1024]>, Sender<[u64; 1024], Boxes>) {
        let (filler, ends) = Handover::new().split();
        let sent = Rc::default();
        (filler, ends.lend(Boxes { left, sent }))
    }

    #[test]
    fn a_slow_publisher_costs_frames_and_never_blocks() {
        let (mut filler, mut sender) = pair(100);
        let filled = (0..20).filter(|&i| filler.fill(|f| *f = [i; 1024])).count();
        assert_eq!(filled, SLOTS);
        assert_eq!(sender.send_filled(), SLOTS);
        assert!(filler.fill(|f| *f = [77; 1024]), "slots are lent anew");
        let sent = Rc::clone(&sender.lender.sent);
        sender.finish();
        let heads: Vec<u64> = sent.borrow().iter().map(|f| f[0]).collect();
        assert_eq!(
            heads,
            [0, 1, 2, 3, 4, 77],
            "in order, none lost, none twice"
        );
    }

    #[test]
    fn lender_that_had_no_free_sample_lends_again() {
        let (mut filler, mut sender) = pair(2);
        assert!(filler.fill(|_| ()) && filler.fill(|_| ()));
        assert!(!filler.fill(|_| ()));
        sender.send_filled();
        assert!(filler.fill(|_| ()) && filler.fill(|_| ()));
        assert!(!filler.fill(|_| ()));
        sender.finish();
    }

    #[test]
    fn frames_arrive_whole_from_another_thread() {
        let (mut filler, mut sender) = pair(100);
        let tick = std::thread::spawn(move || {
            let mut next = 0;
            while next < 2000 {
                if filler.fill(|frame| *frame = [next; 1024]) {
                    next += 1;
                } else {
                    std::thread::yield_now();
                }
            }
        });
        while !tick.is_finished() {
            sender.send_filled();
            std::thread::yield_now();
        }
        tick.join().unwrap();
        let sent = Rc::clone(&sender.lender.sent);
        sender.finish();
        let sent = sent.borrow();
        assert_eq!(sent.len(), 2000);
        for (i, frame) in sent.iter().enumerate() {
            assert!(frame.iter().all(|&word| word == i as u64), "frame {i}");
        }
    }
}
