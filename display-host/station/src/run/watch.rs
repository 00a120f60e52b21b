//! Watches the processes of a station.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use crate::children::Process;

/// Watches the children in a thread. A child that dies ends the run.
pub(super) struct Watch {
    thread: std::thread::JoinHandle<Vec<String>>,
    pub(super) over: Arc<AtomicBool>,
}

impl Watch {
    pub(super) fn begin(mut children: Vec<Process>, stop: Arc<AtomicBool>) -> Self {
        let over = Arc::new(AtomicBool::new(false));
        let watched = over.clone();
        let thread = std::thread::spawn(move || {
            let (mut dead, mut died) = (Vec::new(), Vec::new());
            while !watched.load(Ordering::Relaxed) && dead.is_empty() {
                for child in &mut children {
                    if let Ok(Some(status)) = child.ended() {
                        died.push(child.name());
                        dead.push(format!("the {} process died ({status})", child.name()));
                        stop.store(true, Ordering::Relaxed);
                    }
                }
                std::thread::sleep(Duration::from_millis(20));
            }
            // End the controller first: it sends a last, zero force while the device still listens.
            for child in children.into_iter().rev() {
                let name = child.name();
                if let Some(problem) = child.end()
                    && !died.contains(&name)
                {
                    dead.push(problem);
                }
            }
            dead
        });
        Self { thread, over }
    }

    /// Ends the children. Returns a message for each that died by itself or failed at its end.
    pub(super) fn end(self) -> Vec<String> {
        self.over.store(true, Ordering::Relaxed);
        self.thread
            .join()
            .unwrap_or_else(|_| vec!["the watching thread panicked".into()])
    }
}
