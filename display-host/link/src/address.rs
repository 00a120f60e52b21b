//! Address of a peer, and the keys that prove who it is.

use std::net::IpAddr;
use std::os::unix::fs::{MetadataExt as _, PermissionsExt as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use rustls::client::WebPkiServerVerifier;
use rustls::client::danger::ServerCertVerifier as _;
use rustls::crypto::ring::default_provider;
use rustls::pki_types::pem::PemObject as _;
use rustls::pki_types::{CertificateDer, PrivateKeyDer, ServerName, UnixTime};
use rustls::{CertificateError, RootCertStore};

use crate::error::LinkError;
use crate::reason::of_own;

/// Name under which a station looks at its own certificate. Nobody has this name.
const ANY_NAME: &str = "station.invalid";

/// Certificate files of one peer.
#[derive(Debug, Clone)]
pub struct Keys {
    /// Certificate, PEM.
    pub certificate: PathBuf,
    /// Private key of the certificate, PEM. No other user may read it.
    pub key: PathBuf,
    /// Certificate of the authority that signed both peers' certificates, PEM.
    pub authority: PathBuf,
}

/// Address at which `calot link serve` listens, with the keys of this peer.
#[derive(Debug, Clone)]
pub struct Address {
    pub(crate) host: String,
    pub(crate) port: u16,
    pub(crate) keys: Option<Keys>,
}

impl Address {
    /// Parses `HOST:PORT`. Keys are needed unless `insecure` allows a loopback address without
    /// them.
    ///
    /// # Errors
    /// When the address is invalid, keys are missing, unusable or readable by others, or an address
    /// beyond this computer has no keys.
    pub fn new(address: &str, keys: Option<Keys>, insecure: bool) -> Result<Self, LinkError> {
        let refused = |problem| LinkError::Address {
            given: address.escape_debug().to_string(),
            problem,
        };
        let plain = |c: char| c.is_ascii_alphanumeric() || "[].:-".contains(c);
        let (host, port) = address
            .rsplit_once(':')
            .filter(|(host, _)| !host.is_empty() && address.chars().all(plain))
            .ok_or_else(|| refused("write HOST:PORT, such as 10.0.0.7:7447 or [::1]:7447"))?;
        let Ok(port) = port.parse::<u16>() else {
            return Err(refused("the port must be 0 to 65535"));
        };
        let host = host.trim_matches(['[', ']']);
        let is_this_computer =
            host == "localhost" || host.parse::<IpAddr>().is_ok_and(|it| it.is_loopback());
        match (&keys, insecure) {
            (Some(keys), false) => keys.check()?,
            (Some(_), true) => return Err(refused("give certificates or --insecure, not both")),
            (None, true) if is_this_computer => {}
            (None, true) => return Err(refused("--insecure allows only 127.0.0.1 and [::1]")),
            (None, false) => return Err(LinkError::NoKeys),
        }
        Ok(Self {
            host: host.to_owned(),
            port,
            keys,
        })
    }

    /// True if the certificate of the station at this address ends within this time.
    ///
    /// # Errors
    /// When a file cannot be read.
    pub fn ends_within(&self, time: Duration) -> Result<bool, LinkError> {
        self.keys
            .as_ref()
            .map_or(Ok(false), |it| it.ends_within(time))
    }

    /// Text that the system resolves; IPv6 in brackets.
    pub(crate) fn text(&self) -> String {
        match self.host.contains(':') {
            true => format!("[{}]:{}", self.host, self.port),
            false => format!("{}:{}", self.host, self.port),
        }
    }
}

impl Keys {
    /// Checks that all three files are usable.
    fn check(&self) -> Result<(), LinkError> {
        self.authority()?;
        self.own()?;
        self.check_private()
    }

    /// Authorities that this peer trusts.
    pub(crate) fn authority(&self) -> Result<RootCertStore, LinkError> {
        let mut roots = RootCertStore::empty();
        for certificate in self.certificates(&self.authority)? {
            let added = roots.add(certificate);
            added.map_err(|error| self.refused(&self.authority, &error))?;
        }
        Ok(roots)
    }

    /// Certificate chain and private key of this peer.
    pub(crate) fn own(
        &self,
    ) -> Result<(Vec<CertificateDer<'static>>, PrivateKeyDer<'static>), LinkError> {
        let key = PrivateKeyDer::from_pem_file(&self.key);
        let key = key.map_err(|error| self.refused(&self.key, &error))?;
        Ok((self.certificates(&self.certificate)?, key))
    }

    /// Refuses a station's certificate that watchers would refuse: one that has expired or is of
    /// another authority.
    pub(crate) fn check_station(&self) -> Result<(), LinkError> {
        match self.verified(Duration::ZERO)? {
            // Watchers compare the name, which depends on how they connect.
            Ok(())
            | Err(
                CertificateError::NotValidForName | CertificateError::NotValidForNameContext { .. },
            ) => Ok(()),
            Err(problem) => {
                let words = of_own(&problem).map_or_else(|| problem.to_string(), str::to_owned);
                Err(self.refused(&self.certificate, &words))
            }
        }
    }

    /// True if a station's certificate ends within this time.
    fn ends_within(&self, time: Duration) -> Result<bool, LinkError> {
        let verified = self.verified(time)?;
        Ok(matches!(
            verified,
            Err(CertificateError::Expired | CertificateError::ExpiredContext { .. })
        ))
    }

    /// A watcher's judgement of this station's certificate, this long from now.
    fn verified(&self, later: Duration) -> Result<Result<(), CertificateError>, LinkError> {
        let (roots, (chain, _)) = (Arc::new(self.authority()?), self.own()?);
        let refused = |error: &dyn core::fmt::Display| self.refused(&self.certificate, error);
        let provider = Arc::new(default_provider());
        let watcher = WebPkiServerVerifier::builder_with_provider(roots, provider).build();
        let watcher = watcher.map_err(|error| refused(&error))?;
        let Some((certificate, between)) = chain.split_first() else {
            return Err(refused(&"the file holds no certificate"));
        };
        let name = ServerName::try_from(ANY_NAME).map_err(|error| refused(&error))?;
        let now =
            UnixTime::since_unix_epoch(Duration::from_secs(UnixTime::now().as_secs()) + later);
        match watcher.verify_server_cert(certificate, between, &name, &[], now) {
            Ok(_) => Ok(Ok(())),
            Err(rustls::Error::InvalidCertificate(problem)) => Ok(Err(problem)),
            Err(error) => Err(refused(&error)),
        }
    }

    fn certificates(&self, path: &Path) -> Result<Vec<CertificateDer<'static>>, LinkError> {
        let found = CertificateDer::pem_file_iter(path).and_then(Iterator::collect);
        let found: Vec<_> = found.map_err(|error| self.refused(path, &error))?;
        match found.is_empty() {
            true => Err(self.refused(path, &"the file holds no certificate")),
            false => Ok(found),
        }
    }

    pub(crate) fn refused(&self, path: &Path, problem: &dyn core::fmt::Display) -> LinkError {
        LinkError::Key {
            path: path.to_owned(),
            problem: problem.to_string(),
        }
    }

    /// Refuses a private key that others can read, because they could pose as this peer.
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
                    "others can read this private key (mode {mode:o}): make new keys and keep them at mode 600"
                ),
            )),
        }
    }
}
