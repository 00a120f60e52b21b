//! The window's Wayland objects, which belong to winit, as objects of wayland-client.
#![allow(unsafe_code)] // pointers from winit's handles

use std::sync::Arc;

use wayland_client::backend::{Backend, ObjectId};
use wayland_client::protocol::wl_surface::WlSurface;
use wayland_client::{Connection, Proxy as _};
use winit::event_loop::OwnedDisplayHandle;
use winit::raw_window_handle::{
    HasDisplayHandle as _, HasWindowHandle as _, RawDisplayHandle, RawWindowHandle,
};
use winit::window::Window;

use crate::presentation::Missing;

/// A window's connection to the compositor, shared with winit, and its surface. The fields are
/// dropped in this order: winit's owners go last.
pub(super) struct Objects {
    pub(super) surface: WlSurface,
    pub(super) connection: Connection,
    _window: Arc<Window>,
    _display: OwnedDisplayHandle,
}

impl Objects {
    /// The objects of a window on this display.
    pub(super) fn of(window: &Arc<Window>, display: OwnedDisplayHandle) -> Result<Self, Missing> {
        let refused = |error: &dyn std::fmt::Display| Missing::Refused(error.to_string());
        let shown = display.display_handle().map_err(|error| refused(&error))?;
        let drawn = window.window_handle().map_err(|error| refused(&error))?;
        let (RawDisplayHandle::Wayland(shown), RawWindowHandle::Wayland(drawn)) =
            (shown.as_raw(), drawn.as_raw())
        else {
            return Err(refused(&"the window is not on Wayland"));
        };
        // SAFETY: the pointer is that of an open connection. `display` keeps it open. Only
        // `connection` and objects made from it use this backend, and `display` is dropped after
        // them.
        let backend = unsafe { Backend::from_foreign_display(shown.display.as_ptr().cast()) };
        let connection = Connection::from_backend(backend);
        // SAFETY: the window owns the surface and is borrowed here. Later, the id shows whether the
        // surface is gone, because winit uses the same wayland-client.
        let id =
            unsafe { ObjectId::from_ptr(WlSurface::interface(), drawn.surface.as_ptr().cast()) };
        let id = id.map_err(|error| refused(&error))?;
        let surface = WlSurface::from_id(&connection, id).map_err(|error| refused(&error))?;
        Ok(Self {
            surface,
            connection,
            _window: Arc::clone(window),
            _display: display,
        })
    }
}
