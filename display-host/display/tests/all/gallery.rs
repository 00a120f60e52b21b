//! The gallery of the tests' scene is complete, no picture is black, and none is there twice.

use display_host::gallery;

use crate::support;

#[test]
fn every_picture_is_there_shows_something_and_no_other() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let out = folder.path().join("gallery");
    let scene = support::scene(24);
    let mut said = 0;
    let pictures = gallery::make(&scene, &out, Some([96, 72]), &mut |_, done| {
        assert!((0.0..1.0).contains(&done));
        said += 1;
    })
    .expect("a driver: apt-get install mesa-vulkan-drivers");
    assert_eq!(said, pictures.len());
    // Two organs, in place and alone; eight pictures of instruments and trocar; effects; views.
    assert!(pictures.len() >= 2 * 2 + 8 + 6 + 7, "{}", pictures.len());
    let page = std::fs::read_to_string(out.join("index.html")).expect("a page");
    let mut seen: Vec<image::RgbaImage> = Vec::new();
    for picture in &pictures {
        assert!(page.contains(&picture.file), "{}", picture.file);
        let drawn = image::open(out.join(&picture.file))
            .unwrap_or_else(|error| panic!("{}: {error}", picture.file))
            .to_rgba8();
        let bright = drawn.pixels().filter(|p| p.0[..3].iter().any(|&c| c > 40));
        let share = bright.count() as f64 / (96.0 * 72.0);
        assert!(
            share > 0.02,
            "{}: {share} of it shows something",
            picture.title
        );
        assert!(!seen.contains(&drawn), "{} is there twice", picture.title);
        seen.push(drawn);
    }
    let sheet = image::open(out.join("sheet.png"))
        .expect("a sheet")
        .to_rgba8();
    assert!(sheet.width() > 1000 && sheet.height() > 400);
}
