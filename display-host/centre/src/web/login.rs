//! Logins: a cookie that nobody can guess, for a working day.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use axum::extract::FromRequestParts;
use axum::http::header::{COOKIE, HOST, ORIGIN};
use axum::http::request::Parts;
use axum::http::{HeaderMap, StatusCode};
use axum::response::{IntoResponse as _, Redirect, Response};

use super::Web;
use crate::error::CentreError;
use crate::roster::random;

/// Name of the cookie. Browsers accept a cookie of such a name over TLS only, and from this host
/// alone.
const NAME: &str = "__Host-calot";
/// Length of a login.
const DAY: Duration = Duration::from_secs(12 * 3600);
/// Number of wrong passwords for one name within [`MINUTE`] after which the name must wait.
const TRIES_MAX: usize = 5;
const MINUTE: Duration = Duration::from_secs(60);

/// Logins that hold.
#[derive(Debug, Default)]
pub(super) struct Logins {
    open: Mutex<BTreeMap<String, (String, Instant)>>,
    wrong: Mutex<BTreeMap<String, Vec<Instant>>>,
}

impl Logins {
    /// Lets a person in. Returns the header that sets the cookie.
    pub(super) fn begin(&self, who: &str) -> Result<String, CentreError> {
        let token = random::<32>()?.map(|byte| format!("{byte:02x}")).concat();
        let mut open = self.open.lock().unwrap_or_else(PoisonError::into_inner);
        open.retain(|_, (_, since)| since.elapsed() < DAY);
        open.insert(token.clone(), (who.to_owned(), Instant::now()));
        let seconds = DAY.as_secs();
        Ok(format!(
            "{NAME}={token}; Path=/; Secure; HttpOnly; SameSite=Strict; Max-Age={seconds}"
        ))
    }

    /// Ends a login. Returns the header that removes the cookie.
    pub(super) fn end(&self, headers: &HeaderMap) -> String {
        if let Some(token) = token(headers) {
            let mut open = self.open.lock().unwrap_or_else(PoisonError::into_inner);
            open.remove(token);
        }
        format!("{NAME}=; Path=/; Secure; HttpOnly; SameSite=Strict; Max-Age=0")
    }

    /// Name of the person whose login this is, while it holds.
    pub(super) fn who(&self, token: &str, now: Instant) -> Option<String> {
        let open = self.open.lock().unwrap_or_else(PoisonError::into_inner);
        let (who, since) = open.get(token)?;
        (now.saturating_duration_since(*since) < DAY).then(|| who.clone())
    }

    /// True if too many wrong passwords came for this name lately.
    pub(super) fn is_guessed(&self, who: &str) -> bool {
        let mut wrong = self.wrong.lock().unwrap_or_else(PoisonError::into_inner);
        wrong.retain(|_, times| {
            times.retain(|it| it.elapsed() < MINUTE);
            !times.is_empty()
        });
        wrong.get(who).is_some_and(|it| it.len() >= TRIES_MAX)
    }

    /// Notes a wrong password.
    pub(super) fn note_wrong(&self, who: &str) {
        let mut wrong = self.wrong.lock().unwrap_or_else(PoisonError::into_inner);
        wrong
            .entry(who.to_owned())
            .or_default()
            .push(Instant::now());
    }
}

fn token(headers: &HeaderMap) -> Option<&str> {
    let cookies = headers.get_all(COOKIE).into_iter();
    let cookies = cookies.filter_map(|it| it.to_str().ok());
    let mut pairs = cookies
        .flat_map(|it| it.split("; "))
        .filter_map(|it| it.split_once('='));
    pairs
        .find(|(name, _)| *name == NAME)
        .map(|(_, value)| value)
}

/// True unless another site's page sends the request.
pub(super) fn is_own(headers: &HeaderMap) -> bool {
    let text = |name| {
        headers
            .get(name)
            .and_then(|it: &axum::http::HeaderValue| it.to_str().ok())
    };
    match (text(ORIGIN), text(HOST)) {
        (Some(origin), Some(host)) => origin.strip_prefix("https://") == Some(host),
        (None, _) => true,
        (Some(_), None) => false,
    }
}

/// An instructor who is logged in and still on the list.
pub(super) struct Who {
    pub(super) name: String,
    /// The login.
    pub(super) token: String,
}

impl FromRequestParts<Web> for Who {
    type Rejection = Response;

    async fn from_request_parts(parts: &mut Parts, web: &Web) -> Result<Self, Response> {
        if !is_own(&parts.headers) {
            return Err(StatusCode::FORBIDDEN.into_response());
        }
        let token = token(&parts.headers).unwrap_or_default().to_owned();
        let who = web.logins.who(&token, Instant::now());
        let listed = web.hall.roster.read().await;
        match who.filter(|it| listed.instructors.contains_key(it)) {
            Some(name) => Ok(Self { name, token }),
            None if parts.uri.path() == "/" => Err(Redirect::to("/login").into_response()),
            None => Err(StatusCode::UNAUTHORIZED.into_response()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn headers(name: axum::http::HeaderName, value: &str) -> HeaderMap {
        let mut headers = HeaderMap::new();
        headers.insert(name, value.parse().unwrap());
        headers
    }

    #[test]
    fn a_login_holds_until_its_end_and_cannot_be_guessed() {
        let logins = Logins::default();
        let cookie = logins.begin("bo").unwrap();
        assert_ne!(cookie, logins.begin("bo").unwrap());
        assert!(cookie.contains("; Secure; HttpOnly; SameSite=Strict"));
        let pair = cookie.split(';').next().unwrap();
        let sent = headers(COOKIE, &format!("x=1; {pair}"));
        let (known, now) = (token(&sent).unwrap(), Instant::now());
        assert_eq!(logins.who(known, now).as_deref(), Some("bo"));
        assert_eq!(logins.who("00", now), None);
        let almost = now + DAY - MINUTE;
        assert_eq!(logins.who(known, almost).as_deref(), Some("bo"));
        assert_eq!(logins.who(known, now + DAY), None, "the day is over");
        logins.end(&sent);
        assert_eq!(logins.who(known, now), None);
    }

    #[test]
    fn who_guesses_waits() {
        let logins = Logins::default();
        for _ in 0..TRIES_MAX {
            assert!(!logins.is_guessed("bo"));
            logins.note_wrong("bo");
        }
        assert!(logins.is_guessed("bo") && !logins.is_guessed("cy"));
    }

    #[test]
    fn requests_of_other_sites_are_told_apart() {
        let mut sent = headers(HOST, "centre:8443");
        assert!(is_own(&sent));
        sent.insert(ORIGIN, "https://centre:8443".parse().unwrap());
        assert!(is_own(&sent));
        for other in ["https://evil", "http://centre:8443", "null"] {
            sent.insert(ORIGIN, other.parse().unwrap());
            assert!(!is_own(&sent), "{other}");
        }
    }
}
