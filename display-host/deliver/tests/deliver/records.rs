//! Results arrive in a record store, each once.

use std::sync::{Arc, Barrier};

use rustls::pki_types::pem::PemObject as _;
use rustls::pki_types::{CertificateDer, PrivateKeyDer};
use rustls::{ServerConfig, ServerConnection, StreamOwned};
use store::Store;
use system_tests::lrs::Fault;

use super::*;

#[test]
fn statements_keep_every_rule_and_arrive_once() {
    let (lrs, to) = records();
    let mut station = Station::new();
    let outcomes = ["passed", "failed", "aborted", "practised", "cut-short"];
    for (number, outcome) in outcomes.iter().enumerate() {
        let it = SessionRecord {
            outcome: (*outcome).to_owned(),
            score: [81.5, 0.0, 100.0, 40.0, 120.0][number],
            circumstances: Circumstances::default(),
            ..session(100 + number as i64)
        };
        station.keep("Ada", &it);
    }
    station.keep(
        "Ada",
        &SessionRecord {
            hand: Hand::Scripted,
            ..session(200)
        },
    );
    let pushed = station.push_all(&to);
    assert_eq!((pushed.sent, pushed.left_out), (5, 1));
    let verbs = |lrs: &Lrs| {
        let mut verbs: Vec<String> = { lrs.standing().into_iter() }
            .map(|it| {
                it["verb"]["display"]["en"]
                    .as_str()
                    .unwrap_or_default()
                    .to_owned()
            })
            .collect();
        verbs.sort();
        verbs
    };
    let expected = [
        "broke off",
        "failed",
        "passed",
        "practised",
        "was cut short",
    ];
    assert_eq!(verbs(&lrs), expected);
    let all = lrs.standing();
    let passed = all
        .iter()
        .find(|it| it["result"]["success"] == true)
        .expect("one");
    assert_eq!(passed["result"]["score"]["scaled"], 0.815);
    assert_eq!(passed["result"]["duration"], "PT13.59S");
    assert_eq!(passed["object"]["id"], "urn:calot:task:clamp");
    assert_eq!(
        passed["actor"]["account"]["homePage"],
        format!("http://127.0.0.1:{}", lrs.port())
    );
    // Without notes, everything is sent again under the same ids, even to a record store that does
    // not compare.
    for is_picky in [false, true] {
        lrs.kept().is_picky = is_picky;
        station.lose_notes();
        let again = station.push_all(&to);
        assert_eq!(again.sent + again.known, 5);
        assert_eq!(verbs(&lrs), expected);
    }
    assert!(lrs.kept().broken.is_empty(), "{:?}", lrs.kept().broken);
}

#[test]
fn a_line_that_is_cut_loses_and_doubles_nothing() {
    let (lrs, to) = records();
    let mut station = Station::new();
    station.keep_many(4);
    for (fault, arrived) in [
        (Fault::CutBefore, 0),
        (Fault::CutAfter, 1),
        (Fault::Busy, 1),
    ] {
        lrs.kept().faults.push_back(fault);
        let cut = station.push(&to);
        let problem = cut.problem.expect("it was cut");
        assert!(
            problem.contains("does not work at the moment"),
            "{fault:?}: {problem}"
        );
        assert_eq!((cut.sent, cut.waiting), (0, 4), "{fault:?}");
        assert_eq!(lrs.standing().len(), arrived, "{fault:?}");
    }
    assert_eq!(station.push_all(&to).sent, 4);
    assert_eq!(lrs.standing().len(), 4);
    assert!(lrs.kept().broken.is_empty(), "{:?}", lrs.kept().broken);
}

#[test]
fn two_programs_at_once_make_one_statement_of_a_result() {
    let (lrs, to) = records();
    let mut station = Station::new();
    station.keep_many(40);
    let start = Barrier::new(2);
    let push = || {
        let mut store = Store::open(&station.path).expect("a store");
        start.wait();
        super::push(&mut store, &to).expect("a store")
    };
    std::thread::scope(|threads| {
        for it in [threads.spawn(push), threads.spawn(push)] {
            assert_eq!(it.join().expect("it works").problem, None);
        }
    });
    assert_eq!(lrs.standing().len(), 40);
    assert!(lrs.kept().broken.is_empty(), "{:?}", lrs.kept().broken);
}

#[test]
fn a_result_that_is_refused_does_not_hold_up_the_others() {
    let (lrs, to) = records();
    let mut station = Station::new();
    station.keep_many(3);
    lrs.kept().faults.push_back(Fault::Refuse);
    let pushed = station.push(&to);
    assert_eq!((pushed.sent, pushed.waiting), (2, 1));
    let said = &pushed.refused[0].problem;
    assert!(said.contains("status 400: not today"), "{said}");
    assert_eq!(station.push_all(&to).sent, 1);
}

#[test]
fn a_record_store_is_reached_over_tls_if_its_authority_is_known() {
    let folder = tempfile::tempdir().expect("a folder");
    make_keys(folder.path());
    let file = |name: &str| folder.path().join(name);
    let chain = CertificateDer::pem_file_iter(file("server.pem")).expect("a file");
    let chain = chain.collect::<Result<Vec<_>, _>>().expect("certificates");
    let own = PrivateKeyDer::from_pem_file(file("server.key")).expect("a key");
    let provider = Arc::new(rustls::crypto::ring::default_provider());
    let config = ServerConfig::builder_with_provider(provider);
    let config = config
        .with_safe_default_protocol_versions()
        .expect("versions");
    let config = config.with_no_client_auth().with_single_cert(chain, own);
    let config = Arc::new(config.expect("a certificate and its key"));
    let lrs = Lrs::start(move |line| {
        let server = ServerConnection::new(config.clone()).ok()?;
        Some(StreamOwned::new(server, line))
    });
    let address = format!("https://127.0.0.1:{}/xapi", lrs.port());
    let mut station = Station::new();
    station.keep_many(2);
    let stranger = Destination::shown(&address, None, &key).expect("an address");
    let problem = station
        .push(&stranger)
        .problem
        .expect("an unknown authority");
    assert!(problem.contains("certificate is not trusted"), "{problem}");
    assert!(problem.contains("--ca FILE"), "{problem}");
    assert_eq!(lrs.kept().writes, 0);
    let known = Destination::shown(&address, Some(&file("ca.pem")), &key).expect("an address");
    assert_eq!(station.push_all(&known).sent, 2);
    assert_eq!(lrs.standing().len(), 2);
}
