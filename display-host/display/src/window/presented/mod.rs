//! Asks the window system when it presents the window's pictures.

mod foreign;
mod wayland;
mod x11;

use std::sync::Arc;

use winit::event_loop::OwnedDisplayHandle;
use winit::raw_window_handle::{HasWindowHandle as _, RawWindowHandle};
use winit::window::Window;

use crate::latency::FrameRecord;
use crate::patch::Lit;
use crate::presentation::{Missing, Presented, Source};

/// A picture that was handed to the driver.
pub(super) struct Handed {
    /// Record of the scene's picture in it, if that picture is new.
    pub(super) frame: Option<FrameRecord>,
    /// The square of `calot photon` in it.
    pub(super) lit: Option<Lit>,
    /// Time of the handing over, ns.
    pub(super) handed_ns: u64,
}

/// Pictures of a window on their way to the screen. `T` holds the data that are kept of a picture.
pub(super) struct Watch<T> {
    source: Option<Source>,
    system: Result<System<T>, Missing>,
}

/// The window system that is asked.
enum System<T> {
    X11(Box<x11::Server<T>>),
    Wayland(Box<wayland::Compositor<T>>),
}

impl<T> Watch<T> {
    /// Watches a window of this display. Call it before its first picture.
    pub(super) fn of(window: &Arc<Window>, display: OwnedDisplayHandle) -> Self {
        let (source, system) = match window.window_handle().map(|it| it.as_raw()) {
            Ok(RawWindowHandle::Xlib(it)) => {
                let number = u32::try_from(it.window);
                let number = number.map_err(|error| Missing::Refused(error.to_string()));
                (Some(Source::X11Present), number.and_then(asked))
            }
            Ok(RawWindowHandle::Xcb(it)) => (Some(Source::X11Present), asked(it.window.get())),
            Ok(RawWindowHandle::Wayland(_)) => {
                let asked = foreign::Objects::of(window, display);
                let asked = asked.and_then(wayland::Compositor::of);
                let system = asked.map(|it| System::Wayland(Box::new(it)));
                (Some(Source::WpPresentation), system)
            }
            Ok(other) => {
                let unknown = format!("unknown window {other:?}");
                (None, Err(Missing::Refused(unknown)))
            }
            Err(error) => (None, Err(Missing::Refused(error.to_string()))),
        };
        Self { source, system }
    }

    /// The window system's interface that is asked.
    pub(super) const fn source(&self) -> Option<Source> {
        self.source
    }

    /// Reason for which no times are reported, if it is known.
    pub(super) fn refused(&self) -> Option<&Missing> {
        self.system.as_ref().err()
    }

    /// From now on pictures are of a new swapchain.
    pub(super) fn renew(&mut self) {
        if let Ok(System::X11(server)) = &mut self.system {
            server.renew();
        }
    }

    /// Asks about the picture that is handed to the driver next.
    pub(super) fn ask(&mut self) {
        if let Ok(System::Wayland(compositor)) = &mut self.system {
            compositor.ask();
        }
    }

    /// Notes that a picture was handed to the driver.
    pub(super) fn hand(&mut self, picture: T) {
        match &mut self.system {
            Ok(System::X11(server)) => server.hand(picture),
            Ok(System::Wayland(compositor)) => compositor.hand(picture),
            Err(_) => {}
        }
    }

    /// Calls `each` for each picture that the window system reported since the last call.
    /// `handed_ns` is the time at which a picture was handed over.
    pub(super) fn take(&mut self, handed_ns: impl Fn(&T) -> u64, each: impl FnMut(T, Presented)) {
        let outcome = match &mut self.system {
            Ok(System::X11(server)) => server.take(handed_ns, each),
            Ok(System::Wayland(compositor)) => compositor.take(handed_ns, each),
            Err(_) => return,
        };
        if let Err(missing) = outcome {
            self.system = Err(missing);
        }
    }
}

fn asked<T>(window: u32) -> Result<System<T>, Missing> {
    x11::Server::of(window).map(|it| System::X11(Box::new(it)))
}
