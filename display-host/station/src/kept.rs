//! Prepared scenes that are kept: a station starts at once with a scene that it has prepared
//! before.
//!
//! They lie in `$XDG_CACHE_HOME/calot/scenes` or `~/.cache/calot/scenes`, named after the recipe
//! and the program that prepared them; a few, the oldest go. What cannot be kept or read there is
//! prepared again, as if there were none.

use std::fs;
use std::hash::{DefaultHasher, Hash as _, Hasher as _};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use scene_prepare::Recipe;
use scene_prepare::recipe::Surface;
use shared_mem::scene::SceneFile;

use crate::home;

/// Scenes that are kept.
const MOST: usize = 12;

/// Where a recipe's scene is kept.
#[derive(Debug)]
pub(crate) struct Kept {
    path: PathBuf,
}

impl Kept {
    /// `None`: there is no folder for it, or the recipe's meshes cannot be looked at.
    pub(crate) fn of(recipe: &Recipe) -> Option<Self> {
        Self::within(&home::cache()?.join("scenes"), recipe)
    }

    fn within(folder: &Path, recipe: &Recipe) -> Option<Self> {
        let mut hash = DefaultHasher::new();
        // Every number of it, to the last digit.
        format!("{recipe:?}").hash(&mut hash);
        stamp(&std::env::current_exe().ok()?)?.hash(&mut hash);
        for organ in &recipe.organs {
            if let Surface::Mesh { path, .. } = &organ.surface {
                stamp(path)?.hash(&mut hash);
            }
        }
        let name = format!("{:016x}.calot", hash.finish());
        Some(Self {
            path: folder.join(name),
        })
    }

    /// Puts it to `target`; whether it was there, and sound.
    pub(crate) fn fetch(&self, target: &Path) -> bool {
        let is_there = fs::copy(&self.path, target).is_ok() && SceneFile::open(target).is_ok();
        if is_there && let Ok(file) = fs::File::open(&self.path) {
            // Used, so that it stays.
            let _ = file.set_modified(SystemTime::now());
        }
        is_there
    }

    /// Keeps the compiled scene at `source` for the next time.
    pub(crate) fn keep(&self, source: &Path) {
        let Some(folder) = self.path.parent() else {
            return;
        };
        // Whole or not at all, whoever else does the same at this moment.
        let begun = self.path.with_extension(std::process::id().to_string());
        let _ = fs::create_dir_all(folder)
            .and_then(|()| fs::copy(source, &begun))
            .and_then(|_| fs::rename(&begun, &self.path));
        let _ = fs::remove_file(&begun);
        forget_oldest(folder);
    }
}

/// What changes with a file: size and time of change, in ns.
fn stamp(path: &Path) -> Option<(PathBuf, u64, u128)> {
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
    for (_, path) in files.iter().skip(MOST) {
        let _ = fs::remove_file(path);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_kept_comes_back_and_another_recipe_has_its_own() {
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
        // What is broken is as if it were not there.
        fs::write(&kept.path, "garbage").unwrap();
        assert!(!kept.fetch(&again));
    }

    #[test]
    fn the_oldest_go() {
        let folder = tempfile::tempdir().unwrap();
        for number in 0..MOST as u64 + 3 {
            let file = fs::File::create(folder.path().join(format!("{number}"))).unwrap();
            let at = SystemTime::UNIX_EPOCH + std::time::Duration::from_secs(number);
            file.set_modified(at).unwrap();
        }
        forget_oldest(folder.path());
        let left = fs::read_dir(folder.path()).unwrap().count();
        assert_eq!(left, MOST);
        assert!(!folder.path().join("2").exists() && folder.path().join("3").exists());
    }

    #[test]
    fn a_mesh_that_is_not_there_is_not_kept() {
        let mut recipe = Recipe::built_in().unwrap();
        recipe.organs[0].surface = Surface::Mesh {
            path: "no-such-mesh.obj".into(),
            parts: Vec::new(),
            unit_m: None,
        };
        assert!(Kept::within(Path::new("x"), &recipe).is_none());
    }
}
