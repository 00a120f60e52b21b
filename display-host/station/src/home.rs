//! Folders of the user's own files by the XDG base directory specification. A relative path in a
//! variable counts as unset, as the specification requires.

use std::ffi::OsString;
use std::path::PathBuf;

/// Folder of files that can be made again. `None`: there is no home folder.
pub(crate) fn cache() -> Option<PathBuf> {
    folder("XDG_CACHE_HOME", ".cache", |name| std::env::var_os(name))
}

/// Folder of files that must not be lost. `None`: there is no home folder.
pub(crate) fn data() -> Option<PathBuf> {
    folder("XDG_DATA_HOME", ".local/share", |name| {
        std::env::var_os(name)
    })
}

/// Folder of settings. `None`: there is no home folder.
pub(crate) fn config() -> Option<PathBuf> {
    folder("XDG_CONFIG_HOME", ".config", |name| std::env::var_os(name))
}

fn folder(
    named: &str,
    in_home: &str,
    variable: impl Fn(&str) -> Option<OsString>,
) -> Option<PathBuf> {
    let rooted = |name| {
        variable(name)
            .map(PathBuf::from)
            .filter(|path| path.is_absolute())
    };
    rooted(named)
        .or_else(|| Some(rooted("HOME")?.join(in_home)))
        .map(|folder| folder.join("calot"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn among(variables: &[(&str, &str)]) -> Option<PathBuf> {
        folder("XDG_CACHE_HOME", ".cache", |name| {
            let found = variables.iter().find(|(known, _)| *known == name)?;
            Some(found.1.into())
        })
    }

    #[test]
    fn a_named_folder_comes_before_the_home() {
        let home = ("HOME", "/home/anna");
        let found = |named| among(&[home, ("XDG_CACHE_HOME", named)]);
        assert_eq!(found("/fast"), Some("/fast/calot".into()));
        for not_rooted in ["", "fast", "./fast"] {
            assert_eq!(found(not_rooted), Some("/home/anna/.cache/calot".into()));
        }
        assert_eq!(among(&[("HOME", "")]), None);
        assert_eq!(among(&[]), None);
    }
}
