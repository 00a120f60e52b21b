//! The main job as a newcomer runs it: real processes, ptys, shared memory and pictures.

use std::path::Path;
use std::time::Duration;

use shared_mem::message::{SphereState, StateFrame};
use shared_mem::service::{Host, Station};
use system_tests::{
    Program, anatomy, calot, finish, may_be_realtime, moved_pages_max, said, station_name, summary,
    turn,
};

/// Runs the station headless. Returns its summary and the depth of the dent in tissue, m.
fn operate(scene: &[&str], seconds: &str, out: &Path) -> (serde_json::Value, f32) {
    let _turn = turn();
    let name = station_name("job");
    let mut calot = calot();
    calot
        .args([
            "run",
            "--headless",
            "--seconds",
            seconds,
            "--frames",
            "4",
            "--size",
            "320x240",
        ])
        .args(["--station", &name, "--out"])
        .arg(out)
        .args(scene);
    let mut run = Program::start(&mut calot);
    let dent_m = watch_dent(&name, &mut run);
    let output = run.finish();
    assert!(output.status.success(), "{}", said(&output));
    (summary(out), dent_m)
}

/// Greatest displacement of a sphere while the instrument touches tissue and grasps nothing, m.
fn watch_dent(station: &str, run: &mut Program) -> f32 {
    let host = Station::new(station)
        .and_then(|s| Host::open(&s))
        .expect("a station");
    let mut state: Box<StateFrame> = bytemuck::zeroed_box();
    let (mut rest, mut dent_m) = (Vec::new(), 0.0f32);
    while run.ended().is_none() {
        if host.newest_state(&mut state)
            && let Some(spheres) = state.spheres()
        {
            let touched = spheres.iter().any(|s| s.bits & SphereState::CONTACT != 0);
            let grasped = spheres.iter().any(|s| s.bits & SphereState::GRASPED != 0);
            if rest.is_empty() || !(touched || grasped) {
                rest = spheres.iter().map(|s| s.center_m).collect();
            } else if touched && !grasped {
                let moved = spheres
                    .iter()
                    .zip(&rest)
                    .map(|(s, r)| distance(s.center_m, *r));
                dent_m = moved.fold(dent_m, f32::max);
            }
        }
        std::thread::sleep(Duration::from_millis(4));
    }
    dent_m
}

fn distance(a: [f32; 3], b: [f32; 3]) -> f32 {
    a.iter()
        .zip(b)
        .map(|(a, b)| (a - b).powi(2))
        .sum::<f32>()
        .sqrt()
}

fn check_summary(s: &serde_json::Value, seconds: u64) {
    let number = |key: &str| s[key].as_u64().unwrap_or_else(|| panic!("{key} in {s:#}"));
    let periods = number("ticks") + number("deadline_misses");
    assert!(
        periods >= seconds * 1000,
        "{periods} periods in {seconds} s"
    );
    // Other programs may take much of the time of a machine. A controller that loses most of its
    // periods is broken.
    assert!(number("ticks") * 2 > periods, "{s:#}");
    for key in ["wake_latency_ns", "tick_ns", "motion_to_force_ns"] {
        let q = |p: &str| {
            s[key][p]
                .as_u64()
                .unwrap_or_else(|| panic!("{key}.{p} in {s:#}"))
        };
        assert!(0 < q("p50") && q("p50") <= q("p99"), "{key}: {s:#}");
        assert!(
            q("p99") <= q("p999") && q("p999") <= q("max"),
            "{key}: {s:#}"
        );
    }
    let force = |end: &str| s["force_n"][end].as_f64().expect("force_n");
    assert!(
        force("min") >= 0.0 && force("max") > 0.1 && force("max") <= 3.301,
        "{s:#}"
    );
    assert_eq!(number("allocations_after_start"), 0, "{s:#}");
    assert_eq!(s["realtime"].as_bool(), Some(may_be_realtime()), "{s:#}");
    if may_be_realtime() {
        // The kernel may page out memory that is not locked, and page it in again.
        assert!(
            number("page_faults_after_start") <= moved_pages_max(),
            "{s:#}"
        );
    }
    assert_eq!(s["ended"], "time_over");
    assert_eq!(number("events_lost"), 0);
    for event in ["contact", "grasp", "let_go", "release"] {
        assert!(s["events"][event].as_u64() > Some(0), "no {event} in {s:#}");
    }
    assert!(number("frames") >= 4, "{s:#}");
}

/// Mean absolute difference of two pictures, 0..=255.
fn difference(a: &Path, b: &Path) -> f64 {
    let open = |path: &Path| {
        image::open(path)
            .unwrap_or_else(|e| panic!("{}: {e}", path.display()))
            .to_rgb8()
    };
    let (a, b) = (open(a), open(b));
    assert_eq!(a.dimensions(), b.dimensions());
    let sum: u64 = a
        .as_raw()
        .iter()
        .zip(b.as_raw())
        .map(|(&a, &b)| u64::from(a.abs_diff(b)))
        .sum();
    sum as f64 / a.as_raw().len() as f64
}

/// Share of the picture whose brightness differs by at least a tenth of white.
fn changed_share(a: &Path, b: &Path) -> f64 {
    let [a, b] = [a, b].map(|path| {
        image::open(path)
            .unwrap_or_else(|e| panic!("{}: {e}", path.display()))
            .to_luma8()
    });
    assert_eq!(a.dimensions(), b.dimensions());
    let pairs = a.as_raw().iter().zip(b.as_raw());
    let changed = pairs.filter(|(a, b)| a.abs_diff(**b) > 25).count();
    changed as f64 / a.as_raw().len() as f64
}

fn check_pictures(out: &Path) {
    let frame = out.join("frame_0000.png");
    let press = out.join("deepest_press.png");
    let grasp = out.join("grasp.png");
    let picture = image::open(&frame).expect("a picture").to_rgb8();
    let lit = picture
        .pixels()
        .filter(|p| p.0.iter().any(|&c| c > 40))
        .count();
    assert!(
        lit * 5 > picture.pixels().len(),
        "the scene fills the scope"
    );
    // Both pictures have the same view and tool; one shows the tissue before contact. They differ
    // by the dent alone.
    let dent = changed_share(&out.join("before_press.png"), &press);
    assert!(dent > 0.01, "the press changes {dent} of the picture");
    let moved = difference(&press, &grasp);
    assert!(
        moved > 0.5,
        "the grasp looks different from the press: {moved}"
    );
}

#[test]
fn the_built_in_scene_is_operated_on() {
    let folder = tempfile::tempdir().unwrap();
    let (s, dent_m) = operate(&[], "20", folder.path());
    check_summary(&s, 20);
    assert!(dent_m > 0.003, "the press dents the liver: {dent_m} m");
    check_pictures(folder.path());
    let report = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    assert!(
        report.matches("<svg").count() >= 6,
        "histograms and courses are drawn"
    );
    assert!(report.contains("frame_0000.png") && report.contains("deepest_press.png"));
    assert!(
        !report.contains("http://") || !report.contains("src=\"http"),
        "the report needs no network"
    );
}

#[test]
fn the_real_anatomy_is_operated_on() {
    let Some(anatomy) = anatomy() else {
        eprintln!("skipped: no real anatomy (set CALOT_ANATOMY to its folder)");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let meshes = anatomy.join("hra-female");
    let scene = [
        "--scene",
        "tests/assets/hra-female.toml",
        "--meshes",
        meshes.to_str().unwrap(),
    ];
    let (s, dent_m) = operate(&scene, "10", folder.path());
    check_summary(&s, 10);
    assert!(dent_m > 0.003, "the press dents the liver: {dent_m} m");
    check_pictures(folder.path());
}

#[test]
fn two_stations_run_side_by_side() {
    let folders = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    std::thread::scope(|scope| {
        for folder in &folders {
            scope.spawn(|| {
                let output = finish(
                    calot()
                        .args(["run", "--headless", "--seconds", "3", "--frames", "0"])
                        .args(["--station", &station_name("side"), "--out"])
                        .arg(folder.path()),
                );
                assert!(output.status.success(), "{}", said(&output));
            });
        }
    });
    for folder in &folders {
        let s = summary(folder.path());
        assert!(s["ticks"].as_u64() > Some(500), "{s:#}");
        assert_eq!(s["frames"], 0);
    }
}

#[test]
fn station_without_a_graphics_driver_says_so_and_still_measures() {
    let folder = tempfile::tempdir().unwrap();
    let output = finish(
        calot()
            .args([
                "run",
                "--headless",
                "--seconds",
                "2",
                "--station",
                &station_name("blind"),
            ])
            .arg("--out")
            .arg(folder.path())
            .envs([
                ("VK_DRIVER_FILES", "/nonexistent.json"),
                ("WGPU_BACKEND", "vulkan"),
            ]),
    );
    assert!(output.status.success(), "{}", said(&output));
    assert!(
        said(&output).contains("mesa-vulkan-drivers"),
        "{}",
        said(&output)
    );
    let s = summary(folder.path());
    assert_eq!(s["frames"], 0);
    assert!(s["adapter"].is_null());
    assert!(s["ticks"].as_u64() > Some(500), "{s:#}");
}

#[test]
fn station_without_privileges_runs_and_says_not_realtime() {
    let folder = tempfile::tempdir().unwrap();
    let output = finish(
        calot()
            .args([
                "run",
                "--headless",
                "--seconds",
                "2",
                "--frames",
                "0",
                "--no-realtime",
            ])
            .args(["--station", &station_name("soft"), "--out"])
            .arg(folder.path()),
    );
    assert!(output.status.success(), "{}", said(&output));
    let s = summary(folder.path());
    assert_eq!(s["realtime"], false);
    assert!(
        s["not_realtime"]
            .as_array()
            .is_some_and(|lacks| !lacks.is_empty()),
        "{s:#}"
    );
    let report = std::fs::read_to_string(folder.path().join("report.html")).unwrap();
    assert!(report.contains("Not realtime"));
}
