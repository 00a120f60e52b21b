//! A folder of keys: the certificate of this computer, its private key, and its authority.

use std::os::unix::fs::PermissionsExt as _;
use std::path::{Path, PathBuf};

use x509_parser::pem::parse_x509_pem;

use crate::error::CentreError;

/// File of the authority's certificate.
const AUTHORITY: &str = "ca.pem";

/// Keys of one computer.
#[derive(Debug, Clone)]
pub struct Keys {
    /// Common name of the certificate.
    pub name: String,
    /// File of the certificate.
    pub certificate: PathBuf,
    /// File of the private key.
    pub key: PathBuf,
    /// File of the authority's certificate.
    pub authority: PathBuf,
}

impl Keys {
    /// Finds the keys in a folder.
    ///
    /// # Errors
    /// [`CentreError::Keys`].
    pub fn read(folder: &Path) -> Result<Self, CentreError> {
        let wrong = |problem: String| CentreError::Keys {
            folder: folder.to_owned(),
            problem,
        };
        let entries = std::fs::read_dir(folder).map_err(|error| wrong(error.to_string()))?;
        let paths = entries.flatten().map(|it| it.path());
        let keys: Vec<PathBuf> = paths
            .filter(|it| it.extension().is_some_and(|it| it == "key"))
            .collect();
        let [key] = keys.as_slice() else {
            return Err(wrong(format!("it holds {} files *.key", keys.len())));
        };
        let mode = std::fs::metadata(key).map_err(|error| wrong(error.to_string()))?;
        if mode.permissions().mode() & 0o077 != 0 {
            let problem = format!("others may read {}; chmod 600 {0}", key.display());
            return Err(wrong(problem));
        }
        let (certificate, authority) = (key.with_extension("pem"), folder.join(AUTHORITY));
        for file in [&certificate, &authority] {
            if !file.is_file() {
                return Err(wrong(format!("there is no {}", file.display())));
            }
        }
        let name = common_name(&certificate).map_err(wrong)?;
        Ok(Self {
            name,
            certificate,
            key: key.clone(),
            authority,
        })
    }
}

/// Common name of a certificate.
fn common_name(file: &Path) -> Result<String, String> {
    let bytes = std::fs::read(file).map_err(|error| error.to_string())?;
    let said = |problem: String| format!("{} is no certificate: {problem}", file.display());
    let (_, pem) = parse_x509_pem(&bytes).map_err(|error| said(error.to_string()))?;
    let certificate = pem.parse_x509().map_err(|error| said(error.to_string()))?;
    let mut names = certificate.subject().iter_common_name();
    let name = names.next().and_then(|it| it.as_str().ok());
    let name = name.ok_or_else(|| said("it names nobody".to_owned()))?;
    Ok(name.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn openssl(folder: &Path, name: &str) {
        let made = std::process::Command::new("openssl")
            .args(
                "req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -batch"
                    .split(' '),
            )
            .args([
                "-keyout",
                &format!("{name}.key"),
                "-out",
                &format!("{name}.pem"),
            ])
            .args(["-subj", &format!("/CN={name}")])
            .current_dir(folder)
            .output();
        assert!(made.expect("openssl").status.success());
    }

    fn said(folder: &Path) -> String {
        Keys::read(folder).unwrap_err().to_string()
    }

    #[test]
    fn a_folder_of_keys_has_one_name_and_what_is_missing_is_said() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        assert!(said(&folder.join("none")).contains("is no folder of keys: No such file"));
        assert!(said(folder).contains("it holds 0 files *.key"));
        openssl(folder, "theatre-1");
        assert!(said(folder).contains("ca.pem"), "{}", said(folder));
        std::fs::copy(folder.join("theatre-1.pem"), folder.join("ca.pem")).unwrap();
        assert_eq!(Keys::read(folder).unwrap().name, "theatre-1");
        let key = folder.join("theatre-1.key");
        std::fs::set_permissions(&key, std::fs::Permissions::from_mode(0o644)).unwrap();
        assert!(said(folder).contains("others may read"), "{}", said(folder));
        std::fs::set_permissions(&key, std::fs::Permissions::from_mode(0o600)).unwrap();
        std::fs::write(folder.join("theatre-1.pem"), "nothing").unwrap();
        assert!(
            said(folder).contains("is no certificate"),
            "{}",
            said(folder)
        );
        openssl(folder, "theatre-2");
        assert!(said(folder).contains("it holds 2 files *.key"));
    }
}
