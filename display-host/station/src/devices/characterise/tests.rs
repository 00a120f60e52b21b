//! Tests of table, page and place on a device with known figures.

use std::path::Path;

use hardware::characterise::{Axis, Characterised, Estimate, Opened, Trace, Trial, Wall};
use rt_core::port::DeviceCapabilities;

use super::{page, place, table};

fn about(value: f64) -> Estimate {
    Estimate {
        value,
        error: 0.01 * value,
    }
}

/// A Touch that declares no delay and has 1 ms.
fn touch() -> Characterised {
    let trace = Trace {
        at_s: vec![0.0, 0.001, 0.002],
        measured_m: vec![0.0, 0.001, 0.003],
        fitted_m: vec![0.0, 0.001, 0.0029],
    };
    let axis = Axis {
        mass_kg: about(0.045),
        damping_n_s_m: about(0.2),
        friction_n: about(0.26),
        break_away_n: about(0.27),
        carries_n: about(0.01),
        delay_s: about(0.001),
        rms_m: 2e-5,
        friction_curve: vec![[-0.1, -0.28], [0.1, 0.28]],
        chirp: [trace.clone(), trace.clone()],
        run_out: trace,
    };
    let trial = |stiffness_n_m, buzz| Trial {
        stiffness_n_m,
        buzz,
    };
    Characterised {
        declared: DeviceCapabilities {
            delay_s: 0.0,
            ..DeviceCapabilities::TOUCH
        },
        force_n: 0.88,
        axes: [Some(Ok(axis)), None, Some(Err("no <motor>".into()))],
        echo_s: Some(0.001),
        wall: Some(Wall {
            trials: vec![trial(100.0, None), trial(200.0, Some((40.0, 1e-3)))],
            still_n_m: Some(100.0),
            buzzes_n_m: Some(200.0),
            was_left: false,
        }),
        opening: None,
        opening_wall: None,
    }
}

/// A Touch whose handle opens.
fn handle() -> Characterised {
    let mut found = touch();
    let axis = found.axes[0].as_ref().and_then(|it| it.clone().ok());
    found.declared.opening = rt_core::port::Opening {
        travel_m: 0.03,
        force_max_n: 5.0,
        stiffness_max_n_m: 1000.0,
    };
    found.opening = axis.map(|axis| {
        Ok(Opened {
            axis,
            range: [0.01, 0.8],
            given: vec![[0.25, 1.0], [0.95, 0.5]],
        })
    });
    found.opening_wall = found.wall.clone();
    found
}

#[test]
fn opening_of_a_handle_has_its_column_its_figures_and_its_charts() {
    let found = handle();
    let text = table::text(&found);
    for expected in [
        "opening    declared\n",
        "23.7 mm of the declared 30.0 mm: ends or travel are wrong",
        "of 0.95 N the motor renders only 0.50 times what small forces promise",
        "opening: declares 1000 N/m, a wall of 200 N/m buzzes",
    ] {
        assert!(text.contains(expected), "{text}");
    }
    let json = table::json(Path::new("/dev/rig"), &found);
    assert_eq!(json["opening"]["range"][1], 0.8);
    assert_eq!(json["declared"]["opening"]["stiffness_max_n_m"], 1000.0);
    assert_eq!(json["opening_wall"]["still_n_m"], 100.0);
    let page = page::html(Path::new("/dev/rig"), &found).unwrap();
    for expected in [
        "Along the opening",
        "Force along the opening",
        "Virtual walls along the opening",
    ] {
        assert!(page.contains(expected), "{expected}");
    }

    let mut still = touch();
    still.opening = Some(Err("no force".into()));
    let text = table::text(&still);
    assert!(text.contains("opening: not measured. no force"), "{text}");
    let json = table::json(Path::new("/dev/rig"), &still);
    assert_eq!(json["opening"]["not_measured"], "no force");
    assert!(table::json(Path::new("/dev/rig"), &touch())["opening"].is_null());
}

#[test]
fn table_has_measured_and_declared_values_and_lines_for_the_station_file() {
    let text = table::text(&touch());
    for expected in [
        "45.0 ± 0.5",
        "z: not measured. no <motor>",
        "declares 0.0 ms delay, measured 1.0 ms",
        "declare less",
        "stiffness_max_n_m = 100",
    ] {
        assert!(text.contains(expected), "{text}");
    }
}

#[test]
fn json_and_page_hold_the_figures() {
    let path = Path::new("/dev/<rig>");
    let found = table::json(path, &touch());
    assert_eq!(found["axes"]["x"]["friction_n"]["value"], 0.26);
    assert_eq!(found["axes"]["z"]["not_measured"], "no <motor>");
    assert_eq!(found["wall"]["trials"][1]["buzz_hz"], 40.0);
    let page = page::html(path, &touch()).unwrap();
    assert!(page.starts_with("<!doctype html>") && page.contains("/dev/&lt;rig&gt;"));
    assert_eq!(page.matches("</svg>").count(), 2);
}

#[test]
fn place_lies_between_devices_of_the_map() {
    let said = place::sentence(&touch()).unwrap();
    // The device has 1.855 N s/m, as the map's Touch. Rounding decides on which side of the
    // Touch it lies.
    assert!(said.contains("N s/m ("), "{said}");
    let mut strong = touch();
    strong.axes[0]
        .as_mut()
        .unwrap()
        .as_mut()
        .unwrap()
        .damping_n_s_m = about(9.0);
    let said = place::sentence(&strong).unwrap();
    assert!(said.contains("above 2 N s/m"), "{said}");
    let mut weak = touch();
    let axis = weak.axes[0].as_mut().unwrap().as_mut().unwrap();
    (axis.damping_n_s_m, axis.friction_n) = (about(0.05), about(0.0));
    axis.delay_s = about(0.01);
    let said = place::sentence(&weak).unwrap();
    assert!(
        said.contains("below 0.1 N s/m") && said.contains("ends at"),
        "{said}"
    );
}
