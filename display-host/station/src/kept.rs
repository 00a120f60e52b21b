//! Cache of prepared scenes. A scene that was prepared before is not prepared again.
//!
//! The files lie in `$XDG_CACHE_HOME/calot/scenes` or `~/.cache/calot/scenes`. Their names depend
//! on the recipe, its meshes and the program that prepared them. The cache keeps the few scenes
//! that were used last. A scene that cannot be stored or read is prepared again.

use std::fs;
use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use scene_prepare::Recipe;
use scene_prepare::recipe::Surface;
use shared_mem::scene::SceneFile;

use crate::home;

/// Largest number of scenes kept.
const SCENES_MAX: usize = 12;

/// Largest number of files near a glTF file that are checked for changes. With more, the scene is
/// not cached.
const FILES_MAX: usize = 1000;
/// Largest number of folders near a glTF file that are found and not yet searched. With more, the
/// scene is not cached.
const FOLDERS_MAX: usize = 16;

/// Place of a recipe's scene in the cache.
#[derive(Debug)]
pub(crate) struct Kept {
    path: PathBuf,
}

impl Kept {
    /// Place of the scene of `recipe`. Returns `None` without a cache folder, or if a mesh cannot
    /// be read or has too many files near it.
    pub(crate) fn of(recipe: &Recipe) -> Option<Self> {
        Self::within(&home::cache()?.join("scenes"), recipe)
    }

    fn within(folder: &Path, recipe: &Recipe) -> Option<Self> {
        let mut hash = DefaultHasher::new();
        // The debug text of a recipe holds every number exactly.
        format!("{recipe:?}").hash(&mut hash);
        file_identity(&std::env::current_exe().ok()?)?.hash(&mut hash);
        for organ in &recipe.organs {
            if let Surface::Mesh { path, .. } = &organ.surface {
                file_identity(path)?.hash(&mut hash);
                // A glTF file may keep its numbers in other files next to it.
                if path
                    .extension()
                    .is_some_and(|it| it.eq_ignore_ascii_case("gltf"))
                {
                    buffers_beside(path)?.hash(&mut hash);
                }
            }
        }
        let name = format!("{:016x}.calot", hash.finish());
        Some(Self {
            path: folder.join(name),
        })
    }

    /// Copies the scene to `target`. Returns true if the cache held it intact.
    pub(crate) fn fetch(&self, target: &Path) -> bool {
        let is_there = fs::copy(&self.path, target).is_ok() && SceneFile::open(target).is_ok();
        if is_there && let Ok(file) = fs::File::open(&self.path) {
            // Mark the file as recently used, so that the cache keeps it.
            let _ = file.set_modified(SystemTime::now());
        }
        is_there
    }

    /// Stores the compiled scene at `source`.
    pub(crate) fn keep(&self, source: &Path) {
        let Some(folder) = self.path.parent() else {
            return;
        };
        // A rename stores all or nothing, even if another process stores the same scene at this
        // moment.
        let unfinished = self.path.with_extension(std::process::id().to_string());
        let _ = fs::create_dir_all(folder)
            .and_then(|()| fs::copy(source, &unfinished))
            .and_then(|_| fs::rename(&unfinished, &self.path));
        let _ = fs::remove_file(&unfinished);
        forget_oldest(folder);
    }
}

/// Identities of all files in a mesh's folder and below it, any of which may hold the mesh's
/// numbers. `None` if there are too many.
fn buffers_beside(mesh: &Path) -> Option<Vec<(PathBuf, u64, u128)>> {
    let folder = mesh.parent().filter(|it| !it.as_os_str().is_empty());
    let mut folders = vec![folder.unwrap_or(Path::new(".")).to_owned()];
    let mut found = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(folder).ok()?.flatten().take(FILES_MAX + 1) {
            let path = entry.path();
            match entry.file_type().ok()? {
                kind if kind.is_dir() => folders.push(path),
                kind if kind.is_file() => found.extend(file_identity(&path)),
                _ => {}
            }
        }
        if found.len() > FILES_MAX || folders.len() > FOLDERS_MAX {
            return None; // too many to check at every start
        }
    }
    found.sort();
    Some(found)
}

/// Identity of a file: path, size, and time of change in ns.
fn file_identity(path: &Path) -> Option<(PathBuf, u64, u128)> {
    let known = fs::metadata(path).ok()?;
    let changed = known.modified().ok()?;
    let since = changed.duration_since(SystemTime::UNIX_EPOCH).ok()?;
    Some((path.to_owned(), known.len(), since.as_nanos()))
}

fn forget_oldest(folder: &Path) {
    let Ok(files) = fs::read_dir(folder) else {
        return;
    };
    let used = |file: fs::DirEntry| Some((file.metadata().ok()?.modified().ok()?, file.path()));
    let mut files: Vec<_> = files.flatten().filter_map(used).collect();
    files.sort_by(|a, b| b.cmp(a));
    for (_, path) in files.iter().skip(SCENES_MAX) {
        let _ = fs::remove_file(path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cached_scene_is_found_and_another_recipe_has_its_own() {
        let folder = tempfile::tempdir().unwrap();
        let recipe = Recipe::built_in().unwrap().with_spheres(60).unwrap();
        let scene = scene_prepare::prepare(&recipe, &mut |_| {}).unwrap().scene;
        let (first, again) = (folder.path().join("a.calot"), folder.path().join("b.calot"));
        scene.write(&first).unwrap();
        let cache = folder.path().join("cache");
        let kept = Kept::within(&cache, &recipe).unwrap();
        assert!(!kept.fetch(&again));
        kept.keep(&first);
        assert!(Kept::within(&cache, &recipe).unwrap().fetch(&again));
        assert_eq!(fs::read(&first).unwrap(), fs::read(&again).unwrap());
        let other = Recipe::built_in().unwrap().with_spheres(61).unwrap();
        assert!(!Kept::within(&cache, &other).unwrap().fetch(&again));
        // A broken file counts as missing.
        fs::write(&kept.path, "garbage").unwrap();
        assert!(!kept.fetch(&again));
    }

    #[test]
    fn the_scenes_used_least_recently_are_deleted() {
        let folder = tempfile::tempdir().unwrap();
        for number in 0..SCENES_MAX as u64 + 3 {
            let file = fs::File::create(folder.path().join(format!("{number}"))).unwrap();
            let at = SystemTime::UNIX_EPOCH + std::time::Duration::from_secs(number);
            file.set_modified(at).unwrap();
        }
        forget_oldest(folder.path());
        let left = fs::read_dir(folder.path()).unwrap().count();
        assert_eq!(left, SCENES_MAX);
        assert!(!folder.path().join("2").exists() && folder.path().join("3").exists());
    }

    #[test]
    fn a_scene_with_a_missing_mesh_is_not_cached() {
        let mut recipe = Recipe::built_in().unwrap();
        recipe.organs[0].surface = Surface::Mesh {
            path: "no-such-mesh.obj".into(),
            parts: Vec::new(),
            unit_m: None,
            axes: scene_prepare::recipe::Axes::default(),
        };
        assert!(Kept::within(Path::new("x"), &recipe).is_none());
    }
}
