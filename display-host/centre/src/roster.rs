//! The list of stations that may join, and of instructors who may look.

use std::collections::{BTreeMap, BTreeSet};
use std::fs::File;
use std::io::Read as _;
use std::path::Path;

use argon2::Argon2;
use argon2::password_hash::{PasswordHash, PasswordHasher as _, PasswordVerifier as _, SaltString};
use serde::Deserialize;

use crate::error::CentreError;

/// Characters of a name.
const PLAIN: &str = "1 to 40 characters of a-z, A-Z, 0-9, - and _, and each name once";

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields, default)]
struct List {
    station: Vec<StationEntry>,
    instructor: Vec<InstructorEntry>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct StationEntry {
    name: String,
    certificate: Option<String>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct InstructorEntry {
    name: String,
    password: String,
    stations: Option<BTreeSet<String>>,
}

/// Rights of stations and instructors.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Roster {
    /// Stations by the common names of their certificates. A name that is missing here has no
    /// rights.
    pub stations: BTreeMap<String, String>,
    /// Instructors by name.
    pub instructors: BTreeMap<String, Instructor>,
}

/// An instructor.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Instructor {
    password: String,
    /// Stations that this person may see; `None`: all.
    pub stations: Option<BTreeSet<String>>,
}

impl Instructor {
    /// True if this is the person's password. The check is slow on purpose.
    #[must_use]
    pub fn has(&self, password: &str) -> bool {
        let Ok(hash) = PasswordHash::new(&self.password) else {
            return false;
        };
        let right = Argon2::default().verify_password(password.as_bytes(), &hash);
        right.is_ok()
    }

    /// True if this person may see the station of this name.
    #[must_use]
    pub fn may_see(&self, station: &str) -> bool {
        self.stations.as_ref().is_none_or(|it| it.contains(station))
    }
}

impl Roster {
    /// Reads the list.
    ///
    /// # Errors
    /// [`CentreError::File`], [`CentreError::Roster`].
    pub fn read(path: &Path) -> Result<Self, CentreError> {
        let unreadable = |problem: String| CentreError::File {
            path: path.to_owned(),
            problem,
        };
        let text = std::fs::read_to_string(path).map_err(|error| unreadable(error.to_string()))?;
        let file: List = toml::from_str(&text).map_err(|error| unreadable(error.to_string()))?;
        let wrong = |what, value: &str, allowed| CentreError::Roster {
            path: path.to_owned(),
            what,
            value: value.to_owned(),
            allowed,
        };
        let mut roster = Self::default();
        for it in file.station {
            let certificate = it.certificate.unwrap_or_else(|| it.name.clone());
            if !is_plain(&it.name) || roster.stations.values().any(|known| *known == it.name) {
                return Err(wrong("the name of a station", &it.name, PLAIN));
            }
            if !is_plain(&certificate) || roster.stations.contains_key(&certificate) {
                return Err(wrong("the certificate of a station", &certificate, PLAIN));
            }
            roster.stations.insert(certificate, it.name);
        }
        for it in file.instructor {
            if !is_plain(&it.name) || roster.instructors.contains_key(&it.name) {
                return Err(wrong("the name of an instructor", &it.name, PLAIN));
            }
            if PasswordHash::new(&it.password).is_err() {
                let allowed = "what `calot centre password` prints";
                return Err(wrong("the password of an instructor", "…", allowed));
            }
            let known: BTreeSet<&String> = roster.stations.values().collect();
            let unknown = { it.stations.iter().flatten() }.find(|it| !known.contains(it));
            if let Some(unknown) = unknown {
                let allowed = "the name of a [[station]] above";
                return Err(wrong("a station of an instructor", unknown, allowed));
            }
            let instructor = Instructor {
                password: it.password,
                stations: it.stations,
            };
            roster.instructors.insert(it.name, instructor);
        }
        Ok(roster)
    }
}

fn is_plain(name: &str) -> bool {
    let plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    !name.is_empty() && name.len() <= 40 && name.chars().all(plain)
}

/// Hash of a password, for the list.
///
/// # Errors
/// [`CentreError::Password`] if it is too short or too long.
pub fn hashed(password: &str) -> Result<String, CentreError> {
    let length = password.chars().count();
    let refused = |_| CentreError::Password(length);
    if !(10..=200).contains(&length) {
        return Err(CentreError::Password(length));
    }
    let salt = SaltString::encode_b64(&random::<16>()?).map_err(refused)?;
    let hash = Argon2::default().hash_password(password.as_bytes(), &salt);
    Ok(hash.map_err(refused)?.to_string())
}

/// Bytes that nobody can guess.
///
/// # Errors
/// [`CentreError::File`] if the system gives none.
pub fn random<const N: usize>() -> Result<[u8; N], CentreError> {
    let path = Path::new("/dev/urandom");
    let mut bytes = [0; N];
    let read = File::open(path).and_then(|mut file| file.read_exact(&mut bytes));
    read.map_err(|error| CentreError::File {
        path: path.to_owned(),
        problem: error.to_string(),
    })?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Roster, CentreError> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("centre.toml");
        std::fs::write(&path, text).unwrap();
        Roster::read(&path)
    }

    #[test]
    fn rights_follow_names_and_passwords_are_kept_as_hashes() {
        let hash = hashed("correct horse").unwrap();
        assert!(hash.starts_with("$argon2id$") && !hash.contains("horse"));
        let text = format!(
            "[[station]]\nname = 'theatre-1'\ncertificate = 'theatre-1-b'\n[[station]]\nname = 'left'\n\
             [[instructor]]\nname = 'bo'\npassword = '{hash}'\nstations = ['left']\n"
        );
        let roster = read(&text).unwrap();
        assert_eq!(roster.stations["theatre-1-b"], "theatre-1");
        assert!(!roster.stations.contains_key("theatre-1"), "it was revoked");
        let bo = &roster.instructors["bo"];
        assert!(bo.has("correct horse") && !bo.has("wrong horse"));
        assert!(bo.may_see("left") && !bo.may_see("theatre-1"));
        let said = hashed("short").unwrap_err().to_string();
        assert!(
            said.contains("has 5 characters; it needs 10 to 200"),
            "{said}"
        );
    }

    #[test]
    fn mistakes_in_the_list_are_named() {
        let hash = hashed("correct horse").unwrap();
        for (text, words) in [
            (
                "[[station]]\nname = 'a/b'".to_owned(),
                "the name of a station is 'a/b'; allowed is 1 to 40",
            ),
            (
                "[[station]]\nname = 'a'\n[[station]]\nname = 'a'".to_owned(),
                "each name once",
            ),
            (
                "[[station]]\nname = 'a'\ncertificate = '*'".to_owned(),
                "the certificate of a station is '*'",
            ),
            (
                "[[instructor]]\nname = ''\npassword = ''".to_owned(),
                "the name of an instructor is ''",
            ),
            (
                "[[instructor]]\nname = 'bo'\npassword = 'secret'".to_owned(),
                "is '…'; allowed is what `calot centre password` prints",
            ),
            (
                format!("[[instructor]]\nname = 'bo'\npassword = '{hash}'\nstations = ['x']"),
                "a station of an instructor is 'x'; allowed is the name of a [[station]]",
            ),
            ("[[room]]".to_owned(), "centre.toml: TOML parse error"),
        ] {
            let said = read(&text).unwrap_err().to_string();
            assert!(said.contains(words) && !said.contains("secret"), "{said}");
        }
    }
}
