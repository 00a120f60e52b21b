//! The instructors' page, over TLS. Everything that it needs is compiled in.

mod live;
mod login;
mod records;
mod tls;

use std::path::Path;
use std::sync::Arc;

use axum::extract::{Form, State};
use axum::http::header::{
    CACHE_CONTROL, CONTENT_SECURITY_POLICY, CONTENT_TYPE, HeaderValue, REFERRER_POLICY, SET_COOKIE,
    STRICT_TRANSPORT_SECURITY, X_CONTENT_TYPE_OPTIONS,
};
use axum::http::{HeaderMap, StatusCode};
use axum::middleware::map_response;
use axum::response::{IntoResponse, Redirect, Response};
use axum::routing::{get, post};
use axum::{Router, serve};
use serde::Deserialize;
use serde_json::Value;

use self::login::{Logins, Who, is_own};
use self::tls::Lines;
use crate::error::CentreError;
use crate::hall::Hall;

/// Policy of the page: it loads nothing from elsewhere, and no other page may embed it.
const POLICY: &str = "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; \
    connect-src 'self'; form-action 'self'; frame-ancestors 'none'; base-uri 'none'";

/// State that every request can see.
#[derive(Debug, Clone)]
struct Web {
    hall: Arc<Hall>,
    logins: Arc<Logins>,
}

/// Serves the page until the process ends. `listening` gets the address.
///
/// # Errors
/// [`CentreError::Listen`]; [`CentreError::Keys`] if the keys cannot be used.
pub async fn run(
    hall: Arc<Hall>,
    address: &str,
    certificate: &Path,
    key: &Path,
    listening: impl FnOnce(std::net::SocketAddr),
) -> Result<(), CentreError> {
    let lines = Lines::open(address, certificate, key).await?;
    let failed = |error: std::io::Error| CentreError::Listen {
        address: address.to_owned(),
        problem: error.to_string(),
    };
    listening(axum::serve::Listener::local_addr(&lines).map_err(failed)?);
    let web = Web {
        hall,
        logins: Arc::default(),
    };
    serve(lines, router(web)).await.map_err(failed)
}

fn router(web: Web) -> Router {
    Router::new()
        .route("/", get(page))
        .route("/login", get(login_page).post(login))
        .route("/logout", post(logout))
        .route(
            "/page.css",
            get(async || asset("text/css", include_str!("../../page/page.css"))),
        )
        .route(
            "/page.js",
            get(async || script(include_str!("../../page/page.js"))),
        )
        .route(
            "/words.js",
            get(async || script(include_str!("../../page/words.js"))),
        )
        .route(
            "/results.js",
            get(async || script(include_str!("../../page/results.js"))),
        )
        .route("/live", get(live::live))
        .route("/api/people", get(records::people))
        .route("/api/sessions", get(records::sessions))
        .route("/api/alarms", get(records::alarms))
        .with_state(web)
        .layer(map_response(guard))
}

/// Adds headers that restrict browsers. With a policy of no referrer at all, the login could not
/// see that its own page sends the form.
async fn guard(mut response: Response) -> Response {
    let headers = response.headers_mut();
    for (name, value) in [
        (CONTENT_SECURITY_POLICY, POLICY),
        (X_CONTENT_TYPE_OPTIONS, "nosniff"),
        (REFERRER_POLICY, "same-origin"),
        (CACHE_CONTROL, "no-store"),
        (STRICT_TRANSPORT_SECURITY, "max-age=31536000"),
    ] {
        headers.insert(name, HeaderValue::from_static(value));
    }
    response
}

fn asset(kind: &'static str, text: &'static str) -> Response {
    ([(CONTENT_TYPE, format!("{kind}; charset=utf-8"))], text).into_response()
}

fn script(text: &'static str) -> Response {
    asset("text/javascript", text)
}

async fn page(_: Who) -> Response {
    asset("text/html", include_str!("../../page/page.html"))
}

async fn login_page() -> Response {
    asset("text/html", include_str!("../../page/login.html"))
}

#[derive(Deserialize)]
struct Given {
    name: String,
    password: String,
}

async fn login(State(web): State<Web>, headers: HeaderMap, Form(given): Form<Given>) -> Response {
    let Given { name, password } = given;
    if !is_own(&headers) || name.len() > 40 || password.len() > 800 {
        return StatusCode::FORBIDDEN.into_response();
    }
    if web.logins.is_guessed(&name) {
        return Redirect::to("/login?wait").into_response();
    }
    let listed = web.hall.roster.read().await;
    let person = listed.instructors.get(&name).cloned();
    drop(listed);
    // Argon2 is slow, so it does not run in the threads that serve everybody.
    let checking = tokio::task::spawn_blocking(move || person.is_some_and(|it| it.has(&password)));
    if !checking.await.unwrap_or(false) {
        web.logins.note_wrong(&name);
        web.hall.log.note("refused", &name, "", &Value::Null);
        return Redirect::to("/login?wrong").into_response();
    }
    web.hall.log.note("login", &name, "", &Value::Null);
    match web.logins.begin(&name) {
        Ok(cookie) => ([(SET_COOKIE, cookie)], Redirect::to("/")).into_response(),
        Err(_) => StatusCode::INTERNAL_SERVER_ERROR.into_response(),
    }
}

async fn logout(State(web): State<Web>, headers: HeaderMap, who: Who) -> Response {
    web.hall.log.note("logout", &who.name, "", &Value::Null);
    let cookie = web.logins.end(&headers);
    ([(SET_COOKIE, cookie)], Redirect::to("/login")).into_response()
}
