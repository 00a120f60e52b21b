//! User mistakes: each gives an error that names the mistake and its remedy, never a panic.

use std::path::Path;

use system_tests::{calot, compiled, finish, said, station_name};

/// Runs `calot` with bad input and returns its exit code and standard error.
fn refused(args: &[&str]) -> (i32, String) {
    let output = finish(calot().args(args));
    let said = said(&output);
    assert!(!output.status.success(), "{args:?} was accepted");
    assert!(!said.contains("panicked"), "{args:?} panicked: {said}");
    (output.status.code().unwrap_or(-1), said)
}

fn expect(args: &[&str], code: i32, words: &[&str]) {
    let (got, said) = refused(args);
    assert_eq!(got, code, "{args:?} said: {said}");
    for word in words {
        assert!(
            said.contains(word),
            "{args:?}: expected '{word}' in: {said}"
        );
    }
}

fn file(folder: &Path, name: &str, text: &str) -> String {
    let path = folder.join(name);
    std::fs::write(&path, text).expect("a folder to write to");
    path.to_str().expect("a plain path").to_owned()
}

#[test]
fn bad_usage_exits_with_2_and_shows_what_is_allowed() {
    expect(&["frobnicate"], 2, &["frobnicate", "Usage"]);
    expect(&["run", "--frobnicate"], 2, &["--frobnicate"]);
    expect(&["run", "--size", "big"], 2, &["1280x720"]);
    expect(&["run", "--seconds", "NaN"], 2, &["0.1 to 86400"]);
    expect(
        &["rt", "--scene", "x", "--seconds", "0"],
        2,
        &["0.1 to 86400"],
    );
    expect(&["run", "--priority", "100"], 2, &["100", "2..=99"]);
    expect(&["rt"], 2, &["--scene"]);
    expect(&["prepare"], 2, &["RECIPE|MESH"]);
}

#[test]
fn help_teaches() {
    for (args, words) in [
        (&["--help"][..], &["run", "rt", "emulate", "prepare"][..]),
        (
            &["run", "--help"],
            &["--scene", "--headless", "--attach", "Examples"],
        ),
        (&["prepare", "--help"], &["--spheres", "Examples"]),
    ] {
        let output = finish(calot().args(args));
        assert!(output.status.success());
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        for word in words {
            assert!(text.contains(word), "{args:?}: no '{word}' in {text}");
        }
    }
}

#[test]
fn bad_scenes_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let f = |name, text| file(folder.path(), name, text);
    expect(
        &["prepare", "no-such-thing"],
        1,
        &["no-such-thing", "built-in"],
    );
    expect(&["prepare", "missing.toml"], 1, &["missing.toml"]);
    expect(&["prepare", "missing.obj"], 1, &["missing.obj"]);
    expect(&["prepare", &f("empty.obj", "")], 1, &["empty.obj"]);
    expect(
        &["prepare", &f("no-faces.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n")],
        1,
        &["no-faces.obj"],
    );
    expect(
        &["prepare", &f("garbage.stl", "not a mesh at all")],
        1,
        &["garbage.stl"],
    );
    expect(
        &["prepare", &f("garbage.glb", "glTF????")],
        1,
        &["garbage.glb"],
    );
    let beyond = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n";
    expect(&["prepare", &f("beyond.obj", beyond)], 1, &["beyond.obj"]);
    let nan = "v nan 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 4 2\nf 1 3 4\nf 2 4 3\n";
    expect(&["prepare", &f("nan.obj", nan)], 1, &["nan.obj"]);
    let broken = f("broken.toml", "name = \"x\"\nnonsense = 3\n");
    expect(&["prepare", &broken], 1, &["broken.toml", "nonsense"]);
    let syntax = f("syntax.toml", "name = [");
    expect(&["prepare", &syntax], 1, &["syntax.toml"]);
    expect(
        &[
            "run",
            "--headless",
            "--scene",
            &broken,
            "--station",
            &station_name("bad"),
        ],
        1,
        &["broken.toml"],
    );
}

#[test]
fn bad_compiled_scenes_are_refused_by_the_controller() {
    let folder = tempfile::tempdir().unwrap();
    let name = station_name("scene");
    let rt = |scene: &str, words: &[&str]| {
        expect(&["rt", "--station", &name, "--scene", scene], 1, words);
    };
    rt("missing.calot", &["missing.calot", "calot prepare"]);
    rt(
        &file(folder.path(), "text.calot", "hello"),
        &["not a compiled scene"],
    );
}

#[test]
fn missing_and_silent_devices_are_named() {
    let scene = &*compiled("built-in", None);
    let rt = |device: &str, path: &str, words: &[&str]| {
        let name = station_name("device");
        expect(
            &["rt", "--station", &name, "--scene", scene, device, path],
            1,
            words,
        );
    };
    rt("--haptic", "/dev/no-such-tty", &["/dev/no-such-tty"]);
    rt("--tracker", "/dev/no-such-tty", &["/dev/no-such-tty"]);
    rt("--haptic", "/dev/null", &["/dev/null"]);
    expect(
        &["rt", "--station", "a b", "--scene", scene],
        2,
        &["station name 'a b'"],
    );
}
