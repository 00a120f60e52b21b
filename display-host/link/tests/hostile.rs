//! Any bytes from the line are read without a panic, refused if invalid, and bounded in size.

#[path = "../fuzz/body.rs"]
mod body;
mod support;

use bytemuck::{Zeroable as _, bytes_of};
use link::wire::{ANSWER_MAX, Answer, Ask, EVENTS_MAX, Head, MAGIC, SceneHead, scene_part};
use link::{Desk, Inbox};
use proptest::prelude::*;
use shared_mem::message::{MAX_CELLS, MAX_SPHERES, StateFrame, StoneMsg};
use shared_mem::task::TaskMsg;
use support::{batch, event, state, tools};

const SERVER: u64 = 77;

fn desk(events: u64, batches: u64) -> Desk {
    let mut desk = Desk::new(SERVER);
    desk.set_state(&state(9, 5_000, [7; 16]));
    desk.set_tools(&tools(9, 5_000, [7; 16]));
    desk.set_task(&TaskMsg::new(4_000, "{\"score\": 80}").expect("it is short"));
    (0..events).for_each(|i| desk.add_event(event(i)));
    (0..batches).for_each(|i| desk.add_batch(&batch(i)));
    desk
}

fn first_ask() -> Ask {
    Inbox::default().ask()
}

#[test]
fn an_answer_of_another_version_says_so() {
    let said = Answer::read(&[0; 200]).expect_err("no magic").to_string();
    let words = "the other side sent a message of another version";
    assert!(said.starts_with(words), "{said}");
}

#[test]
fn an_answer_brings_all_that_was_put_in() {
    let mut desk = desk(10, 3);
    let ask = Ask {
        server: SERVER,
        ..first_ask()
    };
    let bytes = desk.answer(bytes_of(&ask), 1).expect("an answer");
    let answer = Answer::read(&bytes).expect("it is whole");
    let (sent, came) = (state(9, 5_000, [7; 16]), answer.state.expect("a state"));
    assert_eq!(bytes_of(&*came), bytes_of(&*sent));
    let came = answer.tools.expect("tools");
    assert_eq!(bytes_of(&*came), bytes_of(&tools(9, 5_000, [7; 16])));
    let came = answer.task.expect("a task");
    assert_eq!((came.at_ns, came.text()), (4_000, Some("{\"score\": 80}")));
    let again = Ask {
        task_at_ns: 4_000,
        ..ask
    };
    let bytes = desk.answer(bytes_of(&again), 2).expect("an answer");
    assert!(
        Answer::read(&bytes).is_ok_and(|it| it.task.is_none()),
        "the asker has this task already"
    );
    let events: Vec<_> = (0..10).map(event).collect();
    assert_eq!(answer.events, events);
    assert_eq!(answer.batches.len(), 3);
    assert_eq!(bytes_of(&answer.batches[2]), bytes_of(&batch(2)));
}

#[test]
fn a_task_that_nobody_tells_of_any_more_is_not_told() {
    let mut desk = desk(0, 0);
    let mut told = |now_ns| {
        let bytes = desk.answer(bytes_of(&first_ask()), now_ns);
        let answer = Answer::read(&bytes.expect("an answer")).expect("it is whole");
        answer.task.is_some()
    };
    assert!(told(4_000_000_000));
    assert!(!told(5_000_004_000));
}

#[test]
fn the_longest_answer_is_one_that_a_watcher_takes() {
    let mut full = StateFrame::zeroed();
    full.sphere_count = MAX_SPHERES as u32;
    full.cell_count = MAX_CELLS as u32;
    full.clip_count = 24;
    let mut desk = desk(100_000, 1000);
    desk.set_state(&full);
    let ask = Ask {
        server: SERVER,
        ..first_ask()
    };
    let bytes = desk.answer(bytes_of(&ask), 1).expect("an answer");
    assert!(bytes.len() < ANSWER_MAX, "{}", bytes.len());
    let answer = Answer::read(&bytes).expect("it is whole");
    assert_eq!(answer.events.len(), EVENTS_MAX);
    assert!(answer.head.first_event > 0, "the oldest are forgotten");
}

#[test]
fn stones_arrive_as_they_were() {
    let mut desk = desk(1, 0);
    let mut with = state(10, 6_000, [7; 16]);
    with.stone_count = 2;
    for (number, stone) in (0u32..).zip(&mut with.stones[..2]) {
        *stone = StoneMsg {
            at_m: [0.01 * number as f32, 0.2, 0.3],
            radius_m: 0.002,
            orientation: [0.0, 0.0, 0.0, 1.0],
            number,
            is_held: number,
        };
    }
    desk.set_state(&with);
    let bytes = desk.answer(bytes_of(&first_ask()), 1).expect("an answer");
    let answer = Answer::read(&bytes).expect("it is whole");
    let arrived = answer.state.expect("a state");
    assert_eq!(arrived.stones(), with.stones());
}

#[test]
fn a_garbled_state_stays_at_the_station() {
    let mut desk = desk(1, 0);
    let mut bad = state(10, 6_000, [7; 16]);
    bad.spheres[0].center_m[1] = f32::NAN;
    desk.set_state(&bad);
    let bytes = desk.answer(bytes_of(&first_ask()), 1).expect("an answer");
    let answer = Answer::read(&bytes).expect("it is whole");
    assert!(answer.state.is_none() && answer.events.len() == 1);
}

proptest! {
    #[test]
    fn any_bytes_are_survived(bytes in prop::collection::vec(any::<u8>(), 0..2000), server in any::<u64>()) {
        let _ = Answer::read(&bytes);
        let _ = scene_part(&bytes);
        let _ = Desk::new(server).answer(&bytes, 5);
    }

    /// The head is valid except for its counts.
    #[test]
    fn any_counts_are_survived(
        counts in any::<[u32; 5]>(),
        small in any::<[u8; 5]>(),
        body in prop::collection::vec(any::<u8>(), 0..4000),
    ) {
        for counts in [counts, small.map(u32::from)] {
            let [state_bytes, tools, events, batches, task_bytes] = counts;
            let head = Head {
                magic: MAGIC, state_bytes, tools, events, batches, task_bytes, ..Head::zeroed()
            };
            let mut bytes = bytes_of(&head).to_vec();
            bytes.extend(&body);
            let _ = Answer::read(&bytes);
        }
    }

    #[test]
    fn a_changed_or_cut_answer_is_refused_or_sane(
        at in any::<prop::sample::Index>(), bit in 0u8..8, cut in any::<prop::sample::Index>(),
    ) {
        let whole = desk(5, 2).answer(bytes_of(&first_ask()), 1).expect("an answer");
        let mut changed = whole.clone();
        changed[at.index(whole.len())] ^= 1 << bit;
        if let Ok(answer) = Answer::read(&changed) {
            prop_assert!(answer.state.is_none_or(|it| it.spheres().is_some() && it.cells().is_some()));
            prop_assert!(answer.tools.is_none_or(|it| it.capsules().is_some()));
            prop_assert!(answer.task.is_none_or(|it| it.text().is_some()));
            prop_assert!(answer.batches.iter().all(|it| it.records().is_some()));
        }
        let end = cut.index(whole.len());
        prop_assert!(Answer::read(&whole[..end]).is_err(), "cut at {}", end);
    }

    #[test]
    fn a_part_beyond_its_scene_is_refused(total in any::<u64>(), offset in any::<u64>(), length in 1usize..100) {
        let mut bytes = bytes_of(&SceneHead { magic: MAGIC, total, offset }).to_vec();
        bytes.resize(bytes.len() + length, 0);
        let fits = offset.checked_add(length as u64).is_some_and(|end| end <= total);
        prop_assert_eq!(scene_part(&bytes).is_ok(), fits && total <= link::wire::SCENE_MAX);
    }

    /// Answers arrive late, twice or never. Every event is returned once and in order, unless the
    /// station dropped it.
    #[test]
    fn every_event_comes_once_and_in_order(
        steps in prop::collection::vec((0u64..40, 0usize..4, any::<bool>()), 1..60),
    ) {
        let (mut desk, mut inbox) = (desk(0, 0), Inbox::default());
        let (mut made, mut seen, mut seen_batches) = (0, Vec::new(), Vec::new());
        let mut on_their_way: Vec<Vec<u8>> = Vec::new();
        let mut take = |bytes: &[u8], inbox: &mut Inbox| {
            let fresh = inbox.take(Answer::read(bytes).expect("whole"), 1, 2);
            seen.extend(fresh.events.iter().map(|it| it.sequence));
            seen_batches.extend(fresh.batches.iter().map(|it| it.sequence));
        };
        // The first exchange makes the server known.
        let first = desk.answer(bytes_of(&inbox.ask()), 1).expect("an answer");
        take(&first, &mut inbox);
        for (events, which, twice) in steps {
            for _ in 0..events {
                desk.add_event(event(made));
                desk.add_batch(&batch(made));
                made += 1;
            }
            on_their_way.push(desk.answer(bytes_of(&inbox.ask()), 1).expect("an answer"));
            if which < on_their_way.len() {
                let bytes = on_their_way.swap_remove(which);
                take(&bytes, &mut inbox);
                if twice {
                    take(&bytes, &mut inbox);
                }
            }
        }
        // From here on no answer is lost, so that every event must arrive.
        for _ in 0..200 {
            let bytes = desk.answer(bytes_of(&inbox.ask()), 1).expect("an answer");
            take(&bytes, &mut inbox);
        }
        prop_assert_eq!(inbox.events_lost, 0);
        prop_assert_eq!(seen, (0..made).collect::<Vec<_>>());
        prop_assert!(seen_batches.windows(2).all(|it| it[0] < it[1]));
        prop_assert_eq!(seen_batches.last().copied(), made.checked_sub(1));
    }
}

/// Files that the fuzzer kept, because each reached something new.
#[test]
fn the_corpus_is_read_or_refused() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/fuzz/seeds/link");
    let files = std::fs::read_dir(folder).unwrap();
    let count = files
        .map(|file| body::read(&std::fs::read(file.unwrap().path()).unwrap()))
        .count();
    assert!(count > 2, "{count} files");
}
