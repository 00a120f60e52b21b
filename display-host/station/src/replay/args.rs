//! Options of `calot replay`.

use std::path::PathBuf;

use clap::Args;

use crate::args::{LanguageName, LookArgs, parse_seconds, parse_size, parse_station};
use crate::output::Overwrite;

#[derive(Debug, Clone, Args)]
#[command(after_help = "\
Exit code 0: every tick in the session is equal, even if its end is cut off (its recorder was killed).
Exit code 1: a tick differs, ticks are missing, or the session is damaged or empty. The command names
the first tick that differs, and the organ.

Examples:
  calot run --headless --seconds 10 --out out    leaves out/session.mcap
  calot replay out/session.mcap
  calot replay out/session.mcap --repair           complete the file of a killed recorder
  calot replay out/session.mcap --show --speed 0.25 --from 4
  calot replay out/session.mcap --at 75            the window at an error, as the debrief says
  calot replay out/session.mcap --video film.mp4   a film for raters, and film.truth.json
  calot replay out/session.mcap --what-if triangle-variant --out what-if
  calot replay out/session.mcap --what-if-iterations 10 --out what-if   the paper's solver")]
pub(crate) struct ReplayArgs {
    /// Recorded session (.mcap), the folder of its run, or a session's id as `calot store list
    /// NAME` prints it
    #[arg(value_name = "SESSION")]
    pub(crate) session: PathBuf,
    /// Run the session on this compiled scene (.calot) instead of its own; both must be equal. With
    /// --repair: put this scene into a session whose own scene is damaged
    #[arg(long, value_name = "FILE")]
    pub(crate) scene: Option<PathBuf>,
    /// Apply the recorded hands to another scene, named as for `run` (a recipe with other tissue, a
    /// coarser level `FILE.calot#1`). Charts force and tip of both runs and their difference
    #[arg(long, value_name = "NAME|FILE")]
    pub(crate) what_if: Option<String>,
    /// Apply the recorded hands to the paper's solver, with this number of iterations per tick,
    /// e.g. 10
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(crate) what_if_iterations: Option<u32>,
    /// Folder with the meshes that the recipe of --what-if names [default: folder of the recipe]
    #[arg(long, value_name = "DIR", requires = "what_if")]
    pub(crate) meshes: Option<PathBuf>,
    /// Show the session in a window. Its panel pauses, seeks, changes the speed and starts again;
    /// the view can be turned to any side
    #[arg(long, conflicts_with_all = ["what_if", "what_if_iterations"])]
    pub(crate) show: bool,
    /// Show the session without a window: write this number of pictures, spread over --seconds, to
    /// --out
    #[arg(long, value_name = "N", conflicts_with_all = ["show", "what_if", "what_if_iterations"])]
    pub(crate) frames: Option<u32>,
    /// Make a film of the session with ffmpeg, for blinded raters: the endoscope's picture alone,
    /// 25 pictures a second. The truth of the critical view goes to FILE with the ending
    /// .truth.json
    #[arg(long, value_name = "FILE.mp4",
          conflicts_with_all = ["show", "frames", "at", "what_if", "what_if_iterations", "repair"])]
    pub(crate) video: Option<PathBuf>,
    /// Size of --video, pixels [default: 640x480]
    #[arg(long, value_name = "WxH", value_parser = parse_size, requires = "video")]
    pub(crate) size: Option<[u32; 2]>,
    /// Playing time of --frames, s [default: to the end of the session]
    #[arg(long, value_name = "N", value_parser = parse_seconds)]
    pub(crate) seconds: Option<f64>,
    /// Speed of the show, as a multiple of real time, e.g. 0.25
    #[arg(long, value_name = "X", default_value_t = 1.0, value_parser = parse_speed)]
    pub(crate) speed: f64,
    /// Start of the show in the session, s
    #[arg(long, value_name = "S", default_value = "0", value_parser = parse_from)]
    pub(crate) from: f64,
    /// Show the session in a window from 3 s before this time, s. A debrief names the time of each
    /// error
    #[arg(long, value_name = "S", value_parser = parse_from,
          conflicts_with_all = ["from", "frames", "what_if", "what_if_iterations", "repair"])]
    pub(crate) at: Option<f64>,
    /// Language of the window [default: that of LANG]
    #[arg(long, value_enum)]
    pub(crate) language: Option<LanguageName>,
    #[command(flatten)]
    pub(crate) look: LookArgs,
    /// Name by which other displays join the show (`calot run --attach --station NAME`)
    #[arg(long, value_name = "NAME", default_value = "replay", value_parser = parse_station)]
    pub(crate) station: String,
    /// Folder for pictures, what_if.html and what_if.csv [default: out, or out-2, out-3, … if it
    /// holds results]
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) overwrite: Overwrite,
    /// Close a session that breaks off (its recorder was killed), so that other programs open it.
    /// Of a damaged session, keep all whole chunks, and list the lost parts. The result goes to
    /// SESSION-repaired.mcap; the session itself stays as it is
    #[arg(long, conflicts_with_all = ["show", "frames", "what_if", "what_if_iterations", "out"])]
    pub(crate) repair: bool,
    /// Print one JSON object on standard output
    #[arg(long)]
    pub(crate) json: bool,
}

/// Time shown before the moment of `--at`, s.
const BEFORE_S: f64 = 3.0;

impl ReplayArgs {
    /// True if the session is shown in a window.
    pub(super) const fn is_shown(&self) -> bool {
        self.show || self.at.is_some()
    }

    /// Playing time of the pictures, s, of a session of this length, s: what is left of it at this
    /// speed, unless the user names a time.
    pub(super) fn pictures_s(&self, length_s: f64) -> f64 {
        let left_s = (length_s - self.start_s()) / self.speed;
        // The show itself refuses a start after the end.
        self.seconds.unwrap_or(left_s.max(1.0))
    }

    /// Start of the show in the session, s.
    pub(super) fn start_s(&self) -> f64 {
        self.at.map_or(self.from, |at| (at - BEFORE_S).max(0.0))
    }
}

fn parse_speed(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(speed) if (0.01..=100.0).contains(&speed) => Ok(speed),
        _ => Err("a speed is 0.01 to 100 times".into()),
    }
}

fn parse_from(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(seconds) if (0.0..=86_400.0).contains(&seconds) => Ok(seconds),
        _ => Err("a time is 0 to 86400 seconds".into()),
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser as _;

    use crate::cli::{Cli, Command};

    #[test]
    fn pictures_cover_the_session_unless_the_user_names_a_time() {
        let seconds = |options: &str| {
            let words = format!("calot replay x --frames 4{options}");
            match Cli::parse_from(words.split(' ')).command {
                Some(Command::Replay(args)) => args.pictures_s(142.0),
                _ => unreachable!("it is a replay"),
            }
        };
        for (options, expected) in [
            ("", 142.0),
            (" --from 42", 100.0),
            (" --speed 4", 35.5),
            (" --seconds 10", 10.0),
        ] {
            let found = seconds(options);
            assert!((found - expected).abs() < 1e-9, "{options}: {found}");
        }
    }
}
