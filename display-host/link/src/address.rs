//! Where a side is, and how it proves who it is.

use std::net::IpAddr;
use std::os::unix::fs::{MetadataExt as _, PermissionsExt as _};
use std::path::{Path, PathBuf};

use rustls::RootCertStore;
use rustls::pki_types::pem::PemObject as _;
use rustls::pki_types::{CertificateDer, PrivateKeyDer};

use crate::error::LinkError;

/// Certificates of one side.
#[derive(Debug, Clone)]
pub struct Keys {
    /// Its certificate, PEM.
    pub certificate: PathBuf,
    /// The certificate's private key, PEM; for its user's eyes only.
    pub key: PathBuf,
    /// The certificate of the authority that signed both sides', PEM.
    pub authority: PathBuf,
}

/// Where a station's side listens, with what this side proves itself by.
#[derive(Debug, Clone)]
pub struct Address {
    pub(crate) host: String,
    pub(crate) port: u16,
    pub(crate) keys: Option<Keys>,
}

impl Address {
    /// `HOST:PORT` with certificates, or on this computer alone without.
    ///
    /// # Errors
    /// When it is no address, keys are missing, no keys, or can be read by others, or it is another
    /// computer's and no keys are given.
    pub fn new(address: &str, keys: Option<Keys>, insecure: bool) -> Result<Self, LinkError> {
        let refused = |problem| LinkError::Address {
            given: address.escape_debug().to_string(),
            problem,
        };
        let plain = |c: char| c.is_ascii_alphanumeric() || "[].:-".contains(c);
        let (host, port) = address
            .rsplit_once(':')
            .filter(|(host, _)| !host.is_empty() && address.chars().all(plain))
            .ok_or_else(|| refused("HOST:PORT is one, as in 10.0.0.7:7447 or [::1]:7447"))?;
        let Ok(port) = port.parse::<u16>() else {
            return Err(refused("a port is 0 to 65535"));
        };
        let host = host.trim_matches(['[', ']']);
        let is_this_computer =
            host == "localhost" || host.parse::<IpAddr>().is_ok_and(|it| it.is_loopback());
        match (&keys, insecure) {
            (Some(keys), false) => keys.check()?,
            (Some(_), true) => return Err(refused("either certificates or --insecure")),
            (None, true) if is_this_computer => {}
            (None, true) => return Err(refused("--insecure is for 127.0.0.1 and [::1] alone")),
            (None, false) => return Err(LinkError::NoKeys),
        }
        Ok(Self {
            host: host.to_owned(),
            port,
            keys,
        })
    }

    /// As the system takes it.
    pub(crate) fn text(&self) -> String {
        match self.host.contains(':') {
            true => format!("[{}]:{}", self.host, self.port),
            false => format!("{}:{}", self.host, self.port),
        }
    }
}

impl Keys {
    /// Whether all three can be used.
    fn check(&self) -> Result<(), LinkError> {
        self.authority()?;
        self.own()?;
        self.check_private()
    }

    /// Whom this side believes.
    pub(crate) fn authority(&self) -> Result<RootCertStore, LinkError> {
        let mut roots = RootCertStore::empty();
        for certificate in self.certificates(&self.authority)? {
            let added = roots.add(certificate);
            added.map_err(|error| self.refused(&self.authority, &error))?;
        }
        Ok(roots)
    }

    /// What this side proves itself by.
    pub(crate) fn own(
        &self,
    ) -> Result<(Vec<CertificateDer<'static>>, PrivateKeyDer<'static>), LinkError> {
        let key = PrivateKeyDer::from_pem_file(&self.key);
        let key = key.map_err(|error| self.refused(&self.key, &error))?;
        Ok((self.certificates(&self.certificate)?, key))
    }

    fn certificates(&self, path: &Path) -> Result<Vec<CertificateDer<'static>>, LinkError> {
        let found = CertificateDer::pem_file_iter(path).and_then(Iterator::collect);
        let found: Vec<_> = found.map_err(|error| self.refused(path, &error))?;
        match found.is_empty() {
            true => Err(self.refused(path, &"there is no certificate in it")),
            false => Ok(found),
        }
    }

    pub(crate) fn refused(&self, path: &Path, problem: &dyn core::fmt::Display) -> LinkError {
        LinkError::Key {
            path: path.to_owned(),
            problem: problem.to_string(),
        }
    }

    /// A private key is refused that others can read: it would be no proof of anything.
    fn check_private(&self) -> Result<(), LinkError> {
        let meta = std::fs::metadata(&self.key);
        let meta = meta.map_err(|error| self.refused(&self.key, &error))?;
        let mode = meta.permissions().mode() & 0o777;
        let is_ours = [rustix::process::geteuid().as_raw(), 0].contains(&meta.uid());
        match is_ours && mode & 0o077 == 0 {
            true => Ok(()),
            false => Err(self.refused(
                &self.key,
                &format_args!(
                    "a private key that others can read (mode {mode:o}): make new ones, and keep them at mode 600"
                ),
            )),
        }
    }
}
