//! Connections that are cut, and a centre that is started anew.

use std::net::{Shutdown, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::{Arc, Mutex};

use crate::house::{House, heard, long_recording, sent};
use crate::support::{Centre, Killed, free_port, wait};

/// A cable between stations and a centre, which can be cut.
pub(crate) struct Cable {
    pub(crate) address: String,
    is_cut: Arc<AtomicBool>,
    ends: Arc<Mutex<Vec<TcpStream>>>,
}

impl Cable {
    pub(crate) fn to(centre: &str) -> Self {
        let listener = loop {
            if let Ok(it) = TcpListener::bind(("127.0.0.1", free_port())) {
                break it;
            }
        };
        let address = listener.local_addr().expect("an address").to_string();
        let (is_cut, ends) = (Arc::<AtomicBool>::default(), Arc::default());
        let cable = Self {
            address,
            is_cut,
            ends,
        };
        let (centre, is_cut, ends) = (centre.to_owned(), cable.is_cut.clone(), cable.ends.clone());
        std::thread::spawn(move || {
            for near in listener.incoming().map_while(Result::ok) {
                if is_cut.load(Relaxed) {
                    continue;
                }
                let Ok(far) = TcpStream::connect(&centre) else {
                    continue;
                };
                let copies = [&near, &far].map(|it| it.try_clone().expect("a line"));
                ends.lock().expect("ends").extend(copies);
                carry(&near, &far);
                carry(&far, &near);
            }
        });
        cable
    }

    pub(crate) fn cut(&self) {
        self.is_cut.store(true, Relaxed);
        for end in self.ends.lock().expect("ends").drain(..) {
            let _ = end.shutdown(Shutdown::Both);
        }
    }

    pub(crate) fn mend(&self) {
        self.is_cut.store(false, Relaxed);
    }
}

fn carry(from: &TcpStream, to: &TcpStream) {
    let [mut from, mut to] = [from, to].map(|it| it.try_clone().expect("a line"));
    std::thread::spawn(move || {
        let _ = std::io::copy(&mut from, &mut to);
        let _ = to.shutdown(Shutdown::Both);
    });
}

#[test]
fn a_station_that_is_cut_off_comes_back_with_every_alarm() {
    let house = House::open(&["s-1"], &["s-1"]);
    let file = house.file("recording");
    long_recording(&file);
    let cable = Cable::to(&house.centre.stations);
    let mut page = house.page();
    let told = std::fs::File::create(house.file("told")).expect("a file");
    let mut station = house.rehearse_at(&cable.address, &file, &["s-1"]);
    let _station = Killed(station.stdout(told).spawn().expect("a rehearsal"));
    let mut until = |what: &str, present: usize| {
        wait(what, || {
            page.look();
            (page.present() == present).then_some(())
        });
    };
    until("the station is there", 1);
    wait("an alarm", || {
        (!heard(&house.centre).is_empty()).then_some(())
    });
    cable.cut();
    until("it is cut off", 0);
    let before = heard(&house.centre).len();
    let missed = wait("alarms that nobody hears", || {
        Some(sent(&house.file("told"))).filter(|it| it.len() > before + 1)
    });
    assert_eq!(heard(&house.centre).len(), before, "the cable is cut");
    cable.mend();
    until("the station is back", 1);
    wait("every alarm", || {
        let heard = heard(&house.centre);
        missed.keys().all(|it| heard.contains_key(it)).then_some(())
    });
}

#[test]
fn a_centre_that_starts_anew_finds_its_stations_and_repeats_no_alarm() {
    let mut house = House::open(&["s-1"], &["s-1"]);
    let file = house.file("recording");
    long_recording(&file);
    let told = std::fs::File::create(house.file("told")).expect("a file");
    let mut station = house.rehearse(&file, &["s-1"]);
    let _station = Killed(station.stdout(told).spawn().expect("a rehearsal"));
    wait("two alarms", || {
        (heard(&house.centre).len() > 1).then_some(())
    });
    let (stations, page) = (house.centre.stations.clone(), house.centre.page.clone());
    house.centre.kill();
    house.centre = wait("the centre starts at its old addresses", || {
        Centre::start_at(house.folder.path(), &stations, &page)
    });
    let mut page = house.page();
    wait("the station is back", || {
        page.look();
        (page.present() == 1).then_some(())
    });
    let sent = sent(&house.file("told"));
    wait("every alarm, once", || {
        let heard = heard(&house.centre);
        sent.keys().all(|it| heard.contains_key(it)).then_some(())
    });
    let known = page.get(&house.centre, &house.file("ca.pem"), "/api/alarms?name=s-1");
    let known = known.as_array().map_or(0, Vec::len);
    assert!(
        known >= sent.len(),
        "{known} alarms; {} were sent",
        sent.len()
    );
}
