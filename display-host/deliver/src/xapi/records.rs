//! The conversation with a learning record store.

use std::sync::Arc;

use base64::Engine as _;
use percent_encoding::{NON_ALPHANUMERIC, utf8_percent_encode};
use serde_json::Value;
use store::{Outgoing, Withdrawal};
use ureq::Agent;
use ureq::tls::{Certificate, RootCerts, TlsConfig, TlsProvider};
use uuid::Uuid;

use super::statement::{
    OWN, actor, is_persons, says_the_same, statement, statement_id, timestamp, voiding, voiding_id,
};
use crate::address::{Destination, Key};
use crate::centre::{CONNECT, Centre, PATIENCE, Receipt};
use crate::error::{DeliverError, certificate_problem, in_words, printable};

/// Version that every request names.
const VERSION: &str = "2.0.0";
/// Longest answer that is read, bytes.
const ANSWER_MAX: u64 = 8 << 20;
/// Longest list of one person's statements, pages.
const PAGES_MAX: usize = 1000;

/// A record store that has answered.
pub(crate) struct Records {
    agent: Agent,
    /// Address above `/statements`.
    to: String,
    /// Scheme and host: the page that the accounts of people belong to.
    home: String,
    authorization: String,
}

/// An answer: status and body.
struct Answer {
    status: u16,
    text: String,
}

impl Records {
    pub(crate) fn connect(to: &Destination, key: &Key) -> Result<Self, DeliverError> {
        let roots: Vec<Certificate<'static>> = to
            .authorities
            .iter()
            .map(|it| Certificate::from_der(it).to_owned())
            .collect();
        let tls = TlsConfig::builder()
            .provider(TlsProvider::Rustls)
            .root_certs(RootCerts::new_with_certs(&roots))
            .unversioned_rustls_crypto_provider(Arc::new(rustls::crypto::ring::default_provider()))
            .build();
        let config = Agent::config_builder()
            .timeout_global(Some(PATIENCE))
            .timeout_connect(Some(CONNECT))
            .http_status_as_error(false)
            // The key goes to the address that was named, and nowhere else.
            .max_redirects(0)
            .tls_config(tls)
            .user_agent("calot")
            .build();
        let pair = format!("{}:{}", key.user, key.password);
        let pair = base64::engine::general_purpose::STANDARD.encode(pair);
        let home = to.name.match_indices('/').nth(2).map(|(at, _)| at);
        let records = Self {
            agent: config.new_agent(),
            to: to.name.clone(),
            home: to
                .name
                .get(..home.unwrap_or(to.name.len()))
                .unwrap_or(&to.name)
                .to_owned(),
            authorization: format!("Basic {pair}"),
        };
        records.check_version()?;
        Ok(records)
    }

    /// Refuses a record store that says that it does not speak version 2. A store that says nothing
    /// is tried.
    fn check_version(&self) -> Result<(), DeliverError> {
        let answer = self.get(&format!("{}/about", self.to))?;
        match answer.status {
            404 | 405 | 501 => return Ok(()),
            200 => {}
            _ => return Err(self.refused(&answer)),
        }
        let about: Value =
            serde_json::from_str(&answer.text).map_err(|_| self.strange(&answer.text))?;
        let Some(versions) = about["version"].as_array() else {
            return Err(self.strange(&answer.text));
        };
        let versions: Vec<&str> = versions.iter().filter_map(Value::as_str).collect();
        match versions.iter().any(|it| it.starts_with("2.")) {
            true => Ok(()),
            false => Err(DeliverError::Version {
                to: self.to.clone(),
                found: format!("xAPI {}", printable(&versions.join(", "))),
                needed: "xAPI 2.0: use a record store that has it",
            }),
        }
    }

    fn get(&self, url: &str) -> Result<Answer, DeliverError> {
        let request = self.agent.get(url);
        let request = request.header("X-Experience-API-Version", VERSION);
        let sent = request.header("Authorization", &self.authorization).call();
        self.answer(sent)
    }

    fn put(&self, id: Uuid, statement: &Value) -> Result<Answer, DeliverError> {
        let url = format!("{}/statements?statementId={id}", self.to);
        let request = self.agent.put(&url);
        let request = request.header("X-Experience-API-Version", VERSION);
        let request = request.header("Authorization", &self.authorization);
        let request = request.header("Content-Type", "application/json");
        self.answer(request.send(statement.to_string()))
    }

    fn answer(
        &self,
        sent: Result<ureq::http::Response<ureq::Body>, ureq::Error>,
    ) -> Result<Answer, DeliverError> {
        // The library's error hides its cause.
        let cause = |error: &ureq::Error| match error {
            ureq::Error::Io(cause) => certificate_problem(cause),
            other => certificate_problem(other),
        };
        let failed = |error: ureq::Error| match cause(&error) {
            Some(problem) => DeliverError::Certificate {
                to: self.to.clone(),
                problem,
            },
            None => DeliverError::Unreachable {
                to: self.to.clone(),
                problem: in_words(&error),
            },
        };
        let mut response = sent.map_err(failed)?;
        let status = response.status().as_u16();
        let body = response.body_mut().with_config().limit(ANSWER_MAX);
        let text = body.lossy_utf8(true).read_to_string().map_err(failed)?;
        Ok(Answer { status, text })
    }

    /// An answer that is no success, as an error.
    fn refused(&self, answer: &Answer) -> DeliverError {
        let to = self.to.clone();
        let problem = match answer.text.trim() {
            "" => format!("status {}", answer.status),
            text => format!("status {}: {}", answer.status, printable(text)),
        };
        match answer.status {
            401 | 403 => DeliverError::Access { to, problem },
            400 | 409 | 412 | 413 | 422 => DeliverError::Rejected { to, problem },
            408 | 425 | 429 | 500.. => DeliverError::Unreachable { to, problem },
            _ => self.strange(&problem),
        }
    }

    fn strange(&self, problem: &str) -> DeliverError {
        DeliverError::Answer {
            to: self.to.clone(),
            kind: "learning record store",
            problem: printable(problem),
        }
    }

    /// A statement that is there and not voided.
    fn find(&self, id: Uuid) -> Result<Option<Value>, DeliverError> {
        let answer = self.get(&format!("{}/statements?statementId={id}", self.to))?;
        match answer.status {
            200 => serde_json::from_str(&answer.text)
                .map(Some)
                .map_err(|_| self.strange(&answer.text)),
            404 => Ok(None),
            _ => Err(self.refused(&answer)),
        }
    }

    /// Voids a statement, if it is there and not voided.
    fn void(&self, id: Uuid, at_unix_s: i64) -> Result<(), DeliverError> {
        if self.find(id)?.is_none() {
            return Ok(());
        }
        let answer = self.put(voiding_id(id), &voiding(&self.home, id, at_unix_s))?;
        match answer.status {
            200 | 204 => Ok(()),
            // Another program voided it a moment ago.
            409 if self.find(voiding_id(id))?.is_some() => Ok(()),
            _ => Err(self.refused(&answer)),
        }
    }

    /// Ids of a person's statements about tasks that began by `at_unix_s`, from whichever station.
    fn statements_of(&self, person: &str, at_unix_s: i64) -> Result<Vec<Uuid>, DeliverError> {
        let actor = actor(&self.home, person).to_string();
        let actor = utf8_percent_encode(&actor, NON_ALPHANUMERIC);
        let until = timestamp(at_unix_s);
        let mut url = format!("{}/statements?agent={actor}&limit=100", self.to);
        let mut found = Vec::new();
        for _ in 0..PAGES_MAX {
            let answer = self.get(&url)?;
            if answer.status != 200 {
                return Err(self.refused(&answer));
            }
            let page: Value =
                serde_json::from_str(&answer.text).map_err(|_| self.strange(&answer.text))?;
            let Some(statements) = page["statements"].as_array() else {
                return Err(self.strange(&answer.text));
            };
            for it in statements {
                let is_ours = it["object"]["id"]
                    .as_str()
                    .is_some_and(|id| id.starts_with(OWN));
                let began = it["timestamp"].as_str().and_then(|it| it.get(..19));
                let is_before = began.is_some_and(|it| Some(it) <= until.get(..19));
                let id = it["id"].as_str().and_then(|it| Uuid::parse_str(it).ok());
                found.extend(id.filter(|_| is_ours && is_before));
            }
            match page["more"].as_str() {
                None | Some("") => return Ok(found),
                // It is relative to the host, and leads to no other.
                Some(more) if more.starts_with('/') => url = format!("{}{more}", self.home),
                Some(more) if more.starts_with(&format!("{}/", self.home)) => {
                    more.clone_into(&mut url);
                }
                Some(more) => return Err(self.strange(more)),
            }
        }
        Err(self.strange("the list of a person's statements has no end"))
    }
}

impl Centre for Records {
    fn deliver(&mut self, it: &Outgoing) -> Result<Receipt, DeliverError> {
        if !is_persons(it) {
            return Ok(Receipt::LeftOut);
        }
        let id = statement_id(&it.session.id, &it.person);
        let ours = statement(&self.home, it);
        let answer = self.put(id, &ours)?;
        match answer.status {
            200 | 204 => Ok(Receipt::New),
            // Some record stores answer so even if the statement is the same.
            409 => Ok(match self.find(id)? {
                Some(theirs) if says_the_same(&theirs, &ours) => Receipt::Known,
                _ => Receipt::Differs,
            }),
            _ => Err(self.refused(&answer)),
        }
    }

    fn forget(&mut self, it: &Withdrawal) -> Result<(), DeliverError> {
        let mut statements: Vec<Uuid> = { it.sessions.iter() }
            .map(|session| statement_id(session, &it.person))
            .collect();
        // Statements of other stations, if this user may look for them.
        match self.statements_of(&it.person, it.at_unix_s) {
            Ok(found) => statements.extend(found),
            Err(DeliverError::Access { .. }) => {}
            Err(error) => return Err(error),
        }
        statements.sort();
        statements.dedup();
        statements
            .into_iter()
            .try_for_each(|id| self.void(id, it.at_unix_s))
    }
}
