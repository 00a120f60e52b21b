//! A screen reader: it reads and works windows through the accessibility bus (AT-SPI), as Orca
//! does.

use std::io::{BufRead as _, BufReader};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use pollster::block_on;
use zbus::zvariant::{DynamicType, OwnedObjectPath, OwnedValue, Value};
use zbus::{Connection, Message, connection};

use crate::wait_until;

/// Name of the registry of applications.
const REGISTRY: &str = "org.a11y.atspi.Registry";
/// Path of an application's, and of the registry's, first object.
const ROOT: &str = "/org/a11y/atspi/accessible/root";
const ACCESSIBLE: &str = "org.a11y.atspi.Accessible";
const PROPERTIES: &str = "org.freedesktop.DBus.Properties";
/// Largest number of objects of a window that are read.
const OBJECTS_MAX: usize = 600;
/// Longest wait for an answer: a window that is closing gives none.
const ANSWER: Duration = Duration::from_secs(5);
/// Time after which an action without effect is repeated: one that comes while a window changes its
/// page is lost.
const AGAIN: Duration = Duration::from_secs(20);

/// A session bus with an accessibility bus of its own. Both are ended on drop.
pub struct ScreenReader {
    session: Child,
    /// Value for `DBUS_SESSION_BUS_ADDRESS`.
    pub bus: String,
    accessibility: Connection,
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
        let bus = bus.trim().to_owned();
        let on = connect(&bus);
        let path = "/org/a11y/bus";
        let told = call(&on, "org.a11y.Bus", path, "org.a11y.Bus", "GetAddress", &())?;
        let address: String = told.body().deserialize().expect("an address");
        for switch in ["IsEnabled", "ScreenReaderEnabled"] {
            let set = ("org.a11y.Status", switch, Value::from(true));
            call(&on, "org.a11y.Bus", path, PROPERTIES, "Set", &set).expect("a status");
        }
        Some(Self {
            session,
            bus,
            accessibility: connect(&address),
        })
    }

    fn ask<Words: serde::Serialize + DynamicType>(
        &self,
        it: (&str, &str),
        interface: &str,
        method: &str,
        words: &Words,
    ) -> Option<Message> {
        call(&self.accessibility, it.0, it.1, interface, method, words)
    }

    fn children(&self, of: &str, path: &str) -> Vec<(String, OwnedObjectPath)> {
        let told = self.ask((of, path), ACCESSIBLE, "GetChildren", &());
        told.and_then(|it| it.body().deserialize().ok())
            .unwrap_or_default()
    }

    fn object(&self, of: String, path: String) -> Object {
        let it = (&*of, &*path);
        let name = self.ask(it, PROPERTIES, "Get", &(ACCESSIBLE, "Name"));
        let name = name.and_then(|it| it.body().deserialize::<OwnedValue>().ok());
        let role = self.ask(it, ACCESSIBLE, "GetRoleName", &());
        Object {
            role: role
                .and_then(|it| it.body().deserialize().ok())
                .unwrap_or_default(),
            name: name.and_then(|it| it.try_into().ok()).unwrap_or_default(),
            of,
            path,
        }
    }

    /// Reads all objects of all windows.
    #[must_use]
    pub fn read(&self) -> Vec<Object> {
        let mut open = vec![(REGISTRY.to_owned(), ROOT.to_owned())];
        let mut objects = Vec::new();
        while let Some((of, path)) = open.pop() {
            if objects.len() >= OBJECTS_MAX {
                break;
            }
            let below = self.children(&of, &path).into_iter().rev();
            open.extend(below.map(|(of, path)| (of, path.to_string())));
            objects.push(self.object(of, path));
        }
        objects
    }

    /// An object whose name begins with `name` and that can be worked.
    fn find(&self, name: &str) -> Option<Object> {
        let mut objects = self.read().into_iter();
        objects.find(|it| it.name.starts_with(name) && !it.role.contains("label"))
    }

    /// Does what an object is for: a button is pressed, a choice is chosen.
    fn act(&self, on: &Object) -> bool {
        let interface = "org.a11y.atspi.Action";
        self.ask((&on.of, &on.path), interface, "DoAction", &0_i32)
            .is_some()
    }

    /// Waits for an object whose name begins with `name`, and performs its action.
    #[track_caller]
    pub fn work(&self, name: &str) {
        wait_until(name, || self.find(name).is_some_and(|it| self.act(&it)));
    }

    /// Works the object again and again until its effect is there.
    #[track_caller]
    pub fn work_until(&self, name: &str, mut effect: impl FnMut() -> bool) {
        wait_until(name, || {
            let found = self.find(name);
            if effect() {
                return true;
            }
            let Some(it) = found else {
                return false;
            };
            self.act(&it);
            let acted = Instant::now();
            while acted.elapsed() < AGAIN {
                if effect() {
                    return true;
                }
                std::thread::sleep(Duration::from_millis(100));
            }
            false
        });
    }

    /// An object with this name is there.
    #[must_use]
    pub fn shows(&self, name: &str) -> bool {
        self.read().iter().any(|it| it.name == name)
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

fn connect(address: &str) -> Connection {
    let builder = connection::Builder::address(address).expect("an address of a bus");
    block_on(builder.method_timeout(ANSWER).build()).expect("a bus")
}

/// Calls a method. `None` if it fails, as where the object is gone.
fn call<Words: serde::Serialize + DynamicType>(
    on: &Connection,
    of: &str,
    path: &str,
    interface: &str,
    method: &str,
    words: &Words,
) -> Option<Message> {
    block_on(on.call_method(Some(of), path, Some(interface), method, words)).ok()
}
