//! Both sides over a real line on this computer.

mod support;

use std::io::Write as _;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering::Relaxed};
use std::time::Duration;

use bytemuck::Zeroable as _;
use link::{Address, Keys, LinkError};
use shared_mem::message::{CommandMsg, ReplyMsg, StateFrame, ToolFrame};
use shared_mem::scene::SceneFile;
use shared_mem::service::Host;
use support::{beside_a_station, keys, make_keys, now_ns, port, scene, wait_until, watched};

/// `beside_a_station` returns only after `serve` has ended.
#[test]
fn peer_that_sends_byte_by_byte_does_not_hold_up_the_end() {
    let folder = tempfile::tempdir().expect("a folder");
    let listen = format!("127.0.0.1:{}", port());
    let (ended, sent) = (AtomicBool::new(false), AtomicU64::new(0));
    std::thread::scope(|scope| {
        let trickle = || {
            let mut line = std::net::TcpStream::connect(&listen).expect("it listens");
            line.set_nodelay(true).expect("set");
            // A message of 4 kB that stays incomplete for the whole test.
            let head = [0, 16, 0, 0, 1];
            for byte in head.into_iter().chain(std::iter::repeat_n(0, 4 << 10)) {
                if ended.load(Relaxed) || line.write_all(&[byte]).is_err() {
                    break;
                }
                sent.fetch_add(1, Relaxed);
                std::thread::sleep(Duration::from_millis(2));
            }
        };
        beside_a_station("end", (listen.as_str(), None), folder.path(), |_| {
            scope.spawn(trickle);
            wait_until("it trickles", || sent.load(Relaxed) > 20);
        });
        let before_the_last = sent.load(Relaxed) < 4 << 10;
        ended.store(true, Relaxed);
        assert!(before_the_last, "the station waited for the whole message");
    });
}

#[test]
fn a_display_sees_a_station_that_is_elsewhere() {
    let folder = tempfile::tempdir().expect("a folder");
    let listen = format!("127.0.0.1:{}", port());
    let copy = folder.path().join("copy.calot");
    let address = Address::new(&listen, None, true).expect("this computer");
    let result = beside_a_station("there", (listen.as_str(), None), folder.path(), |ticks| {
        watched("here", &address, copy.clone(), |here, _| {
            let host = Host::open(here).expect("a host");
            let (mut frame, mut tool) = (bytemuck::zeroed_box::<StateFrame>(), ToolFrame::zeroed());
            let (mut events, mut batches) = (Vec::new(), 0);
            wait_until("states, tools, events and timing come", || {
                host.newest_state(&mut frame);
                host.newest_tools(&mut tool);
                host.drain_events(|it| events.push(it.sequence));
                host.drain_timing(|it| batches += it.records().map_or(0, <[_]>::len));
                events.len() > 300 && batches > 100 && frame.tick > 100 && tool.tick > 100
            });
            assert_eq!(frame.spheres().map(<[_]>::len), Some(2));
            assert_eq!(frame.cells(), Some(&[1, 2, 255][..]));
            let now = now_ns();
            let off = now.abs_diff(frame.at_ns);
            assert!(off < 20_000_000_000, "the stamp is of this clock: {off}");
            assert!(events.windows(2).all(|it| it[1] == it[0] + 1), "{events:?}");
            let reply = host.command(
                CommandMsg {
                    kind: CommandMsg::STOP,
                    argument: 0,
                },
                Duration::from_secs(30),
            );
            assert_eq!(reply.expect("an answer").outcome, ReplyMsg::UNKNOWN);
            let before = ticks.load(Relaxed);
            wait_until("the station goes on", || ticks.load(Relaxed) > before + 10);
        })
    });
    assert!(result.states > 10 && result.connections >= 1, "{result:?}");
    let copied = SceneFile::open(&copy).expect("the scene came");
    assert_eq!(copied.id(), scene().id());
}

#[test]
fn station_shows_itself_only_to_certificates_of_its_authority() {
    let folder = tempfile::tempdir().expect("a folder");
    let other = tempfile::tempdir().expect("a folder");
    for folder in [folder.path(), other.path()] {
        make_keys(folder, &["authority"]);
        make_keys(folder, &["station", "theatre", "IP:127.0.0.1"]);
        make_keys(folder, &["watcher", "desk"]);
    }
    make_keys(folder.path(), &["station", "elsewhere", "IP:10.99.99.99"]);
    let listen = format!("127.0.0.1:{}", port());
    let served = (listen.as_str(), Some(keys(folder.path(), "theatre")));
    beside_a_station("tls", served, folder.path(), |_| {
        let scene = folder.path().join("copy.calot");
        let ours = keys(folder.path(), "desk");
        let address = Address::new(&listen, Some(ours.clone()), false).expect("keys");
        let right = watched("right", &address, scene.clone(), |_, seen| {
            wait_until("it is connected", || {
                seen.lock()
                    .expect("no panic")
                    .iter()
                    .any(|it| it == "Connected")
            });
        });
        assert!(right.connections >= 1, "{right:?}");

        // Rejected keys: all of another authority; signed by another authority while trusting ours;
        // a station's certificate used by a watcher.
        let theirs = keys(other.path(), "desk");
        let mixed = Keys {
            authority: ours.authority,
            ..theirs.clone()
        };
        let station = keys(folder.path(), "theatre");
        for (name, wrong) in [("theirs", theirs), ("mixed", mixed), ("station", station)] {
            let address = Address::new(&listen, Some(wrong), false).expect("keys");
            let result = watched(name, &address, scene.clone(), |_, seen| {
                wait_until("it is refused", || {
                    !seen.lock().expect("no panic").is_empty()
                });
                let seen = seen.lock().expect("no panic");
                assert!(!seen.iter().any(|it| it == "Connected"), "{name}: {seen:?}");
            });
            assert_eq!(result.states, 0, "{name}");
        }
        // A connection without TLS.
        let bare = Address::new(&listen, None, true).expect("this computer");
        let result = watched("bare", &bare, scene.clone(), |_, seen| {
            wait_until("it is refused", || {
                !seen.lock().expect("no panic").is_empty()
            });
        });
        assert_eq!(result.states, 0);
        // Bytes that are not TLS harm nobody.
        let mut line = std::net::TcpStream::connect(&listen).expect("it listens");
        let _ = line.write_all(&[0xff; 70_000]);
        let after = watched("after", &address, scene, |_, seen| {
            wait_until("it is connected", || {
                seen.lock()
                    .expect("no panic")
                    .iter()
                    .any(|it| it == "Connected")
            });
        });
        assert!(after.connections >= 1);
    });
    // The station listens at an address that its certificate does not name.
    let listen = format!("127.0.0.1:{}", port());
    let served = (listen.as_str(), Some(keys(folder.path(), "elsewhere")));
    beside_a_station("misnamed", served, folder.path(), |_| {
        let address =
            Address::new(&listen, Some(keys(folder.path(), "desk")), false).expect("keys");
        let result = watched(
            "misled",
            &address,
            folder.path().join("x.calot"),
            |_, seen| {
                wait_until("it is refused", || {
                    !seen.lock().expect("no panic").is_empty()
                });
            },
        );
        assert_eq!(result.states, 0);
    });
}

#[test]
fn an_address_is_refused_unless_it_is_safe() {
    let folder = tempfile::tempdir().expect("a folder");
    make_keys(folder.path(), &["authority"]);
    make_keys(folder.path(), &["watcher", "a"]);
    let ours = keys(folder.path(), "a");
    let new = |address: &str, keys: Option<&Keys>, insecure| {
        Address::new(address, keys.cloned(), insecure)
    };
    assert!(new("10.0.0.7:7447", Some(&ours), false).is_ok());
    assert!(new("[::]:7447", Some(&ours), false).is_ok());
    assert!(new("localhost:1", None, true).is_ok() && new("[::1]:1", None, true).is_ok());
    assert!(matches!(
        new("10.0.0.7:7447", None, false),
        Err(LinkError::NoKeys)
    ));
    for bad in [
        "10.0.0.7:7447",
        "0.0.0.0:7447",
        "127.0.0.1.evil.net:1",
        "localhost.evil:1",
    ] {
        assert!(
            matches!(new(bad, None, true), Err(LinkError::Address { .. })),
            "{bad}"
        );
    }
    for bad in [
        "",
        ":1",
        "a",
        "a:b",
        "a:70000",
        "a:1#iface=x",
        "tcp/127.0.0.1:1",
        "a b:1",
        "ä:1",
    ] {
        assert!(
            matches!(new(bad, Some(&ours), false), Err(LinkError::Address { .. })),
            "{bad}"
        );
    }
    let missing = keys(folder.path(), "b");
    assert!(matches!(
        new("a:1", Some(&missing), false),
        Err(LinkError::Key { .. })
    ));
    let swapped = Keys {
        key: ours.certificate.clone(),
        ..ours.clone()
    };
    assert!(matches!(
        new("a:1", Some(&swapped), false),
        Err(LinkError::Key { .. })
    ));
    use std::os::unix::fs::PermissionsExt as _;
    let open = std::fs::Permissions::from_mode(0o644);
    std::fs::set_permissions(&ours.key, open).expect("set");
    let error = new("a:1", Some(&ours), false).expect_err("others can read it");
    assert!(error.to_string().contains("mode 644"), "{error}");
}
