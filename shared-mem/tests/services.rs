//! Tests ends of a station that communicate through real shared memory.

use core::time::Duration;

use bytemuck::Zeroable;
use shared_mem::inputs::InputBatch;
use shared_mem::message::{CommandMsg, EventMsg, ReplyMsg, StateFrame, TimingBatch, ToolFrame};
use shared_mem::service::{Controller, Host, ServiceError, Station, Tap, TaskReceiver, TaskSender};
use shared_mem::task::{TASK_TEXT, TaskMsg};

fn station(test: &str) -> Station {
    Station::new(&format!("t{}-{test}", std::process::id())).expect("a plain name")
}

fn zeroed<T: Zeroable>() -> Box<T> {
    bytemuck::zeroed_box()
}

fn send_state(controller: &Controller, tick: u64) {
    let mut frame = zeroed::<StateFrame>();
    frame.tick = tick;
    controller.state.send_copy(*frame).expect("sending");
}

#[test]
fn a_host_sees_the_newest_state_and_every_event() {
    let station = station("newest");
    let controller = Controller::open(&station).unwrap();
    let host = Host::open(&station).unwrap();
    for tick in 1..=10 {
        send_state(&controller, tick);
        let event = EventMsg {
            sequence: tick,
            ..EventMsg::zeroed()
        };
        controller.events.send_copy(event).unwrap();
    }
    let mut frame = zeroed::<StateFrame>();
    assert!(host.newest_state(&mut frame));
    assert_eq!(frame.tick, 10);
    assert!(!host.newest_state(&mut frame), "nothing newer came");
    let mut seen = Vec::new();
    host.drain_events(|event| seen.push(event.sequence));
    assert_eq!(seen, (1..=10).collect::<Vec<_>>());
}

#[test]
fn a_host_that_comes_later_gets_the_newest_state_at_once() {
    let station = station("late");
    let controller = Controller::open(&station).unwrap();
    send_state(&controller, 7);
    let host = Host::open(&station).unwrap();
    let mut frame = zeroed::<StateFrame>();
    // The publisher's next send or the subscriber's next receive makes the connection.
    assert!(
        host.newest_state(&mut frame) || {
            send_state(&controller, 8);
            host.newest_state(&mut frame)
        }
    );
    assert!(frame.tick >= 7);
}

#[test]
fn late_host_gets_the_last_events_without_waiting_for_another() {
    let station = station("past");
    let controller = Controller::open(&station).unwrap();
    let event = |sequence| EventMsg {
        sequence,
        ..EventMsg::zeroed()
    };
    for sequence in 0..100 {
        controller.events.send_copy(event(sequence)).unwrap();
    }
    for _ in 0..2 {
        let host = Host::open(&station).unwrap();
        controller.greet();
        controller.greet();
        let mut seen = Vec::new();
        host.drain_events(|event| seen.push(event.sequence));
        assert_eq!(seen, (36..100).collect::<Vec<_>>(), "the last, once");
    }
}

#[test]
fn a_full_event_buffer_shows_as_a_gap_in_sequence() {
    let station = station("gap");
    let controller = Controller::open(&station).unwrap();
    let host = Host::open(&station).unwrap();
    for sequence in 0..5000 {
        let event = EventMsg {
            sequence,
            ..EventMsg::zeroed()
        };
        controller.events.send_copy(event).unwrap();
    }
    let mut seen = Vec::new();
    host.drain_events(|event| seen.push(event.sequence));
    assert_eq!(seen.last(), Some(&4999), "the newest are kept");
    assert!(
        seen.windows(2).all(|w| w[1] == w[0] + 1),
        "what is left is whole"
    );
    assert!(seen[0] > 0, "the gap is visible");
}

#[test]
fn commands_are_answered() {
    let station = station("command");
    let host = Host::open(&station).unwrap();
    let impatient = host.command(CommandMsg::zeroed(), Duration::from_millis(30));
    assert!(matches!(impatient, Err(ServiceError::NoAnswer { .. })));
    std::thread::scope(|scope| {
        scope.spawn(|| {
            let controller = Controller::open(&station).unwrap();
            // The loop is bounded, so that a lost command fails the test instead of blocking it.
            for _ in 0..30_000 {
                if let Some(request) = controller.next_request() {
                    let command = request.command();
                    request.reply(ReplyMsg {
                        outcome: command.argument,
                        reserved: 0,
                        tick: 3,
                    });
                    if command.kind == CommandMsg::STOP {
                        return;
                    }
                }
                std::thread::sleep(Duration::from_millis(1));
            }
        });
        let ask = |kind, argument| {
            host.command(CommandMsg { kind, argument }, Duration::from_secs(20))
                .unwrap()
        };
        assert_eq!(ask(CommandMsg::PAUSE, 1).outcome, 1);
        assert_eq!(ask(CommandMsg::INSTRUMENT, 2).tick, 3);
        // The controller may end before the host has read the last reply.
        let _ = host.command(
            CommandMsg {
                kind: CommandMsg::STOP,
                argument: 0,
            },
            Duration::from_secs(2),
        );
    });
}

#[test]
fn a_second_controller_is_refused_and_the_first_goes_on() {
    let station = station("second");
    let controller = Controller::open(&station).unwrap();
    let host = Host::open(&station).unwrap();
    let second = Controller::open(&station);
    assert!(
        matches!(second, Err(ServiceError::SecondController(_))),
        "{second:?}"
    );
    send_state(&controller, 1);
    assert!(host.newest_state(&mut zeroed()));
    drop(controller);
    let third = Controller::open(&station).unwrap();
    send_state(&third, 2);
    let mut frame = zeroed::<StateFrame>();
    assert!(
        host.newest_state(&mut frame),
        "a controller that restarts is found again"
    );
    assert_eq!(frame.tick, 2);
}

#[test]
fn stations_do_not_see_each_other() {
    let (left, right) = (station("left"), station("right"));
    let controller = Controller::open(&left).unwrap();
    let host = Host::open(&right).unwrap();
    send_state(&controller, 1);
    assert!(!host.newest_state(&mut zeroed()));
    Controller::open(&right).unwrap();
}

#[test]
fn bad_station_names_are_refused() {
    for name in ["", "a b", "../x", "ä", &"x".repeat(41)] {
        assert!(
            matches!(Station::new(name), Err(ServiceError::StationName(_))),
            "{name}"
        );
    }
}

#[test]
fn malformed_frames_are_refused_as_such() {
    let mut state = zeroed::<StateFrame>();
    state.sphere_count = 2;
    assert!(state.spheres().is_some_and(|s| s.len() == 2));
    state.spheres[1].center_m[0] = f32::NAN;
    assert!(state.spheres().is_none());
    state.sphere_count = u32::MAX;
    assert!(state.spheres().is_none());

    let mut state = zeroed::<StateFrame>();
    (state.sphere_count, state.clip_count) = (2, 1);
    state.clips[0].spheres = [0, 1];
    assert!(state.clips().is_some_and(|clips| clips.len() == 1));
    state.clips[0].legs[2] = f32::INFINITY;
    assert!(state.clips().is_none());
    state.clips[0].legs[2] = 0.0;
    state.clips[0].spheres = [1, 2];
    assert!(state.clips().is_none(), "there is no third sphere");
    state.clip_count = u32::MAX;
    assert!(state.clips().is_none());

    let mut state = zeroed::<StateFrame>();
    state.stone_count = 1;
    state.stones[0].radius_m = 0.002;
    assert!(state.stones().is_none(), "a zero quaternion is no rotation");
    state.stones[0].orientation[3] = 1.0;
    assert!(state.stones().is_some_and(|stones| stones.len() == 1));
    state.stones[0].number = 30;
    assert!(state.stones().is_none(), "there are 30 stones at most");
    (state.stones[0].number, state.stones[0].radius_m) = (0, f32::NAN);
    assert!(state.stones().is_none());
    state.stone_count = u32::MAX;
    assert!(state.stones().is_none());

    let mut state = zeroed::<StateFrame>();
    (state.link_count, state.parted[1]) = (10, 1);
    let parted = state.parted().map(|links| links.collect::<Vec<_>>());
    let severed = |link: usize| link == 8;
    assert_eq!(parted, Some((0..10).map(severed).collect()));
    state.link_count = 2049;
    assert!(state.parted().is_none());

    let mut tools = zeroed::<ToolFrame>();
    assert!(
        tools.capsules().is_none(),
        "a zero quaternion is no rotation"
    );
    for pose in [
        &mut tools.world_from_handle,
        &mut tools.world_from_instrument,
        &mut tools.world_from_camera,
    ] {
        pose.orientation[3] = 1.0;
    }
    assert!(tools.capsules().is_some());
    tools.capsule_count = 99;
    assert!(tools.capsules().is_none());
    tools.dent_count = 1;
    assert!(tools.dents().is_some_and(|dents| dents.len() == 1));
    tools.dents[0].depth_m = f32::NAN;
    assert!(tools.dents().is_none());
    tools.dent_count = 65;
    assert!(tools.dents().is_none());

    let mut timing = zeroed::<TimingBatch>();
    timing.count = 65;
    assert!(timing.records().is_none());
}

/// Only the station's user can read or write the messages between the processes.
#[test]
fn shared_memory_of_a_station_is_its_users_alone() {
    use std::os::unix::fs::MetadataExt;
    let station = station("private");
    let _controller = Controller::open(&station).unwrap();
    let _host = Host::open(&station).unwrap();
    let _tap = Tap::open(&station).unwrap();
    let folder = shared_mem::service::user_folder().unwrap();
    let mode = |path: &std::path::Path| std::fs::metadata(path).map(|it| it.mode() & 0o777);
    assert_eq!(mode(&folder).unwrap() & 0o077, 0, "{}", folder.display());
    let prefix = station.file_prefix();
    let mut seen = 0;
    for entry in std::fs::read_dir("/dev/shm").unwrap().flatten() {
        // A file of the station may disappear during the check.
        let is_ours = entry.file_name().to_string_lossy().starts_with(prefix);
        if is_ours && let Ok(mode) = mode(&entry.path()) {
            assert_eq!(mode & 0o077, 0, "{:?} has mode {mode:o}", entry.path());
            seen += 1;
        }
    }
    assert!(seen >= 6, "{seen} of the services' files");
}

/// The names of a station's files can be guessed, so any user can put a link into /dev/shm under
/// such a name. The station must not change the file that the link leads to.
#[test]
fn a_link_under_a_name_of_the_station_does_not_change_its_target() {
    use std::os::unix::fs::PermissionsExt;
    let station = station("planted");
    let victim = tempfile::NamedTempFile::new().unwrap();
    let open = std::fs::Permissions::from_mode(0o644);
    victim.as_file().set_permissions(open).unwrap();
    let link = format!("/dev/shm/{}planted", station.file_prefix());
    std::os::unix::fs::symlink(victim.path(), &link).unwrap();
    let opened = Controller::open(&station).map(|_| ());
    // The first end that joins removes the link itself, not the link's target.
    assert!(!std::path::Path::new(&link).is_symlink());
    opened.unwrap();
    let mode = victim.as_file().metadata().unwrap().permissions().mode();
    assert_eq!(mode & 0o777, 0o644);
}

#[test]
fn a_recorder_that_listens_first_gets_every_batch() {
    let station = station("tap");
    let tap = Tap::open(&station).unwrap();
    let controller = Controller::open(&station).unwrap();
    for tick in 0..100 {
        let mut batch = zeroed::<InputBatch>();
        batch.count = 1;
        batch.records[0].tick = tick;
        controller.inputs.send_copy(*batch).unwrap();
    }
    let mut seen = Vec::new();
    tap.drain_inputs(|batch| seen.extend(batch.records().unwrap().iter().map(|it| it.tick)));
    assert_eq!(seen, (0..100).collect::<Vec<_>>());
}

#[test]
fn watchers_of_a_task_get_its_newest_message_whenever_they_start() {
    let station = station("task");
    let early = TaskReceiver::open(&station).unwrap();
    let mut heard = zeroed::<TaskMsg>();
    assert!(!early.newest(&mut heard), "there is no task yet");
    let sender = TaskSender::open(&station).unwrap();
    for text in ["one", "zwölf"] {
        assert!(sender.send(&TaskMsg::new(5, text).unwrap()));
    }
    assert!(early.newest(&mut heard));
    assert_eq!((heard.text(), heard.at_ns), (Some("zwölf"), 5));
    let late = TaskReceiver::open(&station).unwrap();
    let mut heard = zeroed::<TaskMsg>();
    // The sender's next message or the receiver's next call makes the connection.
    let told = late.newest(&mut heard) || {
        sender.send(&TaskMsg::new(6, "zwölf").unwrap()) && late.newest(&mut heard)
    };
    assert!(told && heard.text() == Some("zwölf"));
    drop(early);
    assert!(sender.send(&TaskMsg::new(7, "").unwrap()));
    let error = TaskSender::open(&station).unwrap_err();
    assert!(matches!(error, ServiceError::SecondTask(_)), "{error}");
}

#[test]
fn a_tasks_message_is_bounded_and_malformed_bytes_are_refused() {
    let longest = "x".repeat(TASK_TEXT);
    assert_eq!(TaskMsg::new(0, &longest).unwrap().text(), Some(&*longest));
    assert!(TaskMsg::new(0, &format!("{longest}x")).is_none());
    let good = TaskMsg::new(0, "a word").unwrap();
    for broken in [
        TaskMsg {
            length: 9000,
            ..*good
        },
        TaskMsg {
            version: TaskMsg::VERSION + 1,
            ..*good
        },
        TaskMsg {
            text: [0xff; TASK_TEXT],
            ..*good
        },
    ] {
        assert_eq!(broken.text(), None);
    }
}
