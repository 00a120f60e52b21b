//! `calot`: the command of the station.

mod args;
mod bare_loop;
mod build;
mod centre;
mod check;
mod children;
mod cli;
mod clock;
mod curriculum;
mod devices;
mod document;
mod emulate;
mod environment;
mod export;
mod folder;
mod gallery;
mod home;
mod igtlink;
mod jitter;
mod kept;
mod link;
mod load;
mod observe;
mod output;
mod photon;
mod prepare;
mod problem;
mod replay;
mod report;
mod rt;
mod run;
mod say;
mod scene;
mod schema;
mod sessions;
mod settings;
mod start;
mod stop;
mod store;
mod surgeon;
mod task;
mod tell;

use std::process::ExitCode;

/// Counts allocations of the realtime thread, so that "0 allocations" in a report is measured.
#[global_allocator]
static ALLOCATOR: rt_process::alloc_counter::CountingAllocator =
    rt_process::alloc_counter::CountingAllocator::new();

fn main() -> ExitCode {
    environment::prepare();
    // The code is 2 on bad usage, and 0 on `--help`.
    let cli = match cli::Cli::read() {
        Ok(cli) => cli,
        Err(code) => return code,
    };
    if let Err(problem) = stop::outlive_file_limit() {
        say::note(format_args!("calot: signals: {problem}"));
        return ExitCode::FAILURE;
    }
    let command = cli.command.unwrap_or_else(cli::Command::alone);
    let outcome = match command {
        cli::Command::Start(args) => start::run(&args),
        cli::Command::Run(args) => run::run(&args),
        cli::Command::Observe(args) => observe::run(&args),
        cli::Command::Rt(args) => rt::run(&args),
        cli::Command::Emulate(args) => emulate::run(&args),
        cli::Command::Replay(args) => replay::run(&args),
        cli::Command::Export(args) => export::run(&args),
        cli::Command::Report(args) => report::run(&args),
        cli::Command::Store(args) => store::run(&args),
        cli::Command::Prepare(args) => prepare::run(&args),
        cli::Command::Gallery(args) => gallery::run(&args),
        cli::Command::Check(args) => check::run(&args),
        cli::Command::Devices(args) => devices::run(&args),
        cli::Command::Igtlink(args) => igtlink::run(&args),
        cli::Command::Link(args) => link::run(&args),
        cli::Command::Centre(args) => centre::run(&args),
        cli::Command::Tell(args) => tell::run(&args),
        cli::Command::Jitter(args) => jitter::run(&args),
        cli::Command::Photon(args) => photon::run(&args),
        cli::Command::Schema(args) => schema::run(&args),
        cli::Command::Load(args) => load::run(&args),
        cli::Command::BareLoop(args) => bare_loop::run(&args),
    };
    match outcome {
        Ok(code) => code,
        Err(problem) => {
            say::note(format_args!("calot: {problem}"));
            ExitCode::FAILURE
        }
    }
}
