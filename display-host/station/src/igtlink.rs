//! `calot igtlink`: sends the poses of instrument and endoscope to 3D Slicer, PLUS and others.

use std::process::ExitCode;
use std::sync::atomic::Ordering::Relaxed;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use bytemuck::Zeroable as _;
use clap::Args;
use hardware::igtlink::Server;
use hardware::igtlink::wire::Transform;
use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion};
use rt_process::time_driver::monotonic_ns;
use serde_json::json;
use shared_mem::message::{PoseMsg, ToolFrame};
use shared_mem::service::{Host, Station};

use crate::args::{parse_seconds, parse_station};
use crate::problem::Problem;
use crate::say;
use crate::stop;

#[derive(Debug, Clone, Args)]
#[command(after_help = "\
It sends transforms in the scene's frame, mm: ToolToReference, HandleToReference and
EndoscopeToReference. ForceToReference moves 1 mm per newton on the hand.

In 3D Slicer, open the module OpenIGTLinkIF and add a connector of type Client to the address of
--listen.")]
pub(crate) struct IgtlinkArgs {
    /// Name of the station
    #[arg(long, value_name = "NAME", default_value = "main", value_parser = parse_station)]
    pub(crate) station: String,
    /// Address where clients connect. 0.0.0.0:18944 admits other machines, without a password
    #[arg(long, value_name = "ADDRESS:PORT", default_value = "127.0.0.1:18944")]
    pub(crate) listen: std::net::SocketAddr,
    /// Frames per second, Hz, 1 to 1000
    #[arg(long, value_name = "HZ", default_value_t = 60.0, value_parser = parse_rate)]
    pub(crate) rate_hz: f64,
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

/// Length on the wire for one newton of force, m: one millimetre.
const FORCE_M_N: f32 = 1.0e-3;
/// After this silence the controller may have died.
const SILENT: Duration = Duration::from_millis(500);

/// Serves until told to end. Runs outside the realtime process and reads shared memory like a
/// display.
pub(crate) fn run(args: &IgtlinkArgs) -> Result<ExitCode, Problem> {
    let stop = stop::flag()?;
    let host = Host::open(&Station::new(&args.station)?)?;
    let mut server = Server::bind(args.listen)
        .map_err(|error| format!("{}: {error}; choose another with --listen", args.listen))?;
    let address = server.address()?;
    if args.json {
        say::answer(json!({ "listening": address.to_string() }));
    } else {
        say::note(format_args!(
            "OpenIGTLink at {address}, station '{}'; Ctrl-C ends it",
            args.station
        ));
    }
    let clock = WallClock::now();
    let mut tools = ToolFrame::zeroed();
    let (mut sent, mut clients, mut heard) = (0u64, 0, Instant::now());
    let start = Instant::now();
    while !stop.load(Relaxed)
        && args
            .seconds
            .is_none_or(|s| start.elapsed().as_secs_f64() < s)
    {
        let is_new = host.newest_tools(&mut tools) && tools.capsules().is_some();
        if is_new {
            heard = Instant::now();
            server.publish(&transforms(&tools, clock));
            sent += 1;
        } else {
            server.publish(&[]); // sends nothing, but admits new clients
        }
        if heard.elapsed() > SILENT {
            host.forget_dead();
            heard = Instant::now();
        }
        if server.client_count() != clients {
            clients = server.client_count();
            say::note(format_args!("{clients} connected"));
        }
        std::thread::sleep(Duration::from_secs_f64(1.0 / args.rate_hz));
    }
    let skipped = server.skipped();
    if args.json {
        say::answer(json!({ "frames": sent, "skipped": skipped }));
    } else {
        say::note(format_args!(
            "{sent} frames; {skipped} messages skipped for clients that did not read"
        ));
    }
    Ok(ExitCode::SUCCESS)
}

/// A wall clock that is read once at the start and then advances with the monotonic clock. If
/// somebody sets the wall clock meanwhile, the stamps do not jump; receivers refuse stamps that run
/// backwards.
#[derive(Debug, Clone, Copy)]
struct WallClock {
    unix_from_monotonic_ns: i128,
}

impl WallClock {
    fn now() -> Self {
        let now = SystemTime::now().duration_since(UNIX_EPOCH);
        let unix_ns = now.unwrap_or_default().as_nanos() as i128;
        Self {
            unix_from_monotonic_ns: unix_ns - i128::from(monotonic_ns()),
        }
    }

    /// Time since 1970 of a moment on the monotonic clock, ns.
    fn unix_ns(self, at_ns: u64) -> u64 {
        let unix_ns = i128::from(at_ns) + self.unix_from_monotonic_ns;
        u64::try_from(unix_ns).unwrap_or_default()
    }
}

/// Transforms to send for a frame.
fn transforms(tools: &ToolFrame, clock: WallClock) -> [Transform<'static>; 4] {
    let unix_ns = clock.unix_ns(tools.sample_ns);
    let force = tools.force_n.map(|part| part * FORCE_M_N);
    [
        ("ToolToReference", pose(&tools.world_from_instrument)),
        ("HandleToReference", pose(&tools.world_from_handle)),
        ("EndoscopeToReference", pose(&tools.world_from_camera)),
        ("ForceToReference", Translation3::from(force).into()),
    ]
    .map(|(name, pose)| Transform {
        name,
        pose,
        unix_ns,
    })
}

fn pose(message: &PoseMsg) -> Isometry3<f32> {
    let [x, y, z, w] = message.orientation;
    let rotation = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
    Isometry3::from_parts(Translation3::from(message.position_m), rotation)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stamps_follow_the_samples_and_not_the_wall_clock() {
        // A wall clock that is read once cannot move a stamp; the samples alone do.
        let clock = WallClock {
            unix_from_monotonic_ns: 1_700_000_000_000_000_000,
        };
        let mut tools = ToolFrame::zeroed();
        tools.world_from_instrument.orientation[3] = 1.0;
        let mut before_ns = 0;
        for sample_ns in [5, 1_000_005, 2_000_005] {
            tools.sample_ns = sample_ns;
            let [tool, .., force] = transforms(&tools, clock);
            assert_eq!(tool.unix_ns, 1_700_000_000_000_000_000 + sample_ns);
            assert_eq!(tool.unix_ns, force.unix_ns);
            assert!(tool.unix_ns > before_ns);
            before_ns = tool.unix_ns;
        }
    }

    #[test]
    fn stamps_begin_at_the_time_of_day() {
        let clock = WallClock::now();
        let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap();
        let apart_ns = i128::from(clock.unix_ns(monotonic_ns())) - now.as_nanos() as i128;
        assert!(apart_ns.abs() < 60_000_000_000, "{apart_ns} ns");
    }
}
