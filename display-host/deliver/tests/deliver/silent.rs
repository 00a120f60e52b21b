//! Centres that take a connection and say nothing.

use std::net::TcpListener;
use std::time::{Duration, Instant};

use super::*;

#[test]
fn a_push_ends_though_nobody_answers() {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
    let port = listener.local_addr().expect("an address").port();
    // The kernel completes connections; nobody reads from them.
    let wait = |address: String| {
        let to = Destination::shown(&address, None, &key).expect("an address");
        let mut station = Station::new();
        station.keep("Ada", &session(100));
        let start = Instant::now();
        let pushed = station.push(&to);
        let problem = pushed.problem.expect("nobody answers");
        assert!(problem.contains("does not work at the moment"), "{problem}");
        assert!(problem.contains("the results wait"), "{problem}");
        assert_eq!(pushed.waiting, 1);
        start.elapsed()
    };
    let longest = std::thread::scope(|threads| {
        let both = [
            format!("postgres://owner@127.0.0.1:{port}/calot"),
            format!("http://127.0.0.1:{port}/xapi"),
        ];
        let both = both.map(|it| threads.spawn(move || wait(it)));
        both.map(|it| it.join().expect("it ends")).into_iter().max()
    });
    assert!(
        longest < Some(deliver::PATIENCE + Duration::from_secs(20)),
        "{longest:?}"
    );
}
