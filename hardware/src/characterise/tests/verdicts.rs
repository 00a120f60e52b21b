//! Tests the comparisons in words and the lines for a station file.

use rt_core::port::DeviceCapabilities;

use super::super::{Axis, Characterised, Estimate, Trace, Trial, Wall, rendered_n_m};
use crate::station::StationFile;

fn exactly(value: f64) -> Estimate {
    Estimate { value, error: 0.0 }
}

/// Result of a Touch with this viscous damping, friction, break-away force and delay.
fn found(viscous: f64, friction_n: f64, break_away_n: f64, delay_s: f64) -> Characterised {
    let axis = Axis {
        mass_kg: exactly(0.045),
        damping_n_s_m: exactly(viscous),
        friction_n: exactly(friction_n),
        break_away_n: exactly(break_away_n),
        carries_n: exactly(0.0),
        delay_s: exactly(delay_s),
        rms_m: 0.0,
        friction_curve: Vec::new(),
        chirp: [Trace::default(), Trace::default()],
        run_out: Trace::default(),
    };
    Characterised {
        declared: DeviceCapabilities {
            delay_s: 0.0,
            damping_n_s_m: 1.85,
            ..DeviceCapabilities::TOUCH
        },
        force_n: 0.88,
        axes: [Some(Ok(axis)), None, Some(Err("no motor".into()))],
        echo_s: None,
        wall: None,
        opening: None,
        opening_wall: None,
    }
}

#[test]
fn differences_are_reported_with_their_consequence() {
    let agrees = found(0.2, 0.26, 0.26, 0.0001);
    let said = agrees.verdicts().join("\n");
    assert_eq!(said.matches("they agree").count(), 2, "{said}");

    let worse = found(0.2, 0.1, 0.2, 0.0021);
    let said = worse.verdicts().join("\n");
    assert!(
        said.contains(
            "declares 0.0 ms delay, measured 2.1 ms: contacts will be rendered too stiff and may buzz"
        ),
        "{said}"
    );
    assert!(
        said.contains(
            "declares 1.85 N s/m damping, measured 0.84 N s/m: contacts will be rendered too stiff"
        ),
        "{said}"
    );
    assert!(said.contains("x: the handle sticks"), "{said}");

    let mut safe = found(2.0, 0.26, 0.26, 0.001);
    safe.declared.delay_s = 0.005;
    safe.echo_s = Some(0.02);
    let said = safe.verdicts().join("\n");
    assert_eq!(
        said.matches("softer than they could be").count(),
        2,
        "{said}"
    );
    assert!(said.contains("confirmed only after 20.0 ms"), "{said}");
}

#[test]
fn a_declared_stiffness_is_compared_with_that_of_the_wall() {
    let mut found = found(0.2, 0.26, 0.26, 0.002);
    for (still, buzzes, expected, line) in [
        (Some(600.0), Some(650.0), "declare less", true),
        (Some(200.0), None, "stiffer walls were not pressed", false),
        (Some(1500.0), Some(1600.0), "that holds", false),
        (None, Some(100.0), "even a wall of 100 N/m buzzes", false),
        (Some(20e3), None, "no wall buzzed, up to 20000 N/m", false),
        (None, None, "the wall was not pressed", false),
    ] {
        found.wall = Some(Wall {
            trials: vec![Trial {
                stiffness_n_m: 100.0,
                buzz: None,
            }],
            still_n_m: still,
            buzzes_n_m: buzzes,
            was_left: still == Some(200.0),
        });
        let said = found.verdicts().join("\n");
        assert!(said.contains(expected), "{said}");
        assert_eq!(found.station_lines().contains("stiffness_max_n_m"), line);
    }
}

#[test]
fn the_printed_lines_are_valid_in_a_station_file() {
    let mut found = found(0.2, 0.26, 0.26, 0.002);
    if let Some(Ok(axis)) = &mut found.axes[0] {
        axis.delay_s.error = 0.0005;
    }
    let lines = found.station_lines();
    let text = format!("[haptic]\ndriver = \"rig\"\npath = \"rig\"\n{lines}");
    let file = StationFile::parse(&text, "station.toml".as_ref()).unwrap();
    let limits = file.haptic.unwrap().limits;
    // The margin is two standard errors.
    assert_eq!(limits.delay_s, Some(0.003));
    assert!(
        (limits.damping_n_s_m.unwrap() - 1.855).abs() < 1e-3,
        "{lines}"
    );
}

#[test]
fn stiffness_follows_from_the_rule_of_the_core() {
    let rendered = rendered_n_m(1.0, 0.002, 1000.0);
    assert!((rendered - 0.7 * 1.0 / 0.0025).abs() < 0.1, "{rendered}");
    let found = found(0.2, 0.26, 0.26, 0.002);
    let expected = rendered_n_m(
        0.2 + 4.0 * 0.26 / (std::f64::consts::PI * 0.2),
        0.002,
        1000.0,
    );
    assert!((found.rendered_n_m().unwrap() - expected).abs() < 1e-6);
}
