//! Full disks, damaged and hostile files.

use super::*;

#[test]
fn full_disk_leaves_a_readable_file_and_loses_nothing_once_it_has_room() {
    let whole = Disk::with_room(usize::MAX);
    // The head of the file holds the scene and the descriptions; its end repeats the descriptions.
    let head = {
        let disk = Disk::with_room(usize::MAX);
        let _ = record(&disk, 0);
        disk.bytes().len()
    };
    let mut all = record(&whole, 3);
    let flushed = whole.bytes().len();
    all.finish().unwrap();
    let length = whole.bytes().len();
    let disk = Disk::with_room(head + (flushed - head) * 2 / 3);
    let mut file = record(&disk, 3);
    assert!(file.outbox.failures > 0);
    let (ticks, session) = read(disk.bytes()).unwrap();
    assert!(!ticks.is_empty() && given(3).starts_with(&ticks));
    assert_eq!(file.ticks.on_disk, ticks.len() as u64);
    assert!(matches!(session.end(), Some(End::BrokenOff(_))));
    disk.set_room(usize::MAX);
    file.finish().unwrap();
    assert_eq!(file.outbox.given_up, None);
    assert_eq!(disk.bytes().len(), length);
    let (ticks, session) = read(disk.bytes()).unwrap();
    assert!(ticks == given(3) && session.end() == Some(&End::Whole));
}

#[test]
fn a_disk_that_stays_full_is_given_up_and_memory_stays_bounded() {
    let disk = Disk::with_room(100_000);
    let mut file = record(&disk, 1);
    let mut i = 1;
    while file.outbox.given_up.is_none() {
        file.inputs(&batch(i * INPUT_BATCH as u64)).unwrap();
        if i.is_multiple_of(16) {
            file.flush().unwrap();
        }
        i += 1;
        assert!(i < 10_000, "16 MB are waiting by now");
    }
    file.finish().unwrap();
    let (ticks, _) = read(disk.bytes()).unwrap();
    assert!(given(10_000).starts_with(&ticks) && ticks.len() >= INPUT_BATCH);
}

/// Start and end of each chunk.
pub(super) fn chunks(bytes: &[u8]) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    let mut at = mcap::MAGIC.len();
    while at + 9 < bytes.len() {
        let length = u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap());
        let end = at + 9 + length as usize;
        if bytes[at] == 6 {
            found.push((at, end));
        }
        at = end;
    }
    found
}

fn why_damaged(bytes: Vec<u8>) -> String {
    match read(bytes) {
        Ok((_, session)) => match session.end() {
            Some(End::Damaged(why)) => why.clone(),
            end => panic!("{end:?}"),
        },
        Err(error) => error.to_string(),
    }
}

#[test]
fn wrong_lengths_are_damage_and_allocate_no_memory() {
    let whole = recorded();
    let (chunk, end) = chunks(&whole)[2];
    let body = chunk + 9;
    // (offset, bytes, error message)
    let lies: [(usize, &[u8], &str); 6] = [
        (chunk + 1, &[0xff; 8], "at most"),
        (chunk + 1, &1_000_000u64.to_le_bytes(), "length"),
        (chunk, &[0x86], "0x86"),
        (body + 28, &0xf000_0000u32.to_le_bytes(), "compressed"),
        (body + 32, &[0xff; 8], "length"),
        (
            body + 40 + 1,
            &10_000_000u64.to_le_bytes(),
            "exceeds its chunk",
        ),
    ];
    for (at, value, said) in lies {
        let mut bytes = whole.clone();
        bytes[body + 24..body + 28].fill(0);
        bytes[at..at + value.len()].copy_from_slice(value);
        let (ticks, _) = read(bytes.clone()).unwrap();
        assert_eq!(ticks, given(1), "{said}");
        let why = why_damaged(bytes);
        assert!(
            why.contains(said) && why.contains(&format!("byte {chunk}")),
            "{why}"
        );
    }
    // The chunk is cut although it claims to be longer.
    let (ticks, session) = read(whole[..end - 1].to_vec()).unwrap();
    assert!(ticks == given(1) && matches!(session.end(), Some(End::BrokenOff(_))));
    // An attachment shorter than its own head, which the library does not expect.
    let mut attachment = mcap::MAGIC.to_vec();
    attachment.push(9);
    attachment.extend(32u64.to_le_bytes());
    attachment.extend([0; 32]);
    assert!(why_damaged(attachment).contains("exceed it"));
}

#[test]
fn texts_of_a_file_are_shown_without_control_characters() {
    let map = Info {
        build: "\u{1b}[31mred\u{7}".to_owned() + &"x".repeat(1000),
        ..info()
    }
    .to_map();
    let read = Info::from_map(&map).unwrap().build;
    assert!(read.starts_with("[31mredxx") && read.len() == 200, "{read}");
}

#[test]
fn ticks_that_are_missing_at_the_end_are_known() {
    let finish = |ran: u32, lost: u64| {
        let disk = Disk::with_room(usize::MAX);
        let mut file = record(&disk, 2);
        let mut last = InputBatch::zeroed();
        (last.ran, last.lost) = (ran, lost);
        file.inputs(&last).unwrap();
        file.finish().unwrap();
        let (ticks, session) = read(disk.bytes()).unwrap();
        assert_eq!(ticks, given(2));
        assert_eq!(
            session.finish().map(|it| it.missing),
            Some(file.ticks.missing)
        );
        session.finish().unwrap()
    };
    let ticks = 2 * INPUT_BATCH as u64;
    let ended = |ran, missing| Finish {
        ran,
        missing,
        missing_events: 0,
    };
    assert_eq!(finish(ticks as u32, 0), ended(Some(ticks), 0));
    assert_eq!(finish(ticks as u32 + 7, 5), ended(Some(ticks + 7), 7));
    assert_eq!(finish(0, 5), ended(None, 5));
    assert_eq!(finish(0, 0), ended(None, 0));
}

#[test]
fn a_recording_is_private_even_if_it_replaces_a_public_file() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("x.mcap");
    std::fs::write(&path, "old").unwrap();
    std::fs::set_permissions(&path, Permissions::from_mode(0o644)).unwrap();
    let file = crate::create_private(&path).unwrap();
    let found = file.metadata().unwrap();
    assert_eq!(
        (found.len(), found.permissions().mode() & 0o777),
        (0, 0o600)
    );
}

fn recorded() -> Vec<u8> {
    let disk = Disk::with_room(usize::MAX);
    record(&disk, 3).finish().unwrap();
    disk.bytes()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn a_session_that_is_cut_anywhere_gives_the_flushed_ticks(share in 0.0f64..1.0) {
        let disk = Disk::with_room(usize::MAX);
        let mut flushed = Vec::new();
        let mut file = record(&disk, 0);
        for i in 0..3 {
            file.inputs(&batch(i * INPUT_BATCH as u64)).unwrap();
            file.flush().unwrap();
            flushed.push(disk.bytes().len());
        }
        file.finish().unwrap();
        let mut bytes = disk.bytes();
        let cut = (share * bytes.len() as f64) as usize;
        bytes.truncate(cut);
        let whole = flushed.iter().filter(|&&end| end <= cut).count();
        match read(bytes) {
            // One more chunk may be complete: only its index is cut.
            Ok((ticks, _)) => {
                prop_assert!(given(3).starts_with(&ticks));
                prop_assert!(ticks.len() >= whole * INPUT_BATCH);
            }
            Err(_) => prop_assert_eq!(whole, 0),
        }
    }

    /// A disk may fill up in the middle of a chunk, of the final record, or of the index.
    #[test]
    fn a_disk_that_is_full_anywhere_holds_the_reported_ticks(share in 0.0f64..1.0) {
        let room = (share * recorded().len() as f64) as usize;
        let disk = Disk::with_room(room);
        let mut file = record(&disk, 3);
        file.finish().unwrap();
        prop_assert!(file.outbox.given_up.is_some());
        prop_assert_eq!(file.outbox.written, disk.bytes().len() as u64);
        match read(disk.bytes()) {
            Ok((ticks, session)) => {
                prop_assert!(given(3).starts_with(&ticks));
                prop_assert_eq!(ticks.len() as u64, file.ticks.on_disk);
                prop_assert!(matches!(session.end(), Some(End::BrokenOff(_))));
            }
            Err(_) => prop_assert_eq!(file.ticks.on_disk, 0),
        }
    }

    #[test]
    fn a_damaged_session_gives_true_ticks_or_none(
        flips in prop::collection::vec((0.0f64..1.0, 0u8..8), 1..6),
    ) {
        let mut bytes = recorded();
        for (share, bit) in flips {
            let at = (share * bytes.len() as f64) as usize;
            bytes[at] ^= 1 << bit;
        }
        if let Ok((ticks, session)) = read(bytes) {
            prop_assert!(given(3).starts_with(&ticks));
            prop_assert!(ticks.len() == given(3).len() || session.end() != Some(&End::Whole));
        }
    }

    /// Without checksums flipped bits reach everything in a chunk: the content may be false, but
    /// nothing crashes.
    #[test]
    fn a_damaged_session_without_checksums_is_read_or_refused(
        flips in prop::collection::vec((0.0f64..1.0, any::<u8>()), 1..9),
        chunk in 0usize..3,
    ) {
        let mut bytes = recorded();
        let chunks = chunks(&bytes);
        for (at, _) in &chunks {
            bytes[at + 9 + 24..at + 9 + 28].fill(0);
        }
        let (from, to) = chunks[chunk];
        for (share, value) in flips {
            // Most changes hit the beginning of a chunk, where the lengths are.
            let at = from + (share * share * (to - from) as f64) as usize;
            bytes[at] = value;
        }
        read_course(&bytes);
        let _ = read(bytes);
    }

    #[test]
    fn any_bytes_after_the_beginning_are_read_or_refused(
        kept in 0usize..200,
        noise in prop::collection::vec(any::<u8>(), 0..2000),
    ) {
        let mut bytes = recorded();
        bytes.truncate(kept);
        bytes.extend(noise);
        read_course(&bytes);
        let _ = read(bytes);
    }
}
