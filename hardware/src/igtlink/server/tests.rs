//! The server with real sockets.

use std::io::{Read as _, Write as _};
use std::net::Shutdown;
use std::time::Duration;

use nalgebra::Isometry3;

use super::*;
use crate::igtlink::message::Unit;
use crate::igtlink::wire::{self, HEADER_BYTES, Header, Version};

const NAME: &str = "ToolToReference";

fn server() -> Server {
    Server::bind("127.0.0.1:0", "Calot", "ras").unwrap()
}

fn connected(server: &Server) -> TcpStream {
    let stream = TcpStream::connect(server.address().unwrap()).unwrap();
    stream
        .set_read_timeout(Some(Duration::from_secs(60)))
        .unwrap();
    stream
}

fn tool() -> Message {
    Message::transform(NAME, &Isometry3::identity(), 0).unwrap()
}

fn tracking() -> Message {
    Message::tracking("Calot", &[(NAME, Isometry3::identity())], 0).unwrap()
}

/// Attends and sends until `done` returns true, for at most a minute.
fn until(server: &mut Server, messages: &[Message], mut done: impl FnMut(&Server) -> bool) {
    let start = Instant::now();
    while start.elapsed() < Duration::from_secs(60) {
        server.attend(0);
        server.send(messages);
        if done(server) {
            return;
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    panic!("the awaited state did not come within a minute");
}

/// Reads one message: its version, type and name, and its content.
fn read(stream: &mut TcpStream) -> (Version, String, String, Vec<u8>) {
    let mut head = [0; HEADER_BYTES];
    stream.read_exact(&mut head).unwrap();
    let header = Header::read(&head).unwrap();
    let mut body = vec![0; usize::try_from(header.body_bytes).unwrap()];
    stream.read_exact(&mut body).unwrap();
    assert_eq!(wire::checksum(&body), header.checksum);
    let (version, content) = header.open(&body).unwrap();
    let content = content.to_vec();
    (version, header.kind, header.name, content)
}

/// Asks, and returns type and content of the next answer.
fn ask(
    server: &mut Server,
    client: &mut TcpStream,
    kind: &str,
    name: &str,
    content: &[u8],
) -> (String, Vec<u8>) {
    let request = wire::pack(Version::One, kind, name, 0, content);
    client.write_all(&request).unwrap();
    answered(server, client)
}

fn answered(server: &mut Server, client: &mut TcpStream) -> (String, Vec<u8>) {
    let mut one = [0];
    client.set_nonblocking(true).unwrap();
    until(server, &[], |_| client.peek(&mut one).is_ok());
    client.set_nonblocking(false).unwrap();
    let (_, kind, _, content) = read(client);
    (kind, content)
}

fn status(content: &[u8]) -> (u8, String) {
    (content[1], String::from_utf8_lossy(&content[30..]).into())
}

/// True if bytes wait for the client.
fn has_bytes(client: &TcpStream) -> bool {
    client.set_nonblocking(true).unwrap();
    let has = client.peek(&mut [0]).is_ok();
    client.set_nonblocking(false).unwrap();
    has
}

/// Waits until the clients get messages without a request, and reads these messages.
fn listen(server: &mut Server, clients: &mut [&mut TcpStream]) {
    until(server, &[tool()], |_| {
        clients.iter().all(|it| has_bytes(it))
    });
    for client in clients {
        while has_bytes(client) {
            read(client);
        }
    }
    server.forget_moment();
}

fn start(resolution_ms: i32, frame: &str) -> Vec<u8> {
    let mut content = resolution_ms.to_be_bytes().to_vec();
    content.extend(wire::field::<32>(frame));
    content
}

#[test]
fn every_client_gets_every_message_and_one_that_leaves_is_forgotten() {
    let mut server = server();
    let mut first = connected(&server);
    let mut second = connected(&server);
    listen(&mut server, &mut [&mut first, &mut second]);
    server.send(&[tool()]);
    for client in [&mut first, &mut second] {
        let mut message = [0; 106];
        client.read_exact(&mut message).unwrap();
        assert_eq!(message[..], tool().bytes(Version::One));
    }
    drop(first);
    until(&mut server, &[tool()], |server| server.client_count() == 1);
}

#[test]
fn a_client_that_does_not_read_misses_whole_messages_only() {
    let mut server = server();
    let mut client = connected(&server);
    listen(&mut server, &mut [&mut client]);
    for _ in 0..200_000 {
        server.send(&[tool()]);
        if server.skipped() > 10 {
            break;
        }
    }
    assert!(server.skipped() > 10, "the client's buffers never fill");
    // The client resumes: it reads whole messages and gets new ones again.
    let reader = std::thread::spawn(move || {
        let expected = tool().bytes(Version::One);
        let mut message = [0; 106];
        let mut count = 0u64;
        while client.read_exact(&mut message).is_ok() {
            assert_eq!(message[..], expected, "message {count}");
            count += 1;
        }
        count
    });
    let mut before = server.skipped();
    until(&mut server, &[tool()], |server| {
        let is_read = server.skipped() == before;
        before = server.skipped();
        is_read
    });
    drop(server);
    assert!(reader.join().unwrap() > 100);
}

#[test]
fn one_client_too_many_gets_a_status_and_is_disconnected() {
    let mut server = server();
    let mut clients: Vec<TcpStream> = (0..9).map(|_| connected(&server)).collect();
    until(&mut server, &[], |server| server.turned_away() == 1);
    assert_eq!(server.client_count(), Server::CLIENTS_MAX);
    let (_, kind, _, content) = read(&mut clients[8]);
    assert_eq!((kind.as_str(), status(&content).0), ("STATUS", 6));
    assert_eq!(clients[8].read(&mut [0]).unwrap(), 0, "closed");
}

#[test]
fn a_client_that_closes_its_sending_side_still_gets_messages() {
    let mut server = server();
    let mut client = connected(&server);
    until(&mut server, &[], |server| server.client_count() == 1);
    client.shutdown(Shutdown::Write).unwrap();
    for _ in 0..50 {
        server.attend(0);
        std::thread::sleep(Duration::from_millis(1));
    }
    server.send(&[tool()]);
    assert_eq!(read(&mut client).1, "TRANSFORM");
    assert_eq!(server.client_count(), 1);
}

#[test]
fn requests_are_answered() {
    let mut server = server();
    let mut client = connected(&server);
    listen(&mut server, &mut [&mut client]);
    let (kind, content) = ask(&mut server, &mut client, "GET_TRANS", NAME, b"");
    assert_eq!((kind.as_str(), status(&content).0), ("STATUS", 13));

    server.announce(&Message::status("Calot", Code::Ok, "running", "runs", 0));
    assert_eq!(answered(&mut server, &mut client).0, "STATUS");
    let force = Message::sensor("Force", &[1.0], Unit::Newton, 0).unwrap();
    server.send(&[tool(), tracking(), force]);
    assert_eq!(answered(&mut server, &mut client).0, "TRANSFORM");
    assert_eq!(answered(&mut server, &mut client).0, "SENSOR");
    for (request, answer) in [
        ("GET_STATUS", "STATUS"),
        ("GET_CAPABIL", "CAPABILITY"),
        ("GET_TRANS", "TRANSFORM"),
        ("GET_TDATA", "TDATA"),
        ("GET_SENSOR", "SENSOR"),
    ] {
        let (kind, content) = ask(&mut server, &mut client, request, "", b"");
        assert_eq!(kind, answer);
        assert!(!content.is_empty());
    }
    let (kind, content) = ask(&mut server, &mut client, "GET_TRANS", "Nobody", b"");
    assert_eq!((kind.as_str(), status(&content).0), ("STATUS", 4));
    assert!(status(&content).1.contains("ToolToReference"));
    let (kind, content) = ask(&mut server, &mut client, "GET_IMAGE", "", b"");
    assert_eq!((kind.as_str(), status(&content).0), ("STATUS", 12));
    assert!(status(&content).1.contains("GET_IMAGE is not supported"));

    server.forget_moment();
    let (_, content) = ask(&mut server, &mut client, "GET_TRANS", NAME, b"");
    assert_eq!(status(&content).0, 13);
}

#[test]
fn tracking_data_go_to_clients_that_ask_until_they_stop_them() {
    let mut server = server();
    let mut client = connected(&server);
    let mut beside = connected(&server);
    listen(&mut server, &mut [&mut client, &mut beside]);
    for (content, words) in [
        (
            start(-1, ""),
            "the resolution -1 ms is not in 0 to 60000 ms",
        ),
        (
            start(0, "LPS"),
            "poses are in the frame RAS, not LPS; start calot igtlink with",
        ),
        (vec![1], "the request has no resolution"),
    ] {
        let refused = ask(&mut server, &mut client, "STT_TDATA", "", &content);
        assert_eq!(refused, ("RTS_TDATA".to_owned(), vec![1]));
        let (kind, content) = answered(&mut server, &mut client);
        assert_eq!((kind.as_str(), status(&content).0), ("STATUS", 10));
        assert!(status(&content).1.contains(words));
    }
    let begun = ask(
        &mut server,
        &mut client,
        "STT_TDATA",
        "",
        &start(60_000, "Patient"),
    );
    assert_eq!(begun, ("RTS_TDATA".to_owned(), vec![0]));
    for _ in 0..5 {
        server.send(&[tracking()]);
    }
    // One only: the next is due in a minute. The answer to STP_TDATA follows it.
    assert_eq!(answered(&mut server, &mut client).0, "TDATA");
    let ended = ask(&mut server, &mut client, "STP_TDATA", "", b"");
    assert_eq!(ended, ("RTS_TDATA".to_owned(), vec![0]));
    ask(&mut server, &mut client, "STT_TDATA", "", &start(0, "ras"));
    for _ in 0..3 {
        server.send(&[tracking()]);
        assert_eq!(answered(&mut server, &mut client).0, "TDATA");
    }
    ask(&mut server, &mut client, "STP_TDATA", "", b"");
    server.send(&[tracking(), tool()]);
    assert_eq!(answered(&mut server, &mut client).0, "TRANSFORM");
    assert_eq!(answered(&mut server, &mut beside).0, "TRANSFORM");
}

#[test]
fn answers_come_in_the_version_of_the_request() {
    let mut server = server();
    server.announce(&Message::status("Calot", Code::Ok, "running", "runs", 0));
    let mut client = connected(&server);
    assert_eq!(answered(&mut server, &mut client).0, "STATUS");
    let version = Version::Two { message_id: 42 };
    client
        .write_all(&wire::pack(version, "GET_STATUS", "", 0, b""))
        .unwrap();
    client.set_nonblocking(true).unwrap();
    until(&mut server, &[], |_| client.peek(&mut [0]).is_ok());
    client.set_nonblocking(false).unwrap();
    let (answered_in, kind, _, _) = read(&mut client);
    assert_eq!((answered_in, kind.as_str()), (version, "STATUS"));
    // A message without a request also has that version.
    server.send(&[tool()]);
    assert_eq!(read(&mut client).0, Version::Two { message_id: 0 });
}

#[test]
fn noise_and_damage_are_answered_once_and_data_continue() {
    let mut server = server();
    let mut client = connected(&server);
    listen(&mut server, &mut [&mut client]);
    let mut damaged = wire::pack(Version::One, "GET_STATUS", "", 0, b"x");
    damaged[58] = b'y';
    client.write_all(&damaged).unwrap();
    let (kind, content) = answered(&mut server, &mut client);
    assert_eq!((kind.as_str(), status(&content).0), ("STATUS", 9));
    // Data are refused once; an answer to a status would never end.
    for kind in ["IMAGE", "IMAGE", "STATUS", "RTS_TDATA"] {
        let data = wire::pack(Version::One, kind, "", 0, b"");
        client.write_all(&data).unwrap();
    }
    let (_, content) = answered(&mut server, &mut client);
    assert!(status(&content).1.contains("IMAGE is not supported"));
    client.write_all(&[0xFF; 20_000]).unwrap();
    let (kind, content) = answered(&mut server, &mut client);
    assert_eq!((kind.as_str(), status(&content).0), ("STATUS", 17));
    assert!(status(&content).1.contains("this is no OpenIGTLink header"));
    server.attend(0);
    server.send(&[tool()]);
    assert_eq!(answered(&mut server, &mut client).0, "TRANSFORM");
}

#[test]
fn a_later_client_first_gets_the_newest_announcements() {
    let mut server = server();
    server.announce(&Message::string("Instrument", "grasper", 0));
    server.announce(&Message::string("Instrument", "scissors", 0));
    server.send(&[Message::string("Event", "cut", 0)]);
    let mut client = connected(&server);
    let (kind, content) = answered(&mut server, &mut client);
    assert_eq!((kind.as_str(), &content[4..]), ("STRING", &b"scissors"[..]));
    server.send(&[tool()]);
    assert_eq!(read(&mut client).1, "TRANSFORM");
}

#[test]
fn a_client_that_begins_with_a_request_gets_answers_only() {
    let mut server = server();
    server.announce(&Message::status("Calot", Code::Ok, "running", "runs", 0));
    let surface = Message::polydata("liver", &[[0.0; 3]; 3], &[[0, 1, 2]], 0);
    server.send(&[surface.clone(), tool()]);
    let mut client = connected(&server);
    // The reference library's examples name themselves where the device's name belongs.
    for _ in 0..3 {
        let request = wire::pack(Version::One, "GET_POLYDATA", "Client", 0, b"");
        client.write_all(&request).unwrap();
        until(&mut server, &[tool()], |_| has_bytes(&client));
        assert_eq!(read(&mut client).3, surface.content);
    }
    // There are no images. An empty list would not do: without a body, the library's client waits
    // for the next message.
    let (kind, content) = ask(&mut server, &mut client, "GET_IMGMETA", "Client", b"");
    assert_eq!((kind.as_str(), status(&content).0), ("STATUS", 12));
    // It sends no more requests, and after a while it gets all messages.
    until(&mut server, &[tool()], |_| has_bytes(&client));
    assert_eq!(read(&mut client).1, "STATUS");
    assert_eq!(read(&mut client).1, "TRANSFORM");
}

#[test]
fn quaternions_go_to_clients_that_ask() {
    let mut server = server();
    let mut client = connected(&server);
    listen(&mut server, &mut [&mut client]);
    let poses = [(NAME, Isometry3::identity())];
    let quaternions = Message::quaternions("Calot", &poses, 0).unwrap();
    let begun = ask(&mut server, &mut client, "STT_QTDATA", "", &start(0, "ras"));
    assert_eq!(begun, ("RTS_QTDATA".to_owned(), vec![0]));
    server.send(&[tracking(), quaternions.clone()]);
    assert_eq!(
        answered(&mut server, &mut client),
        ("QTDATA".to_owned(), quaternions.content.clone())
    );
    let newest = ask(&mut server, &mut client, "GET_QTDATA", "", b"");
    assert_eq!(newest, ("QTDATA".to_owned(), quaternions.content.clone()));
    let ended = ask(&mut server, &mut client, "STP_QTDATA", "", b"");
    assert_eq!(ended, ("RTS_QTDATA".to_owned(), vec![0]));
    server.send(&[quaternions, tool()]);
    assert_eq!(answered(&mut server, &mut client).0, "TRANSFORM");
}
