//! Tests whether contact is stable under a hand. Device and hand move along one axis, in steps of
//! 1/20 ms. The force comes from Calot's own tick, or from a law with which it is compared.

mod device;
mod felt;
mod law;
mod port;
mod report;
mod sample;
mod scene;
mod trial;

use rt_core::state::State;

pub(crate) use port::strokes;
pub(crate) use report::{chart, csv, section, waits_csv};
pub(crate) use sample::Sample;

use crate::methods::Parts;
use device::{Device, Hand};
use felt::Felt;
use law::{Coupling, Hooke, Law, LimitRecord, Product, START_M, boundless, stated};
use scene::Meets;
use trial::{TrialOutcome, press, respond, wave};

/// Kind of test.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Test {
    /// Finds the stiffest wall up to which all walls are stable.
    Wall,
    /// A press on a liver.
    Tissue,
    /// A hand that waves in free space.
    Free,
    /// A handle that is moved to and fro inside a wall: gain and delay.
    Response,
    /// A stroke through free air into a wall and out: the measures of OmniSurg's haptic bench.
    Felt,
}

/// Law by which force follows position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum LawKind {
    /// Calot's contact and output limits.
    Ours,
    /// Hooke's law on the penetration.
    Hooke,
    /// A virtual coupling.
    Coupling,
    /// Calot's contact without its output limits.
    Bare,
    /// As `Bare`, but the tool touches wide, nearly rigid spheres instead of the skin.
    Rigid,
}

impl LawKind {
    /// Name of the law in files and charts.
    pub(crate) const fn name(self) -> &'static str {
        match self {
            Self::Ours => "Calot",
            Self::Hooke => "Hooke on penetration",
            Self::Coupling => "virtual coupling",
            Self::Bare => "multiplier, no limits",
            Self::Rigid => "multiplier, rigid contact",
        }
    }
}

/// Result of one test with one law, hand and device.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Row {
    pub(crate) test: Test,
    pub(crate) kind: LawKind,
    hand: Hand,
    device: Device,
    /// Parameter of the test: stiffness of a wall, N/m; modulus of tissue, Pa; frequency of a
    /// response, Hz; 0 in free space.
    pub(crate) of: f64,
    /// Stiffness of the stiffest stable wall, or the gain of a response, N/m.
    stiffness_n_m: f64,
    /// Force divided by depth at the end of a press, N/m. For a wall test, the press is on the
    /// stiffest stable wall.
    rendered_n_m: f64,
    outcome: TrialOutcome,
    limits: LimitRecord,
    /// Delay of a response, s.
    lag_s: f64,
    /// Measures of a stroke.
    felt: Option<Felt>,
}

/// Stiffness of the softest tested wall, N/m. A weight of 1 N would sink too deep into a softer
/// one.
const SOFTEST_N_M: f64 = 100.0;
/// Force of the hand on a wall, N.
const WALL_PRESS_N: f64 = 1.0;
/// Force of the hand on tissue, N: it presses the tip 8 mm into soft tissue.
const TISSUE_PRESS_N: f64 = 0.3;
/// Number of jaws. Closed jaws lie side by side. Each presses the wall like a spring of its own.
const JAWS: f64 = 2.0;
/// Spheres of the liver.
const SPHERES: usize = 581;
/// Stiffness of the stiffest wall that is tried, N/m.
const STIFFEST_N_M: f64 = 20e3;

/// Runs all tests.
///
/// # Errors
/// The message of the scene's check.
pub(crate) fn run(quick: bool) -> Result<Vec<Row>, String> {
    let mut bench = Bench {
        state: Box::new(State::new()),
        rows: Vec::new(),
        ratio: if quick { 2.0 } else { 1.25 },
    };
    let delays_ms: &[f64] = if quick {
        &[0.0, 2.0, 5.0]
    } else {
        &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0]
    };
    let dampings: &[f64] = if quick {
        &[0.2, 1.0]
    } else {
        &[0.0, 0.1, 0.2, 0.5, 1.0, 2.0]
    };
    let viscous = |&damping_n_s_m: &f64| Device {
        damping_n_s_m,
        ..Device::BARE
    };
    let devices: Vec<Device> = dampings
        .iter()
        .map(viscous)
        .chain([Device::TOUCH])
        .collect();
    let delayed = |device: Device, delay_ms: f64| Device {
        delay_s: delay_ms * 1e-3,
        ..device
    };
    for (i, device) in devices.iter().enumerate() {
        eprintln!("haptics: walls, device {} of {}", i + 1, devices.len());
        for delay_ms in delays_ms {
            for kind in [LawKind::Ours, LawKind::Hooke, LawKind::Coupling] {
                for hand in Hand::ALL {
                    bench.wall(kind, hand, delayed(*device, *delay_ms))?;
                }
            }
        }
    }
    eprintln!("haptics: slow, lost and late samples");
    for (every, lost, late) in [
        (2, 0.0, 0),
        (4, 0.0, 0),
        (1, 0.1, 0),
        (1, 0.5, 0),
        (1, 0.1, 3),
    ] {
        for device in [viscous(&0.5), Device::TOUCH] {
            let device = Device {
                every,
                lost,
                late,
                ..delayed(device, 2.0)
            };
            for kind in [LawKind::Ours, LawKind::Hooke, LawKind::Coupling] {
                for hand in Hand::ALL {
                    bench.wall(kind, hand, device)?;
                }
            }
        }
    }
    let youngs: &[f64] = if quick { &[5e3] } else { &[5e3, 20e3] };
    for young_pa in youngs {
        eprintln!("haptics: a liver of {} kPa", young_pa / 1e3);
        let skin = scene::liver(SPHERES, *young_pa, Meets::Skin)?;
        let spheres = scene::liver(SPHERES, *young_pa, Meets::Spheres)?;
        for device in [viscous(&0.1), viscous(&0.5), Device::TOUCH] {
            for delay_ms in delays_ms.iter().step_by(if quick { 1 } else { 2 }) {
                for kind in [LawKind::Ours, LawKind::Bare, LawKind::Rigid] {
                    let (parts, top_m) = if kind == LawKind::Rigid {
                        &spheres
                    } else {
                        &skin
                    };
                    let tissue = (parts, *top_m, *young_pa);
                    bench.tissue(kind, tissue, delayed(device, *delay_ms))?;
                }
            }
        }
    }
    bench.free(delayed(Device::TOUCH, 2.0))?;
    bench.response(delayed(Device::TOUCH, 2.0))?;
    bench.rows.extend(felt(quick)?);
    Ok(bench.rows)
}

/// Measures strokes into walls with every law, as OmniSurg's haptic bench does.
///
/// # Errors
/// The message of the scene's check.
pub(crate) fn felt(quick: bool) -> Result<Vec<Row>, String> {
    let mut bench = Bench {
        state: Box::new(State::new()),
        rows: Vec::new(),
        ratio: 1.0,
    };
    let viscous = Device {
        damping_n_s_m: 0.5,
        ..Device::BARE
    };
    let (walls_n_m, delays_ms): (&[f64], &[f64]) = match quick {
        true => (&[1000.0], &[2.0]),
        false => (&[300.0, 1000.0, 3000.0], &[0.0, 2.0, 4.0]),
    };
    eprintln!("haptics: measures of felt quality");
    for device in [viscous, Device::TOUCH] {
        for delay_ms in delays_ms {
            let device = Device {
                delay_s: delay_ms * 1e-3,
                ..device
            };
            for hand in [Hand::RELAXED, Hand::FIRM] {
                for kind in [LawKind::Ours, LawKind::Hooke, LawKind::Coupling] {
                    for stiffness_n_m in walls_n_m {
                        bench.felt(kind, hand, device, *stiffness_n_m)?;
                    }
                }
            }
        }
    }
    Ok(bench.rows)
}

/// Tests walls with samples that wait for the tick. It shows the gain if ticks follow the device.
///
/// # Errors
/// The message of the scene's check.
pub(crate) fn waits(quick: bool) -> Result<Vec<Row>, String> {
    let mut bench = Bench {
        state: Box::new(State::new()),
        rows: Vec::new(),
        // Smaller than in the other tests, because the gain is only a few percent.
        ratio: if quick { 1.25 } else { 1.05 },
    };
    let viscous = Device {
        damping_n_s_m: 0.5,
        ..Device::BARE
    };
    for device in [viscous, Device::TOUCH] {
        for delay_ms in [0.0, 1.0] {
            eprintln!("haptics: waits, delay {delay_ms} ms");
            for wait_ms in WAITS_MS {
                let device = Device {
                    delay_s: delay_ms * 1e-3,
                    wait_s: wait_ms * 1e-3,
                    ..device
                };
                for kind in [LawKind::Ours, LawKind::Hooke] {
                    for hand in [Hand::RELAXED, Hand::FIRM] {
                        bench.wall(kind, hand, device)?;
                    }
                }
            }
        }
    }
    Ok(bench.rows)
}

/// Tested waits, ms: the target of `--follow-device` (just after the arrival), and the median and
/// the longest wait of ticks that do not follow the device.
const WAITS_MS: [f64; 3] = [0.05, 0.5, 1.0];

struct Bench {
    state: Box<State>,
    rows: Vec<Row>,
    /// Ratio of a wall's stiffness to that of the previous wall.
    ratio: f64,
}

impl Bench {
    /// Runs `ask` with a law of this kind, at a wall of this stiffness.
    fn with_wall<T>(
        &mut self,
        kind: LawKind,
        device: &Device,
        stiffness_n_m: f64,
        ask: impl FnOnce(&mut dyn Law) -> T,
    ) -> Result<(T, LimitRecord), String> {
        Ok(match kind {
            LawKind::Hooke => {
                let mut law = Hooke {
                    stiffness_n_m,
                    x_m: START_M,
                };
                (ask(&mut law), LimitRecord::default())
            }
            LawKind::Coupling => (
                ask(&mut Coupling::new(stiffness_n_m, START_M)),
                LimitRecord::default(),
            ),
            LawKind::Ours | LawKind::Bare | LawKind::Rigid => {
                let wall = scene::Wall::new(stiffness_n_m / JAWS);
                let capabilities = if kind == LawKind::Ours {
                    stated(device)
                } else {
                    boundless(device)
                };
                let mut law = Product::new(wall.scene()?, &mut self.state, capabilities, 0.0);
                (ask(&mut law), law.limits())
            }
        })
    }

    /// Tests stiffer and stiffer walls until one is not stable.
    fn wall(&mut self, kind: LawKind, hand: Hand, device: Device) -> Result<(), String> {
        let mut stiffness_n_m = SOFTEST_N_M;
        let mut best: Option<(f64, TrialOutcome, LimitRecord)> = None;
        while stiffness_n_m <= STIFFEST_N_M * 1.001 {
            let (outcome, limits) = self.with_wall(kind, &device, stiffness_n_m, |law| {
                press(law, device, hand, [WALL_PRESS_N, stiffness_n_m])
            })?;
            if !outcome.is_stable() {
                break;
            }
            best = Some((stiffness_n_m, outcome, limits));
            if stiffness_n_m >= STIFFEST_N_M {
                break;
            }
            stiffness_n_m = (stiffness_n_m * self.ratio).min(STIFFEST_N_M);
        }
        let (stiffness_n_m, outcome, limits) =
            best.unwrap_or((0.0, TrialOutcome::NONE, LimitRecord::default()));
        self.rows.push(Row {
            test: Test::Wall,
            kind,
            hand,
            device,
            of: stiffness_n_m,
            stiffness_n_m,
            rendered_n_m: outcome.force_n / (-outcome.x_m).max(1e-9),
            outcome,
            limits,
            lag_s: 0.0,
            felt: None,
        });
        Ok(())
    }

    /// Tests a liver under every hand. `top_m` is the height of its top, `young_pa` its modulus.
    fn tissue(
        &mut self,
        kind: LawKind,
        (parts, top_m, young_pa): (&Parts, f64, f64),
        device: Device,
    ) -> Result<(), String> {
        for hand in Hand::ALL {
            let capabilities = if kind == LawKind::Ours {
                stated(&device)
            } else {
                boundless(&device)
            };
            let scene = parts.scene().map_err(|e| e.to_string())?;
            let mut law = Product::new(scene, &mut self.state, capabilities, top_m);
            let outcome = press(&mut law, device, hand, [TISSUE_PRESS_N, 60.0]);
            let limits = law.limits();
            self.rows.push(Row {
                test: Test::Tissue,
                kind,
                hand,
                device,
                of: young_pa,
                stiffness_n_m: 0.0,
                rendered_n_m: outcome.force_n / (-outcome.x_m).max(1e-9),
                outcome,
                limits,
                lag_s: 0.0,
                felt: None,
            });
        }
        Ok(())
    }

    fn felt(
        &mut self,
        kind: LawKind,
        hand: Hand,
        device: Device,
        stiffness_n_m: f64,
    ) -> Result<(), String> {
        let (felt, limits) = self.with_wall(kind, &device, stiffness_n_m, |law| {
            felt::stroke(law, device, hand, [WALL_PRESS_N, stiffness_n_m])
        })?;
        self.rows.push(Row {
            test: Test::Felt,
            kind,
            hand,
            device,
            of: stiffness_n_m,
            stiffness_n_m: 0.0,
            rendered_n_m: 0.0,
            outcome: TrialOutcome::NONE,
            limits,
            lag_s: 0.0,
            felt: Some(felt),
        });
        Ok(())
    }

    fn free(&mut self, device: Device) -> Result<(), String> {
        for kind in [LawKind::Ours, LawKind::Hooke, LawKind::Coupling] {
            let (force_n, limits) =
                self.with_wall(kind, &device, 500.0, |law| wave(law, device))?;
            self.rows.push(Row {
                test: Test::Free,
                kind,
                hand: Hand::FIRM,
                device,
                of: 0.0,
                stiffness_n_m: 0.0,
                rendered_n_m: 0.0,
                outcome: TrialOutcome {
                    force_n,
                    ..TrialOutcome::NONE
                },
                limits,
                lag_s: 0.0,
                felt: None,
            });
        }
        Ok(())
    }

    fn response(&mut self, device: Device) -> Result<(), String> {
        for kind in [LawKind::Ours, LawKind::Hooke, LawKind::Coupling] {
            for hz in [1.0, 3.0, 10.0, 30.0, 100.0] {
                let ([gain, lag_s], limits) =
                    self.with_wall(kind, &device, 300.0, |law| respond(law, device, 0.002, hz))?;
                self.rows.push(Row {
                    test: Test::Response,
                    kind,
                    hand: Hand::FIRM,
                    device,
                    of: hz,
                    stiffness_n_m: gain,
                    rendered_n_m: gain,
                    outcome: TrialOutcome::NONE,
                    limits,
                    lag_s,
                    felt: None,
                });
            }
        }
        Ok(())
    }
}
