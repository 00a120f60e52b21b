//! A screen reader: it reads and works windows through the accessibility bus (AT-SPI), as Orca
//! does, with `dbus-send` of the package `dbus`.

use std::io::{BufRead as _, BufReader};
use std::process::{Child, Command, Stdio};

use crate::wait_until;

/// Name of the registry of applications.
const REGISTRY: &str = "org.a11y.atspi.Registry";
/// Path of an application's, and of the registry's, first object.
const ROOT: &str = "/org/a11y/atspi/accessible/root";
const ACCESSIBLE: &str = "org.a11y.atspi.Accessible";
/// Largest number of objects of a window that are read.
const OBJECTS_MAX: usize = 600;

/// A session bus with an accessibility bus of its own. Both are ended on drop.
pub struct ScreenReader {
    session: Child,
    /// Value for `DBUS_SESSION_BUS_ADDRESS`.
    pub bus: String,
    /// Address of the accessibility bus.
    accessibility: String,
}

/// An object of a window.
#[derive(Debug, Clone)]
pub struct Object {
    of: String,
    path: String,
    /// Its role, such as `button`.
    pub role: String,
    /// Its name, such as the text of a button.
    pub name: String,
}

impl ScreenReader {
    /// Starts the buses. `None` if D-Bus or AT-SPI is not installed.
    ///
    /// # Panics
    ///
    /// If the buses are installed and do not answer.
    #[must_use]
    pub fn start() -> Option<Self> {
        Command::new("dbus-send").arg("--version").output().ok()?;
        let mut session = Command::new("dbus-daemon")
            .args(["--session", "--nofork", "--print-address"])
            // The buses are to be found by this reader and its programs alone.
            .env_remove("DISPLAY")
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .ok()?;
        let mut bus = String::new();
        BufReader::new(session.stdout.take()?)
            .read_line(&mut bus)
            .ok()?;
        let mut reader = Self {
            session,
            bus: bus.trim().to_owned(),
            accessibility: String::new(),
        };
        let bus = reader.bus.clone();
        let told = call(
            &bus,
            "org.a11y.Bus",
            "/org/a11y/bus",
            "org.a11y.Bus.GetAddress",
            &[],
        )?;
        reader.accessibility = strings(&told).pop()?;
        for switch in ["IsEnabled", "ScreenReaderEnabled"] {
            let words = [
                "string:org.a11y.Status",
                &format!("string:{switch}"),
                "variant:boolean:true",
            ];
            let set = "org.freedesktop.DBus.Properties.Set";
            call(&bus, "org.a11y.Bus", "/org/a11y/bus", set, &words).expect("a status");
        }
        Some(reader)
    }

    fn ask(&self, of: &str, path: &str, method: &str, words: &[&str]) -> Option<String> {
        call(&self.accessibility, of, path, method, words)
    }

    fn children(&self, of: &str, path: &str) -> Vec<(String, String)> {
        let method = format!("{ACCESSIBLE}.GetChildren");
        let told = self.ask(of, path, &method, &[]).unwrap_or_default();
        let words = strings(&told);
        let pairs = words
            .chunks_exact(2)
            .map(|it| (it[0].clone(), it[1].clone()));
        pairs.collect()
    }

    /// Reads all objects of all windows.
    #[must_use]
    pub fn read(&self) -> Vec<Object> {
        let mut open = self.children(REGISTRY, ROOT);
        open.reverse();
        let mut objects = Vec::new();
        while let Some((of, path)) = open.pop() {
            if objects.len() >= OBJECTS_MAX {
                break;
            }
            let get = "org.freedesktop.DBus.Properties.Get";
            let property = [&*format!("string:{ACCESSIBLE}"), "string:Name"];
            let name = self.ask(&of, &path, get, &property).unwrap_or_default();
            let role = format!("{ACCESSIBLE}.GetRoleName");
            let role = self.ask(&of, &path, &role, &[]).unwrap_or_default();
            let mut below = self.children(&of, &path);
            below.reverse();
            open.extend(below);
            let first = |told: &str| strings(told).pop().unwrap_or_default();
            objects.push(Object {
                of,
                path,
                role: first(&role),
                name: first(&name),
            });
        }
        objects
    }

    /// Waits for an object whose name begins with `name`, and does what it is for: a button is
    /// pressed, a choice is chosen.
    #[track_caller]
    pub fn work(&self, name: &str) {
        let mut found = None;
        wait_until(name, || {
            let mut objects = self.read().into_iter();
            found = objects.find(|it| it.name.starts_with(name) && !it.role.contains("label"));
            found.is_some()
        });
        if let Some(it) = found {
            let method = "org.a11y.atspi.Action.DoAction";
            let _ = self.ask(&it.of, &it.path, method, &["int32:0"]);
        }
    }
}

impl Drop for ScreenReader {
    fn drop(&mut self) {
        if std::thread::panicking() {
            for it in self.read() {
                eprintln!("{}: {}", it.role, it.name);
            }
        }
        let _ = self.session.kill();
        let _ = self.session.wait();
    }
}

/// Calls a method, and returns the text of the answer.
fn call(bus: &str, of: &str, path: &str, method: &str, words: &[&str]) -> Option<String> {
    let output = Command::new("dbus-send")
        .args([
            &format!("--bus={bus}"),
            "--print-reply",
            "--reply-timeout=5000",
        ])
        .args([&format!("--dest={of}"), path, method])
        .args(words)
        .output()
        .ok()?;
    let is_answer = output.status.success();
    is_answer.then(|| String::from_utf8_lossy(&output.stdout).into_owned())
}

/// Texts and paths in an answer.
fn strings(told: &str) -> Vec<String> {
    let lines = told.lines().filter(|line| {
        let line = line.trim_start();
        ["string ", "object path ", "variant "]
            .iter()
            .any(|it| line.starts_with(it))
    });
    let quoted = |line: &str| Some(line.split_once('"')?.1.rsplit_once('"')?.0.to_owned());
    lines.filter_map(quoted).collect()
}
