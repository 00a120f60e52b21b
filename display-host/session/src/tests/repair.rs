//! Sessions that break off and are closed afterwards.

use super::*;
use crate::{Repaired, repair};

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
    } = repair(&from, &to).unwrap()
    else {
        panic!("it broke off");
    };
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
fn what_cannot_be_repaired_is_refused_with_a_reason() {
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
