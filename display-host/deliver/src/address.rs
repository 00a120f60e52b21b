//! Addresses of centres.

use std::fmt;
use std::path::Path;
use std::str::FromStr as _;

use percent_encoding::percent_decode_str;
use tokio_postgres::config::{Host, SslMode};
use ureq::http::Uri;

use crate::error::{DeliverError, printable};
use crate::secret;

/// Problem of an address in which a password may have been split.
const UNESCAPED: &str = "an '@' stands where none belongs. In a user or a password, write '@' as %40, '/' as %2F, \
    ':' as %3A, '#' as %23 and '?' as %3F";
/// Problem of an address that makes no sense.
const UNREADABLE: &str = "it cannot be read, and is not repeated because it may hold a password. In a user or a \
    password, write '@' as %40, '/' as %2F, ':' as %3A, '#' as %23 and '?' as %3F";

/// A centre, with the key to it.
#[derive(Debug)]
pub struct Destination {
    pub(crate) kind: Kind,
    /// Address without user and password. It names the centre in the store, and all spellings of
    /// the address have one name.
    pub(crate) name: String,
    /// Name that earlier versions wrote: the address as it was spelled.
    pub(crate) spelled: String,
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
    /// the authority of the centre's certificate. Without `ca`, the authorities count that the
    /// computer trusts.
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
        check_escapes(address)?;
        let authorities = secret::authorities(ca)?;
        let is_database = ["postgres://", "postgresql://"]
            .iter()
            .any(|it| address.starts_with(it));
        let (kind, name, spelled) = match is_database {
            true => database(address, is_hidden, variable)?,
            false => records(address, is_hidden, variable)?,
        };
        Ok(Self {
            kind,
            name,
            spelled,
            authorities,
        })
    }
}

fn database(
    address: &str,
    is_hidden: bool,
    variable: &dyn Fn(&str) -> Option<String>,
) -> Result<(Kind, String, String), DeliverError> {
    let refused = |problem: &str| refused(address, problem);
    // The library's error repeats parts of the address.
    let mut config = tokio_postgres::Config::from_str(address).map_err(|_| refused(UNREADABLE))?;
    let hosts: Vec<String> = config.get_hosts().iter().map(host).collect();
    if hosts.is_empty() {
        return Err(refused("it names no host"));
    }
    let database = match config.get_dbname() {
        Some(name) => name.to_owned(),
        None => return Err(refused("it names no database")),
    };
    if database.contains('@') || hosts.iter().any(|it| it.contains('@')) {
        return Err(refused(UNESCAPED));
    }
    let ports = match config.get_ports() {
        [] => "5432".to_owned(),
        ports => ports
            .iter()
            .map(u16::to_string)
            .collect::<Vec<_>>()
            .join(","),
    };
    let named = |hosts: &[String]| {
        let hosts = hosts.join(",");
        printable(&format!("postgres://{hosts}:{ports}/{database}"))
    };
    let spelled = named(&hosts);
    let plain = config.get_hosts().iter().map(|it| match it {
        Host::Tcp(name) => plain_host(name),
        Host::Unix(_) => host(it),
    });
    let name = named(&plain.collect::<Vec<_>>());
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
        let mut numbers = config.get_hostaddrs().iter();
        let is_here = config.get_hosts().iter().all(is_this_computer)
            && numbers.all(std::net::IpAddr::is_loopback);
        config.ssl_mode(match is_here {
            true => SslMode::Disable,
            false => SslMode::Require,
        });
    }
    config.application_name("calot");
    Ok((Kind::Database(Box::new(config)), name, spelled))
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
    host.eq_ignore_ascii_case("localhost")
        || host
            .parse::<std::net::IpAddr>()
            .is_ok_and(|it| it.is_loopback())
}

fn records(
    address: &str,
    is_hidden: bool,
    variable: &dyn Fn(&str) -> Option<String>,
) -> Result<(Kind, String, String), DeliverError> {
    let refused = |problem: &str| refused(address, problem);
    let uri = Uri::from_str(address).map_err(|_| refused(UNREADABLE))?;
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
    if place != authority.host() && authority.port_u16().is_none() {
        return Err(refused("its port is no number up to 65535"));
    }
    let path = uri
        .path()
        .trim_end_matches('/')
        .trim_end_matches("/statements");
    let spelled = format!("{scheme}://{place}{path}");
    let port = match (scheme, authority.port_u16()) {
        ("https", Some(443)) | ("http", Some(80)) | (_, None) => String::new(),
        (_, Some(port)) => format!(":{port}"),
    };
    let name = format!("{scheme}://{}{port}{path}", plain_host(authority.host()));
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
    Ok((Kind::Records(Key { user, password }), name, spelled))
}

/// One spelling of a host.
fn plain_host(host: &str) -> String {
    host.trim_end_matches('.').to_ascii_lowercase()
}

/// Refuses an address if a part of a password could pass for its host, path or parameter.
fn check_escapes(address: &str) -> Result<(), DeliverError> {
    let rest = address.split_once("://").map_or(address, |(_, rest)| rest);
    let is_plain = match rest.split_once('@') {
        Some((key, place)) => !key.contains(['/', '?', '#']) && !place.contains('@'),
        None => true,
    };
    match is_plain {
        true => Ok(()),
        false => Err(refused(address, UNESCAPED)),
    }
}

/// The error for a refused address. It shows only the address's scheme.
fn refused(address: &str, problem: &str) -> DeliverError {
    let known = ["postgres://", "postgresql://", "https://", "http://"];
    let scheme = known.into_iter().find(|it| address.starts_with(it));
    DeliverError::Address {
        given: format!("{}…", scheme.unwrap_or_default()),
        problem: problem.to_owned(),
    }
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
    fn the_spellings_of_one_address_are_one_centre() {
        for (one, name) in [
            (
                "https://LRS.Example:443/xapi/statements",
                "https://lrs.example/xapi",
            ),
            ("HTTPS://lrs.example./xapi/", "https://lrs.example/xapi"),
            (
                "https://lrs.example:8443/XAPI",
                "https://lrs.example:8443/XAPI",
            ),
            ("http://LocalHost:80/xapi", "http://localhost/xapi"),
            ("http://[::1]:81/", "http://[::1]:81"),
            (
                "postgres://ada@DB.example/Calot",
                "postgres://db.example:5432/Calot",
            ),
            (
                "postgresql://db.example.:5432/Calot",
                "postgres://db.example:5432/Calot",
            ),
        ] {
            let to = Destination::shown(one, None, &variables).unwrap();
            assert_eq!(to.name(), name, "{one}");
        }
    }

    #[test]
    fn a_number_of_another_computer_demands_encryption_whatever_the_name() {
        for (number, mode) in [
            ("192.0.2.2", SslMode::Require),
            ("127.0.0.1", SslMode::Disable),
        ] {
            let address = format!("postgres://ada@localhost/calot?hostaddr={number}");
            let to = Destination::shown(&address, None, &none).unwrap();
            let Kind::Database(config) = &to.kind else {
                panic!("a database")
            };
            assert_eq!(config.get_ssl_mode(), mode, "{number}");
        }
    }

    #[test]
    fn no_part_of_a_password_is_shown_or_becomes_a_name() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("centre");
        std::fs::write(&file, "").unwrap();
        std::fs::set_permissions(&file, std::fs::Permissions::from_mode(0o600)).unwrap();
        for address in [
            "host=localhost user=ada password=s3cret dbname=calot",
            "PGPASSWORD=s3cret",
            "ada:s3cret@lrs.example/xapi",
            "https:/ada:s3cret@lrs.example/xapi",
            "https://ada:12/s3cret@lrs.example/xapi",
            "https://ada:x#s3cret@lrs.example/xapi",
            "https://ada:x?s3cret@lrs.example/xapi",
            "https://ada:x@s3cret@lrs.example/xapi",
            "https://ada:s3cret/xapi",
            "postgres:ada:s3cret@db.example/calot",
            "postgres://ada:x@s3cret@db.example/calot",
            "postgres://ada:x/s3cret@db.example/calot",
            "postgres://ada:x?s3cret@db.example/calot",
            "postgres://ada:s3cret/calot",
            "postgres://ada@db.example/calot?s3cret=1",
            "postgres://db.example/x%40s3cret",
            "POSTGRES://ada:s3cret@db.example/calot",
            "\"postgres://ada:s3cret@db.example/calot\"",
        ] {
            std::fs::write(&file, address).unwrap();
            let hidden = Destination::from_file(&file, None, &variables).unwrap_err();
            for said in [hidden.to_string(), said(address)] {
                assert!(said.contains("…' is no address of a centre"), "{said}");
                let shown = ["s3cret", "ada:", "12", "example"].iter();
                assert!(shown.clone().all(|it| !said.contains(it)), "{said}");
            }
        }
        let unescaped = said("postgres://ada:x@s3cret@db.example/calot");
        assert!(unescaped.contains("write '@' as %40"), "{unescaped}");
        let unreadable = said("postgres://ada:s3cret/calot");
        assert!(unreadable.contains("write '@' as %40"), "{unreadable}");
        let port = said("https://ada:s3cret/xapi");
        assert!(port.contains("its port is no number"), "{port}");
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
