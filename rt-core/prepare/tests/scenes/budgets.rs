//! Counts of spheres that an error budget or a time budget chooses, and levels of detail.

use std::path::Path;

use scene_prepare::{Prepared, Recipe, prepare};

#[test]
fn error_budget_chooses_the_smallest_count_that_keeps_it() {
    let text = "name = \"b\"\n[[organ]]\nname = \"liver\"\nkind = \"liver\"\nspheres = 300\n\
                shape = { form = \"liver\" }\nheld = [{ base = 0.2 }]\n";
    let with = |budget: &str| {
        let text = text.replace(
            "spheres = 300",
            &format!("spheres = 300\ngap_95_mm = {budget}"),
        );
        prepare(
            &Recipe::parse(&text, "budget", Path::new(".")).unwrap(),
            &mut |_| {},
        )
    };
    let coarse = with("6.0").unwrap().report;
    let fine = with("4.0").unwrap().report;
    assert!(coarse.gap_95_mm <= 6.0 && fine.gap_95_mm <= 4.0);
    assert!(
        coarse.gap_95_mm > 5.0 && fine.gap_95_mm > 3.5,
        "no more spheres than needed"
    );
    assert!(coarse.spheres < fine.spheres);
    assert!(fine.organs[0].spheres_because.contains("budget of 4.00 mm"));
    let impossible = with("0.06").unwrap_err().to_string();
    assert!(
        impossible.contains("give the organ a larger gap_95_mm"),
        "{impossible}"
    );
}

fn liver(keys: &str) -> Result<Prepared, scene_prepare::PrepareError> {
    let text = format!(
        "name = \"b\"\n{keys}\nshape = {{ form = \"liver\" }}\nheld = [{{ base = 0.2 }}]\n"
    );
    let text = text.replace("[[organ]]", "[[organ]]\nname = \"liver\"\nkind = \"liver\"");
    let recipe = Recipe::parse(&text, "budget", Path::new(".")).expect("a good recipe");
    prepare(&recipe, &mut |_| {})
}

#[test]
fn time_budget_chooses_the_largest_count_that_keeps_it() {
    let coarse = liver("tick_us = 25\n[[organ]]").unwrap().report;
    let fine = liver("tick_us = 90\n[[organ]]").unwrap().report;
    assert!(
        (0.9 * 25.0..=25.0).contains(&coarse.tick_us),
        "{}",
        coarse.tick_us
    );
    assert!(
        (0.9 * 90.0..=90.0).contains(&fine.tick_us),
        "{}",
        fine.tick_us
    );
    assert!(2 * coarse.spheres < fine.spheres);
    let because = &fine.organs[0].spheres_because;
    assert!(because.contains("of 90 µs allowed"), "{because}");
    // The error budget comes first. The spheres that it needs exceed the time budget.
    let both = liver("tick_us = 25\n[[organ]]\ngap_95_mm = 4.5");
    let refused = both.unwrap_err().to_string();
    assert!(refused.contains("cannot keep tick_us = 25"), "{refused}");
}

#[test]
fn levels_of_detail_are_coarser_each() {
    let text = "name = \"b\"\n[[organ]]\nname = \"liver\"\nkind = \"liver\"\nspheres = 300\n\
                coarser = [150, 80]\nshape = { form = \"liver\" }\nheld = [{ base = 0.2 }]\n";
    let recipe = Recipe::parse(text, "levels", Path::new(".")).unwrap();
    assert_eq!(recipe.levels(), 3);
    let scenes: Vec<_> = (0..3)
        .map(|level| prepare(&recipe.level(level), &mut |_| {}).unwrap().scene)
        .collect();
    let spheres: Vec<usize> = scenes.iter().map(|scene| scene.spheres.len()).collect();
    assert_eq!(spheres, [300, 150, 80]);
    for coarser in &scenes[1..] {
        assert_eq!(
            coarser.room, scenes[0].room,
            "hand and camera stay where they are"
        );
        assert_eq!(coarser.triangles, scenes[0].triangles, "one skin");
    }
    let halved = recipe.with_levels(3, &[400]);
    assert_eq!(halved.organs[0].coarser, [200, 100]);
    let wrong = text.replace("[150, 80]", "[150, 160]");
    let refused = Recipe::parse(&wrong, "levels", Path::new("."))
        .unwrap_err()
        .to_string();
    assert!(refused.contains("each below the one before"), "{refused}");
}

#[test]
fn a_count_for_the_whole_scene_is_shared_among_its_organs() {
    let recipe = Recipe::built_in().unwrap().with_spheres(1642).unwrap();
    let counts: Vec<usize> = recipe.organs.iter().map(|o| o.spheres).collect();
    assert_eq!(counts, [1162, 480]);
    let refused = Recipe::built_in().unwrap().with_spheres(10).unwrap_err();
    assert!(
        refused.to_string().contains("allowed: at least 8"),
        "{refused}"
    );
}
