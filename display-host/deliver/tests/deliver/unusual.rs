//! Centres that are not as they should be: each is refused in words, and nothing is lost.

use std::os::unix::fs::PermissionsExt as _;

use deliver::DeliverError;
use store::Sheet;
use system_tests::postgres::Postgres;

use super::*;

fn problem(station: &mut Station, to: &Destination) -> String {
    let pushed = station.push(to);
    assert_eq!((pushed.sent, pushed.waiting), (0, 1), "{pushed:?}");
    pushed.problem.expect("a problem")
}

#[test]
fn a_database_lets_in_who_has_the_password_and_the_rights() {
    let Some(server) = Postgres::start() else {
        return;
    };
    let mut station = Station::new();
    station.keep("Ada", &session(100));
    let wrong = |_: &str| Some("s3cret".to_owned());
    let to = Destination::shown(&server.address(OWNER), None, &wrong).expect("an address");
    let said = problem(&mut station, &to);
    assert!(
        said.contains("refuses this user or password") && !said.contains("s3cret"),
        "{said}"
    );
    let to = Destination::shown(&server.address(OWNER), None, &none).expect("an address");
    let said = problem(&mut station, &to);
    assert!(said.contains("refuses this user or password"), "{said}");
    let other = server.address(OWNER).replace("/calot", "/none");
    let to = Destination::shown(&other, None, &password).expect("an address");
    let said = problem(&mut station, &to);
    assert!(said.contains("\"none\" does not exist"), "{said}");
    // A station of its own that may not make tables.
    let role = format!(
        "CREATE ROLE the_station LOGIN PASSWORD '{}'",
        PASSWORD.replace('\'', "''")
    );
    server.sql("calot", &role);
    let file = station.path.with_extension("centre");
    let address = server.address("the_station:pass%27word");
    std::fs::write(&file, address).expect("written");
    let mode = std::fs::Permissions::from_mode(0o600);
    std::fs::set_permissions(&file, mode).expect("own file");
    let to = Destination::from_file(&file, None, &none).expect("an address");
    let said = problem(&mut station, &to);
    assert!(said.contains("this user may not do that"), "{said}");
    assert!(said.contains("GRANT SELECT, INSERT"), "{said}");
    // As the message says: once as the owner, then with rights.
    Station::new().push_all(&owners(&server));
    server.sql(
        "calot",
        "GRANT USAGE ON SCHEMA calot TO the_station; \
         GRANT SELECT, INSERT, UPDATE, DELETE ON ALL TABLES IN SCHEMA calot TO the_station",
    );
    assert_eq!(station.push_all(&to).sent, 1);
    station.store.forget("Ada", 500).expect("forgotten");
    station.push_all(&to);
    assert_eq!(server.rows("SELECT count(*) FROM calot.session"), ["0"]);
}

#[test]
fn tables_of_other_versions_and_other_programs_are_left_alone() {
    let Some(server) = Postgres::start() else {
        return;
    };
    let mut station = Station::new();
    station.keep("Ada", &session(100));
    server.sql(
        "calot",
        "CREATE SCHEMA calot; CREATE TABLE calot.theirs (x int)",
    );
    let said = problem(&mut station, &owners(&server));
    assert!(
        said.contains("a schema 'calot' of another program"),
        "{said}"
    );
    server.sql("calot", "DROP SCHEMA calot CASCADE");
    station.push_all(&owners(&server));
    station.keep("Ada", &session(200));
    for version in ["99", "0", "x"] {
        server.sql(
            "calot",
            &format!("UPDATE calot.setting SET value = '{version}'"),
        );
        let said = problem(&mut station, &owners(&server));
        assert!(
            said.contains(&format!("tables of version '{version}'")),
            "{said}"
        );
        assert!(said.contains("Nothing was sent"), "{said}");
    }
}

#[test]
fn a_spool_that_is_damaged_sends_nothing() {
    let (lrs, to) = records();
    let mut station = Station::new();
    station.keep("Ada", &session(100));
    let destination = station.store.destination(to.name()).expect("a centre");
    let other = rusqlite::Connection::open(&station.path).expect("a file");
    let row = "INSERT INTO withdrawal VALUES (?1, 'nobody', 5, '[')";
    other.execute(row, [destination]).expect("a row");
    let error = push(&mut station.store, &to).expect_err("the row makes no sense");
    assert!(matches!(error, DeliverError::Store(_)), "{error}");
    let words = "is damaged (a withdrawal of 'nobody' makes no sense)";
    assert!(error.to_string().contains(words), "{error}");
    assert_eq!(lrs.kept().writes, 0);
}

#[test]
fn tables_of_an_older_version_get_what_they_lack() {
    let Some(server) = Postgres::start() else {
        return;
    };
    let mut station = Station::new();
    let id = station.keep("Ada", &session(100));
    station.push_all(&owners(&server));
    server.sql(
        "calot",
        "DROP TABLE calot.point; ALTER TABLE calot.trainee DROP COLUMN cohort_unix_s, DROP COLUMN consent_unix_s; UPDATE calot.setting SET value = '1'",
    );
    let goals = Sheet::named("goals").expect("a sheet");
    let rated = station.store.rate(&id, &goals, ("Bo", true), &[3; 5]);
    rated.expect("rated");
    assert_eq!(station.push_all(&owners(&server)).known, 1);
    assert_eq!(server.rows("SELECT value FROM calot.setting"), ["4"]);
    assert_eq!(server.rows("SELECT sum(value) FROM calot.point"), ["15"]);
}

#[test]
fn a_result_that_the_centre_has_with_other_contents_stays_as_it_is_there() {
    let Some(server) = Postgres::start() else {
        return;
    };
    let (lrs, to) = records();
    let mut station = Station::new();
    let first = session(100);
    station.keep("Ada", &first);
    station.push_all(&owners(&server));
    station.push_all(&to);
    let changed = SessionRecord {
        score: 12.0,
        ..first.clone()
    };
    station.keep("Ada", &changed);
    for to in [&owners(&server), &to] {
        assert_eq!(station.push_all(to).differing, [first.id.as_str()]);
        assert!(station.push_all(to).differing.is_empty(), "told once");
    }
    assert_eq!(server.rows("SELECT score FROM calot.session"), ["81.5"]);
    assert_eq!(lrs.standing()[0]["result"]["score"]["raw"], 81.5);
}

#[test]
fn record_stores_that_refuse_or_speak_otherwise_are_named() {
    let (lrs, to) = records();
    let mut station = Station::new();
    station.keep("Ada", &session(100));
    let address = format!("http://127.0.0.1:{}", lrs.port());
    let wrong = |_: &str| Some("wr0ng".to_owned());
    let stranger =
        Destination::shown(&format!("{address}/xapi"), None, &wrong).expect("an address");
    let said = problem(&mut station, &stranger);
    assert!(
        said.contains("status 401: who are you?") && !said.contains("wr0ng"),
        "{said}"
    );
    let elsewhere =
        Destination::shown(&format!("{address}/other"), None, &key).expect("an address");
    let said = problem(&mut station, &elsewhere);
    assert!(
        said.contains("answers as no learning record store does"),
        "{said}"
    );
    lrs.kept().versions = vec!["1.0.3"];
    let said = problem(&mut station, &to);
    assert!(
        said.contains("has xAPI 1.0.3; this program needs xAPI 2.0"),
        "{said}"
    );
    // One that does not tell its versions is tried.
    lrs.kept().versions = Vec::new();
    assert_eq!(station.push_all(&to).sent, 1);
}

#[test]
fn a_database_is_reached_over_tls_if_its_authority_is_known() {
    let Some(mut server) = Postgres::start() else {
        return;
    };
    let folder = tempfile::tempdir().expect("a folder");
    make_keys(folder.path());
    let file = |name: &str| folder.path().join(name);
    let address = format!("{}?sslmode=require", server.address(OWNER));
    let mut station = Station::new();
    station.keep("Ada", &session(100));
    let with = |ca: Option<&Path>| Destination::shown(&address, ca, &password).expect("an address");
    let said = problem(&mut station, &with(None));
    assert!(
        said.contains("does not work at the moment"),
        "it has no certificate: {said}"
    );
    server.encrypt(&file("server.pem"), &file("server.key"));
    let said = problem(&mut station, &with(None));
    assert!(said.contains("certificate is not trusted"), "{said}");
    assert_eq!(station.push_all(&with(Some(&file("ca.pem")))).sent, 1);
    let lines = "SELECT count(*) FROM pg_stat_ssl WHERE ssl";
    assert_eq!(server.rows(lines), ["0"], "the push has ended");
}
