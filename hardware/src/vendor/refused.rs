//! The loader's words about a library, turned into the cause and its remedy.

use std::fs::File;
use std::io::Read as _;
use std::path::Path;

use crate::HardwareError;

/// Class byte of an ELF file for 32-bit programs.
const ELF_CLASS_32: u8 = 1;

/// Remedies that differ from vendor to vendor.
#[derive(Debug)]
pub(crate) struct Product {
    /// A function is missing.
    pub(crate) version: &'static str,
    /// The library is missing.
    pub(crate) install: &'static str,
    /// The library is broken.
    pub(crate) again: &'static str,
    /// Another file stands under its name.
    pub(crate) itself: &'static str,
}

/// Error of a library that was refused with `words` by the loader or the look-up of its functions.
pub(crate) fn refused(path: &Path, words: &str, product: &Product) -> HardwareError {
    let (what, remedy) = cause(path, words, product);
    HardwareError::Library {
        path: path.to_path_buf(),
        what,
        remedy,
    }
}

fn cause(path: &Path, words: &str, product: &Product) -> (String, &'static str) {
    if let Some(found) = wrong_kind(path, product) {
        return found;
    }
    if words.contains("ELFCLASS32") {
        return on_32_bit();
    }
    let first = words.split(": ").next().unwrap_or_default();
    if let Some(symbol) = after(words, "undefined symbol: ") {
        return (format!("the library lacks `{symbol}`"), product.version);
    }
    if words.contains("not found (required by") {
        return (
            words.to_owned(),
            "The library was built for another release of the system: take the vendor's package for this one",
        );
    }
    if words.contains("No such file") && Path::new(first) != path {
        return (
            format!("the library needs {first}, which is not installed"),
            "Install the package that holds it (`ldd` on the library lists what is missing)",
        );
    }
    if words.contains("ermission denied") {
        return (
            "permission denied".to_owned(),
            "Let this user read it: `sudo chmod a+rx` on the library",
        );
    }
    if words.contains("No such file") {
        return ("no such library".to_owned(), product.install);
    }
    (words.to_owned(), product.again)
}

fn on_32_bit() -> (String, &'static str) {
    (
        "a library for 32-bit programs".to_owned(),
        "Calot is a 64-bit program: install the vendor's 64-bit driver, or name its library",
    )
}

/// Kind and remedy of a file that cannot be a library for this program. `None` leaves the verdict
/// to the loader. A name without a folder is looked up in the current one.
fn wrong_kind(path: &Path, product: &Product) -> Option<(String, &'static str)> {
    let mut head = [0; 5];
    File::open(path).ok()?.read_exact(&mut head).ok()?;
    match head {
        [0x7F, b'E', b'L', b'F', ELF_CLASS_32] => Some(on_32_bit()),
        [0x7F, b'E', b'L', b'F', _] => None,
        _ => Some((
            "not a library but another file, perhaps a script for the linker".to_owned(),
            product.itself,
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
        version: "Install version 3.4",
        install: "Install the vendor's driver",
        again: "Install it again",
        itself: "Name the library itself",
    };

    fn said(words: &str) -> String {
        refused(Path::new("/opt/libHD.so"), words, &PRODUCT).to_string()
    }

    #[test]
    fn a_missing_dependency_is_not_a_missing_driver() {
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
    fn every_other_cause_has_its_own_remedy() {
        for (words, cause) in [
            (
                "/opt/libHD.so: wrong ELF class: ELFCLASS32",
                "64-bit driver",
            ),
            (
                "/opt/libHD.so: undefined symbol: hdUnschedule",
                "lacks `hdUnschedule`. Install version 3.4",
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
    fn a_file_of_another_kind_is_told_by_its_first_bytes() {
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
