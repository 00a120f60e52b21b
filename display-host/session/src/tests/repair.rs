//! Sessions that break off and are closed afterwards.

use super::*;
use crate::{Lost, Repaired};

fn repair(from: &Path, to: &Path) -> Result<Repaired, ReadError> {
    crate::repair(from, to, None)
}

/// A session of five chunks, the places of its chunks, and where each holds messages.
fn five() -> (Vec<u8>, Vec<(usize, usize)>) {
    let disk = Disk::with_room(usize::MAX);
    record(&disk, 5).finish().unwrap();
    let whole = disk.bytes();
    // The first chunk holds the descriptions only.
    let chunks = damage::chunks(&whole).split_off(1);
    assert_eq!(chunks.len(), 5);
    (whole, chunks)
}

/// The repaired session, and what it lost.
fn repaired(bytes: &[u8], scene: Option<&SceneFile>) -> (Vec<u8>, Lost, String) {
    let (_folder, from, to) = in_file(bytes);
    let Repaired::Closed {
        messages,
        why,
        lost,
        ..
    } = crate::repair(&from, &to, scene).unwrap()
    else {
        panic!("it is damaged");
    };
    let repaired = std::fs::read(&to).unwrap();
    let summary = mcap::Summary::read(&repaired).unwrap().unwrap();
    assert_eq!(summary.stats.unwrap().message_count, messages);
    let all = mcap::MessageStream::new(&repaired).unwrap();
    assert_eq!(all.map(Result::unwrap).count() as u64, messages);
    assert_eq!(crate::repair(&to, &from, None).unwrap(), Repaired::Whole);
    (repaired, lost, why)
}

/// Messages of each topic.
fn topics(bytes: &[u8]) -> std::collections::BTreeMap<String, u64> {
    let mut topics = std::collections::BTreeMap::new();
    for message in mcap::MessageStream::new(bytes).unwrap() {
        *topics
            .entry(message.unwrap().channel.topic.clone())
            .or_default() += 1;
    }
    topics
}

/// The given ticks without those of one batch.
fn without(batch: usize) -> Vec<InputRecord> {
    let mut ticks = given(5);
    ticks.drain(batch * INPUT_BATCH..(batch + 1) * INPUT_BATCH);
    ticks
}

#[test]
fn records_behind_a_damaged_chunk_are_kept() {
    let (whole, chunks) = five();
    let (from, to) = chunks[2];
    let mut flipped = whole.clone();
    flipped[(from + to) / 2] ^= 4;
    let mut wiped = whole.clone();
    wiped[from..from + 64].fill(0);
    let mut long = whole.clone();
    long[from + 3] = 0x10;
    for (damaged, said) in [(flipped, "CRC"), (wiped, "0x00"), (long, "length")] {
        let (repaired, lost, why) = repaired(&damaged, None);
        assert!(
            why.contains(&format!("at byte {from}")) && why.contains(said),
            "{why}"
        );
        let (ticks, session) = read(repaired.clone()).unwrap();
        assert!(ticks == without(2));
        let Some(End::Lost(what)) = session.end() else {
            panic!("{:?}", session.end());
        };
        assert!(
            what.contains(&format!("lost {} messages", lost.messages)),
            "{what}"
        );
        let (before, after) = (topics(&whole), topics(&repaired));
        for (topic, count) in &before {
            let missing = lost.topics.get(topic).copied().unwrap_or(0);
            assert_eq!(after[topic] + missing, *count, "{topic}");
        }
        assert_eq!(lost.messages, lost.topics.values().sum::<u64>());
        assert!(lost.topics["/inputs"] > 0 && !lost.scene, "{lost:?}");
        let [[begin, end]] = lost.spans_ns[..] else {
            panic!("one span: {lost:?}");
        };
        let tick_ns = 1_000_000;
        assert!(begin <= 2 * INPUT_BATCH as u64 * tick_ns, "{begin}");
        assert_eq!(end, 3 * INPUT_BATCH as u64 * tick_ns);
    }
}

#[test]
fn the_first_second_may_be_the_damaged_one() {
    let (whole, chunks) = five();
    let mut damaged = whole;
    damaged[chunks[0].0 + 100] ^= 1;
    let (repaired, lost, _) = repaired(&damaged, None);
    assert_eq!(lost.topics["/setup"], 1);
    let batch_ns = INPUT_BATCH as u64 * 1_000_000;
    assert_eq!(lost.spans_ns, [[0, batch_ns]]);
    // Without the setup the session cannot be replayed; viewers open it.
    let error = read(repaired).unwrap_err().to_string();
    assert!(error.contains("precedes its setup"), "{error}");
}

#[test]
fn without_an_index_the_numbers_of_messages_tell_what_is_lost() {
    let disk = Disk::with_room(usize::MAX);
    let _ = record(&disk, 5);
    let cut = disk.bytes();
    let (from, to) = damage::chunks(&cut)[3];
    let count = |bytes: &[u8]| topics(bytes).values().sum::<u64>();
    let whole = repaired(&cut, None).0;
    for wipes_head in [false, true] {
        let mut damaged = cut.clone();
        let at = if wipes_head { from } else { (from + to) / 2 };
        damaged[at..at + 40].fill(0xaa);
        let (repaired, lost, _) = repaired(&damaged, None);
        assert_eq!(lost.messages, count(&whole) - count(&repaired));
        // The damaged chunk's own index names its topics, if it can be found.
        assert_eq!(lost.topics.is_empty(), wipes_head, "{lost:?}");
        let (ticks, session) = read(repaired).unwrap();
        assert!(ticks == without(2));
        let Some(End::BrokenOff(why)) = session.end() else {
            panic!("{:?}", session.end());
        };
        assert!(
            why.contains("lost") && why.contains("the file ends"),
            "{why}"
        );
    }
}

#[test]
fn the_last_chunk_may_be_the_damaged_one() {
    let (whole, chunks) = five();
    let (from, _) = chunks[4];
    let mut damaged = whole.clone();
    // All up to the record that ends the data goes.
    let footer = whole.len() - mcap::MAGIC.len() - 20;
    let index = u64::from_le_bytes(whole[footer..footer + 8].try_into().unwrap()) as usize;
    damaged[from..index - 13].fill(0);
    let (repaired, lost, _) = repaired(&damaged, None);
    assert!(
        lost.topics["/inputs"] > 0 && lost.spans_ns.len() == 1,
        "{lost:?}"
    );
    let (ticks, _) = read(repaired).unwrap();
    assert!(ticks == without(4));
}

#[test]
fn messages_that_nothing_counts_are_lost_in_an_unknown_number() {
    let (mut damaged, chunks) = five();
    let (_, to) = chunks[4];
    let index = to + 498;
    damaged[to - 193..to + 1].fill(8);
    damaged[index] = 0;
    let (repaired, lost, _) = repaired(&damaged, None);
    assert!(lost.is_more && lost.messages == 0, "{lost:?}");
    assert!(!lost.is_nothing());
    let (ticks, session) = read(repaired).unwrap();
    assert!(ticks == without(4));
    let Some(End::Lost(why)) = session.end() else {
        panic!("{:?}", session.end());
    };
    assert!(why.contains("an unknown number of messages"), "{why}");
}

#[test]
fn descriptions_of_channels_come_from_the_index_if_their_chunk_is_damaged() {
    let (whole, _) = five();
    let (from, to) = damage::chunks(&whole)[0];
    let mut damaged = whole.clone();
    damaged[(from + to) / 2] ^= 1;
    let (repaired, lost, why) = repaired(&damaged, None);
    assert_eq!(lost.messages, 0);
    assert!(why.ends_with("nothing of the data is lost"), "{why}");
    let (ticks, session) = read(repaired.clone()).unwrap();
    assert_eq!((ticks, session.end()), (given(5), Some(&End::Whole)));
    assert_eq!(topics(&repaired), topics(&whole));
}

#[test]
fn a_damaged_scene_is_left_out_or_replaced() {
    let (whole, _) = five();
    let at = mcap::Summary::read(&whole).unwrap().unwrap();
    let at = at.attachment_indexes[0].offset as usize + 200;
    let mut damaged = whole;
    damaged[at] ^= 1;
    let (without, lost, _) = repaired(&damaged, None);
    assert!(lost.scene && lost.messages == 0, "{lost:?}");
    let (ticks, session) = read(without).unwrap();
    assert!(ticks == given(5) && session.scene.is_none());
    assert!(matches!(session.end(), Some(End::Lost(what)) if what.contains("compiled scene")));
    let (with, lost, _) = repaired(&damaged, Some(&scene()));
    assert!(lost.is_nothing(), "{lost:?}");
    let (ticks, session) = read(with).unwrap();
    assert!(ticks == given(5) && session.scene.as_deref() == Some(scene().bytes()));
    assert_eq!(session.end(), Some(&End::Whole));
    // Another scene is refused.
    let other = scene_of(0.02);
    let (_folder, from, to) = in_file(&damaged);
    let error = crate::repair(&from, &to, Some(&other)).unwrap_err();
    assert!(matches!(error, ReadError::OtherScene { .. }), "{error}");
    let said = error.to_string();
    assert!(said.contains(&crate::hex(other.short_id())), "{said}");
    assert!(!to.exists());
}

/// A session in a file, and the path of its repaired copy.
fn in_file(bytes: &[u8]) -> (tempfile::TempDir, std::path::PathBuf, std::path::PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let (from, to) = (folder.path().join("a.mcap"), folder.path().join("b.mcap"));
    std::fs::write(&from, bytes).unwrap();
    (folder, from, to)
}

fn unfinished() -> Vec<u8> {
    let disk = Disk::with_room(usize::MAX);
    let _ = record(&disk, 3);
    disk.bytes()
}

#[test]
fn a_repaired_session_opens_elsewhere_and_says_where_it_broke_off() {
    let cut = unfinished();
    let cut = &cut[..cut.len() - 40];
    assert!(mcap::Summary::read(cut).is_err());
    let (_folder, from, to) = in_file(cut);
    let Repaired::Closed {
        messages,
        why,
        left_out_bytes,
        lost,
    } = repair(&from, &to).unwrap()
    else {
        panic!("it broke off");
    };
    assert_eq!(lost, Lost::default());
    assert!(
        left_out_bytes > 0 && why.contains("the file ends at byte"),
        "{why}"
    );
    assert_eq!(std::fs::read(&from).unwrap(), cut, "the original stays");
    let repaired = std::fs::read(&to).unwrap();
    let summary = mcap::Summary::read(&repaired).unwrap().unwrap();
    assert_eq!(summary.stats.unwrap().message_count, messages);
    let all = mcap::MessageStream::new(&repaired).unwrap();
    assert_eq!(all.map(Result::unwrap).count() as u64, messages);
    let (before, session) = read(cut.to_vec()).unwrap();
    let whole = session.end().unwrap().clone();
    let (after, session) = read(repaired).unwrap();
    assert_eq!(after, before);
    let (End::BrokenOff(before), Some(End::BrokenOff(after))) = (whole, session.end()) else {
        panic!("both break off");
    };
    assert!(after.ends_with(&before), "{before}; {after}");
    // A second repair has nothing to do.
    let again = to.with_file_name("c.mcap");
    assert_eq!(repair(&to, &again).unwrap(), Repaired::Whole);
    assert!(!again.exists());
}

#[test]
fn a_session_without_an_index_loses_nothing() {
    let cut = unfinished();
    let (_folder, from, to) = in_file(&cut);
    repair(&from, &to).unwrap();
    let (ticks, _) = read(std::fs::read(&to).unwrap()).unwrap();
    assert_eq!(ticks, given(3));
}

#[test]
fn a_missing_or_damaged_index_is_made_again() {
    let disk = Disk::with_room(usize::MAX);
    record(&disk, 3).finish().unwrap();
    let whole = disk.bytes();
    let is_open = |bytes: &[u8]| mcap::Summary::read(bytes).is_ok_and(|it| it.is_some());
    assert!(is_open(&whole));
    let mut flipped = whole.clone();
    let at = flipped.len() - 60;
    flipped[at] ^= 1;
    for damaged in [
        &whole[..whole.len() - 1],
        &whole[..whole.len() - 8],
        &whole[..whole.len() - 40],
        &flipped[..],
    ] {
        assert!(!is_open(damaged));
        let (_folder, from, to) = in_file(damaged);
        let repaired = repair(&from, &to).unwrap();
        let Repaired::Closed {
            why,
            left_out_bytes,
            ..
        } = repaired
        else {
            panic!("its index is damaged");
        };
        assert!(why.contains("index") && left_out_bytes == 0, "{why}");
        let repaired = std::fs::read(&to).unwrap();
        assert!(is_open(&repaired));
        let (ticks, session) = read(repaired).unwrap();
        assert_eq!((ticks, session.end()), (given(3), Some(&End::Whole)));
    }
    let (_folder, from, to) = in_file(&whole);
    assert_eq!(repair(&from, &to).unwrap(), Repaired::Whole);
}

#[test]
fn a_session_of_which_nothing_is_left_is_refused_and_leaves_no_file() {
    let (_folder, from, to) = in_file(&unfinished()[..60]);
    let error = repair(&from, &to).unwrap_err();
    assert!(matches!(error, ReadError::NotASession { .. }), "{error}");
    assert!(!to.exists());
}

#[test]
fn a_file_that_cannot_be_repaired_is_refused_with_a_reason() {
    let (_folder, from, to) = in_file(b"something else");
    let error = repair(&from, &to).unwrap_err();
    assert!(matches!(error, ReadError::NotASession { .. }), "{error}");
    assert!(!to.exists());
    std::fs::write(&from, unfinished()).unwrap();
    let nowhere = to.join("b.mcap");
    let error = repair(&from, &nowhere).unwrap_err();
    assert!(matches!(error, ReadError::Write { .. }), "{error}");
    let held = std::fs::File::options().write(true).open(&from).unwrap();
    held.try_lock().unwrap();
    let error = repair(&from, &to).unwrap_err();
    assert!(error.to_string().contains("is being recorded"), "{error}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    /// Whatever is damaged, the repaired session holds true ticks only, and misses none silently.
    #[test]
    fn a_repaired_session_is_true_and_says_what_it_lacks(
        wounds in prop::collection::vec((0.0f64..1.0, 1usize..300, any::<u8>()), 1..4),
    ) {
        let (mut bytes, _) = five();
        for (share, length, value) in wounds {
            let at = (share * bytes.len() as f64) as usize;
            let end = (at + length).min(bytes.len());
            bytes[at..end].fill(value);
        }
        let (_folder, from, to) = in_file(&bytes);
        let Ok(Repaired::Closed { lost, .. }) = repair(&from, &to) else {
            return Ok(());
        };
        let Ok((ticks, session)) = read(std::fs::read(&to).unwrap()) else {
            return Ok(());
        };
        let all = given(5);
        prop_assert!(ticks.iter().all(|it| all.contains(it)));
        if ticks.len() < all.len() {
            prop_assert!(session.end() != Some(&End::Whole), "{lost:?}");
        }
    }
}
