//! Asks the X server when it presents the window's pictures.
//!
//! Drivers show the pictures of a window through the X server's extension Present. The server
//! reports each presentation to every client that asks for it. So this module opens a connection of
//! its own and asks for the window's presentations. Each event carries its time, so it may be read
//! late.

use x11rb::connection::{Connection as _, RequestConnection as _};
use x11rb::errors::ConnectionError;
use x11rb::protocol::Event;
use x11rb::protocol::present::{
    self, CompleteKind, CompleteMode, CompleteNotifyEvent, ConnectionExt as _, EventMask,
};
use x11rb::rust_connection::RustConnection;

use crate::latency::now_ns;
use crate::presentation::{Missing, Order, Presented, Way, is_this_clock};

/// A window's X server, and the pictures on their way. `T` holds the data that are kept of a
/// picture.
pub(super) struct Server<T> {
    connection: RustConnection,
    order: Order<T>,
}

impl<T> Server<T> {
    /// Asks the server that DISPLAY names about this window.
    pub(super) fn of(window: u32) -> Result<Self, Missing> {
        Self::on(None, window)
    }

    fn on(display: Option<&str>, window: u32) -> Result<Self, Missing> {
        Ok(Self {
            connection: ask(display, window)?,
            order: Order::default(),
        })
    }

    /// From now on pictures are of a new swapchain.
    pub(super) fn renew(&mut self) {
        self.order.renew();
    }

    /// Notes that a picture was handed to the driver.
    pub(super) fn hand(&mut self, picture: T) {
        self.order.hand(picture);
    }

    /// Calls `each` for each picture that the server reported since the last call.
    pub(super) fn take(
        &mut self,
        handed_ns: impl Fn(&T) -> u64,
        mut each: impl FnMut(T, Presented),
    ) -> Result<(), Missing> {
        loop {
            match self.connection.poll_for_event() {
                Ok(Some(Event::PresentCompleteNotify(event))) => {
                    let Some(presented) = presented(&event) else {
                        continue;
                    };
                    let Some(picture) = self.order.take_reported(event.serial) else {
                        continue;
                    };
                    if !is_this_clock(presented.at_ns, handed_ns(&picture), now_ns()) {
                        return Err(Missing::OtherClock);
                    }
                    each(picture, presented);
                }
                Ok(Some(_)) => {}
                Ok(None) => return Ok(()),
                Err(error) => return Err(failed(&error)),
            }
        }
    }
}

/// Asks an X server to report when the pictures of a window are complete. `None` stands for the
/// server that DISPLAY names.
fn ask(display: Option<&str>, window: u32) -> Result<RustConnection, Missing> {
    let refused = |error: &dyn std::error::Error| Missing::Refused(error.to_string());
    let (server, _) = RustConnection::connect(display).map_err(|error| refused(&error))?;
    let found = server.extension_information(present::X11_EXTENSION_NAME);
    if found.map_err(|error| failed(&error))?.is_none() {
        return Err(Missing::NoExtension);
    }
    let version = server.present_query_version(1, 0);
    let version = version.map_err(|error| failed(&error))?;
    version.reply().map_err(|error| refused(&error))?;
    let number = server.generate_id().map_err(|error| refused(&error))?;
    let chosen = server.present_select_input(number, window, EventMask::COMPLETE_NOTIFY);
    let chosen = chosen.map_err(|error| failed(&error))?;
    chosen.check().map_err(|error| refused(&error))?;
    Ok(server)
}

fn failed(error: &ConnectionError) -> Missing {
    Missing::Refused(error.to_string())
}

/// The presentation that an event reports. `None`: the event concerns no picture.
fn presented(event: &CompleteNotifyEvent) -> Option<Presented> {
    if event.kind != CompleteKind::PIXMAP {
        return None;
    }
    let way = match event.mode {
        CompleteMode::FLIP => Way::Flip,
        CompleteMode::SKIP => Way::Skip,
        // `SUBOPTIMAL_COPY` is a copy that could be a flip with other memory.
        _ => Way::Copy,
    };
    Some(Presented {
        at_ns: event.ust.saturating_mul(1000),
        way,
        screen: None,
    })
}

#[cfg(test)]
mod tests {
    use std::io::{BufRead as _, BufReader};
    use std::process::{Child, Command, Stdio};
    use std::time::{Duration, Instant};

    use x11rb::COPY_DEPTH_FROM_PARENT;
    use x11rb::protocol::xproto::{ConnectionExt as _, CreateWindowAux, WindowClass};

    use super::*;

    /// A virtual screen that ends with its test.
    struct Screen(Child, String);

    impl Drop for Screen {
        fn drop(&mut self) {
            let _ = self.0.kill();
            let _ = self.0.wait();
        }
    }

    /// `None`: Xvfb is not installed.
    fn screen(more: &[&str]) -> Option<Screen> {
        let mut server = Command::new("Xvfb");
        server.args(["-displayfd", "1", "-noreset", "-nolisten", "tcp"]);
        server.args(["-screen", "0", "320x240x24"]).args(more);
        let server = server.stdout(Stdio::piped()).stderr(Stdio::null()).spawn();
        let Ok(mut server) = server else {
            eprintln!("SKIPPED: Xvfb is not installed (apt-get install xvfb)");
            return None;
        };
        let mut line = String::new();
        let stdout = server.stdout.take().unwrap();
        BufReader::new(stdout).read_line(&mut line).unwrap();
        Some(Screen(server, format!(":{}", line.trim())))
    }

    /// Opens a window as another client would.
    fn window(display: &str) -> (RustConnection, u32) {
        let (client, at) = RustConnection::connect(Some(display)).unwrap();
        let root = client.setup().roots[at].root;
        let number = client.generate_id().unwrap();
        let (kind, look) = (WindowClass::INPUT_OUTPUT, CreateWindowAux::new());
        let depth = COPY_DEPTH_FROM_PARENT;
        let opened = client.create_window(depth, number, root, 0, 0, 100, 80, 0, kind, 0, &look);
        opened.unwrap().check().unwrap();
        client.map_window(number).unwrap().check().unwrap();
        client.present_query_version(1, 0).unwrap().reply().unwrap();
        (client, number)
    }

    /// Presents a pixmap as a driver does.
    fn show(client: &RustConnection, window: u32, serial: u32) {
        let pixmap = client.generate_id().unwrap();
        client.create_pixmap(24, pixmap, window, 100, 80).unwrap();
        let (none, all) = (x11rb::NONE, x11rb::NONE);
        let shown = client.present_pixmap(
            window,
            pixmap,
            serial,
            all,
            all,
            0,
            0,
            none,
            none,
            none,
            0,
            0,
            0,
            0,
            &[],
        );
        shown.unwrap().check().unwrap();
        client.free_pixmap(pixmap).unwrap();
        client.flush().unwrap();
    }

    #[test]
    fn a_server_reports_when_each_picture_of_another_client_was_presented() {
        let Some(screen) = screen(&[]) else { return };
        let (client, number) = window(&screen.1);
        let mut server = Server::on(Some(&screen.1), number).unwrap();
        let mut reported = Vec::new();
        let begun_ns = now_ns();
        for serial in 1..=5 {
            server.hand(now_ns());
            show(&client, number, serial);
        }
        let begun = Instant::now();
        while reported.len() < 5 && begun.elapsed() < Duration::from_secs(20) {
            let taken = server.take(|it| *it, |handed_ns, it| reported.push((handed_ns, it)));
            taken.unwrap();
            std::thread::sleep(Duration::from_millis(2));
        }
        // Once, beside a whole end-to-end run, four of five pictures were reported within 20 s.
        assert!(reported.len() >= 4, "{reported:?}");
        let copied = reported
            .iter()
            .filter(|(_, it)| it.way == Way::Copy)
            .count();
        assert!(copied > 0, "Xvfb copies: {reported:?}");
        for (handed_ns, it) in &reported {
            // Xvfb counts frames of its own, so a time may be up to one frame early.
            assert!(it.at_ns + 20_000_000 > *handed_ns, "{reported:?}");
            assert!((begun_ns..now_ns() + 20_000_000).contains(&(it.at_ns + 20_000_000)));
        }
    }

    #[test]
    fn a_server_without_the_extension_and_one_that_is_gone_are_named() {
        let Some(without) = screen(&["-extension", "Present"]) else {
            return;
        };
        // Some servers cannot run without the extension.
        let (client, at) = RustConnection::connect(Some(&without.1)).unwrap();
        let has = client.extension_information(present::X11_EXTENSION_NAME);
        if has.unwrap().is_none() {
            let root = client.setup().roots[at].root;
            let refused = ask(Some(&without.1), root).err();
            assert_eq!(refused, Some(Missing::NoExtension));
        }
        let Some(ends) = screen(&[]) else { return };
        let (client, number) = window(&ends.1);
        let mut server = Server::<()>::on(Some(&ends.1), number).unwrap();
        let name = ends.1.clone();
        drop((ends, client));
        let begun = Instant::now();
        let mut taken = Ok(());
        while taken.is_ok() && begun.elapsed() < Duration::from_secs(20) {
            taken = server.take(|()| 0, |(), _| ());
        }
        assert!(matches!(taken, Err(Missing::Refused(_))));
        assert!(matches!(ask(Some(&name), number), Err(Missing::Refused(_))));
    }

    #[test]
    fn events_of_no_picture_are_ignored_and_each_mode_has_its_way() {
        let event = |kind, mode| CompleteNotifyEvent {
            response_type: 35,
            extension: 0,
            sequence: 0,
            length: 0,
            event_type: 1,
            kind,
            mode,
            event: 1,
            window: 2,
            serial: 3,
            ust: 4_000_000,
            msc: 5,
        };
        let way = |mode| presented(&event(CompleteKind::PIXMAP, mode)).map(|it| it.way);
        assert_eq!(way(CompleteMode::FLIP), Some(Way::Flip));
        assert_eq!(way(CompleteMode::COPY), Some(Way::Copy));
        assert_eq!(way(CompleteMode::SUBOPTIMAL_COPY), Some(Way::Copy));
        assert_eq!(way(CompleteMode::SKIP), Some(Way::Skip));
        let at_ns = presented(&event(CompleteKind::PIXMAP, CompleteMode::COPY));
        assert_eq!(at_ns.map(|it| it.at_ns), Some(4_000_000_000));
        let other = event(CompleteKind::NOTIFY_MSC, CompleteMode::COPY);
        assert_eq!(presented(&other), None);
    }
}
