//! Reading a store changes nothing, and tables keep their numbers.

use super::*;

#[test]
fn reading_makes_no_file_and_needs_no_right_to_write() {
    let (folder, path) = folder();
    let missing = Store::read(&path).unwrap_err();
    assert!(matches!(missing, StoreError::Missing { .. }), "{missing}");
    assert!(missing.to_string().contains("this command makes none"));
    assert!(std::fs::read_dir(folder.path()).unwrap().next().is_none());

    let mut store = Store::open(&path).unwrap();
    store.add_session("Ada", &session(1, "cut", 1.0)).unwrap();
    drop(store);
    let private = std::fs::Permissions::from_mode(0o444);
    std::fs::set_permissions(&path, private).unwrap();
    let beside = || std::fs::read_dir(path.parent().unwrap()).unwrap().count();
    let before = (std::fs::read(&path).unwrap(), beside());
    let mut store = Store::read(&path).unwrap();
    assert_eq!(store.sessions("Ada", None).unwrap().len(), 1);
    store.export_json(None).unwrap();
    store.export_csv(None, &[]).unwrap();
    store.summarise(&Questionnaire::default()).unwrap();
    // Writing through it fails, even as a user who may write everywhere.
    assert!(store.add_session("Bo", &session(2, "cut", 1.0)).is_err());
    assert_eq!((std::fs::read(&path).unwrap(), beside()), before);
    assert_eq!(mode(&path), 0o444);
}

#[test]
fn a_store_that_is_being_made_is_missing_and_never_foreign() {
    for _ in 0..20 {
        let (_folder, path) = folder();
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, "").unwrap();
        let empty = Store::read(&path).unwrap_err();
        assert!(matches!(empty, StoreError::Missing { .. }), "{empty}");
        let making = std::thread::spawn({
            let path = path.clone();
            move || Store::open(&path).map(drop)
        });
        while let Err(error) = Store::read(&path) {
            assert!(matches!(error, StoreError::Missing { .. }), "{error}");
        }
        making.join().unwrap().unwrap();
    }
}

#[test]
fn a_number_is_the_same_in_every_export() {
    let (_folder, path) = folder();
    let mut store = Store::open(&path).unwrap();
    let mut it = session(1, "cut", 1.0);
    // serde_json without `float_roundtrip` reads this one lower in its last bit.
    let number = 13.591_027_285_000_017_f64;
    it.metrics.insert("path_m".to_owned(), number);
    store.add_session("Ada", &it).unwrap();
    let found = store.sessions("Ada", None).unwrap();
    assert_eq!(found[0].metrics["path_m"].to_bits(), number.to_bits());
    let csv = store.export_csv(None, &["path_m"]).unwrap();
    assert!(csv.contains(",13.591027285000017,"), "{csv}");
    let json = store.export_json(None).unwrap().to_string();
    assert!(json.contains("13.591027285000017"), "{json}");
}

#[test]
fn a_table_has_the_same_columns_whoever_is_in_it() {
    let (_folder, path) = folder();
    let mut store = Store::open(&path).unwrap();
    let metrics = ["time_s", "clip_spacing_mm"];
    let head = |store: &Store| {
        let csv = store.export_csv(None, &metrics).unwrap();
        csv.lines().next().unwrap().to_owned()
    };
    let empty = head(&store);
    let mut it = session(1, "cut", 0.5);
    it.metrics.insert("of_another_version".to_owned(), -2.0);
    it.circumstances = Circumstances {
        realtime: Some(false),
        missed_ticks: Some(7),
        device: "Rig".to_owned(),
        driver: "rig".to_owned(),
        site: "theatre".to_owned(),
    };
    store.add_session("Ada", &it).unwrap();
    store.enrol("Ada", Some("novice"), None, 5).unwrap();
    for (rater, points) in [("R", [1; 5]), ("S", [2; 5])] {
        let goals = Sheet::named("goals").unwrap();
        store.rate(&it.id, &goals, (rater, true), &points).unwrap();
    }
    assert_eq!(head(&store), empty);
    let csv = store.export_csv(None, &metrics).unwrap();
    let row = csv.lines().nth(1).unwrap();
    let wanted = format!(
        "Ada,novice,unknown,{},1,cut,exam,passed,0.5,1,1,triangle,person,0,7,Rig,rig,theatre,a test,\
         monday/session.mcap,7.5,2,1.5,1.5,1.5,1.5,1.5,12.5,,\"{{\"\"of_another_version\"\":-2.0}}\"",
        it.id
    );
    assert_eq!(row, wanted);
    assert_eq!(row.split(',').count(), empty.split(',').count());
    store
        .answer("Ada", &Questionnaire::default(), &[3; 14], 9)
        .unwrap();
    let answers = store.export_answers_csv(Some("Ada")).unwrap();
    assert!(answers.contains("\nAda,novice,unknown,face-validity,anatomy,3,9\n"));
    let sheets = store.export_sheets_csv(None).unwrap();
    let of_s = format!("\nAda,novice,unknown,{},goals,S,1,tissue,2\n", it.id);
    assert!(sheets.contains(&of_s), "{sheets}");
}

#[test]
fn a_site_is_that_of_the_store_when_a_session_is_kept() {
    let (folder, path) = folder();
    let mut store = Store::open(&path).unwrap();
    store.add_session("Ada", &session(1, "cut", 1.0)).unwrap();
    assert!(store.set_site("\u{1b}[0m").is_err());
    store.set_site("Theatre 1").unwrap();
    store.add_session("Ada", &session(2, "cut", 1.0)).unwrap();
    let sites = |store: &Store| {
        let all = store.sessions("Ada", None).unwrap();
        let all = all.into_iter().map(|it| it.circumstances.site);
        all.collect::<Vec<_>>()
    };
    assert_eq!(sites(&store), ["", "Theatre 1"]);
    // In the centre, the first session is of that site, too.
    let mut centre = Store::open(&folder.path().join("centre")).unwrap();
    centre.merge(&path).unwrap();
    assert_eq!(sites(&centre), ["Theatre 1", "Theatre 1"]);
    assert_eq!(centre.merge(&path).unwrap().differing, 0);
    // One that was merged before its store had a site gets it, and is still the same.
    let bare = folder.path().join("bare");
    let mut early = Store::open(&bare).unwrap();
    let it = session(3, "cut", 1.0);
    early.add_session("Ada", &it).unwrap();
    centre.merge(&bare).unwrap();
    early.set_site("Theatre 2").unwrap();
    let merged = centre.merge(&bare).unwrap();
    assert_eq!((merged.known, merged.differing), (1, 0));
    assert_eq!(sites(&centre), ["Theatre 1", "Theatre 1", "Theatre 2"]);
    let to = early.destination("https://lrs.example/xapi").unwrap();
    let sent = early.outgoing(to).unwrap().remove(0);
    assert_eq!(sent.session.circumstances.site, "Theatre 2");
}
