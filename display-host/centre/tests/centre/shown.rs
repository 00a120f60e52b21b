//! The page in a real browser.

use std::path::PathBuf;
use std::process::Stdio;

use crate::browser::Browser;
use crate::house::{House, recording};
use crate::results::keep_results;
use crate::support::{Killed, PASSWORD};

#[test]
fn a_page_shows_stations_alarms_and_results_in_a_browser() {
    let house = House::open(&["s-1", "s-2"], &["s-1", "s-2"]);
    let Some(mut browser) = Browser::start(&house.file("profile")) else {
        return;
    };
    let file = house.file("recording");
    recording(&file);
    keep_results(&house.file("centre.sqlite"));
    let mut stations = house.rehearse(&file, &["s-1", "s-2"]);
    let stations = Killed(stations.stdout(Stdio::null()).spawn().expect("a rehearsal"));
    browser.open(&format!("https://{}/", house.centre.page));
    browser.until("location.pathname === '/login' && document.forms[0]");
    browser.value("document.getElementById('name').value = 'bo'");
    browser.value(&format!(
        "document.getElementById('password').value = '{PASSWORD}'"
    ));
    browser.value("document.forms[0].submit()");
    browser.until("document.querySelectorAll('.tile').length === 2");
    browser.until("[...document.querySelectorAll('.tile img')].every((it) => it.naturalWidth > 0)");
    browser.until("document.querySelector('.tile.flash') && document.querySelector('.tile .alarms').textContent");
    browser.value("document.querySelector('.tile').click()");
    browser.until("window.shownPictures > 3 && document.querySelector('#alarms li').textContent.includes('burnt')");
    browser.until("document.getElementById('large-facts').textContent.includes('trainee 0')");
    // A desk, a small window, and a tablet both ways: nothing lies beyond the right edge.
    let pictures = std::env::var_os("CALOT_CENTRE_PICTURES").map(PathBuf::from);
    let look = |browser: &mut Browser, name: &str| {
        for (width, height) in [(1280, 800), (800, 600), (1024, 768), (768, 1024)] {
            browser.resize(width, height);
            browser.until(&format!("innerWidth === {width}"));
            let within = "document.documentElement.scrollWidth <= innerWidth \
                && [...document.querySelectorAll('.tile .health, .tile .alarms')]\
                   .every((it) => it.scrollWidth <= it.clientWidth || it.clientWidth === 0)";
            assert_eq!(browser.value(within), true, "{name} at {width}x{height}");
            if let Some(folder) = &pictures {
                browser.picture(&folder.join(format!("{name}-{width}x{height}.png")));
            }
        }
    };
    look(&mut browser, "enlarged");
    browser.value("document.getElementById('close').click()");
    look(&mut browser, "stations");
    browser.value("document.getElementById('show-results').click()");
    browser.until("document.querySelector('#people button')");
    browser.value("document.querySelector('#people button').click()");
    browser.until("document.querySelectorAll('circle').length === 2 && document.querySelectorAll('td').length === 12");
    look(&mut browser, "results");
    drop(stations);
    browser.until("[...stations.values()].every((it) => !it.told.present)");
    browser.value("document.querySelector('header form').submit()");
    browser.until("location.pathname === '/login'");
}
