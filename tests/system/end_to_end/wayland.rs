//! A window on a Wayland compositor.

use std::path::Path;

use serde_json::Value;
use system_tests::compositor::Compositor;
use system_tests::{calot, finish, said, station_name, summary, turn};

/// Time between two refreshes of the compositor's screen, ns.
const REFRESH_NS: u64 = 16_666_666;
/// Number of pictures that a run must have before it is judged.
const PICTURES: u64 = 10;

/// Runs a station in a window of this compositor. Returns its summary and its page.
fn run(compositor: &Compositor, out: &Path, seconds: &str) -> (Value, String) {
    let run = finish(
        calot()
            .args(["run", "--station", &station_name("wayland"), "--mute"])
            .args(["--no-realtime", "--size", "320x240", "--seconds", seconds])
            .arg("--out")
            .arg(out)
            .env("WAYLAND_DISPLAY", &compositor.display)
            .env_remove("WAYLAND_SOCKET")
            .env_remove("DISPLAY"),
    );
    assert!(run.status.success(), "{}", said(&run));
    let page = std::fs::read_to_string(out.join("report.html")).expect("a page");
    (summary(out), page)
}

#[test]
fn a_compositor_tells_when_it_presented_the_windows_pictures() {
    let _turn = turn();
    let folder = tempfile::tempdir().expect("a folder");
    let Some(compositor) = Compositor::start(folder.path(), None) else {
        eprintln!(
            "SKIPPED: weston is not installed (apt-get install weston); no window on Wayland was tested"
        );
        return;
    };
    // On a busy machine the first picture may take as long as a short run.
    let runs = ["12", "40", "120"].into_iter();
    let runs = runs.map(|seconds| run(&compositor, &folder.path().join(seconds), seconds));
    let enough = |it: &Value| it["motion_to_photon_ns"]["count"].as_u64() > Some(PICTURES);
    let mut runs = runs.filter(|(summary, _)| enough(summary));
    let (summary, page) = runs.next().expect("a run with enough pictures");
    let told = &summary["presentation"];
    println!("{told} {}", summary["motion_to_presentation_ns"]);
    assert_eq!(told["source"], "wp_presentation", "{told}");
    assert!(told["missing"].is_null(), "{told}");
    let count = |key: &str| told[key].as_u64().expect("a number");
    // This compositor has no hardware, and copies what it shows.
    assert_eq!((count("flips"), count("by_hardware")), (0, 0), "{told}");
    assert!(count("refresh_ns").abs_diff(REFRESH_NS) < 2, "{told}");
    let pictures = summary["motion_to_photon_ns"]["count"].as_u64();
    let pictures = pictures.expect("a number");
    // The last pictures are still on their way at the end. `copies` and `skips` also count pictures
    // of older states, `pictures` does not.
    assert!(count("copies") + count("skips") + 4 > pictures, "{told}");
    let presented = &summary["motion_to_presentation_ns"];
    assert!(presented["count"].as_u64() > Some(pictures / 2), "{told}");
    // A picture comes to the screen later than it is handed over.
    let median = |times: &Value| times["p50"].as_u64().expect("a time");
    assert!(
        median(presented) > median(&summary["motion_to_photon_ns"]),
        "{summary:#}"
    );
    assert!(page.contains("the Wayland compositor (wp_presentation)"));
}
