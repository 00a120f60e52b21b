//! Scoring sheets and their raters.

use super::*;

#[test]
fn built_in_sheets_have_their_scales_and_anchors() {
    let all = Sheet::built_in();
    let of = |it: &Sheet| (it.name.clone(), it.items.len(), it.least, it.most);
    let wanted = [("goals", 5, 1, 5), ("osats", 7, 1, 5), ("cvs", 3, 0, 2)];
    let wanted = wanted.map(|(name, items, least, most)| (name.to_owned(), items, least, most));
    assert_eq!(all.iter().map(of).collect::<Vec<_>>(), wanted);
    for item in all.iter().flat_map(|it| &it.items) {
        assert_eq!(item.anchors.len(), 3, "{}", item.id);
    }
    let goals = all[0].items.iter().map(|it| (it.id.as_str(), &*it.text));
    assert_eq!(goals.collect::<Vec<_>>(), GOALS);
    assert_eq!((all[1].total(), all[2].total()), (35, 6));
}

#[test]
fn several_raters_score_a_session_each_once() {
    let (_folder, path) = folder();
    let mut store = Store::open(&path).unwrap();
    let it = session(1, "cut", 1.0);
    store.add_session("Ada", &it).unwrap();
    let [goals, cvs] = ["goals", "cvs"].map(|it| Sheet::named(it).unwrap());
    store.set_sheet(&it.id, "", [1, 2, 3, 4, 5]).unwrap();
    store.rate(&it.id, &goals, ("R", true), &[2; 5]).unwrap();
    let again = store.rate(&it.id, &goals, (" R ", false), &[4; 5]);
    let again = again.unwrap_err().to_string();
    for part in ["rater 'R'", "'goals'", &it.id, "--replace"] {
        assert!(again.contains(part), "{again}");
    }
    let old = store.ratings(&it.id).unwrap().remove(1);
    assert!(old.blinded && old.sum() == 10, "{old:?}");
    let replaced = store.rate_again(&it.id, &goals, ("R", false), &[4; 5]);
    assert_eq!(replaced.unwrap(), Some(old));
    let unnamed = store.rate(&it.id, &goals, ("", false), &[4; 5]);
    let unnamed = unnamed.unwrap_err().to_string();
    assert!(unnamed.contains("a rater without a name"), "{unnamed}");
    let first = store.rate_again(&it.id, &cvs, ("R", true), &[0, 1, 2]);
    assert_eq!(first.unwrap(), None);
    let ratings = store.ratings(&it.id).unwrap();
    let of = |it: &Rating| (it.sheet.clone(), it.rater.clone(), it.blinded, it.sum());
    let wanted = [
        ("goals", "", false, 15),
        ("goals", "R", false, 20),
        ("cvs", "R", true, 3),
    ];
    let wanted =
        wanted.map(|(sheet, rater, it, sum)| (sheet.to_owned(), rater.to_owned(), it, sum));
    assert_eq!(ratings.iter().map(of).collect::<Vec<_>>(), wanted);
    assert_eq!(store.sheet(&it.id).unwrap()[0].1, 4, "the last");
    for (points, why) in [
        (&[1, 2][..], "the number of points"),
        (&[0, 3, 0], "allowed is 0 to 2"),
    ] {
        let rated = store.rate_again(&it.id, &cvs, ("R", true), points);
        let error = rated.unwrap_err();
        assert!(error.to_string().contains(why), "{error}");
    }
    assert!(
        store
            .rate(&it.id, &cvs, ("\u{202e}", true), &[0; 3])
            .is_err()
    );
    assert!(store.ratings("none").is_err());
}

#[test]
fn sheets_in_files_are_checked() {
    let item = "[[item]]\nid = 'a'\ntext = 'b'\nanchors = { 2 = 'c' }\n";
    let good = format!("name = 'x'\ntitle = 'y'\nleast = 0\nmost = 3\n{item}");
    assert!(Sheet::parse(&good).unwrap().has(3));
    for (bad, why) in [
        (format!("{good}{item}"), "two items"),
        (good.replace("2 =", "4 ="), "anchor at '4'"),
        (good.replace("most = 3", "most = 0"), "from 0 to 0"),
        (good.replace("most = 3", "most = 101"), "0 to 100"),
        (good.replace("'b'", "''"), "0 characters"),
        (good.replace("title", "titel"), "titel"),
    ] {
        let error = Sheet::parse(&bad).unwrap_err();
        assert!(matches!(error, StoreError::Sheet(_)), "{error}");
        assert!(error.to_string().contains(why), "{error}");
    }
    let error = Sheet::named("/nowhere/a.toml").unwrap_err().to_string();
    assert!(error.contains("/nowhere/a.toml") && error.contains("osats"));
}

#[test]
fn raters_whose_names_are_easily_confused_are_found() {
    let (_folder, path) = folder();
    let mut store = Store::open(&path).unwrap();
    let it = session(1, "cut", 1.0);
    store.add_session("Ada", &it).unwrap();
    let goals = Sheet::named("goals").unwrap();
    for rater in ["", "Bo", "Am\u{e9}lie"] {
        store.rate(&it.id, &goals, (rater, false), &[3; 5]).unwrap();
    }
    for (rater, like) in [
        ("bo", Some("Bo")),
        (" BO ", Some("Bo")),
        ("B\u{43e}", Some("Bo")),
        ("b\u{43e}", Some("Bo")),
        ("Bo", None),
        ("Ame\u{301}lie", None),
        ("Ada", None),
        ("", None),
    ] {
        let found = store.alike_rater(rater).unwrap();
        assert_eq!(found.as_deref(), like, "{rater}");
    }
    assert!(store.alike_rater("\u{202e}").is_err());
}
