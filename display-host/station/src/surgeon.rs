//! Scripted surgeons: each works a task through the real processes, for tests and demonstrations. They see
//! what a display sees, lead the emulated hand as mouse and keyboard do, and look where it went.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::{Builder, JoinHandle};
use std::time::{Duration, Instant};

use assess::Task;
use bytemuck::Zeroable as _;
use clap::ValueEnum;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use rt_process::time_driver::monotonic_ns;
use shared_mem::message::{CommandMsg, EventMsg, HandMsg, PoseMsg, StateFrame, ToolFrame};
use shared_mem::scene::{OrganKind, SceneFile};
use shared_mem::service::{HandSender, Host, Station};

use crate::say;
use crate::scene::Problem;

type Vec3 = Vector3<f64>;
/// A place, m, and which way what lies there runs, if it does.
type Place = (Vec3, Option<Vec3>);

/// Instruments, as `ToolFrame::instrument` counts.
const HOOK: u32 = 1;
const SCISSORS: u32 = 2;
const CLIPS: u32 = 3;
/// Length of the jaws of scissors and clip applier, m (`rt_core::tool::Instrument`).
const JAW_M: f64 = 0.015;
/// Which part of the jaws takes the vessel.
const BITE: f64 = 0.7;
/// So far back along the shaft it moves from place to place, m.
const BACK_M: f64 = 0.03;
/// How often it looks and moves.
const LOOK_EVERY: Duration = Duration::from_millis(5);
/// A movement is over within this, m and rad; or it is given up, s.
const THERE_M: f64 = 0.0015;
const ALIGNED_RAD: f64 = 0.12;
const GIVE_UP: Duration = Duration::from_secs(8);
/// How often a vessel that was missed is tried.
const ATTEMPTS: u32 = 4;
/// The jaws take so long to close or open.
const JAWS: Duration = Duration::from_millis(900);
const TURN_RAD_S: f64 = 1.5;

/// A scripted surgeon.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum Surgeon {
    /// Two clips on each vessel, and cuts between clips
    Careful,
    /// The same at three times the speed, without lining up
    Hurried,
    /// Cuts where no clips are
    Unclamped,
    /// Coagulates the bile duct
    Burner,
    /// Closes clips on nothing
    Dropper,
}

/// What it does next.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Act {
    Take(u32),
    /// To this share of the way along an organ.
    Reach(OrganKind, f64),
    /// There, closes the jaws, and goes back; again until a clip or a cut came of it.
    Work(OrganKind, f64),
    /// Closes the jaws, and opens them.
    Close,
    /// The foot on the pedal.
    Burn(Duration),
    /// Back along the shaft.
    Retreat,
}

impl Surgeon {
    /// What it does in a task.
    fn plan(self, task: Task) -> Vec<Act> {
        let vessels = [OrganKind::CysticDuct, OrganKind::CysticArtery];
        let mut plan = Vec::new();
        match self {
            Self::Careful | Self::Hurried => {
                // Task `cut` begins with clips: two on the body's side of 0.65, one on the other.
                if task != Task::Cut {
                    plan.push(Act::Take(CLIPS));
                    for kind in vessels {
                        plan.extend([0.45, 0.8].map(|share| Act::Work(kind, share)));
                    }
                }
                if task != Task::Clamp {
                    plan.push(Act::Take(SCISSORS));
                    plan.extend(vessels.map(|kind| Act::Work(kind, 0.65)));
                }
            }
            Self::Unclamped => {
                // Beside the clips that task `cut` begins with.
                let share = if task == Task::Cut { 0.92 } else { 0.65 };
                plan.push(Act::Take(SCISSORS));
                plan.extend(vessels.map(|kind| Act::Work(kind, share)));
            }
            Self::Burner => plan.extend([
                Act::Take(HOOK),
                Act::Reach(OrganKind::BileDuct, 0.4),
                Act::Burn(Duration::from_secs(3)),
                Act::Retreat,
            ]),
            Self::Dropper => {
                plan.extend([Act::Take(CLIPS), Act::Retreat]);
                plan.extend([Act::Close; 3]);
            }
        }
        plan
    }

    fn speed_m_s(self) -> f64 {
        if self == Self::Hurried { 0.12 } else { 0.04 }
    }
}

/// A surgeon at work.
pub(crate) struct AtWork {
    thread: JoinHandle<Result<(), String>>,
    stop: Arc<AtomicBool>,
}

impl AtWork {
    /// Begins once the controller publishes.
    pub(crate) fn begin(
        surgeon: Surgeon,
        task: Task,
        station: &Station,
        scene: SceneFile,
    ) -> Result<Self, Problem> {
        let stop = Arc::new(AtomicBool::new(false));
        let (stopped, station) = (stop.clone(), station.clone());
        let thread = Builder::new()
            .name("calot-surgeon".to_owned())
            .spawn(move || {
                let mut work = Work::new(surgeon, &station, scene, stopped)?;
                work.all(&surgeon.plan(task))
            })
            .map_err(|error| format!("cannot start the surgeon's thread: {error}"))?;
        Ok(Self { thread, stop })
    }

    /// Ends it; why it gave up, if it did.
    pub(crate) fn end(self) -> Option<String> {
        self.stop.store(true, Ordering::Relaxed);
        match self.thread.join() {
            Ok(outcome) => outcome.err(),
            Err(_) => Some("it panicked; please report this".to_owned()),
        }
    }
}

struct Work {
    surgeon: Surgeon,
    scene: SceneFile,
    host: Host,
    hand: HandSender,
    message: HandMsg,
    state: Box<StateFrame>,
    tools: ToolFrame,
    /// Organs that were clipped or cut, event by event.
    worked: Vec<u32>,
    stop: Arc<AtomicBool>,
}

/// Stopped from outside.
const STOPPED: &str = "stopped";

impl Work {
    fn new(
        surgeon: Surgeon,
        station: &Station,
        scene: SceneFile,
        stop: Arc<AtomicBool>,
    ) -> Result<Self, String> {
        let text = |error: shared_mem::service::ServiceError| error.to_string();
        Ok(Self {
            surgeon,
            scene,
            host: Host::open(station).map_err(text)?,
            hand: HandSender::open(station).map_err(text)?,
            message: HandMsg {
                began_ns: monotonic_ns(),
                ..HandMsg::zeroed()
            },
            state: bytemuck::zeroed_box(),
            tools: ToolFrame::zeroed(),
            worked: Vec::new(),
            stop,
        })
    }

    fn all(&mut self, plan: &[Act]) -> Result<(), String> {
        let done = self.look_for(GIVE_UP * 8, |work| {
            work.state.sphere_count > 0 && work.tools.capsule_count > 0
        });
        if !done {
            return Err("no controller".to_owned());
        }
        for act in plan {
            match self.act(*act) {
                Err(stopped) if stopped == STOPPED => return Ok(()),
                Err(why) => say::note(format_args!("calot: the surgeon: {why}")),
                Ok(()) => {}
            }
        }
        // It lets go of nothing: the hand holds still until the run ends.
        self.look_for(Duration::MAX, |_| false);
        Ok(())
    }

    fn act(&mut self, act: Act) -> Result<(), String> {
        match act {
            Act::Take(instrument) => self.take(instrument),
            Act::Reach(kind, share) => {
                let place = |work: &Self| work.place(kind, share);
                // Beside it first, so that nothing is swept along on the way.
                self.reach(&place, BACK_M, true)?;
                self.reach(&place, 0.0, false)
            }
            Act::Work(kind, share) => {
                let before = self.worked(kind);
                // Tissue gives way: what was missed is tried again, a little deeper and beside it.
                for attempt in 0..ATTEMPTS {
                    let side = if attempt % 2 == 0 { 0.02 } else { -0.02 };
                    let missed = self.act(Act::Reach(kind, share + side * f64::from(attempt)));
                    self.is_stopped()?;
                    self.act(Act::Close)?;
                    let done = self.worked(kind) > before;
                    self.act(Act::Retreat)?;
                    match (done, missed) {
                        (true, _) => return Ok(()),
                        (false, Err(why)) => say::note(format_args!("calot: the surgeon: {why}")),
                        (false, Ok(())) => {}
                    }
                }
                Err(format!("nothing came of {ATTEMPTS} attempts"))
            }
            Act::Close => {
                self.message.buttons = 1;
                self.wait(JAWS)?;
                self.message.buttons = 0;
                self.wait(JAWS)
            }
            Act::Burn(time) => {
                self.message.switches = 2;
                let burnt = self.wait(time);
                self.message.switches = 0;
                burnt
            }
            Act::Retreat => {
                let (from, along) = (self.tip(), self.along());
                self.reach(&|_| Some((from - along * BACK_M, None)), 0.0, false)
            }
        }
    }

    /// Looks and moves until `done`; whether it was within the time.
    fn look_for(&mut self, time: Duration, mut done: impl FnMut(&mut Self) -> bool) -> bool {
        let start = Instant::now();
        while start.elapsed() < time && !self.stop.load(Ordering::Relaxed) {
            self.host.newest_state(&mut self.state);
            self.host.newest_tools(&mut self.tools);
            let worked = &mut self.worked;
            self.host.drain_events(|event| {
                if matches!(event.kind, EventMsg::CLIP | EventMsg::CUT) {
                    worked.push(event.organ);
                }
            });
            if done(self) {
                return true;
            }
            self.message.at_ns = monotonic_ns();
            self.hand.send(self.message);
            std::thread::sleep(LOOK_EVERY);
        }
        false
    }

    fn is_stopped(&self) -> Result<(), String> {
        match self.stop.load(Ordering::Relaxed) {
            true => Err(STOPPED.to_owned()),
            false => Ok(()),
        }
    }

    fn wait(&mut self, time: Duration) -> Result<(), String> {
        self.look_for(time, |_| false);
        self.is_stopped()
    }

    fn take(&mut self, instrument: u32) -> Result<(), String> {
        let command = CommandMsg {
            kind: CommandMsg::INSTRUMENT,
            argument: instrument,
        };
        let sent = self.host.command(command, GIVE_UP);
        sent.map_err(|error| error.to_string())?;
        let taken = self.look_for(GIVE_UP, |work| work.tools.instrument == instrument);
        self.is_stopped()?;
        match taken {
            true => Ok(()),
            false => Err(format!("instrument {instrument} did not come")),
        }
    }

    /// How often an organ was clipped or cut.
    fn worked(&self, kind: OrganKind) -> usize {
        let mut organs = self.scene.organs().iter();
        let organ = organs.position(|organ| organ.kind == kind as u32);
        let of = |index: &&u32| Some(**index as usize) == organ;
        self.worked.iter().filter(of).count()
    }

    /// A place along an organ now, and which way the organ runs there.
    fn place(&self, kind: OrganKind, share: f64) -> Option<Place> {
        let mut organs = self.scene.organs().iter();
        let organ = organs.find(|organ| organ.kind == kind as u32)?;
        let [first, count] = organ.spheres.map(|number| number as usize);
        let own = first..first + count;
        let rest = self.scene.spheres().get(own.clone())?;
        let now = self.state.spheres()?.get(own)?;
        let at = |sphere: &[f32; 3]| Vec3::from(sphere.map(f64::from));
        // Spheres of a tube stand in line; shares count towards the gallbladder.
        let to_bag_m = |index: usize| {
            let bag = self.scene.organs().iter();
            let bag = bag.filter(|it| it.kind == OrganKind::Gallbladder as u32);
            let spheres = bag.flat_map(|it| it.spheres[0]..it.spheres[0] + it.spheres[1]);
            let spheres = spheres.filter_map(|it| self.scene.spheres().get(it as usize));
            let own = rest
                .get(index)
                .map(|it| at(&it.center_m))
                .unwrap_or_default();
            let away = spheres.map(|it| (at(&it.center_m) - own).norm());
            away.fold(f64::MAX, f64::min)
        };
        let mut order: Vec<usize> = (0..rest.len()).collect();
        if to_bag_m(0) < to_bag_m(rest.len().saturating_sub(1)) {
            order.reverse();
        }
        let exact = share * (order.len().saturating_sub(2)) as f64;
        let first = exact as usize;
        let center = |place: usize| Some(at(&now.get(*order.get(place)?)?.center_m));
        let (a, b) = (center(first)?, center(first + 1)?);
        Some((a.lerp(&b, exact.fract()), Some((b - a).normalize())))
    }

    /// Brings what the jaws bite with to a place, or so far before it; lines them up with it if it is to.
    fn reach(
        &mut self,
        place: &dyn Fn(&Self) -> Option<Place>,
        before_m: f64,
        line_up: bool,
    ) -> Result<(), String> {
        let speed_m_s = self.surgeon.speed_m_s();
        let line_up = line_up && self.surgeon != Surgeon::Hurried;
        let mut before = Instant::now();
        let there = self.look_for(GIVE_UP, |work| {
            let seconds = before.elapsed().as_secs_f64().min(0.05);
            before = Instant::now();
            let Some((place, runs)) = place(work) else {
                return false;
            };
            let along = work.along();
            // A place with a direction is to lie between the jaws; else the tip goes there.
            let past_m = if runs.is_some() {
                (1.0 - BITE) * JAW_M
            } else {
                0.0
            };
            let way = place + along * (past_m - before_m) - work.tip();
            let step = way * (4.0 * seconds);
            let step = step.cap_magnitude(speed_m_s * seconds);
            let local = rotation(&work.tools.world_from_camera).inverse() * step;
            for (sum, part) in work.message.moved_m.iter_mut().zip(local.iter()) {
                *sum += part;
            }
            let off = match runs.filter(|_| line_up) {
                Some(runs) => work.off(runs),
                None => 0.0,
            };
            let most = TURN_RAD_S * seconds;
            work.message.rolled_rad += (4.0 * off * seconds).clamp(-most, most);
            way.norm() < THERE_M && off.abs() < ALIGNED_RAD
        });
        self.is_stopped()?;
        match there {
            true => Ok(()),
            false => {
                let missed = place(self).map_or(f64::NAN, |(place, _)| (place - self.tip()).norm());
                Err(format!("{:.1} mm from where it wanted to be", missed * 1e3))
            }
        }
    }

    /// How far the jaws' hinge is turned off a tube that runs this way, about the shaft, rad: they take it
    /// when it runs along their hinge's axis (x).
    fn off(&self, runs: Vec3) -> f64 {
        let turned = rotation(&self.tools.world_from_instrument).inverse() * runs;
        let angle = turned.y.atan2(turned.x);
        // Either way round.
        let half = std::f64::consts::FRAC_PI_2;
        match angle {
            angle if angle > half => angle - 2.0 * half,
            angle if angle < -half => angle + 2.0 * half,
            angle => angle,
        }
    }

    /// From the port to the tip.
    fn along(&self) -> Vec3 {
        rotation(&self.tools.world_from_instrument) * -Vec3::z()
    }

    /// Where the jaws end when they are closed, or the hook.
    fn tip(&self) -> Vec3 {
        let joint = Vec3::from(self.tools.world_from_instrument.position_m.map(f64::from));
        joint + self.along() * JAW_M
    }
}

fn rotation(pose: &PoseMsg) -> UnitQuaternion<f64> {
    let [x, y, z, w] = pose.orientation.map(f64::from);
    UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_unclamped_takes_no_clip_and_the_careful_two_on_each() {
        let clips = |surgeon: Surgeon, task| {
            let plan = surgeon.plan(task);
            let applier = plan.iter().position(|act| *act == Act::Take(CLIPS));
            let scissors = plan.iter().position(|act| *act == Act::Take(SCISSORS));
            let closes = plan.iter().enumerate().filter(|(number, act)| {
                let with_clips = applier.is_some_and(|it| it < *number)
                    && scissors.is_none_or(|it| it > *number);
                matches!(act, Act::Close | Act::Work(..)) && with_clips
            });
            closes.count()
        };
        assert_eq!(clips(Surgeon::Careful, Task::Cut), 0, "they are there");
        assert_eq!(clips(Surgeon::Careful, Task::Full), 4);
        assert_eq!(clips(Surgeon::Careful, Task::Clamp), 4);
        assert_eq!(clips(Surgeon::Unclamped, Task::Cut), 0);
        assert_eq!(clips(Surgeon::Dropper, Task::Clamp), 3);
    }
}
