//! Golden bytes. The reference library (libOpenIGTLink 1.11, Debian) packed the same contents.

use nalgebra::{Isometry3, Quaternion, Translation3, UnitQuaternion, Vector3};

use super::*;

const TRANSFORM: &str = "\
     00015452414e53464f524d000000546f6f6c546f5265666572656e63650000000000000000017fffffff0000\
     000000000030de286ffcb3409bac3f8000000000000000000000000000003f80000000000000000000000000\
     00003f80000041200000c1a0000041f00000";
const TDATA: &str = "\
     000154444154410000000000000043616c6f74000000000000000000000000000000000000017fffffff0000\
     000000000046d1a328bac7f941de546f6f6c546f5265666572656e6365000000000002003f80000000000000\
     00000000000000003f8000000000000000000000000000003f80000041200000c1a0000041f00000";
const SENSOR: &str = "\
     000153454e534f52000000000000466f726365000000000000000000000000000000000000017fffffff0000\
     000000000022af5f98ed6005a0c9030002c40000000000003fe0000000000000bff000000000000040000000\
     00000000";
const STRING: &str = "\
     0001535452494e47000000000000496e737472756d656e7400000000000000000000000000017fffffff0000\
     00000000000b6eec85f7e26dd3ea0003000767726173706572";
const STATUS: &str = "\
     000153544154555300000000000043616c6f74000000000000000000000000000000000000017fffffff0000\
     000000000022a385a166d5b5815600130000000000000000656e646564000000000000000000000000000000\
     62796500";
const CAPABILITY: &str = "\
     00014341504142494c495459000043616c6f74000000000000000000000000000000000000017fffffff0000\
     000000000018e3cb8f3c1cbaff275452414e53464f524d0000004745545f5354415455530000";
const RTS_TDATA: &str = "\
     00015254535f544441544100000043616c6f74000000000000000000000000000000000000017fffffff0000\
     00000000000142f0e1eba9ea369301";
const QTDATA: &str = "\
     000151544441544100000000000043616c6f74000000000000000000000000000000000000017fffffff0000\
     000000000032a3fcd9ec0d7263bb546f6f6c00000000000000000000000000000000020041200000c1a00000\
     41f0000000000000000000003f19999a3f4ccccd";
const RTS_QTDATA: &str = "\
     00015254535f515444415441000043616c6f74000000000000000000000000000000000000017fffffff0000\
     000000000001000000000000000000";
const POLYDATA: &str = "\
     0001504f4c5944415441000000006c69766572000000000000000000000000000000000000017fffffff0000\
     00000000006c945a468fe7555615000000030000000000000000000000000000000000000002000000200000\
     0000000000000000000041200000c1a0000041f0000041300000c1a0000041f0000041200000c1a000004202\
     00000000000300000000000000010000000200000003000000000000000200000001";

/// Time of all golden messages. The library's clock cuts 2⁻³² s off it.
const UNIX_NS: u64 = 1_500_000_000;
const STAMP: std::ops::Range<usize> = 34..42;

#[track_caller]
fn is_golden(message: &Message, golden: &str) {
    let mut bytes = message.bytes(Version::One);
    assert_eq!(bytes[STAMP], [0, 0, 0, 1, 0x80, 0, 0, 0]);
    bytes[STAMP].copy_from_slice(&[0, 0, 0, 1, 0x7F, 0xFF, 0xFF, 0xFF]);
    let digits: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
    assert_eq!(digits, golden);
}

fn pose() -> Isometry3<f32> {
    Translation3::new(0.01, -0.02, 0.03).into()
}

#[test]
fn every_message_is_packed_as_the_reference_library_packs_it() {
    let transform = Message::transform("ToolToReference", &pose(), UNIX_NS).unwrap();
    is_golden(&transform, TRANSFORM);
    let tools = [("ToolToReference", pose())];
    let tracking = Message::tracking("Calot", &tools, UNIX_NS).unwrap();
    is_golden(&tracking, TDATA);
    let force = Message::sensor("Force", &[0.5, -1.0, 2.0], Unit::Newton, UNIX_NS).unwrap();
    is_golden(&force, SENSOR);
    is_golden(&Message::string("Instrument", "grasper", UNIX_NS), STRING);
    let status = Message::status("Calot", Code::ShutDown, "ended", "bye", UNIX_NS);
    is_golden(&status, STATUS);
    let kinds = ["TRANSFORM", "GET_STATUS"];
    is_golden(&Message::capability("Calot", &kinds, UNIX_NS), CAPABILITY);
    let refused = Message::tracking_reply("RTS_TDATA", "Calot", false, UNIX_NS);
    is_golden(&refused, RTS_TDATA);
    let turn = UnitQuaternion::new_unchecked(Quaternion::new(0.8, 0.0, 0.0, 0.6));
    let turned = [("Tool", Isometry3::from_parts(pose().translation, turn))];
    let tracking = Message::quaternions("Calot", &turned, UNIX_NS).unwrap();
    is_golden(&tracking, QTDATA);
    let begun = Message::tracking_reply("RTS_QTDATA", "Calot", true, UNIX_NS);
    is_golden(&begun, RTS_QTDATA);
    let points_m = [
        [0.01, -0.02, 0.03],
        [0.011, -0.02, 0.03],
        [0.01, -0.02, 0.0325],
    ];
    let both_sides = [[0, 1, 2], [0, 2, 1]];
    let surface = Message::polydata("liver", &points_m, &both_sides, UNIX_NS);
    is_golden(&surface, POLYDATA);
}

#[test]
fn a_rotation_is_packed_column_by_column() {
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), 0.5);
    let content = Message::transform("x", &(pose() * turn), 0)
        .unwrap()
        .content;
    let number = |index: usize| {
        let bytes = content[4 * index..].first_chunk::<4>().unwrap();
        f32::from_be_bytes(*bytes)
    };
    assert!((number(0) - 0.5f32.cos()).abs() < 1e-6, "R11");
    assert!((number(1) - 0.5f32.sin()).abs() < 1e-6, "R21 follows R11");
    for (index, mm) in [(9, 10.0), (10, -20.0), (11, 30.0)] {
        assert!((number(index) - mm).abs() < 1e-5);
    }
}

#[test]
fn numbers_that_are_not_finite_are_not_sent() {
    let nowhere: Isometry3<f32> = Translation3::new(f32::NAN, 0.0, 0.0).into();
    assert_eq!(Message::transform("x", &nowhere, 0), None);
    assert_eq!(Message::tracking("x", &[("y", nowhere)], 0), None);
    assert_eq!(Message::quaternions("x", &[("y", nowhere)], 0), None);
    assert_eq!(Message::sensor("x", &[f32::INFINITY], Unit::One, 0), None);
    assert_eq!(Message::sensor("x", &[0.0; 256], Unit::One, 0), None);
}

#[test]
fn text_outside_of_ascii_becomes_question_marks() {
    let content = Message::string("x", "gallengängig", 0).content;
    assert_eq!(&content[4..], b"galleng?ngig");
}
