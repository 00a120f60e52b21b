//! Names that are one, and names that look alike.

use super::*;

#[test]
fn a_name_is_the_same_in_every_form_of_unicode() {
    assert_eq!(check_name("Ame\u{301}lie").unwrap(), "Am\u{e9}lie");
    let (_folder, path) = folder();
    let mut store = Store::open(&path).unwrap();
    store
        .add_session("Ame\u{301}lie", &session(1, "cut", 1.0))
        .unwrap();
    store
        .add_session("Am\u{e9}lie", &session(2, "cut", 1.0))
        .unwrap();
    assert_eq!(store.trainees().unwrap().len(), 1);
    assert_eq!(store.sessions("Ame\u{301}lie", None).unwrap().len(), 2);
}

#[test]
fn names_that_are_easily_confused_are_found() {
    let (_folder, path) = folder();
    let mut store = Store::open(&path).unwrap();
    for name in ["Ada", "Ian", "Jürgen Groß"] {
        store.enrol(name, None, None, 5).unwrap();
    }
    for (name, like) in [
        ("ada", Some("Ada")),
        ("\u{410}da", Some("Ada")),
        ("Ａｄａ", Some("Ada")),
        ("lan", Some("Ian")),
        ("JÜRGEN  GROSS", Some("Jürgen Groß")),
        ("Ada", None),
        ("Adam", None),
        ("Jurgen Gross", None),
    ] {
        assert_eq!(store.alike(name).unwrap().as_deref(), like, "{name}");
    }
}

#[test]
fn cohort_and_consent_are_set_one_by_one_and_the_later_telling_wins_in_a_merge() {
    let (folder, path) = folder();
    let mut store = Store::open(&path).unwrap();
    store.enrol("Ada", Some(" novice "), None, 30).unwrap();
    store.enrol("Ada", None, Some(Consent::Yes), 10).unwrap();
    let ada = store.trainees().unwrap().remove(0);
    assert_eq!((ada.cohort.as_str(), ada.consent), ("novice", Consent::Yes));
    assert!(store.enrol("Ada", Some("a\nb"), None, 40).is_err());
    let other = folder.path().join("other");
    let mut theirs = Store::open(&other).unwrap();
    theirs
        .enrol("Ada", Some("expert"), Some(Consent::No), 20)
        .unwrap();
    store.merge(&other).unwrap();
    let ada = store.trainees().unwrap().remove(0);
    assert_eq!((ada.cohort.as_str(), ada.consent), ("novice", Consent::No));
    // A cohort can be taken back, and a consent given after a refusal.
    store
        .enrol("Ada", Some(""), Some(Consent::Yes), 50)
        .unwrap();
    store.merge(&other).unwrap();
    let ada = store.trainees().unwrap().remove(0);
    assert_eq!((ada.cohort.as_str(), ada.consent), ("", Consent::Yes));
}
