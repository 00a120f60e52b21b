//! Files that only their user may read, and the authorities that are trusted.

use std::io::Read as _;
use std::os::unix::fs::{MetadataExt as _, PermissionsExt as _};
use std::path::Path;

use rustls::pki_types::CertificateDer;
use rustls::pki_types::pem::PemObject as _;

use crate::error::DeliverError;

/// Longest file of an address, bytes.
const MAX_BYTES: u64 = 4096;

/// First line of a file that holds an address with its password. Refuses a file that others can
/// read.
pub(crate) fn line(path: &Path) -> Result<String, DeliverError> {
    let refused = |problem: String| DeliverError::File {
        path: path.to_owned(),
        problem,
    };
    let file = std::fs::File::open(path).map_err(|error| refused(error.to_string()))?;
    let meta = file
        .metadata()
        .map_err(|error| refused(error.to_string()))?;
    if meta.permissions().mode() & 0o077 != 0 {
        return Err(refused(format!(
            "mode {:o} lets others read the password; chmod 600 {}",
            meta.mode() & 0o777,
            path.display()
        )));
    }
    let mut text = String::new();
    let read = file.take(MAX_BYTES).read_to_string(&mut text);
    read.map_err(|error| refused(error.to_string()))?;
    match text.lines().next().map(str::trim) {
        Some(line) if !line.is_empty() => Ok(line.to_owned()),
        _ => Err(refused(
            "its first line is empty; write the centre's address there".to_owned(),
        )),
    }
}

/// Certificates of the authorities in a file, or of those that this computer trusts.
pub(crate) fn authorities(ca: Option<&Path>) -> Result<Vec<CertificateDer<'static>>, DeliverError> {
    let Some(path) = ca else {
        return Ok(rustls_native_certs::load_native_certs().certs);
    };
    let refused = |problem: String| DeliverError::File {
        path: path.to_owned(),
        problem,
    };
    let found = CertificateDer::pem_file_iter(path)
        .and_then(Iterator::collect::<Result<Vec<_>, _>>)
        .map_err(|error| refused(format!("{error}; --ca takes certificates in PEM")))?;
    match found.is_empty() {
        true => Err(refused(
            "no certificate is in it; --ca takes certificates in PEM".to_owned(),
        )),
        false => Ok(found),
    }
}
