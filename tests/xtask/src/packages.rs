//! System packages that Calot needs besides Rust and a C compiler.

use std::process::{Command, Stdio};

/// Something that the system must have, and the Debian or Ubuntu package that has it.
struct Need {
    what: &'static str,
    package: &'static str,
    only_for_tests: bool,
    is_there: fn() -> bool,
}

const NEEDS: [Need; 11] = [
    Need {
        what: "a Vulkan loader",
        package: "libvulkan1",
        only_for_tests: false,
        is_there: || library("libvulkan.so.1"),
    },
    Need {
        what: "a Vulkan driver (Mesa's, which also draws without a GPU)",
        package: "mesa-vulkan-drivers",
        only_for_tests: false,
        is_there: vulkan_driver,
    },
    Need {
        what: "a virtual screen, for the window's tests",
        package: "xvfb",
        only_for_tests: true,
        is_there: || on_path("Xvfb"),
    },
    Need {
        what: "xdotool, which presses keys in windows on that screen",
        package: "xdotool",
        only_for_tests: true,
        is_there: || on_path("xdotool"),
    },
    Need {
        what: "the accessibility bus, through which a screen reader works windows",
        package: "at-spi2-core",
        only_for_tests: true,
        is_there: || {
            std::path::Path::new("/usr/share/dbus-1/services/org.a11y.Bus.service").is_file()
        },
    },
    Need {
        what: "D-Bus, which carries it",
        package: "dbus",
        only_for_tests: true,
        is_there: || on_path("dbus-daemon") && on_path("dbus-send"),
    },
    Need {
        what: "a Wayland compositor without a screen, for the window's tests",
        package: "weston",
        only_for_tests: true,
        is_there: || on_path("weston"),
    },
    Need {
        what: "a C++ compiler, for the firmware header and its sketches",
        package: "g++",
        only_for_tests: true,
        is_there: || on_path("c++"),
    },
    Need {
        what: "openssl, for the keys of a link",
        package: "openssl",
        only_for_tests: true,
        is_there: || on_path("openssl"),
    },
    Need {
        what: "ip, for tests in networks of their own",
        package: "iproute2",
        only_for_tests: true,
        is_there: || on_path("ip") || on_path_of_root("ip"),
    },
    Need {
        what: "a server of PostgreSQL, as a centre has one",
        package: "postgresql",
        only_for_tests: true,
        is_there: postgresql,
    },
];

/// Installs what is missing, or returns an error with the line to type.
pub(crate) fn set_up(for_tests: bool) -> Result<(), String> {
    let missing: Vec<&Need> = NEEDS
        .iter()
        .filter(|need| (for_tests || !need.only_for_tests) && !(need.is_there)())
        .collect();
    if missing.is_empty() {
        return Ok(());
    }
    for need in &missing {
        println!("missing: {} (package {})", need.what, need.package);
    }
    let names: Vec<&str> = missing.iter().map(|need| need.package).collect();
    let by_hand = format!(
        "apt-get install -y --no-install-recommends {}",
        names.join(" ")
    );
    if !on_path("apt-get") {
        return Err(format!(
            "this is not Debian or Ubuntu: install what is missing above, then try again \
             (there it would be: {by_hand})"
        ));
    }
    let Some(prefix) = installer() else {
        return Err(format!(
            "this user may not install packages. Type:\n\n  sudo {by_hand}\n"
        ));
    };
    println!("installing {} ...", names.join(" "));
    apt(prefix, &["update", "-qq"])?;
    let mut install = vec!["install", "-y", "-qq", "--no-install-recommends"];
    install.extend(&names);
    apt(prefix, &install)?;
    match missing.iter().find(|need| !(need.is_there)()) {
        None => Ok(()),
        Some(need) => Err(format!(
            "{} is still missing after installing {}",
            need.what, need.package
        )),
    }
}

fn apt(prefix: &[&str], args: &[&str]) -> Result<(), String> {
    let mut words: Vec<&str> = prefix.to_vec();
    words.push("apt-get");
    words.extend(args);
    let status = Command::new(words[0])
        .args(&words[1..])
        .env("DEBIAN_FRONTEND", "noninteractive")
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .status()
        .map_err(|error| format!("{}: {error}", words.join(" ")))?;
    if status.success() {
        Ok(())
    } else {
        Err(format!("{} failed: {status}", words.join(" ")))
    }
}

/// Words before `apt-get` with which this user installs packages without a password: none for root.
/// `None` if the user may not.
fn installer() -> Option<&'static [&'static str]> {
    if output("id", &["-u"]).is_some_and(|id| id.trim() == "0") {
        return Some(&[]);
    }
    output("sudo", &["-n", "true"]).map(|_| &["sudo", "-n"][..])
}

fn output(program: &str, args: &[&str]) -> Option<String> {
    let output = Command::new(program)
        .args(args)
        .stderr(Stdio::null())
        .output()
        .ok()?;
    output
        .status
        .success()
        .then(|| String::from_utf8_lossy(&output.stdout).into_owned())
}

pub(crate) fn on_path(program: &str) -> bool {
    let path = std::env::var_os("PATH").unwrap_or_default();
    std::env::split_paths(&path).any(|folder| folder.join(program).is_file())
}

/// Looks in `/usr/sbin`, which a user's path may lack.
fn on_path_of_root(program: &str) -> bool {
    std::path::Path::new("/usr/sbin").join(program).is_file()
}

fn library(name: &str) -> bool {
    ["/sbin/ldconfig", "ldconfig"]
        .iter()
        .find_map(|ldconfig| output(ldconfig, &["-p"]))
        .is_some_and(|list| list.contains(name))
}

/// True if `initdb` lies where Debian or others put it.
fn postgresql() -> bool {
    let versions = std::fs::read_dir("/usr/lib/postgresql")
        .into_iter()
        .flatten();
    { versions.flatten() }.any(|it| it.path().join("bin/initdb").is_file()) || on_path("initdb")
}

/// True if a driver's manifest lies in one of the loader's folders, or if a variable names one.
fn vulkan_driver() -> bool {
    let named = ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"]
        .iter()
        .any(|name| std::env::var_os(name).is_some_and(|files| !files.is_empty()));
    let folders = [
        "/usr/share/vulkan/icd.d",
        "/etc/vulkan/icd.d",
        "/usr/local/share/vulkan/icd.d",
    ];
    named
        || folders.iter().any(|folder| {
            std::fs::read_dir(folder).is_ok_and(|mut entries| entries.next().is_some())
        })
}
