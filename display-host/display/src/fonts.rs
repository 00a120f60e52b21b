//! Fonts of the computer for characters that the built-in fonts lack, so that names in all scripts
//! are displayed. A font is looked for when a character needs it.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use egui::epaint::text::{FallbackRequest, FontInsert};
use egui::{FontData, FontProvider};
use skrifa::raw::FileRef;
use skrifa::{FontRef, MetadataProvider as _};

/// Largest number of font files that are looked at.
const FILES_MAX: usize = 4000;
/// Largest depth of folders below a folder of fonts.
const DEPTH_MAX: usize = 6;
/// Largest font file that is read, bytes.
const BYTES_MAX: u64 = 64 << 20;
/// Number of low bits of a character's code that do not count for its block. If no font has one
/// character of a block, the whole block counts as missing.
const BLOCK_BITS: u32 = 7;

/// Adds the fonts of this computer to an interface.
pub fn add(context: &egui::Context) {
    // A character without a font is drawn as a box, so that no name can end the program.
    context.set_missing_glyph_policy(egui::MissingGlyphPolicy::Tofu);
    context.add_font_provider(Arc::new(SystemFonts::of(folders(|name| {
        std::env::var_os(name)
    }))));
}

/// Fonts in some folders.
struct SystemFonts {
    folders: Vec<PathBuf>,
    found: Mutex<Found>,
}

#[derive(Default)]
struct Found {
    /// Font files, the plainest first; `None`: not looked for yet.
    files: Option<Vec<PathBuf>>,
    /// Fonts in use: file and number in the file.
    used: Vec<(PathBuf, u32)>,
    /// Blocks of characters for which no file has a font.
    missing: Vec<u32>,
}

impl SystemFonts {
    fn of(folders: Vec<PathBuf>) -> Self {
        Self {
            folders,
            found: Mutex::default(),
        }
    }

    /// Content of the first font file with this character, and its name.
    fn with(&self, character: char) -> Option<(String, Vec<u8>, u32)> {
        let mut found = self.found.lock().unwrap_or_else(PoisonError::into_inner);
        let block = u32::from(character) >> BLOCK_BITS;
        let Found {
            files,
            used,
            missing,
        } = &mut *found;
        let files = files.get_or_insert_with(|| files_in(&self.folders));
        if missing.contains(&block) {
            return None;
        }
        // Fonts in use come first, so that one font serves a whole name, if it has all characters.
        let again = used.iter().map(|(file, _)| file.clone());
        let mut all = again.chain(files.iter().cloned());
        let font = all.find_map(|file| {
            let bytes = read(&file)?;
            let number = number_with(&bytes, character)?;
            Some((file, bytes, number))
        });
        let Some((file, bytes, number)) = font else {
            missing.push(block);
            return None;
        };
        let name = format!("{}#{number}", file.display());
        used.push((file, number));
        Some((name, bytes, number))
    }
}

impl FontProvider for SystemFonts {
    fn font_for(&self, request: &FallbackRequest<'_>) -> Option<FontInsert> {
        let (name, bytes, number) = self.with(request.cluster.chars().next()?)?;
        let data = FontData {
            index: number,
            ..FontData::from_owned(bytes)
        };
        Some(FontInsert::new(&name, data, Vec::new()))
    }
}

/// Folders of fonts by the XDG base directory specification.
fn folders(variable: impl Fn(&str) -> Option<std::ffi::OsString>) -> Vec<PathBuf> {
    let path = |name| {
        variable(name)
            .map(PathBuf::from)
            .filter(|it| it.is_absolute())
    };
    let home = path("HOME");
    let own = path("XDG_DATA_HOME").or_else(|| Some(home.as_ref()?.join(".local/share")));
    let shared = variable("XDG_DATA_DIRS").filter(|it| !it.is_empty());
    let shared = shared.unwrap_or_else(|| "/usr/local/share:/usr/share".into());
    let data = own.into_iter().chain(std::env::split_paths(&shared));
    let fonts = data.map(|it| it.join("fonts"));
    fonts.chain(home.map(|it| it.join(".fonts"))).collect()
}

/// Font files below these folders, the plainest first.
fn files_in(folders: &[PathBuf]) -> Vec<PathBuf> {
    let mut files = Vec::new();
    let mut open: Vec<(PathBuf, usize)> = folders.iter().map(|it| (it.clone(), 0)).collect();
    while let Some((folder, depth)) = open.pop() {
        for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
            let path = entry.path();
            match path.is_dir() {
                true if depth < DEPTH_MAX => open.push((path, depth + 1)),
                false if is_font(&path) && files.len() < FILES_MAX => files.push(path),
                _ => {}
            }
        }
    }
    files.sort_by_cached_key(|path| (oddness(path), path.clone()));
    files.dedup();
    files
}

fn is_font(path: &Path) -> bool {
    let end = path.extension().and_then(|it| it.to_str()).unwrap_or("");
    ["ttf", "otf", "ttc", "otc"]
        .iter()
        .any(|it| end.eq_ignore_ascii_case(it))
}

/// Number of ways in which the name of a font differs from a plain upright font without serifs.
fn oddness(path: &Path) -> usize {
    let name = path.file_stem().and_then(|it| it.to_str()).unwrap_or("");
    let name = name.to_lowercase();
    let odd = [
        "bold",
        "black",
        "italic",
        "oblique",
        "mono",
        "condensed",
        "narrow",
        "light",
        "thin",
        "serif",
        "emoji",
        "symbol",
        "math",
        "last",
    ];
    let odd = odd.iter().filter(|it| name.contains(*it)).count();
    let plain = name.contains("sans") && !name.contains("mono");
    2 * odd + usize::from(!plain)
}

/// The bytes of a font file. Only plain files of a usual size are read.
fn read(path: &Path) -> Option<Vec<u8>> {
    let about = std::fs::metadata(path).ok()?;
    let is_usual = about.is_file() && about.len() <= BYTES_MAX;
    is_usual.then(|| std::fs::read(path).ok()).flatten()
}

/// Number of the first font of a file that has this character.
fn number_with(bytes: &[u8], character: char) -> Option<u32> {
    let has = |font: &FontRef<'_>| {
        let glyph = font.charmap().map(character);
        glyph.is_some_and(|it| it.to_u32() != 0)
    };
    match FileRef::new(bytes).ok()? {
        FileRef::Font(font) => has(&font).then_some(0),
        FileRef::Collection(all) => {
            (0..all.len()).find(|number| all.get(*number).is_ok_and(|font| has(&font)))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_are_those_of_the_user_and_of_the_system() {
        let found = |set: &[(&str, &str)]| {
            let folders = folders(|name| {
                let found = set.iter().find(|(known, _)| *known == name)?;
                Some(found.1.into())
            });
            let folders = folders.iter().map(|it| it.display().to_string());
            folders.collect::<Vec<_>>().join(" ")
        };
        assert_eq!(
            found(&[("HOME", "/home/anna"), ("XDG_DATA_DIRS", "/opt/share")]),
            "/home/anna/.local/share/fonts /opt/share/fonts /home/anna/.fonts"
        );
        assert_eq!(found(&[]), "/usr/local/share/fonts /usr/share/fonts");
    }

    #[test]
    fn plain_fonts_come_first() {
        let rank = |name: &str| oddness(Path::new(name));
        assert!(rank("NotoSansArabic-Regular.ttf") < rank("NotoSansArabic-Bold.ttf"));
        assert!(rank("NotoSansArabic-Regular.ttf") < rank("NotoSerifArabic-Regular.ttf"));
        assert!(rank("DejaVuSans.ttf") < rank("DejaVuSansMono.ttf"));
    }

    /// A built-in font stands for a font of the computer. Files that are no fonts are ignored.
    #[test]
    fn a_font_is_found_by_its_characters_alone() {
        let folder = tempfile::tempdir().unwrap();
        let inner = folder.path().join("truetype");
        std::fs::create_dir(&inner).unwrap();
        std::fs::write(inner.join("a-sans.ttf"), b"no font").unwrap();
        let fonts = egui::FontDefinitions::default();
        let ubuntu: &[u8] = (*fonts.font_data["Ubuntu-Light"].font).as_ref();
        std::fs::write(inner.join("b-sans.ttf"), ubuntu).unwrap();
        std::fs::write(inner.join("readme.txt"), ubuntu).unwrap();
        let system = SystemFonts::of(vec![folder.path().to_owned(), "/nowhere".into()]);
        let (name, bytes, number) = system.with('\u{416}').expect("it has Cyrillic letters");
        assert!(name.ends_with("b-sans.ttf#0"), "{name}");
        assert_eq!((bytes.len(), number), (ubuntu.len(), 0));
        assert!(system.with('\u{65E5}').is_none(), "it has no Chinese ones");
        let missing = system.found.lock().unwrap().missing.len();
        assert!(system.with('\u{65E6}').is_none());
        assert_eq!(
            system.found.lock().unwrap().missing.len(),
            missing,
            "one block"
        );
    }
}
