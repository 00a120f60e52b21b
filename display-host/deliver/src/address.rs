//! Addresses of centres.

use std::fmt;
use std::path::Path;
use std::str::FromStr as _;

use percent_encoding::percent_decode_str;
use tokio_postgres::config::{Host, SslMode};
use ureq::http::Uri;

use crate::error::{DeliverError, printable};
use crate::secret;

/// A centre, with the key to it.
#[derive(Debug)]
pub struct Destination {
    pub(crate) kind: Kind,
    /// Address without user and password: the name of the centre in the store.
    pub(crate) name: String,
    pub(crate) authorities: Vec<rustls::pki_types::CertificateDer<'static>>,
}

/// Kind of a centre.
#[derive(Debug)]
pub(crate) enum Kind {
    /// A database of PostgreSQL.
    Database(Box<tokio_postgres::Config>),
    /// A learning record store.
    Records(Key),
}

/// User and password of a record store.
pub(crate) struct Key {
    pub(crate) user: String,
    pub(crate) password: String,
}

impl fmt::Debug for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Key").finish_non_exhaustive()
    }
}

impl Destination {
    /// The centre at an address from the command line, which must not hold a password. `ca` names
    /// the authority of the centre's certificate; without it, those that the computer trusts count.
    ///
    /// # Errors
    /// [`DeliverError::Address`], [`DeliverError::Shown`], [`DeliverError::NoPassword`] and
    /// [`DeliverError::File`].
    pub fn shown(
        address: &str,
        ca: Option<&Path>,
        variable: &dyn Fn(&str) -> Option<String>,
    ) -> Result<Self, DeliverError> {
        Self::of(address, false, ca, variable)
    }

    /// The centre whose address and password are the first line of a file that only its user can
    /// read.
    ///
    /// # Errors
    /// As [`Destination::shown`].
    pub fn from_file(
        file: &Path,
        ca: Option<&Path>,
        variable: &dyn Fn(&str) -> Option<String>,
    ) -> Result<Self, DeliverError> {
        Self::of(&secret::line(file)?, true, ca, variable)
    }

    /// Address without user and password.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    fn of(
        address: &str,
        is_hidden: bool,
        ca: Option<&Path>,
        variable: &dyn Fn(&str) -> Option<String>,
    ) -> Result<Self, DeliverError> {
        let authorities = secret::authorities(ca)?;
        let is_database = ["postgres://", "postgresql://"]
            .iter()
            .any(|it| address.starts_with(it));
        let (kind, name) = match is_database {
            true => database(address, is_hidden, variable)?,
            false => records(address, is_hidden, variable)?,
        };
        Ok(Self {
            kind,
            name,
            authorities,
        })
    }
}

fn database(
    address: &str,
    is_hidden: bool,
    variable: &dyn Fn(&str) -> Option<String>,
) -> Result<(Kind, String), DeliverError> {
    let refused = |problem: &str| DeliverError::Address {
        given: without_key(address),
        problem: printable(problem),
    };
    let mut config = tokio_postgres::Config::from_str(address)
        .map_err(|error| refused(&crate::error::in_words(&error)))?;
    let hosts: Vec<String> = config.get_hosts().iter().map(host).collect();
    if hosts.is_empty() {
        return Err(refused("it names no host"));
    }
    let database = match config.get_dbname() {
        Some(name) => name.to_owned(),
        None => return Err(refused("it names no database")),
    };
    let ports = match config.get_ports() {
        [] => "5432".to_owned(),
        ports => ports
            .iter()
            .map(u16::to_string)
            .collect::<Vec<_>>()
            .join(","),
    };
    let name = printable(&format!(
        "postgres://{}:{ports}/{database}",
        hosts.join(",")
    ));
    if config.get_password().is_some() && !is_hidden {
        return Err(DeliverError::Shown {
            to: name,
            variable: "PGPASSWORD",
        });
    }
    if config.get_password().is_none()
        && let Some(password) = variable("PGPASSWORD")
    {
        config.password(password);
    }
    // Names of people do not cross a network in the clear, unless the address says `disable`.
    if config.get_ssl_mode() == SslMode::Prefer {
        let is_here = config.get_hosts().iter().all(is_this_computer);
        config.ssl_mode(match is_here {
            true => SslMode::Disable,
            false => SslMode::Require,
        });
    }
    config.application_name("calot");
    Ok((Kind::Database(Box::new(config)), name))
}

fn host(host: &Host) -> String {
    match host {
        Host::Tcp(name) => name.clone(),
        Host::Unix(path) => path.display().to_string(),
    }
}

fn is_this_computer(host: &Host) -> bool {
    match host {
        Host::Tcp(name) => is_loopback(name),
        Host::Unix(_) => true,
    }
}

fn is_loopback(host: &str) -> bool {
    let host = host.trim_start_matches('[').trim_end_matches(']');
    host == "localhost"
        || host
            .parse::<std::net::IpAddr>()
            .is_ok_and(|it| it.is_loopback())
}

fn records(
    address: &str,
    is_hidden: bool,
    variable: &dyn Fn(&str) -> Option<String>,
) -> Result<(Kind, String), DeliverError> {
    let refused = |problem: &str| DeliverError::Address {
        given: without_key(address),
        problem: printable(problem),
    };
    let uri = Uri::from_str(address).map_err(|error| refused(&error.to_string()))?;
    let (Some(scheme), Some(authority)) = (uri.scheme_str(), uri.authority()) else {
        return Err(refused(
            "it begins neither with postgres:// nor with https://",
        ));
    };
    let is_safe = scheme == "https" || (scheme == "http" && is_loopback(authority.host()));
    if !is_safe {
        return Err(refused(
            "only https is encrypted (http is for this computer alone)",
        ));
    }
    if uri.query().is_some() {
        return Err(refused(
            "it has a question mark; name the path above /statements",
        ));
    }
    let (key, place) = match authority.as_str().rsplit_once('@') {
        Some((key, place)) => (Some(key), place),
        None => (None, authority.as_str()),
    };
    let path = uri
        .path()
        .trim_end_matches('/')
        .trim_end_matches("/statements");
    let name = format!("{scheme}://{place}{path}");
    let key = match key {
        Some(_) if !is_hidden => {
            return Err(DeliverError::Shown {
                to: name,
                variable: "CALOT_LRS_PASSWORD",
            });
        }
        Some(key) => {
            let text = |it: &str| percent_decode_str(it).decode_utf8_lossy().into_owned();
            let pair = key.split_once(':');
            pair.map(|(user, password)| (text(user), text(password)))
        }
        None => variable("CALOT_LRS_USER").zip(variable("CALOT_LRS_PASSWORD")),
    };
    let Some((user, password)) = key else {
        return Err(DeliverError::NoPassword { to: name });
    };
    Ok((Kind::Records(Key { user, password }), name))
}

/// An address as it may be shown: what stands between `//` and the last `@` is left out.
fn without_key(address: &str) -> String {
    let shown = match address.split_once("//") {
        Some((scheme, rest)) => match rest.rsplit_once('@') {
            Some((_, place)) => format!("{scheme}//{place}"),
            None => address.to_owned(),
        },
        None => address.to_owned(),
    };
    // Parameters may hold a password, too.
    printable(shown.split('?').next().unwrap_or_default())
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::PermissionsExt as _;

    use super::*;

    fn none(_: &str) -> Option<String> {
        None
    }

    fn variables(name: &str) -> Option<String> {
        Some(format!("the {name}"))
    }

    fn said(address: &str) -> String {
        let error = Destination::shown(address, None, &none).unwrap_err();
        error.to_string()
    }

    #[test]
    fn addresses_of_two_kinds_are_read_and_named_without_user_and_password() {
        let to = Destination::shown("postgres://ada@db.example/calot", None, &variables).unwrap();
        assert_eq!(to.name(), "postgres://db.example:5432/calot");
        let Kind::Database(config) = &to.kind else {
            panic!("a database")
        };
        assert_eq!(config.get_password(), Some(&b"the PGPASSWORD"[..]));
        assert_eq!(config.get_ssl_mode(), SslMode::Require);
        let to = Destination::shown("postgres://ada@localhost:9/calot", None, &none).unwrap();
        let Kind::Database(config) = &to.kind else {
            panic!("a database")
        };
        assert_eq!(config.get_ssl_mode(), SslMode::Disable);
        let to = Destination::shown("https://lrs.example/xapi/", None, &variables).unwrap();
        assert_eq!(to.name(), "https://lrs.example/xapi");
        let Kind::Records(key) = &to.kind else {
            panic!("a record store")
        };
        assert_eq!(key.user, "the CALOT_LRS_USER");
        assert!(!format!("{to:?}").contains("the CALOT"));
    }

    #[test]
    fn a_password_on_the_command_line_is_refused_and_not_repeated() {
        for address in [
            "postgres://ada:s3cret@db.example/calot",
            "postgres://db.example/calot?password=s3cret",
            "https://ada:s3cret@lrs.example/xapi",
            "https://ada:s3cret@lrs.example/xapi?x",
            "postgres://ada:s3cret@db.example/calot?nonsense=1",
        ] {
            let said = said(address);
            assert!(!said.contains("s3cret"), "{said}");
        }
        assert!(
            said("postgres://ada:s3cret@db.example/calot").contains("in --to, which every user")
        );
        assert!(said("https://ada:s3cret@lrs.example/x").contains("CALOT_LRS_PASSWORD"));
    }

    #[test]
    fn other_addresses_are_refused_with_the_remedy() {
        for (address, why) in [
            ("lrs.example", "is no address of a centre"),
            ("http://lrs.example/xapi", "only https is encrypted"),
            ("ftp://lrs.example/xapi", "only https is encrypted"),
            ("https://lrs.example/xapi?x=1", "question mark"),
            ("postgres:///calot", "names no host"),
            ("postgres://db.example", "names no database"),
            ("https://lrs.example/xapi", "needs a user and a password"),
        ] {
            let said = said(address);
            assert!(said.contains(why), "{address}: {said}");
        }
    }

    #[test]
    fn a_file_with_an_address_is_for_its_user_alone() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("centre");
        let read = || Destination::from_file(&file, None, &none);
        let said = read().unwrap_err().to_string();
        assert!(said.contains("centre: No such file"), "{said}");
        std::fs::write(&file, "\n").unwrap();
        let mode = |mode| std::fs::Permissions::from_mode(mode);
        std::fs::set_permissions(&file, mode(0o644)).unwrap();
        let said = read().unwrap_err().to_string();
        assert!(said.contains("chmod 600"), "{said}");
        std::fs::set_permissions(&file, mode(0o600)).unwrap();
        let said = read().unwrap_err().to_string();
        assert!(said.contains("first line is empty"), "{said}");
        std::fs::write(&file, "https://ada:s%2F3@lrs.example/xapi\nmore").unwrap();
        let Kind::Records(key) = read().unwrap().kind else {
            panic!("a record store")
        };
        assert_eq!((key.user.as_str(), key.password.as_str()), ("ada", "s/3"));
    }

    #[test]
    fn an_authority_is_a_certificate() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("ca.pem");
        std::fs::write(&file, "no certificate").unwrap();
        let ca = Some(file.as_path());
        let error = Destination::shown("postgres://a@localhost/b", ca, &none).unwrap_err();
        assert!(error.to_string().contains("certificates in PEM"), "{error}");
    }
}
