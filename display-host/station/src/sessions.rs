//! Sessions by their names: a path, the folder of a session among the kept ones, or an id that
//! `calot store list` prints.

use std::path::{Path, PathBuf};

use store::SessionRecord;

use crate::args::StoreFile;
use crate::home;
use crate::problem::Problem;

/// Folder in which `calot start` keeps the sessions, if there is a home folder.
pub(crate) fn folder() -> Option<PathBuf> {
    Some(home::data()?.join("sessions"))
}

/// Path of the session that somebody typed: a file or folder, or else the session with this id in
/// the store, or else the folder of this name among the kept sessions.
pub(crate) fn find(typed: &Path) -> Result<PathBuf, Problem> {
    find_within(typed, &StoreFile::default(), folder().as_deref())
}

fn find_within(
    typed: &Path,
    store: &StoreFile,
    sessions: Option<&Path>,
) -> Result<PathBuf, Problem> {
    // A path with a folder in it, or with an ending, names a file. Its reader reports its absence.
    let name = typed.to_str().filter(|it| !it.contains(['/', '.']));
    let Some(name) = name.filter(|it| !it.is_empty() && !typed.exists()) else {
        return Ok(typed.to_owned());
    };
    // A store that cannot be read must not hide a folder.
    let found = store.read_if_any().ok().flatten();
    let stored = match found.map(|it| it.session(name)) {
        Some(Ok(stored)) => stored,
        None | Some(Err(_)) => None,
    };
    if let Some(session) = &stored
        && let Some(place) = folder_of(session).filter(|it| it.exists())
    {
        return Ok(place);
    }
    if let Some(place) = sessions.map(|it| it.join(name)).filter(|it| it.is_dir()) {
        return Ok(place);
    }
    Err(match stored {
        Some(it) => gone(name, it.file.as_deref()),
        None => unknown(name, sessions),
    }
    .into())
}

/// Name of the trainee of a session that somebody typed and that was found at this path, if the
/// store knows the session.
pub(crate) fn trainee(typed: &Path, found: &Path) -> Option<String> {
    trainee_within(typed, found, &StoreFile::default())
}

fn trainee_within(typed: &Path, found: &Path, store: &StoreFile) -> Option<String> {
    let store = store.read_if_any().ok()??;
    let folder = if found.is_dir() {
        found
    } else {
        found.parent()?
    };
    // The folder's name may differ from the id under which the store keeps the session.
    let told = std::fs::read(folder.join("summary.json")).ok();
    let told = told.and_then(|it| serde_json::from_slice::<serde_json::Value>(&it).ok());
    let told = told.and_then(|it| Some(it.get("session")?.as_str()?.to_owned()));
    let typed = typed.to_str().map(str::to_owned);
    let mut ids = [typed, told].into_iter().flatten();
    ids.find_map(|id| store.owner(&id).ok().flatten())
}

/// Folder of a stored session's recording, or the file if it lies in no folder of its own. `None`:
/// the session has no recording.
fn folder_of(session: &SessionRecord) -> Option<PathBuf> {
    let file = PathBuf::from(session.file.as_ref()?);
    let is_own = file.file_name().is_some_and(|it| it == "session.mcap");
    match file.parent().filter(|_| is_own) {
        Some(folder) if !folder.as_os_str().is_empty() => Some(folder.to_owned()),
        _ => Some(file),
    }
}

fn gone(id: &str, file: Option<&str>) -> String {
    let where_from = file.map_or_else(
        || "was stored without a recording".to_owned(),
        |file| format!("was recorded in {file}, which is not there any more"),
    );
    format!(
        "session '{id}' is in the store, and {where_from}; if it was moved, name its new folder"
    )
}

fn unknown(name: &str, sessions: Option<&Path>) -> String {
    let among = sessions.map_or_else(String::new, |it| {
        format!(
            ", the id of a session in the store, or a folder in {}",
            it.display()
        )
    });
    format!(
        "'{name}' is neither a file or folder{among}; `calot store list` lists the trainees, and `calot store list \
         NAME` their sessions"
    )
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use store::{Circumstances, Hand, Store};

    use super::*;

    const ID: &str = "01a22c0e-571c-7163-bf6a-1f2f93a3f980";

    fn record(file: &Path) -> SessionRecord {
        SessionRecord {
            id: ID.to_owned(),
            began_unix_s: 1,
            task: "clamp".to_owned(),
            difficulty: "beginner".to_owned(),
            outcome: "passed".to_owned(),
            score: 90.0,
            alarms: 0,
            metrics_version: 1,
            metrics: BTreeMap::new(),
            scene: String::new(),
            program: String::new(),
            file: Some(file.display().to_string()),
            hand: Hand::Person,
            circumstances: Circumstances::default(),
        }
    }

    #[test]
    fn a_session_is_found_by_the_id_that_the_list_prints_and_by_its_folder() {
        let home = tempfile::tempdir().unwrap();
        let sessions = home.path().join("sessions");
        let kept = sessions.join("01a22c0e-568f-7163-bf6a-1f2f93a3f980");
        std::fs::create_dir_all(&kept).unwrap();
        let recording = kept.join("session.mcap");
        std::fs::write(&recording, "x").unwrap();
        let path = home.path().join("store.sqlite");
        let mut store = Store::open(&path).unwrap();
        store.add_session("Ada", &record(&recording)).unwrap();
        drop(store);
        let file = StoreFile { store: Some(path) };
        let find = |typed: &Path| find_within(typed, &file, Some(&sessions));
        assert_eq!(find(Path::new(ID)).unwrap(), kept);
        let name = kept.file_name().unwrap();
        assert_eq!(find(Path::new(name)).unwrap(), kept);
        assert_eq!(find(&recording).unwrap(), recording);
        for left_alone in ["none.mcap", "out/none"] {
            assert_eq!(find(Path::new(left_alone)).unwrap(), Path::new(left_alone));
        }
        let nobody = find(Path::new("none")).unwrap_err().to_string();
        assert!(nobody.contains("calot store list NAME"), "{nobody}");
        // Its page names the trainee, whichever way the session was named.
        let summary = format!("{{\"session\": \"{ID}\"}}");
        std::fs::write(kept.join("summary.json"), summary).unwrap();
        for (typed, found) in [
            (Path::new(ID), &kept),
            (Path::new(name), &kept),
            (&recording, &recording),
        ] {
            let trainee = trainee_within(typed, found, &file);
            assert_eq!(trainee.as_deref(), Some("Ada"), "{}", typed.display());
        }
        assert_eq!(trainee_within(home.path(), home.path(), &file), None);
        std::fs::remove_dir_all(&kept).unwrap();
        let gone = find(Path::new(ID)).unwrap_err().to_string();
        assert!(
            gone.contains("session.mcap") && gone.contains("new folder"),
            "{gone}"
        );
    }
}
