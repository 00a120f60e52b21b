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

/// Serves until told to end. It runs outside the realtime process and reads as a display does.
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
            server.publish(&transforms(&tools));
            sent += 1;
        } else {
            server.publish(&[]); // new clients are let in all the same
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

/// Transforms to send for a frame.
fn transforms(tools: &ToolFrame) -> [Transform<'static>; 4] {
    let age_ns = monotonic_ns().saturating_sub(tools.sample_ns);
    let now = SystemTime::now().duration_since(UNIX_EPOCH);
    let unix_ns = (now.unwrap_or_default().as_nanos() as u64).saturating_sub(age_ns);
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
