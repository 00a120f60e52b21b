//! Runs the fuzz target's body on bytes from proptest: random ones, and damaged messages of
//! devices.

use hardware::hapi::wire::{ID, answer};
use hardware::rig::frame::Frame;
use hardware::woody::wire::{Encoders, Model};
use proptest::prelude::*;

#[path = "../../fuzz/body.rs"]
mod body;

/// A piece for the fuzz target's body: its bytes, and two bits that state the time after the piece
/// and whether the device then reports.
fn piece(bytes: &[u8], passes: u8) -> Vec<u8> {
    let bytes = &bytes[..bytes.len().min(63)];
    let mut piece = vec![(bytes.len() as u8) << 2 | passes & 3];
    piece.extend_from_slice(bytes);
    piece
}

/// Bytes that a device might send.
fn said() -> impl Strategy<Value = Vec<u8>> {
    let encoders =
        (prop::array::uniform6(-20_000..20_000i32), 0..2000i32).prop_map(|(counts, error)| {
            let model = Model::Woody;
            Encoders {
                model,
                counts,
                error,
            }
            .line()
            .as_bytes()
            .to_vec()
        });
    let framed =
        (0x81u8..0x84, prop::collection::vec(any::<u8>(), 42)).prop_map(|(kind, mut body)| {
            body.insert(0, kind);
            Frame::new(&body).expect("short").as_bytes().to_vec()
        });
    prop_oneof![
        prop::collection::vec(prop_oneof![Just(ID), Just(0), any::<u8>()], 0..63),
        prop::array::uniform2(-400.0..400.0f32).prop_map(|angles| answer(angles).to_vec()),
        encoders,
        framed,
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(96) })]

    #[test]
    fn a_station_keeps_its_force_limit_on_any_bytes(
        device in 0u8..3,
        pieces in prop::collection::vec((said(), any::<u8>(), 0usize..64, any::<bool>()), 0..24),
    ) {
        let mut bytes = vec![device];
        for (mut said, passes, cut, is_cut) in pieces {
            if is_cut && cut < said.len() {
                said.remove(cut);
            }
            bytes.extend_from_slice(&piece(&said, passes));
        }
        body::run(&bytes);
    }

    #[test]
    fn a_station_keeps_its_force_limit_on_random_bytes(bytes in prop::collection::vec(any::<u8>(), 0..600)) {
        body::run(&bytes);
    }
}

/// Files that the fuzzer kept, because each of them reached new code.
#[test]
fn the_corpus_is_read_or_refused() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/fuzz/seeds/line");
    let files = std::fs::read_dir(folder).unwrap();
    let count = files
        .map(|file| body::run(&std::fs::read(file.unwrap().path()).unwrap()))
        .count();
    assert!(count > 5, "{count} files");
}
