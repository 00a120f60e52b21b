//! Heat of the hook's current: how far it spreads along a mesentery and a duct, over the time that
//! the current is held.
//!
//! Published: in rabbits, 30 and 60 W of monopolar current spread heat more than 2 cm along the
//! mesentery once it flowed for more than 3 s; power made no difference (2020, abstract). The
//! source does not tell by which temperature or damage the length was measured. So the table has
//! three lengths.

use std::fmt::Write as _;

use figures::panels::{Panel, Scale, Series, panels};
use rt_core::math::{Pose, Vec3};
use rt_core::port::{Buttons, DeviceCapabilities, DeviceSample, ForceCommand, PedalSample, Polled};
use rt_core::procedure::heat::{Balance, HeatCode};
use rt_core::scene::{Inside, Link, Material, Organ, RestSphere, Room, Scene};
use rt_core::sim::{Command, Parameters, Ports, Samples, Sim, Stage, TickView};
use rt_core::state::State;
use rt_core::tool::{Instrument, Kinematics};

use crate::csv::split;
use crate::page::{Section, table};

/// Published length, mm, and the time after which heat reached farther, s.
const PUBLISHED: ([f64; 2], &str) = ([20.0, 3.0], "published: more than 20 mm beyond 3 s");
/// Distance between the spheres of the mesentery, m, and its thickness.
const SPACING_M: f32 = 0.002;
const THICK_M: f32 = 0.001;
/// Density of tissue, kg/m³.
const DENSITY_KG_M3: f32 = 1060.0;
/// Temperatures above the body's that count as warm (43 °C) and as blanched (60 °C), K.
const WARM_K: u8 = 6;
const BLANCHED_K: u8 = 23;
/// Share of denatured proteins, of 255, at an Arrhenius sum of 1.
const DESTROYED: u8 = 161;
const LEVER: Kinematics = Kinematics {
    port_m: Vec3::new(0.0, 0.0, 0.18),
    length_m: 0.33,
};

/// Structure that the hook touches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Structure {
    /// A sheet of 60 × 60 mm, 1 mm thick, whose edge joins the body.
    Mesentery,
    /// A duct of 60 mm with a diameter of 4 mm, whose ends join the body.
    Duct,
}

impl Structure {
    const fn name(self) -> &'static str {
        match self {
            Self::Mesentery => "mesentery",
            Self::Duct => "duct",
        }
    }

    fn spheres(self) -> Vec<RestSphere> {
        let sphere = |x: i32, y: i32, is_edge: bool, radius_m: f32, mass_kg: f32| RestSphere {
            center_m: Vec3::new(x as f32, y as f32, 0.0) * SPACING_M,
            radius_m,
            mass_kg,
            held: is_edge,
        };
        match self {
            Self::Mesentery => {
                let mass_kg = DENSITY_KG_M3 * SPACING_M * SPACING_M * THICK_M;
                let at = |y: i32| {
                    (-15..=15).map(move |x: i32| {
                        let is_edge = x.abs() == 15 || y.abs() == 15;
                        sphere(x, y, is_edge, 0.5 * SPACING_M, mass_kg)
                    })
                };
                (-15..=15).flat_map(at).collect()
            }
            Self::Duct => {
                let mass_kg = DENSITY_KG_M3 * core::f32::consts::PI * SPACING_M.powi(3);
                let at = |x: i32| sphere(x, 0, x.abs() == 15, SPACING_M, mass_kg);
                (-15..=15).map(at).collect()
            }
        }
    }

    fn links(self) -> Vec<Link> {
        // So stiff that the hook hardly bends it.
        let link = |a: u32, b: u32| Link {
            a,
            b,
            rest_length_m: SPACING_M,
            compliance_m_n: 1.0e-4,
        };
        match self {
            Self::Mesentery => {
                let mut links = Vec::new();
                for y in 0..31 {
                    for x in 0..31 {
                        let own = y * 31 + x;
                        links.extend((x < 30).then(|| link(own, own + 1)));
                        links.extend((y < 30).then(|| link(own, own + 31)));
                    }
                }
                links
            }
            Self::Duct => (0..30).map(|x| link(x, x + 1)).collect(),
        }
    }

    /// Place of the tip, m: its bent end lies across the middle.
    fn tip_m(self) -> Vec3 {
        let radius_m = self.spheres().first().map_or(0.0, |it| it.radius_m);
        Vec3::new(0.0, 0.002, radius_m + 0.000_6)
    }
}

/// A line of `heat.csv`.
pub(crate) struct Row {
    structure: Structure,
    current: &'static str,
    held_s: f64,
    /// Lengths along x that are warm, blanched and destroyed, mm.
    lengths_mm: [f64; 3],
    balance: Balance,
}

/// Measures both structures under both currents. Only cases whose name contains `only` run.
///
/// # Errors
/// If a scene is refused, or the hook missed the structure, in words.
pub(crate) fn run(quick: bool, only: &str) -> Result<Vec<Row>, String> {
    let ends_s: &[f64] = match quick {
        true => &[1.0, 3.0],
        false => &[0.5, 1.0, 2.0, 3.0, 4.0, 5.0, 7.0, 10.0],
    };
    let mut rows = Vec::new();
    for structure in [Structure::Mesentery, Structure::Duct] {
        for (current, pedals) in [("coagulate", (false, true)), ("cut", (true, false))] {
            if format!("{} {current}", structure.name()).contains(only) {
                rows.extend(held(structure, current, pedals, ends_s)?);
            }
        }
    }
    Ok(rows)
}

/// Holds the current on a structure. A row for each of the times `ends_s`.
fn held(
    structure: Structure,
    current: &'static str,
    (cut, coagulate): (bool, bool),
    ends_s: &[f64],
) -> Result<Vec<Row>, String> {
    let (spheres, links) = (structure.spheres(), structure.links());
    let organs = [organ(spheres.len(), links.len())];
    let scene = Scene::new(&organs, &spheres, &links, room()).map_err(|e| e.to_string())?;
    let mut state = Box::new(State::new());
    let parameters = Parameters::default();
    let mut sim = Sim::new(scene, &mut state, DeviceCapabilities::TOUCH, parameters);
    let mut hand = Hand {
        command: Some(Command::Instrument(Instrument::Hook)),
        ..Hand::default()
    };
    let (away_m, tip_m) = (Vec3::new(0.0, 0.0, 0.05), structure.tip_m());
    for step in 0..=400 {
        hand.tick(&mut sim, away_m + (tip_m - away_m) * (step as f32 / 400.0));
    }
    hand.pedal = PedalSample {
        cut,
        coagulate,
        ..PedalSample::default()
    };
    let (mut rows, mut held_ticks) = (Vec::new(), 0u32);
    for held_s in ends_s {
        while f64::from(held_ticks) < held_s * 1000.0 {
            hand.tick(&mut sim, tip_m);
            held_ticks += 1;
        }
        if hand.balance.given_j <= 0.0 {
            return Err(format!("{}: the hook touches nothing", structure.name()));
        }
        rows.push(Row {
            structure,
            current,
            held_s: *held_s,
            lengths_mm: lengths_mm(&spheres, &hand.heat),
            balance: hand.balance,
        });
    }
    Ok(rows)
}

/// Lengths along x of the tissue that is warm, blanched and destroyed, mm: from its first to its
/// last sphere, and half a spacing on either side.
fn lengths_mm(spheres: &[RestSphere], heat: &[HeatCode]) -> [f64; 3] {
    let is_so: [fn(&HeatCode) -> bool; 3] = [
        |it| it.rise_k >= WARM_K,
        |it| it.rise_k >= BLANCHED_K,
        |it| it.denatured >= DESTROYED,
    ];
    is_so.map(|is_so| {
        let own = spheres.iter().zip(heat).filter(|it| is_so(it.1));
        let (low, high) = own.fold((f32::MAX, f32::MIN), |(low, high), (sphere, _)| {
            (low.min(sphere.center_m.x), high.max(sphere.center_m.x))
        });
        if low > high {
            0.0
        } else {
            f64::from(high - low + SPACING_M) * 1e3
        }
    })
}

fn organ(spheres: usize, links: usize) -> Organ {
    Organ {
        sphere_start: 0,
        sphere_count: spheres as u32,
        link_start: 0,
        link_count: links as u32,
        elastic_links: links as u32,
        batch_start: 0,
        batch_count: 0,
        substeps: 8,
        gravity_share: 0.0,
        breath_m: Vec3::zeros(),
        inside: Inside::Solid,
        material: Material {
            young_pa: 50_000.0,
            poisson: 0.45,
            retardation_s: 0.002,
            stretch_stiffness: 0.02,
            laplacian_stiffness: 0.005,
            damping_per_s: 20.0,
            contact_stiffness_n_m: 400.0,
            friction: 0.1,
            toughness_j_m2: 0.0,
        },
    }
}

fn room() -> Room {
    Room {
        trocar: rt_core::scene::Trocar::NONE,
        gravity_m_s2: Vec3::new(0.0, 0.0, -9.81),
        world_from_device: Pose::identity(),
        world_from_tracker: Pose::identity(),
        instrument_port_m: LEVER.port_m,
        instrument_length_m: LEVER.length_m,
        endoscope_port_m: Vec3::new(0.05, 0.0, 0.18),
        world_from_camera: Pose::identity(),
        breath_s: 0.0,
    }
}

/// A hand that follows a path, and the results of the last tick.
#[derive(Default)]
struct Hand {
    now_ns: u64,
    at_m: Vec3,
    pedal: PedalSample,
    command: Option<Command>,
    heat: Vec<HeatCode>,
    balance: Balance,
}

impl Hand {
    fn tick(&mut self, sim: &mut Sim<'_>, at_m: Vec3) {
        self.now_ns += 1_000_000;
        self.at_m = at_m;
        sim.tick(self);
    }
}

impl Ports for Hand {
    fn sample(&mut self) -> Samples {
        let at_ns = self.now_ns;
        Samples {
            now_ns: at_ns,
            device: Polled::Fresh(DeviceSample {
                opening: None,
                device_from_handle: LEVER.handle_from_tip(&self.at_m, &Vec3::new(0.0, 1.0, 0.0)),
                velocity_m_s: None,
                buttons: Buttons(0),
                sequence: 0,
                at_ns,
            }),
            tracker: Polled::Nothing,
            pedal: Polled::Fresh(PedalSample {
                at_ns,
                ..self.pedal
            }),
            command: self.command.take(),
        }
    }

    fn send_force(&mut self, _: ForceCommand) {}

    fn publish(&mut self, view: &TickView<'_>) {
        self.heat.clear();
        self.heat.extend(view.spheres().map(|it| it.heat));
        self.balance = view.heat_balance();
    }

    fn stamp(&mut self, _: Stage) {}
}

/// The rows as `heat.csv`.
pub(crate) fn csv(rows: &[Row]) -> String {
    let mut text = "structure,current,held_s,above_43_mm,above_60_mm,destroyed_mm,given_j,\
                    stored_j,boiled_j,perfused_j,cooled_j,spread_j\n"
        .to_owned();
    for row in rows {
        let [warm, blanched, destroyed] = row.lengths_mm;
        let it = &row.balance;
        let _ = writeln!(
            text,
            "{},{},{},{warm:.0},{blanched:.0},{destroyed:.0},{:.2},{:.2},{:.2},{:.2},{:.2},{:.2}",
            row.structure.name(),
            row.current,
            row.held_s,
            it.given_j,
            it.stored_j,
            it.boiled_j,
            it.perfused_j,
            it.cooled_j,
            it.spread_j,
        );
    }
    text
}

/// Length over time, a panel for each structure.
///
/// # Errors
/// The drawing library's message.
pub(crate) fn chart(rows: &[Row]) -> Result<String, String> {
    let panel = |structure: Structure| {
        let names = ["above 43 °C", "above 60 °C", "destroyed"];
        let mut series = Vec::new();
        for current in ["coagulate", "cut"] {
            let own = |it: &&Row| it.structure == structure && it.current == current;
            for (k, name) in names.iter().enumerate() {
                let points = rows.iter().filter(own);
                series.push(Series {
                    name: format!("{name}, {current}"),
                    points: points.map(|it| [it.held_s, it.lengths_mm[k]]).collect(),
                    is_thin: false,
                });
            }
        }
        let ([length_mm, after_s], name) = PUBLISHED;
        series.push(Series {
            name: name.to_owned(),
            points: vec![[after_s, length_mm], [10.0, length_mm]],
            is_thin: true,
        });
        Panel {
            title: structure.name().to_owned(),
            axes: [
                "current held, s".to_owned(),
                "length along the structure, mm".to_owned(),
            ],
            scales: [Scale::Linear; 2],
            series,
        }
    };
    panels(&[Structure::Mesentery, Structure::Duct].map(panel), 2)
}

/// The rows as a section of the page.
pub(crate) fn section(rows: &[Row], svg: &str) -> Section {
    let text = csv(rows);
    let cells: Vec<_> = text.lines().map(split).collect();
    Section {
        title: "Heat".to_owned(),
        body: format!(
            "<p>The hook holds a current of 30 W on a sheet 1 mm thick and on a duct of 4 mm. The \
             lengths are those of the tissue above 43 °C, above 60 °C, and destroyed (an Arrhenius \
             sum of 1). In rabbits, heat spread more than 2 cm along the mesentery once the \
             current flowed for more than 3 s. The energies of a row sum to what the generator \
             gave.</p>{svg}{}",
            table(&cells)
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heat_spreads_with_time_and_reaches_the_published_length() {
        let rows = run(true, "mesentery coagulate").expect("rows");
        let [short, long] = [&rows[0], &rows[1]];
        assert!(short.lengths_mm[0] < long.lengths_mm[0]);
        assert!(
            (10.0..=60.0).contains(&long.lengths_mm[0]),
            "{:?}",
            long.lengths_mm
        );
        assert!(long.lengths_mm[2] <= long.lengths_mm[0]);
        for row in &rows {
            let it = &row.balance;
            let carried_j = it.perfused_j + it.cooled_j + it.spread_j;
            let sum_j = it.stored_j + it.boiled_j + carried_j + it.due_j;
            assert!((sum_j / it.given_j - 1.0).abs() < 1e-3, "{it:?}");
        }
        let text = csv(&rows);
        assert_eq!(text.lines().count(), 3);
        assert!(chart(&rows).expect("a chart").contains("<svg"));
    }
}
