//! The folder of a user's stations, and the access to their files.

use std::path::PathBuf;

use super::error::ServiceError;

/// Removes the permissions of group and others from a file or folder that this user owns. A
/// symbolic link is not followed, because anybody can put one into /dev/shm. Failures are ignored.
pub(super) fn close(path: &std::path::Path) {
    use rustix::fs::{Mode, OFlags};
    use std::os::unix::fs::{MetadataExt, PermissionsExt};
    let flags = OFlags::RDONLY | OFlags::NOFOLLOW | OFlags::NONBLOCK | OFlags::CLOEXEC;
    let Ok(file) = rustix::fs::open(path, flags, Mode::empty()).map(std::fs::File::from) else {
        return;
    };
    let Ok(meta) = file.metadata() else { return };
    let mode = meta.permissions().mode();
    let is_ours = meta.uid() == user() && (meta.is_file() || meta.is_dir());
    if is_ours && mode & 0o077 != 0 {
        let _ = file.set_permissions(std::fs::Permissions::from_mode(mode & 0o700));
    }
}

/// Effective uid of this process.
pub(super) fn user() -> u32 {
    rustix::process::geteuid().as_raw()
}

/// The user with this uid in words: "user anna" if /etc/passwd has a name, else "user 1001".
#[must_use]
pub fn owner(user: u32) -> String {
    let users = std::fs::read_to_string("/etc/passwd").unwrap_or_default();
    let number = user.to_string();
    let name = users.lines().find_map(|line| {
        let mut fields = line.split(':');
        let name = fields.next()?;
        (fields.nth(1)? == number).then_some(name)
    });
    name.map_or_else(|| format!("user {number}"), |name| format!("user {name}"))
}

/// The file's path and its owner's name, if the file belongs to another user.
pub(super) fn foreign(path: &std::path::Path) -> Option<(PathBuf, String)> {
    use std::os::unix::fs::MetadataExt as _;
    let meta = std::fs::symlink_metadata(path).ok()?;
    (meta.uid() != user()).then(|| (path.to_owned(), owner(meta.uid())))
}

/// The folder of this user's stations. If it does not exist, this function makes it with access for
/// this user alone. Another user can guess the path and make a folder or link there first. So this
/// function refuses a folder of another user, a folder that other users can write to, and anything
/// that is not a folder.
///
/// # Errors
/// [`ServiceError::Folder`] names the folder's fault.
pub fn user_folder() -> Result<PathBuf, ServiceError> {
    use std::os::unix::fs::{DirBuilderExt, MetadataExt};
    let user = user();
    let path = std::env::temp_dir().join(format!("calot-{user}"));
    let refused = |problem: String| ServiceError::Folder {
        path: path.clone(),
        problem,
    };
    match std::fs::DirBuilder::new().mode(0o700).create(&path) {
        Err(error) if error.kind() != std::io::ErrorKind::AlreadyExists => {
            return Err(refused(format!(
                "the temporary folder cannot be used: {error}"
            )));
        }
        _ => {}
    }
    let meta = std::fs::symlink_metadata(&path).map_err(|error| refused(error.to_string()))?;
    if meta.uid() != user {
        return Err(refused(format!("it belongs to {}", owner(meta.uid()))));
    }
    if !meta.is_dir() || meta.mode() & 0o022 != 0 {
        return Err(refused(
            "it is not a folder that only this user can write to".into(),
        ));
    }
    Ok(path)
}
