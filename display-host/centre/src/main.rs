//! `calot-centre`: a centre, and the end of a station that joins one. `calot centre` and
//! `calot run --centre` start it.

use std::io::Read as _;
use std::path::PathBuf;
use std::process::ExitCode;

use centre::CentreError;
use centre::hall::Hall;
use centre::keys::Keys;
use centre::member::Member;
use centre::teller::sibling;
use centre::{network, rehearse, roster, web};
use clap::{Args, Parser, Subcommand};
use serde_json::json;

/// A centre of many stations: one page for instructors, in any browser.
#[derive(Debug, Parser)]
#[command(
    name = "calot centre",
    bin_name = "calot centre",
    version,
    max_term_width = 96,
    after_help = "\
Every computer has a folder of keys of one authority, which `calot link keys` makes with openssl:
  calot link keys > make_keys.sh
  sh make_keys.sh authority
  sh make_keys.sh centre centre IP:10.0.0.2      keys of the centre: centre.pem, centre.key, ca.pem
  sh make_keys.sh member theatre-1               keys of a station: theatre-1.pem, theatre-1.key, ca.pem

The list, centre.toml, names who may join and who may look. A change counts within seconds:
  [[station]]
  name = \"theatre-1\"                  # a name that is taken off the list has no rights any more
  [[instructor]]
  name = \"bo\"
  password = \"$argon2id$…\"            # from `calot centre password`
  stations = [\"theatre-1\"]            # left out: all stations, and everybody's results

At the centre, and at each station:
  calot centre serve --list centre.toml --keys keys --store centre.sqlite
  calot run --task clamp --trainee kim --centre 10.0.0.2:7448 --centre-keys keys"
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Serves the page, and takes what stations tell
    Serve(ServeArgs),
    /// Reads a password from standard input and prints what the list keeps of it
    Password,
    /// Tells a centre of a station of this computer; `calot run --centre` starts it
    Join(JoinArgs),
    /// Plays a recording of `calot tell` as many stations, to try a centre out
    Rehearse(RehearseArgs),
}

#[derive(Debug, Args)]
struct ServeArgs {
    /// List of stations and instructors
    #[arg(long, value_name = "FILE")]
    list: PathBuf,
    /// Folder with NAME.pem, NAME.key and ca.pem of the centre
    #[arg(long, value_name = "DIR")]
    keys: PathBuf,
    /// Address for stations
    #[arg(long, value_name = "HOST:PORT", default_value = "0.0.0.0:7448")]
    stations: String,
    /// Address of the page
    #[arg(long, value_name = "HOST:PORT", default_value = "0.0.0.0:8443")]
    page: String,
    /// Certificate of the page, PEM, with its chain [default: that of --keys]
    #[arg(long, value_name = "FILE", requires = "page_key")]
    page_cert: Option<PathBuf>,
    /// Private key of the page, PEM
    #[arg(long, value_name = "FILE", requires = "page_cert")]
    page_key: Option<PathBuf>,
    /// Store of the centre, which takes the stations' results
    #[arg(long, value_name = "FILE", default_value = "centre.sqlite")]
    store: PathBuf,
    /// Log of who watched which station and when, a JSON object a line
    #[arg(long, value_name = "FILE", default_value = "centre.log.jsonl")]
    log: PathBuf,
    /// Print one JSON object when it listens
    #[arg(long)]
    json: bool,
}

#[derive(Debug, Args)]
struct JoinArgs {
    /// Address of the centre
    #[arg(long, value_name = "HOST:PORT")]
    connect: String,
    /// Folder with NAME.pem, NAME.key and ca.pem; NAME is the station's name at the centre
    #[arg(long, value_name = "DIR")]
    keys: PathBuf,
    /// Name of the station on this computer
    #[arg(long, value_name = "NAME", default_value = "main")]
    station: String,
    /// Name that the trainee chose
    #[arg(long, value_name = "NAME")]
    trainee: Option<String>,
    /// Store whose results go to the centre
    #[arg(long, value_name = "FILE")]
    store: Option<PathBuf>,
    /// End when the parent process of this id ends
    #[arg(long, value_name = "PID", hide = true)]
    with_parent: Option<i32>,
}

#[derive(Debug, Args)]
struct RehearseArgs {
    /// Recording: the output of `calot tell`
    recording: PathBuf,
    /// Address of the centre
    #[arg(long, value_name = "HOST:PORT")]
    connect: String,
    /// Folders of keys, one for each station
    #[arg(long, value_name = "DIR", num_args = 1.., required = true)]
    keys: Vec<PathBuf>,
}

fn main() -> ExitCode {
    let command = Cli::parse().command;
    if let Err(error) = network::on_one_thread() {
        eprintln!("calot-centre: cannot start itself again: {error}");
        return ExitCode::FAILURE;
    }
    run(command)
}

#[tokio::main]
async fn run(command: Command) -> ExitCode {
    // The network's library logs more if RUST_LOG asks for it.
    zenoh::try_init_log_from_env();
    let done = match command {
        Command::Serve(args) => serve(args).await,
        Command::Password => password(),
        Command::Join(args) => join(args).await,
        Command::Rehearse(args) => {
            rehearse::rehearse(&args.recording, &args.connect, &args.keys).await
        }
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("calot-centre: {error}");
            ExitCode::FAILURE
        }
    }
}

async fn serve(args: ServeArgs) -> Result<(), CentreError> {
    let keys = Keys::read(&args.keys)?;
    let certificate = args.page_cert.unwrap_or_else(|| keys.certificate.clone());
    let key = args.page_key.unwrap_or_else(|| keys.key.clone());
    let hall = Hall::open(
        args.list,
        args.store,
        &args.log,
        args.stations.clone(),
        keys,
    )
    .await?;
    let listening = |page: std::net::SocketAddr| match args.json {
        true => println!(
            "{}",
            json!({"stations": args.stations, "page": page.to_string()})
        ),
        false => println!(
            "the page: https://{}/; stations: {}; Ctrl-C ends it",
            reachable(page),
            args.stations
        ),
    };
    tokio::select! {
        ended = web::run(hall, &args.page, &certificate, &key, listening) => ended,
        _ = tokio::signal::ctrl_c() => Ok(()),
    }
}

/// The page's address as a browser elsewhere needs it. Nobody can open 0.0.0.0.
fn reachable(page: std::net::SocketAddr) -> String {
    match page.ip().is_unspecified() {
        true => format!("ADDRESS-OF-THIS-COMPUTER:{}", page.port()),
        false => page.to_string(),
    }
}

fn password() -> Result<(), CentreError> {
    let mut given = String::new();
    let read = std::io::stdin().take(2000).read_to_string(&mut given);
    read.map_err(|error| CentreError::File {
        path: "standard input".into(),
        problem: error.to_string(),
    })?;
    println!("{}", roster::hashed(given.trim_end_matches(['\r', '\n']))?);
    Ok(())
}

async fn join(args: JoinArgs) -> Result<(), CentreError> {
    let own = std::env::current_exe().unwrap_or_default();
    if let Some(parent) = args.with_parent {
        end_with(parent);
    }
    let member = Member {
        station: args.station,
        trainee: args.trainee,
        address: args.connect,
        keys: Keys::read(&args.keys)?,
        store: args.store,
        program: sibling(&own)?,
    };
    member.run().await
}

/// Asks the kernel for SIGTERM when the parent dies, so that nothing outlives its station.
fn end_with(parent: i32) {
    use rustix::process::{Signal, getppid, set_parent_process_death_signal};
    let _ = set_parent_process_death_signal(Some(Signal::TERM));
    // If the parent died before this took effect, another process has adopted us.
    if getppid().map(|pid| pid.as_raw_nonzero().get()) != Some(parent) {
        std::process::exit(1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_browser_elsewhere_gets_an_address_that_it_can_open() {
        let told = |page: &str| reachable(page.parse().expect("an address"));
        assert_eq!(told("10.0.0.2:8443"), "10.0.0.2:8443");
        assert_eq!(told("0.0.0.0:8443"), "ADDRESS-OF-THIS-COMPUTER:8443");
        assert_eq!(told("[::]:1"), "ADDRESS-OF-THIS-COMPUTER:1");
    }
}
