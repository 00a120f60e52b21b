//! Sessions that the fuzzer kept.
#![allow(clippy::unwrap_used)]

#[path = "../fuzz/body.rs"]
mod body;

/// Files that the fuzzer kept, because each reached new code.
#[test]
fn the_corpus_is_read_or_refused() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/fuzz/seeds/session");
    let files = std::fs::read_dir(folder).unwrap();
    let count = files
        .map(|file| body::read(&std::fs::read(file.unwrap().path()).unwrap()))
        .count();
    assert!(count > 2, "{count} files");
}
