//! Turns the dynamic loader's message about a library into the cause and its remedy.

use std::fs::File;
use std::io::Read as _;
use std::path::Path;

use crate::HardwareError;

/// Class byte of an ELF file for 32-bit programs.
const ELF_CLASS_32: u8 = 1;

/// Remedies that differ from vendor to vendor.
#[derive(Debug)]
pub(crate) struct Product {
    /// Remedy if a function is missing.
    pub(crate) wrong_version: &'static str,
    /// Remedy if the library is missing.
    pub(crate) missing: &'static str,
    /// Remedy if the library is broken.
    pub(crate) broken: &'static str,
    /// Remedy if another kind of file has the library's name.
    pub(crate) not_a_library: &'static str,
}

/// Error of a library that the loader refused with `words`.
pub(crate) fn refused(path: &Path, words: &str, product: &Product) -> HardwareError {
    let (what, remedy) = cause(path, words, product);
    HardwareError::Library {
        path: path.to_path_buf(),
        what,
        remedy,
    }
}

/// Error of a library that was loaded but lacks a function. `words` is the error of the look-up.
pub(crate) fn incomplete(path: &Path, words: &str, product: &Product) -> HardwareError {
    let what = match after(words, UNDEFINED) {
        Some(symbol) => format!("the library lacks `{symbol}`"),
        None => words.to_owned(),
    };
    HardwareError::Library {
        path: path.to_path_buf(),
        what,
        remedy: product.wrong_version,
    }
}

const UNDEFINED: &str = "undefined symbol: ";
/// Remedy if the vendor's library needs another library that is missing and does not belong to the
/// vendor's driver.
const MISSING: &str =
    "Install the package that holds it (`ldd` on the library lists what is missing)";
/// Remedy if such a library is of the wrong release.
const OTHER_RELEASE: &str = "Install the release of that dependency for which the library was built (`ldd -r` on the library lists what is missing)";

fn cause(path: &Path, words: &str, product: &Product) -> (String, &'static str) {
    if let Some(found) = wrong_kind(path, product) {
        return found;
    }
    let first = words.split(": ").next().unwrap_or_default();
    if words.contains("not found (required by") {
        return (
            words.to_owned(),
            "The library that requires it was built for another release of the system: install its package for this release",
        );
    }
    if first.contains(".so") && Path::new(first).file_name() != path.file_name() {
        return dependency(first, words);
    }
    if words.contains("ELFCLASS32") {
        return on_32_bit();
    }
    if let Some(symbol) = after(words, UNDEFINED) {
        return (
            format!("the library needs `{symbol}`, which none of the libraries that it uses has"),
            "Install the releases of these dependencies for which the library was built (`ldd -r` on the library lists what is missing)",
        );
    }
    if words.contains("ermission denied") {
        return (
            "permission denied".to_owned(),
            "Let this user read it: `sudo chmod a+rx` on the library",
        );
    }
    if words.contains("No such file") {
        return ("no such library".to_owned(), product.missing);
    }
    (words.to_owned(), product.broken)
}

/// Cause and remedy if the loader's message names `other`, a library that the vendor's library
/// needs.
fn dependency(other: &str, words: &str) -> (String, &'static str) {
    let needs = format!("the library needs {other}");
    if let Some(symbol) = after(words, UNDEFINED) {
        return (
            format!("{needs}, which lacks `{symbol}` of yet another library"),
            OTHER_RELEASE,
        );
    }
    if words.contains("ELFCLASS32") {
        return (
            format!("{needs}, which is installed for 32-bit programs only"),
            "Install the 64-bit package that holds it",
        );
    }
    if words.contains("ermission denied") {
        return (
            format!("{needs}, which this user may not read"),
            "Let this user read that file: `sudo chmod a+rx` on it",
        );
    }
    if words.contains("No such file") {
        return (format!("{needs}, which is not installed"), MISSING);
    }
    (
        format!("{needs}, which cannot be loaded ({words})"),
        "Install the package that holds that file again",
    )
}

fn on_32_bit() -> (String, &'static str) {
    (
        "a library for 32-bit programs".to_owned(),
        "Calot is a 64-bit program: install the vendor's 64-bit driver, or name its library",
    )
}

/// Kind and remedy of a file that cannot be a library for this program. `None` leaves the verdict
/// to the loader. A `path` without a folder is looked up in the current folder.
fn wrong_kind(path: &Path, product: &Product) -> Option<(String, &'static str)> {
    let mut head = [0; 5];
    File::open(path).ok()?.read_exact(&mut head).ok()?;
    match head {
        [0x7F, b'E', b'L', b'F', ELF_CLASS_32] => Some(on_32_bit()),
        [0x7F, b'E', b'L', b'F', _] => None,
        _ => Some((
            "not a library but another file, perhaps a script for the linker".to_owned(),
            product.not_a_library,
        )),
    }
}

/// The word after `mark`.
fn after<'a>(words: &'a str, mark: &str) -> Option<&'a str> {
    let (_, rest) = words.split_once(mark)?;
    rest.split([' ', ',', '('])
        .next()
        .filter(|word| !word.is_empty())
}

#[cfg(test)]
mod tests {
    use super::*;

    const PRODUCT: Product = Product {
        wrong_version: "Install version 3.4",
        missing: "Install the vendor's driver",
        broken: "Install it again",
        not_a_library: "Name the library itself",
    };

    fn said(words: &str) -> String {
        refused(Path::new("/opt/libHD.so"), words, &PRODUCT).to_string()
    }

    #[test]
    fn a_missing_dependency_is_not_reported_as_a_missing_driver() {
        let error =
            said("libncurses.so.5: cannot open shared object file: No such file or directory");
        assert!(error.contains("needs libncurses.so.5"), "{error}");
        assert!(!error.contains("Install the vendor's driver"), "{error}");
        let error =
            said("/opt/libHD.so: cannot open shared object file: No such file or directory");
        assert!(
            error.contains("no such library. Install the vendor's driver"),
            "{error}"
        );
    }

    #[test]
    fn an_unusable_dependency_is_named_instead_of_the_library() {
        let libraries = [
            (
                "/opt/libIO.so.5: undefined symbol: io_open",
                "needs /opt/libIO.so.5, which lacks `io_open`",
            ),
            (
                "libIO.so.5: wrong ELF class: ELFCLASS32",
                "needs libIO.so.5, which is installed for 32-bit programs only. Install the 64-bit package",
            ),
            (
                "/opt/libIO.so.5: cannot open shared object file: Permission denied",
                "needs /opt/libIO.so.5, which this user may not read",
            ),
            (
                "/opt/libIO.so.5: file too short",
                "needs /opt/libIO.so.5, which cannot be loaded",
            ),
            (
                "/opt/libHD.so: undefined symbol: io_open",
                "needs `io_open`, which none of the libraries that it uses has",
            ),
        ];
        for (words, cause) in libraries {
            let error = said(words);
            assert!(error.contains(cause), "{error}");
            for part in [
                PRODUCT.wrong_version,
                PRODUCT.missing,
                PRODUCT.broken,
                "64-bit driver",
            ] {
                assert!(!error.contains(part), "{error}");
            }
        }
    }

    #[test]
    fn a_missing_function_means_another_version_of_the_library() {
        let path = Path::new("/opt/libHD.so");
        let words = |words: &str| incomplete(path, words, &PRODUCT).to_string();
        let error = words("/opt/libHD.so: undefined symbol: hdUnschedule");
        assert!(
            error.contains("lacks `hdUnschedule`. Install version 3.4"),
            "{error}"
        );
        assert!(words("no words").contains("no words. Install version"));
    }

    #[test]
    fn every_other_cause_has_its_own_remedy() {
        for (words, cause) in [
            (
                "/opt/libHD.so: wrong ELF class: ELFCLASS32",
                "64-bit driver",
            ),
            (
                "/opt/libHD.so: cannot open shared object file: Permission denied",
                "chmod",
            ),
            (
                "/lib/libc.so.6: version `GLIBC_2.99' not found (required by /opt/libHD.so)",
                "another release of the system",
            ),
        ] {
            let error = said(words);
            assert!(error.contains(cause), "{error}");
        }
    }

    #[test]
    fn a_file_of_another_kind_is_recognised_by_its_first_bytes() {
        let folder = tempfile::tempdir().unwrap();
        for (bytes, cause) in [
            (b"\x7FELF\x01\x01\x01".as_slice(), "32-bit"),
            (b"GROUP ( /usr/lib/libHD.so.3.4 )", "script for the linker"),
        ] {
            let path = folder.path().join("libHD.so");
            std::fs::write(&path, bytes).unwrap();
            let error = refused(&path, "file too short", &PRODUCT).to_string();
            assert!(error.contains(cause), "{error}");
        }
    }
}
