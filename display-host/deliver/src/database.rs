//! A centre in PostgreSQL. Each session is one transaction. A lock for each person decides which
//! comes first: a session of the person, or the forgetting of the person.

use std::error::Error as _;
use std::future::Future;
use std::sync::Arc;

use rustls::{ClientConfig, RootCertStore};
use store::{Consent, Outgoing, Told, Withdrawal};
use tokio::runtime::Runtime;
use tokio_postgres::error::SqlState;
use tokio_postgres::types::{Json, ToSql};
use tokio_postgres::{Client, Config, Transaction};
use tokio_postgres_rustls::MakeRustlsConnect;
use uuid::Uuid;

use crate::address::Destination;
use crate::centre::{CONNECT, Centre, PATIENCE, Receipt};
use crate::error::{DeliverError, certificate_problem, in_words};
use crate::tables::{
    ADD_POINT, CAPPED, ENROL, FILL_SITE, KNOWN, PLAIN, REMOVE_SHEET, STEPS, VERSION, insert, same,
};

/// Lock under which tables are made: "Calo" in ASCII.
const MAKING: i64 = 0x4361_6c6f;
/// Lock of a person until the transaction ends.
const LOCK: &str = "SELECT pg_advisory_xact_lock(hashtextextended($1::uuid::text, 0))";

/// A connected database whose tables have this program's version.
pub(crate) struct Database {
    runtime: Runtime,
    client: Client,
    to: String,
}

impl Database {
    pub(crate) fn connect(to: &Destination, config: &Config) -> Result<Self, DeliverError> {
        let name = to.name.clone();
        let unreachable = |problem: String| DeliverError::Unreachable {
            to: name.clone(),
            problem,
        };
        let runtime = tokio::runtime::Builder::new_current_thread()
            .enable_all()
            .build()
            .map_err(|error| unreachable(error.to_string()))?;
        let mut config = config.clone();
        config.connect_timeout(CONNECT);
        let connecting = config.connect(MakeRustlsConnect::new(tls(to)?));
        let connected = runtime.block_on(async { tokio::time::timeout(CONNECT, connecting).await });
        let (client, connection) = connected
            .map_err(|_| unreachable("no answer in time".to_owned()))?
            .map_err(|error| refused(&name, &error))?;
        runtime.spawn(connection);
        let mut database = Self {
            runtime,
            client,
            to: name,
        };
        database.run(async |client, to| prepare(client, to).await)?;
        Ok(database)
    }

    /// Runs queries, for as long as [`PATIENCE`] lasts.
    fn run<T>(
        &mut self,
        work: impl AsyncFnOnce(&mut Client, &str) -> Result<T, DeliverError>,
    ) -> Result<T, DeliverError> {
        let Self {
            runtime,
            client,
            to,
        } = self;
        within(runtime, to, work(client, to))
    }
}

fn within<T>(
    runtime: &Runtime,
    to: &str,
    work: impl Future<Output = Result<T, DeliverError>>,
) -> Result<T, DeliverError> {
    let done = runtime.block_on(async { tokio::time::timeout(PATIENCE, work).await });
    done.unwrap_or_else(|_| {
        Err(DeliverError::Unreachable {
            to: to.to_owned(),
            problem: format!("no answer for {} s", PATIENCE.as_secs()),
        })
    })
}

fn tls(to: &Destination) -> Result<ClientConfig, DeliverError> {
    let mut roots = RootCertStore::empty();
    roots.add_parsable_certificates(to.authorities.iter().cloned());
    let provider = Arc::new(rustls::crypto::ring::default_provider());
    let builder =
        ClientConfig::builder_with_provider(provider).with_safe_default_protocol_versions();
    let builder = builder.map_err(|error| DeliverError::Certificate {
        to: to.name.clone(),
        problem: error.to_string(),
    })?;
    Ok(builder.with_root_certificates(roots).with_no_client_auth())
}

/// Makes the tables, or brings those of an older version to this one.
async fn prepare(client: &mut Client, to: &str) -> Result<(), DeliverError> {
    let failed = |error| refused(to, &error);
    let change = client.transaction().await.map_err(failed)?;
    let lock = "SELECT pg_advisory_xact_lock($1)";
    change.execute(lock, &[&MAKING]).await.map_err(failed)?;
    let found = found_version(&change, to).await?;
    if found == VERSION {
        return Ok(());
    }
    for step in &STEPS[found..] {
        change.batch_execute(step).await.map_err(failed)?;
    }
    let note = "INSERT INTO calot.setting (name, value) VALUES ('version', $1) \
                ON CONFLICT (name) DO UPDATE SET value = excluded.value";
    change
        .execute(note, &[&VERSION.to_string()])
        .await
        .map_err(failed)?;
    change.commit().await.map_err(failed)
}

/// Version of the centre's tables; 0: there are none.
async fn found_version(change: &Transaction<'_>, to: &str) -> Result<usize, DeliverError> {
    let failed = |error| refused(to, &error);
    let look =
        "SELECT to_regnamespace('calot') IS NOT NULL, to_regclass('calot.setting') IS NOT NULL";
    let row = change.query_one(look, &[]).await.map_err(failed)?;
    let other = |found: String| DeliverError::Version {
        to: to.to_owned(),
        found,
        needed: "tables that it knows, or none: use the newest Calot at this station, or name another database",
    };
    match (row.get(0), row.get(1)) {
        (false, _) => return Ok(0),
        (true, false) => return Err(other("a schema 'calot' of another program".to_owned())),
        (true, true) => {}
    }
    let read = "SELECT value FROM calot.setting WHERE name = 'version'";
    let row = change.query_opt(read, &[]).await.map_err(failed)?;
    let found: String = row.map_or_else(String::new, |row| row.get(0));
    let version = found.parse().ok();
    let version = version.filter(|it| (1..=VERSION).contains(it));
    version.ok_or_else(|| {
        other(format!(
            "tables of version '{}'",
            crate::error::printable(&found)
        ))
    })
}

impl Centre for Database {
    fn deliver(&mut self, it: &Outgoing) -> Result<Receipt, DeliverError> {
        let row = Row::of(it, &self.to)?;
        self.run(async |client, to| {
            deliver(client, it, &row)
                .await
                .map_err(|error| refused(to, &error))
        })
    }

    fn forget(&mut self, it: &Withdrawal) -> Result<(), DeliverError> {
        let person = id(&it.person, &self.to)?;
        let sessions: Result<Vec<Uuid>, _> =
            it.sessions.iter().map(|it| id(it, &self.to)).collect();
        let sessions = sessions?;
        self.run(async |client, to| {
            forget(client, person, it.at_unix_s, &sessions)
                .await
                .map_err(|error| refused(to, &error))
        })
    }
}

async fn deliver(
    client: &mut Client,
    it: &Outgoing,
    row: &Row<'_>,
) -> Result<Receipt, tokio_postgres::Error> {
    let change = client.transaction().await?;
    change.execute(LOCK, &[&row.person]).await?;
    let began = it.session.began_unix_s;
    let mark = "SELECT EXISTS (SELECT FROM calot.forgotten WHERE person = $1 AND at_unix_s >= $2)";
    if change.query_one(mark, &[&row.person, &began]).await?.get(0) {
        return Ok(Receipt::Forgotten);
    }
    enrol(&change, it, row.person).await?;
    let added = change.execute(&insert(), &row.values()).await?;
    let [lasting @ .., site] = row.values();
    if added == 0 && !change.query_one(&same(), &lasting).await?.get::<_, bool>(0) {
        // No trainee is added because of a session that the centre has from elsewhere.
        return Ok(Receipt::Differs);
    }
    change.execute(FILL_SITE, &[&row.id, site]).await?;
    for sheet in &it.ratings {
        let key: [&(dyn ToSql + Sync); 3] = [&row.id, &sheet.sheet, &sheet.rater];
        change.execute(REMOVE_SHEET, &key).await?;
        for (item, value) in &sheet.points {
            let value = i32::from(*value);
            let [id, name, rater] = key;
            let point: [&(dyn ToSql + Sync); 6] = [id, name, rater, &sheet.blinded, item, &value];
            change.execute(ADD_POINT, &point).await?;
        }
    }
    change.commit().await?;
    Ok(match added {
        0 => Receipt::Known,
        _ => Receipt::New,
    })
}

/// Stores cohort and consent of a person, unless a later statement is known.
async fn enrol(
    change: &Transaction<'_>,
    it: &Outgoing,
    person: Uuid,
) -> Result<(), tokio_postgres::Error> {
    let known = change.query_opt(KNOWN, &[&person]).await?;
    let known = known.map_or_else(Told::default, |row| Told {
        cohort: row.get(0),
        cohort_unix_s: row.get(1),
        consent: Consent::from_name(row.get(2)).unwrap_or_default(),
        consent_unix_s: row.get(3),
    });
    let told = known.joined(&it.told);
    let consent = told.consent.name();
    let values: [&(dyn ToSql + Sync); 6] = [
        &person,
        &it.name,
        &told.cohort,
        &told.cohort_unix_s,
        &consent,
        &told.consent_unix_s,
    ];
    change.execute(ENROL, &values).await.map(drop)
}

async fn forget(
    client: &mut Client,
    person: Uuid,
    at_unix_s: i64,
    sessions: &[Uuid],
) -> Result<(), tokio_postgres::Error> {
    let change = client.transaction().await?;
    change.execute(LOCK, &[&person]).await?;
    let capped = change.query_one(CAPPED, &[&at_unix_s]).await?;
    let at_unix_s: i64 = capped.get(0);
    let remove =
        "DELETE FROM calot.session WHERE person = $1 AND (began_unix_s <= $2 OR id = ANY ($3))";
    change
        .execute(remove, &[&person, &at_unix_s, &sessions])
        .await?;
    // A person who came back stays, without the earlier statements.
    change.execute(PLAIN, &[&person, &at_unix_s]).await?;
    let gone = "DELETE FROM calot.trainee WHERE person = $1 \
                AND NOT EXISTS (SELECT FROM calot.session WHERE person = $1)";
    change.execute(gone, &[&person]).await?;
    let mark = "INSERT INTO calot.forgotten AS known (person, at_unix_s) VALUES ($1, $2) \
                ON CONFLICT (person) DO UPDATE SET at_unix_s = greatest(known.at_unix_s, excluded.at_unix_s)";
    change.execute(mark, &[&person, &at_unix_s]).await?;
    change.commit().await
}

/// A session in the types of the database.
struct Row<'a> {
    it: &'a Outgoing,
    id: Uuid,
    person: Uuid,
    metrics_version: i64,
    metrics: Json<&'a std::collections::BTreeMap<String, f64>>,
    hand: &'static str,
}

impl<'a> Row<'a> {
    fn of(it: &'a Outgoing, to: &str) -> Result<Self, DeliverError> {
        Ok(Self {
            it,
            id: id(&it.session.id, to)?,
            person: id(&it.person, to)?,
            metrics_version: i64::from(it.session.metrics_version),
            metrics: Json(&it.session.metrics),
            hand: it.session.hand.name(),
        })
    }

    fn values(&self) -> [&(dyn ToSql + Sync); 18] {
        let it = &self.it.session;
        let made = &it.circumstances;
        [
            &self.id,
            &self.person,
            &it.began_unix_s,
            &it.task,
            &it.difficulty,
            &it.outcome,
            &it.score,
            &it.alarms,
            &self.metrics_version,
            &self.metrics,
            &it.scene,
            &it.program,
            &self.hand,
            &made.realtime,
            &made.missed_ticks,
            &made.device,
            &made.driver,
            &made.site,
        ]
    }
}

fn id(text: &str, to: &str) -> Result<Uuid, DeliverError> {
    Uuid::parse_str(text).map_err(|error| DeliverError::Rejected {
        to: to.to_owned(),
        problem: format!("'{}' is no UUID: {error}", crate::error::printable(text)),
    })
}

/// Translates an error of the library.
fn refused(to: &str, error: &tokio_postgres::Error) -> DeliverError {
    let (to, problem) = (to.to_owned(), in_words(error));
    if let Some(problem) = certificate_problem(error) {
        return DeliverError::Certificate { to, problem };
    }
    let Some(told) = error.as_db_error() else {
        // Without a password, the library itself ends the conversation.
        let asks = error
            .source()
            .is_some_and(|it| it.to_string().contains("password"));
        return match asks {
            true => DeliverError::Access { to, problem },
            false => DeliverError::Unreachable { to, problem },
        };
    };
    let code = told.code();
    let class = code.code().get(..2).unwrap_or_default();
    if *code == SqlState::INSUFFICIENT_PRIVILEGE {
        return DeliverError::Rights { to, problem };
    }
    match class {
        // Refused logins, and missing databases.
        "28" | "3D" => DeliverError::Access { to, problem },
        // Unfit values.
        "22" | "23" => DeliverError::Rejected { to, problem },
        // Connection, space, a server that stops, a lock: a later try may succeed.
        "08" | "53" | "57" | "40" | "55" => DeliverError::Unreachable { to, problem },
        _ => DeliverError::Answer {
            to,
            kind: "database of Calot",
            problem,
        },
    }
}
