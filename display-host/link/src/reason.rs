//! Reasons for which a line cannot be opened or broke, in words that name the remedy. Equal causes
//! give equal words, however often the watcher tries.

use std::io::Error;

use rustls::{AlertDescription, CertificateError, Error as Tls};

/// The reason as a sentence.
pub(crate) fn reason(error: &Error) -> String {
    let inner = error.get_ref().and_then(|it| it.downcast_ref::<Tls>());
    let words = match inner {
        Some(Tls::InvalidCertificate(problem)) => of_the_station(problem),
        Some(Tls::AlertReceived(alert)) => of_this_computer(*alert),
        _ => None,
    };
    words.map_or_else(|| error.to_string(), str::to_owned)
}

/// The station's certificate, as this computer judges it.
fn of_the_station(problem: &CertificateError) -> Option<&'static str> {
    Some(match problem {
        CertificateError::Expired | CertificateError::ExpiredContext { .. } => {
            "the station's certificate has expired; make a new one there (`calot link keys`)"
        }
        CertificateError::NotValidYet | CertificateError::NotValidYetContext { .. } => {
            "the station's certificate is not valid yet; set the clocks of both computers"
        }
        CertificateError::UnknownIssuer | CertificateError::BadSignature => {
            "the station's certificate is not of the authority in --ca; use the --ca of the station"
        }
        CertificateError::NotValidForName | CertificateError::NotValidForNameContext { .. } => {
            "the station's certificate is for another name; connect to the name that it was made for"
        }
        _ => return None,
    })
}

/// A station's certificate, as the station itself judges it.
pub(crate) fn of_own(problem: &CertificateError) -> Option<&'static str> {
    Some(match problem {
        CertificateError::Expired | CertificateError::ExpiredContext { .. } => {
            "this certificate has expired, and no watcher would accept it; make a new one (`calot link keys`)"
        }
        CertificateError::NotValidYet | CertificateError::NotValidYetContext { .. } => {
            "this certificate is not valid yet; set this computer's clock"
        }
        CertificateError::UnknownIssuer | CertificateError::BadSignature => {
            "this certificate is not of the authority in --ca; name the authority that signed it"
        }
        CertificateError::InvalidPurpose | CertificateError::InvalidPurposeContext { .. } => {
            "this certificate is not a station's; make one with `sh make_keys.sh station NAME IP:…`"
        }
        _ => return None,
    })
}

/// This computer's certificate, as the station judges it.
fn of_this_computer(alert: AlertDescription) -> Option<&'static str> {
    Some(match alert {
        AlertDescription::CertificateExpired => {
            "the station refuses this computer's certificate, which has expired; make a new one (`calot \
             link keys`)"
        }
        AlertDescription::UnknownCA
        | AlertDescription::BadCertificate
        | AlertDescription::CertificateUnknown
        | AlertDescription::UnsupportedCertificate
        | AlertDescription::CertificateRequired
        | AlertDescription::DecryptError
        | AlertDescription::AccessDenied => {
            "the station refuses this computer's certificate; --cert must be a watcher's, of the station's \
             authority"
        }
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use rustls::pki_types::UnixTime;

    use super::*;

    fn said(problem: CertificateError) -> String {
        reason(&Error::other(Tls::InvalidCertificate(problem)))
    }

    #[test]
    fn a_certificate_that_expired_is_told_in_the_same_words_each_second() {
        let at = |seconds| UnixTime::since_unix_epoch(Duration::from_secs(seconds));
        let expired = |now| CertificateError::ExpiredContext {
            time: at(now),
            not_after: at(10),
        };
        assert_eq!(said(expired(11)), said(expired(12)));
        assert!(said(expired(11)).contains("has expired"));
        let early = CertificateError::NotValidYet;
        assert!(said(early).contains("clocks"));
    }

    #[test]
    fn whose_certificate_is_refused_is_told() {
        let foreign = said(CertificateError::UnknownIssuer);
        assert!(foreign.contains("--ca"), "{foreign}");
        let other_name = said(CertificateError::NotValidForName);
        assert!(other_name.contains("another name"), "{other_name}");
        for (alert, expected) in [
            (AlertDescription::CertificateExpired, "has expired"),
            (AlertDescription::UnknownCA, "--cert"),
        ] {
            let said = reason(&Error::other(Tls::AlertReceived(alert)));
            assert!(
                said.contains("this computer's") && said.contains(expected),
                "{said}"
            );
        }
    }

    #[test]
    fn what_a_station_says_of_its_own_certificate_names_the_remedy() {
        for (problem, remedy) in [
            (CertificateError::Expired, "make a new one"),
            (CertificateError::NotValidYet, "set this computer's clock"),
            (CertificateError::UnknownIssuer, "--ca"),
            (CertificateError::InvalidPurpose, "make_keys.sh station"),
        ] {
            let said = of_own(&problem).unwrap();
            assert!(said.contains(remedy), "{said}");
        }
        assert_eq!(of_own(&CertificateError::Revoked), None);
    }

    #[test]
    fn other_errors_keep_their_own_words() {
        let gone = Error::from(std::io::ErrorKind::ConnectionRefused);
        assert_eq!(reason(&gone), gone.to_string());
    }
}
