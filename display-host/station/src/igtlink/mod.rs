//! `calot igtlink`: sends the poses of instrument and endoscope, the force, the instrument in use,
//! events and surfaces to 3D Slicer, PLUS and other programs, over OpenIGTLink.

mod anatomy;
mod clock;
mod frame;
mod messages;
mod watch;

use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::{Duration, Instant};

use bytemuck::Zeroable as _;
use clap::Args;
use hardware::igtlink::Server;
use serde_json::json;
use shared_mem::message::ToolFrame;
use shared_mem::service::{Host, Station};
use shared_mem::words::Switches;

use crate::args::{parse_seconds, parse_station};
use crate::document;
use crate::problem::Problem;
use crate::say;
use crate::stop;

use anatomy::Anatomy;
use clock::Stamps;
use frame::Frame;
use watch::{Condition, Watch};

const HELP: &str = "\
Sent with each frame, in mm and in the frame of --frame, stamped with the time of the tick:
  TRANSFORM ToolToReference       the instrument: origin at the joint of its jaws, the shaft's
                                  tip towards -z. Tissue holds it back, but not the handle
  TRANSFORM HandleToReference     the handle in the hand
  TRANSFORM EndoscopeToReference  the camera: it looks along -z, y is up in its picture
  TRANSFORM ForceToReference      moves by 1 mm per newton on the hand
  SENSOR    Force                 the force on the hand, N: x, y, z
  SENSOR    Jaw                   opening of the jaws, 0 shut to 1 open
  TDATA     Calot                 Tool, Handle and Endoscope; only to clients that ask by STT_TDATA
  QTDATA    Calot                 the same with quaternions; only to clients that ask by STT_QTDATA
Sent with --surfaces HZ, stamped alike in each round:
  POLYDATA  liver, gallbladder …  the organ's surface as it is drawn, in mm
Sent as they occur:
  STRING    Instrument            the instrument in use
  STRING    Event                 alarms and events, e.g. 'alarm speed_trip', 'cut cystic_duct'.
                                  If `calot rt` was started by hand, organs have numbers: 'cut organ 2'
  STATUS    Calot                 running, paused, silent, ended

The scene's axes are x to the patient's left, y to the head, z to the front. --frame turns them:
  ras    x right, y front, z head: 3D Slicer.   (x y z) = (-1,0,0) (0,0,1) (0,1,0)  * scene
  lps    x left,  y back,  z head: DICOM, ITK.  (x y z) = ( 1,0,0) (0,0,-1) (0,1,0) * scene
  scene  x left,  y head,  z front: as it is
Each bracket is a row of the matrix. Both are rotations. The axes of instrument and camera
themselves are not turned.

Answered: GET_STATUS, GET_CAPABIL, GET_TRANS, GET_TDATA, GET_QTDATA, GET_SENSOR, GET_STRING,
GET_POLYDATA, STT_TDATA, STP_TDATA, STT_QTDATA and STP_QTDATA. Other messages get a STATUS that says so. A
client that begins with a GET_ of data, within 0.2 s, gets answers only, until it has asked nothing
for 5 s. Headers of version 1 and 2 are read, and each client is answered in its own version. At
most 8 clients connect; a ninth is told so and disconnected.

In 3D Slicer, open the module OpenIGTLinkIF and add a connector of type Client to the address of
--listen. The exit code is 1 if the station never ran while this program did.";

#[derive(Debug, Clone, Args)]
#[command(after_help = HELP)]
pub(crate) struct IgtlinkArgs {
    /// Name of the station
    #[arg(long, value_name = "NAME", default_value = "main", value_parser = parse_station)]
    pub(crate) station: String,
    /// Address where up to 8 clients connect. 0.0.0.0:18944 admits other machines, without a
    /// password
    #[arg(long, value_name = "ADDRESS:PORT", default_value = "127.0.0.1:18944")]
    pub(crate) listen: std::net::SocketAddr,
    /// Frame of all poses and of the force
    #[arg(long, value_enum, default_value_t = Frame::Ras)]
    frame: Frame,
    /// Frames per second, Hz, 1 to 1000
    #[arg(long, value_name = "HZ", default_value_t = 60.0, value_parser = parse_rate)]
    pub(crate) rate_hz: f64,
    /// Send the surfaces of all organs this often, Hz, up to 30; 0 sends none
    #[arg(long, value_name = "HZ", default_value_t = 0.0, value_parser = parse_surfaces)]
    surfaces: f64,
    /// End after this time, s, e.g. 60 [default: on Ctrl-C]
    #[arg(long, value_name = "N", value_parser = parse_seconds)]
    pub(crate) seconds: Option<f64>,
    /// Print one JSON object when it listens, and one when it ends
    #[arg(long)]
    pub(crate) json: bool,
}

fn parse_rate(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(hz) if (1.0..=1000.0).contains(&hz) => Ok(hz),
        _ => Err(format!("'{text}' is not a rate of 1 to 1000 Hz")),
    }
}

fn parse_surfaces(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(hz) if (0.0..=30.0).contains(&hz) => Ok(hz),
        _ => Err(format!("'{text}' is not a rate of 0 to 30 Hz")),
    }
}

/// Interval at which the condition is repeated while the station sends nothing, so that clients
/// that left are noticed.
const REPEAT: Duration = Duration::from_secs(2);

/// Serves until a signal or --seconds ends the command. Runs outside the realtime process and reads
/// shared memory like a display.
pub(crate) fn run(args: &IgtlinkArgs) -> Result<ExitCode, Problem> {
    let stop = stop::flag()?;
    let station = Station::new(&args.station)?;
    let host = Host::open(&station)?;
    let server = Server::bind(args.listen, messages::STATION, args.frame.name())
        .map_err(|error| format!("{}: {error}; choose another with --listen", args.listen))?;
    let address = server.address()?;
    if args.json {
        document::IGTLINK
            .line(json!({ "listening": address.to_string(), "frame": args.frame.name() }))?;
    } else {
        say::note(format_args!(
            "OpenIGTLink at {address}, station '{}', frame {}; Ctrl-C ends it",
            args.station,
            args.frame.name()
        ));
    }
    let mut sender = Sender::new(args, station, host, server);
    sender.serve(&stop);
    sender.report(args.json)
}

/// Carries a station's frames and events to the server.
struct Sender<'a> {
    args: &'a IgtlinkArgs,
    station: Station,
    host: Host,
    server: Server,
    stamps: Stamps,
    /// Stamps of events, which may be newer than the newest frame.
    event_stamps: Stamps,
    watch: Watch,
    anatomy: Anatomy,
    /// Instrument in the last message `Instrument`.
    instrument: Option<u32>,
    /// Number of frames sent.
    frames: u64,
    /// Number of connected clients.
    clients: usize,
    /// Time of the last message about the condition.
    repeated: Instant,
}

/// Time of the next round. It counts from the time at which this round was due, so that the work of
/// a round does not lower the rate. A round that is missed is not made up for.
fn next(due: Instant, interval: Duration, now: Instant) -> Instant {
    (due + interval).max(now)
}

impl<'a> Sender<'a> {
    fn new(args: &'a IgtlinkArgs, station: Station, host: Host, server: Server) -> Self {
        let stamps = Stamps::now();
        let now = Instant::now();
        let mut sender = Self {
            args,
            station,
            host,
            server,
            event_stamps: stamps.clone(),
            stamps,
            watch: Watch::new(now),
            anatomy: Anatomy::new(&args.station, args.surfaces),
            instrument: None,
            frames: 0,
            clients: 0,
            repeated: now,
        };
        sender.announce_condition();
        sender
    }

    fn serve(&mut self, stop: &AtomicBool) {
        let start = Instant::now();
        let interval = Duration::from_secs_f64(1.0 / self.args.rate_hz);
        let mut due = start;
        let mut tools = ToolFrame::zeroed();
        let is_time = |limit: f64| start.elapsed().as_secs_f64() >= limit;
        while !stop.load(Relaxed) && !self.args.seconds.is_some_and(is_time) {
            self.server.attend(self.stamps.present());
            let is_new = self.host.newest_tools(&mut tools) && tools.capsules().is_some();
            self.follow(is_new.then_some(&tools));
            if is_new {
                self.anatomy.meet(&tools);
            }
            self.send_events();
            if is_new {
                self.send_moment(&tools);
                let surfaces = self.anatomy.due(&self.host, &tools, self.args.frame);
                self.server.send(&surfaces);
            }
            if self.server.client_count() != self.clients {
                self.clients = self.server.client_count();
                say::note(format_args!("{} connected", self.clients));
            }
            let now = Instant::now();
            due = next(due, interval, now);
            std::thread::sleep(due.saturating_duration_since(now));
        }
    }

    /// Follows the station's condition. A change is announced to clients, and to the user.
    fn follow(&mut self, tools: Option<&ToolFrame>) {
        let now = Instant::now();
        let before = match tools {
            Some(tools) => {
                let is_paused = tools.switches().contains(Switches::PAUSED);
                self.watch.heard(now, is_paused)
            }
            None => self.watch.silence(now, || self.station.is_claimed()),
        };
        let condition = self.watch.condition();
        let flows = matches!(condition, Condition::Running | Condition::Paused);
        if condition != before {
            if !flows {
                self.server.forget_moment();
                self.instrument = None;
            }
            self.announce_condition();
            if let Some(note) = condition.note(&self.args.station, before) {
                say::note(note);
            }
        } else if !flows && self.repeated.elapsed() > REPEAT {
            // Forget a controller that died, so that its successor is found.
            self.host.forget_dead();
            self.announce_condition();
        }
    }

    fn announce_condition(&mut self) {
        let condition = self.watch.condition();
        let status = condition.status(&self.args.station, self.stamps.present());
        self.server.announce(&status);
        self.repeated = Instant::now();
    }

    fn send_events(&mut self) {
        let mut events = Vec::new();
        let (stamps, anatomy) = (&mut self.event_stamps, &self.anatomy);
        self.host.drain_events(|event| {
            let organ = anatomy.name(event.organ);
            events.push(messages::event(event, organ, stamps.of(event.at_ns)));
        });
        self.server.send(&events);
    }

    fn send_moment(&mut self, tools: &ToolFrame) {
        let unix_ns = self.stamps.of(tools.at_ns);
        if self.instrument != Some(tools.instrument) {
            self.instrument = Some(tools.instrument);
            self.server.announce(&messages::instrument(tools, unix_ns));
        }
        self.server
            .send(&messages::moment(tools, self.args.frame, unix_ns));
        self.frames += 1;
    }

    /// Reports how much was sent. Fails if no frame was sent.
    fn report(&self, json: bool) -> Result<ExitCode, Problem> {
        let (frames, skipped) = (self.frames, self.server.skipped());
        let turned_away = self.server.turned_away();
        if json {
            document::IGTLINK.line(json!({
                "frames": frames, "skipped": skipped, "turned_away": turned_away,
            }))?;
        } else {
            say::note(format_args!(
                "{frames} frames; {skipped} messages skipped for clients that did not read; \
                 {turned_away} clients turned away"
            ));
        }
        if frames > 0 {
            return Ok(ExitCode::SUCCESS);
        }
        say::note(format_args!(
            "nothing was sent: station '{0}' did not run; start it with `calot run --station {0}`",
            self.args.station
        ));
        Ok(ExitCode::FAILURE)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn work_does_not_lower_the_rate_and_a_missed_round_is_not_made_up_for() {
        let [start, interval] = [Duration::ZERO, Duration::from_millis(20)];
        let zero = Instant::now();
        let round = |due: Duration, now: Duration| next(zero + due, interval, zero + now) - zero;
        let busy = Duration::from_millis(7);
        assert_eq!(round(start, busy), interval);
        assert_eq!(round(interval, interval + busy), 2 * interval);
        let late = Duration::from_millis(95);
        assert_eq!(round(interval, late), late);
    }
}
