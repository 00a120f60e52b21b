//! Finding about the log-in manager, which may remove the shared memory of a running station. With
//! `RemoveIPC=yes`, systemd-logind removes every file of a user in /dev/shm when that user's last
//! session ends (logind.conf(5)). It spares root and system users. A program in a session keeps
//! that session open. So only a program outside the sessions of its user loses its memory, for
//! example a service with `User=`, a cron job, or `sudo -u` from somebody else's session.

use std::path::{Path, PathBuf};

use super::finding::{Finding, Verdict, finding};

const NAME: &str = "shared memory kept";
const SHOULD: &str =
    "yes, also when this user logs out: else programs that join later do not find the station";
/// Highest user number that logind spares, if `login.defs` does not set it. Logind takes the number
/// from the `login.defs` of the machine on which it is built.
const SYSTEM_USER_MAX: u32 = 999;
/// The user `nobody`, whom logind treats as a system user.
const NOBODY: u32 = 65534;
/// Folders of logind's settings, the strongest first.
const FOLDERS: [&str; 4] = [
    "etc/systemd",
    "run/systemd",
    "usr/local/lib/systemd",
    "usr/lib/systemd",
];

/// The finding about a machine whose files are below `root`.
pub(super) fn removal(root: &Path) -> Finding {
    let good = |is: &str| finding(NAME, Verdict::Good, is, SHOULD, "");
    // Logind makes this folder when it starts.
    if !root.join("run/systemd/users").exists() {
        return good("yes: no systemd-logind runs here");
    }
    let Some(user) = user(root) else {
        return finding(NAME, Verdict::Unknown, "cannot be read", SHOULD, "");
    };
    if user <= system_user_max(root) || user == NOBODY {
        return good("yes: logind spares root and system users");
    }
    let cause = match setting(root) {
        Some(false) => return good("yes: RemoveIPC=no"),
        _ if is_in_own_session(root, user) => {
            return good("yes: this program runs in a session of its user and keeps it open");
        }
        _ if lingers(root, user) => return good("yes: its user lingers"),
        Some(true) => "RemoveIPC=yes",
        None => "RemoveIPC is not set, which means yes",
    };
    let is =
        format!("not sure: {cause}, and this program runs outside the sessions of user {user}");
    let mend = format!("sudo loginctl enable-linger {user}");
    finding(NAME, Verdict::Better, is, SHOULD, mend)
}

fn read(root: &Path, path: &str) -> Option<String> {
    std::fs::read_to_string(root.join(path)).ok()
}

/// The effective user: the owner of the files in /dev/shm.
fn user(root: &Path) -> Option<u32> {
    let status = read(root, "proc/self/status")?;
    let users = status.lines().find_map(|line| line.strip_prefix("Uid:"))?;
    users.split_whitespace().nth(1)?.parse().ok()
}

fn system_user_max(root: &Path) -> u32 {
    let settings = read(root, "etc/login.defs").unwrap_or_default();
    let set = settings.lines().find_map(|line| {
        let mut words = line.split_whitespace();
        (words.next() == Some("SYS_UID_MAX")).then(|| words.next()?.parse().ok())?
    });
    set.unwrap_or(SYSTEM_USER_MAX)
}

/// `RemoveIPC` as logind reads it. If no file sets it, a commented-out line of the main file shows
/// the distribution's default (Red Hat's is no). `None` if there is no such line either: logind
/// then takes yes.
fn setting(root: &Path) -> Option<bool> {
    let main = FOLDERS
        .iter()
        .find_map(|folder| read(root, &format!("{folder}/logind.conf")))
        .unwrap_or_default();
    let mut added: Vec<(String, PathBuf)> = Vec::new();
    for folder in FOLDERS {
        let files = std::fs::read_dir(root.join(folder).join("logind.conf.d"));
        for file in files.into_iter().flatten().flatten() {
            let name = file.file_name().to_string_lossy().into_owned();
            // A file hides the files of the same name in weaker folders.
            if name.ends_with(".conf") && added.iter().all(|(known, _)| *known != name) {
                added.push((name, file.path()));
            }
        }
    }
    added.sort();
    let texts = added
        .iter()
        .filter_map(|(_, path)| std::fs::read_to_string(path).ok());
    let last = texts.rev().find_map(|text| assigned(&text, ""));
    last.or_else(|| assigned(&main, ""))
        .or_else(|| assigned(&main, "#"))
}

/// The last value that a file of settings gives `RemoveIPC` on lines that begin with `mark`.
fn assigned(text: &str, mark: &str) -> Option<bool> {
    let mut values = text.lines().rev().filter_map(|line| {
        let (key, value) = line.trim().strip_prefix(mark)?.split_once('=')?;
        (key.trim() == "RemoveIPC").then(|| value.trim().to_lowercase())
    });
    // Logind ignores a value that is neither yes nor no.
    values.find_map(|value| match value.as_str() {
        "yes" | "y" | "true" | "t" | "on" | "1" => Some(true),
        "no" | "n" | "false" | "f" | "off" | "0" => Some(false),
        _ => None,
    })
}

/// True if this program runs in a session of this very user, or under the user's service manager.
fn is_in_own_session(root: &Path, user: u32) -> bool {
    let groups = read(root, "proc/self/cgroup").unwrap_or_default();
    let slice = format!("/user-{user}.slice/");
    groups.lines().any(|line| line.contains(&slice))
}

/// True if the user lingers: logind then keeps the user's files when no session is left.
fn lingers(root: &Path, user: u32) -> bool {
    let users = read(root, "etc/passwd").unwrap_or_default();
    let name = users.lines().find_map(|line| {
        let mut fields = line.split(':');
        let name = fields.next()?;
        (fields.nth(1)?.parse() == Ok(user)).then_some(name)
    });
    name.is_some_and(|name| root.join("var/lib/systemd/linger").join(name).exists())
}

#[cfg(test)]
mod tests {
    use super::*;

    const LOGIND: (&str, &str) = ("run/systemd/users/1000", "");
    const ANNA: (&str, &str) = ("proc/self/status", "Name:\tcalot\nUid:\t0\t1000\t0\t0");
    const SERVICE: (&str, &str) = ("proc/self/cgroup", "0::/system.slice/calot@x.service");
    const OUTSIDE: [(&str, &str); 3] = [LOGIND, ANNA, SERVICE];

    fn with(files: &[(&str, &str)]) -> Finding {
        let folder = tempfile::tempdir().unwrap();
        for (path, text) in files {
            let path = folder.path().join(path);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
        removal(folder.path())
    }

    #[test]
    fn a_service_of_an_ordinary_user_gets_a_warning_with_the_command() {
        let found = with(&OUTSIDE);
        assert_eq!(found.verdict, Verdict::Better);
        assert!(found.is.contains("RemoveIPC is not set"), "{found:?}");
        let mend = found.mend.unwrap();
        assert_eq!(mend, "sudo loginctl enable-linger 1000");
    }

    #[test]
    fn users_who_keep_their_shared_memory_are_not_warned() {
        let root = ("proc/self/status", "Uid:\t0\t0\t0\t0");
        let daemon = ("proc/self/status", "Uid:\t999\t999\t999\t999");
        let nobody = ("proc/self/status", "Uid:\t65534\t65534\t65534\t65534");
        let session = (
            "proc/self/cgroup",
            "0::/user.slice/user-1000.slice/session-3.scope",
        );
        let passwd = (
            "etc/passwd",
            "root:x:0:0::/root:/bin/sh\nanna:x:1000:1000::/home/anna:/bin/sh",
        );
        let linger = ("var/lib/systemd/linger/anna", "");
        for files in [
            &[ANNA, SERVICE][..],
            &[LOGIND, root, SERVICE],
            &[LOGIND, daemon, SERVICE],
            &[LOGIND, nobody, SERVICE],
            &[LOGIND, ANNA, session],
            &[LOGIND, ANNA, SERVICE, passwd, linger],
        ] {
            assert_eq!(with(files).verdict, Verdict::Good, "{files:?}");
        }
    }

    #[test]
    fn a_session_or_lingering_of_somebody_else_does_not_help() {
        let session = (
            "proc/self/cgroup",
            "0::/user.slice/user-1001.slice/session-3.scope",
        );
        assert_eq!(with(&[LOGIND, ANNA, session]).verdict, Verdict::Better);
        let passwd = ("etc/passwd", "anna:x:1000:1000::/:/bin/sh");
        let linger = ("var/lib/systemd/linger/berta", "");
        let found = with(&[LOGIND, ANNA, SERVICE, passwd, linger]);
        assert_eq!(found.verdict, Verdict::Better);
    }

    #[test]
    fn settings_count_in_logind_s_order() {
        const MAIN: &str = "etc/systemd/logind.conf";
        let of = |files: &[(&str, &str)]| with(&[&OUTSIDE, files].concat()).verdict;
        let yes = "[Login]\nRemoveIPC=yes";
        let no = "[Login]\n RemoveIPC = off ";
        let (kept, lost) = (Verdict::Good, Verdict::Better);
        assert_eq!(of(&[(MAIN, "[Login]\n#RemoveIPC=yes")]), lost);
        assert_eq!(of(&[(MAIN, "[Login]\n#RemoveIPC=no")]), kept);
        assert_eq!(of(&[(MAIN, "#RemoveIPC=no\nRemoveIPC=yes")]), lost);
        assert_eq!(of(&[(MAIN, no)]), kept);
        assert_eq!(of(&[(MAIN, "RemoveIPC=no\nRemoveIPC=maybe")]), kept);
        assert_eq!(
            of(&[(MAIN, no), ("usr/lib/systemd/logind.conf", yes)]),
            kept
        );
        let added = "usr/lib/systemd/logind.conf.d/50-a.conf";
        let same = "etc/systemd/logind.conf.d/50-a.conf";
        let later = "run/systemd/logind.conf.d/60-b.conf";
        assert_eq!(of(&[(MAIN, no), (added, yes)]), lost);
        assert_eq!(of(&[(added, yes), (same, no)]), kept);
        assert_eq!(of(&[(same, yes), (later, no)]), kept);
        assert_eq!(of(&[("etc/systemd/logind.conf.d/a.bak", no)]), lost);
    }

    #[test]
    fn the_bound_of_system_users_is_read() {
        let defs = ("etc/login.defs", "# SYS_UID_MAX 5\nSYS_UID_MAX\t\t1000");
        assert_eq!(
            with(&[&OUTSIDE[..], &[defs]].concat()).verdict,
            Verdict::Good
        );
    }
}
