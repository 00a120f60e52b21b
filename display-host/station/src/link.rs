//! `calot link`: shows stations on other computers.

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Duration;

use ::link::{Address, Keys, LinkError, Seen, WatchConfig};
use clap::{Args, Subcommand};
use serde_json::json;
use shared_mem::service::{Station, user_folder};

use crate::args::{parse_seconds, parse_station};
use crate::document;
use crate::folder::Folder;
use crate::problem::Problem;
use crate::say;
use crate::stop;

/// From this time before the end of the station's certificate on, a message warns the user: 30
/// days.
const SOON: Duration = Duration::from_secs(30 * 24 * 3600);

#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Both sides need certificates of one authority, which `calot link keys` makes with openssl:
  calot link keys > make_keys.sh
  sh make_keys.sh authority
  sh make_keys.sh station theatre-1 IP:10.0.0.7
  sh make_keys.sh watcher desk

On the station's computer, while `calot run` runs:
  calot link serve --listen 0.0.0.0:7447 --cert theatre-1.pem --key theatre-1.key --ca ca.pem
On the instructor's computer, once per station:
  calot link watch --connect 10.0.0.7:7447 --as theatre-1 --cert desk.pem --key desk.key --ca ca.pem
  calot observe --station theatre-1                       (the picture and the task's metrics)")]
pub(crate) struct LinkArgs {
    #[command(subcommand)]
    command: LinkCommand,
}

#[derive(Debug, Clone, Subcommand)]
enum LinkCommand {
    /// Lets other computers see a station of this one
    Serve(ServeArgs),
    /// Shows another computer's station to the displays of this one
    Watch(WatchArgs),
    /// Prints the script that makes certificates
    Keys,
}

/// Keys with which one side proves its identity.
#[derive(Debug, Clone, Args)]
struct KeyArgs {
    /// Certificate of this side, PEM, e.g. station.pem
    #[arg(long, value_name = "FILE", requires_all = ["key", "ca"])]
    cert: Option<PathBuf>,
    /// Private key of this side, PEM, of mode 600
    #[arg(long, value_name = "FILE", requires = "cert")]
    key: Option<PathBuf>,
    /// Certificate of the authority, PEM; every client that it signed is admitted
    #[arg(long, value_name = "FILE", requires = "cert")]
    ca: Option<PathBuf>,
    /// Use no certificates and no encryption; works within this computer only
    #[arg(long, conflicts_with = "cert")]
    insecure: bool,
}

#[derive(Debug, Clone, Args)]
struct ServeArgs {
    /// Name of the station
    #[arg(long, value_name = "NAME", default_value = "main", value_parser = parse_station)]
    station: String,
    /// Address where watchers connect
    #[arg(long, value_name = "HOST:PORT")]
    listen: String,
    #[command(flatten)]
    keys: KeyArgs,
    /// Compiled scene that runs [default: the one that `calot run` names]
    #[arg(long, value_name = "FILE")]
    scene: Option<PathBuf>,
    /// End after this time, s, e.g. 60 [default: on Ctrl-C]
    #[arg(long, value_name = "N", value_parser = parse_seconds)]
    seconds: Option<f64>,
    /// End when the parent process of this id ends
    #[arg(long, value_name = "PID", hide = true)]
    with_parent: Option<i32>,
    /// Print one JSON object when it listens, and one when it ends
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Clone, Args)]
struct WatchArgs {
    /// Address of the station's `calot link serve`
    #[arg(long, value_name = "HOST:PORT")]
    connect: String,
    /// Name of the station for displays of this computer
    #[arg(long = "as", value_name = "NAME", value_parser = parse_station)]
    name: String,
    #[command(flatten)]
    keys: KeyArgs,
    /// Pictures per second at most, 1 to 60; a slow line gets fewer
    #[arg(long, value_name = "HZ", default_value_t = 30.0, value_parser = parse_rate)]
    rate_hz: f64,
    /// End after this time, s, e.g. 60 [default: on Ctrl-C]
    #[arg(long, value_name = "N", value_parser = parse_seconds)]
    seconds: Option<f64>,
    /// End when the parent process of this id ends
    #[arg(long, value_name = "PID", hide = true)]
    with_parent: Option<i32>,
    /// Print one JSON object per event, and one when it ends
    #[arg(long)]
    json: bool,
}

impl KeyArgs {
    fn address(&self, address: &str) -> Result<Address, LinkError> {
        let keys = match (&self.cert, &self.key, &self.ca) {
            (Some(certificate), Some(key), Some(authority)) => Some(Keys {
                certificate: certificate.clone(),
                key: key.clone(),
                authority: authority.clone(),
            }),
            _ => None,
        };
        Address::new(address, keys, self.insecure)
    }
}

pub(crate) fn run(args: &LinkArgs) -> Result<ExitCode, Problem> {
    match &args.command {
        LinkCommand::Serve(args) => serve(args),
        LinkCommand::Watch(args) => watch(args),
        LinkCommand::Keys => {
            say::answer(::link::MAKE_KEYS.trim_end());
            Ok(ExitCode::SUCCESS)
        }
    }
}

fn serve(args: &ServeArgs) -> Result<ExitCode, Problem> {
    let address = args.keys.address(&args.listen)?;
    let stop = stop::flag()?;
    if let Some(parent) = args.with_parent {
        stop::end_with_parent(parent)?;
    }
    // The threads of the server inherit this low priority, because none of them may delay the tick.
    display_host::priority::step_aside(None);
    let places: Vec<PathBuf> = match &args.scene {
        Some(scene) => vec![scene.clone()],
        None => vec![user_folder()?.join(&args.station)],
    };
    let station = Station::new(&args.station)?;
    if address.ends_within(SOON)? {
        say::note(
            "the certificate in --cert ends within 30 days; then no watcher accepts it. `calot link \
             keys` makes a new one",
        );
    }
    let mut said = Ok(());
    let served = ::link::serve(&station, &address, &places, args.seconds, &stop, || {
        if args.json {
            said = document::LINK_SERVE.line(json!({ "listening": args.listen }));
        } else {
            say::note(format_args!(
                "station '{}' can be seen at {}; Ctrl-C ends it",
                args.station, args.listen
            ));
        }
        if !station.is_claimed() {
            say::note(format_args!(
                "no station '{0}' runs so far: start it with `calot run --station {0}`, or name another with --station. \
                 Waiting for it",
                args.station
            ));
        }
    })?;
    said?;
    if args.json {
        document::LINK_SERVE.line(json!({
            "answers": served.answers, "bytes": served.bytes, "malformed": served.malformed,
            "states": served.states,
        }))?;
    } else {
        say::note(format_args!(
            "{} answers, {:.1} MB",
            served.answers,
            served.bytes as f64 / 1e6
        ));
    }
    if served.states > 0 {
        return Ok(ExitCode::SUCCESS);
    }
    say::note(format_args!(
        "there was nothing to see: station '{}' did not run",
        args.station
    ));
    Ok(ExitCode::FAILURE)
}

fn watch(args: &WatchArgs) -> Result<ExitCode, Problem> {
    let address = args.keys.address(&args.connect)?;
    let stop = stop::flag()?;
    if let Some(parent) = args.with_parent {
        stop::end_with_parent(parent)?;
    }
    display_host::priority::step_aside(None);
    // Claim the name as a running station does, so that nobody can start a station of this name.
    let folder = Folder::open(&args.name, false)?;
    let config = WatchConfig {
        station: Station::new(&args.name)?,
        address,
        rate_hz: args.rate_hz,
        scene: folder.scene(),
        seconds: args.seconds,
    };
    let mut said = Ok(());
    let mut why = String::new();
    let watched = ::link::watch(&config, &stop, |seen| {
        // `calot observe` waits for this file.
        if let Seen::Scene(path) = seen
            && let Err(problem) = folder.announce_scene(path)
        {
            say::note(format_args!("warning: {problem}"));
        }
        if let Seen::Lost(reason) = seen {
            reason.clone_into(&mut why);
        }
        if let Err(problem) = say_seen(args, seen) {
            said = Err(problem);
        }
    })?;
    said?;
    if args.json {
        document::LINK_WATCH.line(json!({
            "states": watched.states, "events": watched.events, "events_lost": watched.events_lost,
            "malformed": watched.malformed, "connections": watched.connections,
        }))?;
    } else {
        say::note(format_args!(
            "{} states, {} events, {} events lost",
            watched.states, watched.events, watched.events_lost
        ));
    }
    if watched.connections > 0 {
        return Ok(ExitCode::SUCCESS);
    }
    say::note(format_args!("never connected to {}: {why}", args.connect));
    Ok(ExitCode::FAILURE)
}

fn say_seen(args: &WatchArgs, seen: Seen<'_>) -> Result<(), Problem> {
    let (what, words, detail) = match seen {
        Seen::Connected => (
            "connected",
            format!("{} answers", args.connect),
            String::new(),
        ),
        Seen::Lost(why) => (
            "lost",
            format!("{}: {why}; trying again", args.connect),
            why.to_owned(),
        ),
        Seen::Scene(path) => {
            let path = path.display().to_string();
            let words = format!("show it with `calot observe --station {}`", args.name);
            ("scene", words, path)
        }
        Seen::NoScene => {
            let words = "the scene of the station was not found there; name it with `calot link serve --scene`";
            ("no_scene", words.to_owned(), String::new())
        }
    };
    if args.json {
        return document::LINK_WATCH.line(json!({ "what": what, "detail": detail }));
    }
    say::note(words);
    Ok(())
}

fn parse_rate(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(hz) if (1.0..=60.0).contains(&hz) => Ok(hz),
        _ => Err("a rate is 1 to 60 pictures a second".into()),
    }
}
