//! Measurement of an operation: the running totals from which the metrics are computed.

mod force;
mod hands;
mod noise;

use session::Movement;
use shared_mem::message::{Event, EventMsg};
use shared_mem::scene::OrganKind;
use shared_mem::words::{Current, Fault, Instrument, Switches};

pub use self::force::BIN_N;
use self::force::Force;
use self::hands::Hands;
pub(crate) use self::hands::Sight;
use self::noise::Noise;
use crate::anatomy::{Anatomy, Region};
use crate::metrics::{Metric, Values};
use crate::rules::Rules;
use crate::vector::{Vec3, axis, distance, dot, norm, off_sight, wide};

/// Longest time between two records of the hands that does not count as a gap, s.
const GAP_S: f64 = 0.25;
/// Half of the field of view of a 0° endoscope, rad (`display-host`, `Scope`).
pub(crate) const VIEW_HALF_RAD: f64 = 0.61;
/// Smallest turn of the direction of view that counts, rad.
const TURN_RULER_RAD: f64 = std::f64::consts::PI / 180.0;
/// Leaks within this distance of each other are one, m: all events of a leak have one position.
const SAME_LEAK_M: f64 = 0.000_1;
/// Time for which the current counts as burning after an event of burning, s. Events come 20 times
/// a second.
const BURNS_S: f64 = 0.1;

/// A leaking place.
#[derive(Debug, Clone, Copy)]
struct Leak {
    organ: u32,
    at_m: Vec3,
    /// Flow of the leak as a share of the flow of the fully cut vessel.
    flow: f64,
}

/// Running totals.
#[derive(Debug, Clone, Default)]
pub(crate) struct Tally {
    hands: Hands,
    force: Force,
    last: Option<(u64, Movement)>,
    time_s: f64,
    gaps_s: f64,
    paused_s: f64,
    /// Time without a device that the hand needed, s.
    device_lost_s: f64,
    /// Devices that were present or were reported silent so far, also in earlier attempts. The bits
    /// are those of `Movement::live`.
    seen: u8,
    noise: Noise,
    cautery_s: f64,
    cautery_air_s: f64,
    /// Time of the last event of burning, s.
    burnt_s: Option<f64>,
    /// Time with current outside the picture, s, and time with current that was outside the
    /// picture, in air, or both, s.
    cautery_blind_s: [f64; 2],
    out_of_view_s: f64,
    /// True if the tip is outside the picture.
    is_out: bool,
    acts_blind: u32,
    tilt_rad_s: f64,
    turn_rad: f64,
    sight: Option<Vec3>,
    exchanges: u32,
    leaks: Vec<Leak>,
    blood_ml: f64,
    bile_ml: f64,
    burns_j: [f64; 6],
    clips: Vec<u32>,
    clips_lost: u32,
    clips_misplaced: u32,
    perforations: u32,
    /// Numbers of the stones that spilled, and of those that are out of the body.
    stones: [Vec<u32>; 2],
    crushes: u32,
    slips: u32,
    removed: Vec<bool>,
    /// Removed volume of each region, m³.
    removed_in: [f64; Region::COUNT],
}

/// Bit of the haptic device in `Movement::live`.
const HAPTIC: u8 = 1;
/// Bit of the endoscope's tracker in `Movement::live`.
const TRACKER: u8 = 2;
/// Bit of the foot pedal in `Movement::live`.
const PEDAL: u8 = 4;
/// Largest number of leaks that are kept. More can only come from a vessel whose leak changes its
/// place all the time.
const LEAKS_MAX: usize = 64;

/// Largest number of stones that are kept: those of a scene, and the limit of a forged session.
const STONES_MAX: usize = 30;

impl Tally {
    /// Sets the greatest force of the haptic device, N.
    pub(crate) fn device(&mut self, force_max_n: f64) {
        self.force.device(force_max_n);
    }

    /// Starts over for a new attempt on the same device.
    pub(crate) fn again(&self) -> Self {
        Self {
            force: self.force.again(),
            seen: self.seen,
            ..Self::default()
        }
    }

    /// Number of clips and divisions outside the picture.
    pub(crate) fn acts_blind(&self) -> u32 {
        self.acts_blind
    }

    /// Counted time, s.
    pub(crate) fn time_s(&self) -> f64 {
        self.time_s
    }

    /// Takes the positions of the hands. Returns the counted time since the last call, s.
    pub(crate) fn moved(
        &mut self,
        at_ns: u64,
        moved: &Movement,
        anatomy: &Anatomy,
        rules: &Rules,
    ) -> f64 {
        let Some((before_ns, before)) = self.last.replace((at_ns, *moved)) else {
            return 0.0;
        };
        // No time passed if the clock stands or goes back.
        let seconds = at_ns.saturating_sub(before_ns) as f64 * 1e-9;
        if seconds <= 0.0 {
            return 0.0;
        }
        if let Some(other_s) = self.not_the_trainees(moved, &before, seconds) {
            *other_s += seconds;
            self.hands.gap();
            self.noise.gap();
            self.sight = None;
            return 0.0;
        }
        self.time_s += seconds;
        let places = |it: &Movement| [it.tip_m, it.world_from_camera.position_m].map(wide);
        let [tip, _] = places(moved);
        self.hands.step(places(&before), places(moved), seconds);
        let handle = wide(moved.world_from_handle.position_m);
        self.noise.step(handle, seconds);
        let touches = moved.contacts > 0;
        self.force.step(norm(wide(moved.force_n)), touches, seconds);
        self.look(moved, tip, anatomy.up, seconds);
        if moved.instrument() == Some(Instrument::Hook)
            && moved.switches().current() != Current::Off
        {
            self.cautery_s += seconds;
            let burns = self
                .burnt_s
                .is_some_and(|at_s| self.time_s - at_s < BURNS_S);
            let is_in_air = !touches && !burns;
            self.cautery_air_s += if is_in_air { seconds } else { 0.0 };
            let [blind_s, unsafe_s] = &mut self.cautery_blind_s;
            *blind_s += if self.is_out { seconds } else { 0.0 };
            *unsafe_s += if self.is_out || is_in_air {
                seconds
            } else {
                0.0
            };
        }
        if moved.instrument != before.instrument {
            self.exchanges += 1;
        }
        for leak in &self.leaks {
            let ml = leak.flow * rules.flow_ml_min(anatomy.kind(leak.organ)) / 60.0 * seconds;
            match is_duct(anatomy.kind(leak.organ)) {
                true => self.bile_ml += ml,
                false => self.blood_ml += ml,
            }
        }
        seconds
    }

    /// Returns the total that takes this time if it is not the trainee's: the total of pauses, of
    /// gaps, or of time without a device that the hand needs. Returns `None` if the time counts.
    /// Nobody can work without haptic device or tracker. Without the pedal there is no current, and
    /// only the hook needs current. So with any other instrument the time counts.
    fn not_the_trainees(
        &mut self,
        moved: &Movement,
        before: &Movement,
        seconds: f64,
    ) -> Option<&mut f64> {
        self.seen |= before.live | moved.live;
        let burns = [before, moved].map(|it| it.instrument() == Some(Instrument::Hook));
        let needed = HAPTIC | TRACKER | if burns == [true; 2] { PEDAL } else { 0 };
        let gone = self.seen & needed & !(before.live & moved.live);
        if (moved.switches() | before.switches()).contains(Switches::PAUSED) {
            Some(&mut self.paused_s)
        } else if seconds > GAP_S {
            Some(&mut self.gaps_s)
        } else {
            (gone != 0).then_some(&mut self.device_lost_s)
        }
    }

    fn look(&mut self, moved: &Movement, tip: Vec3, up: Vec3, seconds: f64) {
        let camera = &moved.world_from_camera;
        self.is_out = off_sight(camera, tip).0 > VIEW_HALF_RAD;
        self.out_of_view_s += if self.is_out { seconds } else { 0.0 };
        let right = dot(axis(camera, 0), up).clamp(-1.0, 1.0);
        self.tilt_rad_s += right.asin().abs() * seconds;
        let sight = axis(camera, 2);
        let from = *self.sight.get_or_insert(sight);
        let turn = (0.5 * distance(from, sight)).min(1.0).asin() * 2.0;
        if turn >= TURN_RULER_RAD {
            self.turn_rad += turn;
            self.sight = Some(sight);
        }
    }

    /// Takes an event.
    pub(crate) fn event(&mut self, event: &EventMsg, anatomy: &Anatomy) {
        let kind = anatomy.kind(event.organ);
        match event.decode() {
            Ok(Event::Burn { energy_j }) => {
                self.burnt_s = Some(self.time_s);
                let joule = f64::from(energy_j).max(0.0);
                if let Some(sum) = self.burns_j.get_mut(burn_class(kind)) {
                    *sum += joule;
                }
            }
            Ok(Event::Clip { number }) => self.clip(number, kind),
            Ok(Event::Divided { .. }) => {
                let last = self.last.as_ref();
                let held = last.and_then(|(_, moved)| moved.instrument());
                let cuts = held == Some(Instrument::Scissors);
                self.acts_blind += u32::from(cuts && self.is_out);
            }
            Ok(Event::Leak { flow }) => self.leak(event, flow),
            Ok(Event::Removed { cell }) => self.remove(cell as usize, anatomy),
            Ok(Event::Perforation { .. }) => self.perforations += 1,
            Ok(Event::StoneSpilled { stone }) => note_once(&mut self.stones[0], stone),
            // An event of its spill may be lost, and then the stone has spilled all the same.
            Ok(Event::StoneRetrieved { stone }) => {
                self.stones.iter_mut().for_each(|it| note_once(it, stone));
            }
            Ok(Event::Crush { .. }) => self.crushes += 1,
            Ok(Event::Slip { .. }) => self.slips += 1,
            // A device that is silent from the start counts as gone, too.
            Ok(Event::Fault(Fault::SilentDevice)) => self.seen |= HAPTIC,
            _ => {}
        }
    }

    /// Removes the triangle's tissue, as the controller did before the task.
    pub(crate) fn clear(&mut self, anatomy: &Anatomy) {
        for index in &anatomy.cleared {
            self.remove(*index, anatomy);
        }
    }

    fn remove(&mut self, index: usize, anatomy: &Anatomy) {
        self.removed.resize(anatomy.cells.len(), false);
        if let Some(removed) = self.removed.get_mut(index)
            && !core::mem::replace(removed, true)
            && let Some((region, volume_m3)) = anatomy.cells.get(index)
            && let Some(sum) = self.removed_in.get_mut(*region as usize)
        {
            *sum += volume_m3;
        }
    }

    fn clip(&mut self, number: u32, kind: Option<OrganKind>) {
        if !self.clips.contains(&number) {
            self.clips.push(number);
            self.acts_blind += u32::from(self.is_out);
        }
        match kind {
            None => self.clips_lost += 1,
            Some(OrganKind::CysticDuct | OrganKind::CysticArtery) => {}
            // Fat or connective tissue may lie between the jaws together with the vessel, which is
            // no error.
            Some(OrganKind::Fat | OrganKind::ConnectiveTissue) => {}
            Some(_) => self.clips_misplaced += 1,
        }
    }

    fn leak(&mut self, event: &EventMsg, flow: f32) {
        let (at_m, flow) = (wide(event.at_m), f64::from(flow).clamp(0.0, 10.0));
        let distance_m = |leak: &Leak| distance(leak.at_m, at_m);
        let same = self
            .leaks
            .iter()
            .enumerate()
            .filter(|(_, leak)| leak.organ == event.organ && distance_m(leak) < SAME_LEAK_M)
            .min_by(|a, b| distance_m(a.1).total_cmp(&distance_m(b.1)))
            .map(|(index, _)| index);
        if let Some(leak) = same.and_then(|index| self.leaks.get_mut(index)) {
            (leak.at_m, leak.flow) = (at_m, flow);
        } else if self.leaks.len() < LEAKS_MAX {
            let organ = event.organ;
            self.leaks.push(Leak { organ, at_m, flow });
        }
        self.leaks.retain(|leak| leak.flow > 0.0);
    }

    /// Removed share of these regions' tissue, by volume; NaN if they have none.
    pub(crate) fn removed(&self, anatomy: &Anatomy, regions: &[Region]) -> f64 {
        let sum = |volumes: &[f64]| -> f64 {
            let of = |region: &Region| volumes.get(*region as usize).copied();
            regions.iter().filter_map(of).sum()
        };
        sum(&self.removed_in) / sum(&anatomy.volume_in)
    }

    /// Time in each bin of force while the instrument touched, s. A bin is [`BIN_N`] wide.
    pub(crate) fn force_histogram(&self) -> Vec<f64> {
        self.force.histogram()
    }

    /// Number of spilled stones that are still in the body.
    pub(crate) fn stones_left(&self) -> u32 {
        let [spilled, retrieved] = &self.stones;
        spilled.len().saturating_sub(retrieved.len()) as u32
    }

    /// The metrics counted here; procedure and assessment set the rest.
    pub(crate) fn values(&self, anatomy: &Anatomy) -> Values {
        let mut values = Values::none();
        let [tip, lens] = self.hands.tracks();
        let [liver, gallbladder, duct, vessel, target, _] = self.burns_j;
        let [blind_s, unsafe_s] = self.cautery_blind_s;
        let [spilled, retrieved] = [0, 1].map(|k: usize| self.stones[k].len() as f64);
        for (metric, value) in [
            (Metric::Time, self.time_s),
            (Metric::Gaps, self.gaps_s),
            (Metric::Paused, self.paused_s),
            (Metric::DeviceLost, self.device_lost_s),
            (Metric::Noise, self.noise.mm()),
            (Metric::Path, tip.path_m()),
            (Metric::ScopePath, lens.path_m()),
            (Metric::Movements, tip.movements().into()),
            (Metric::ScopeMovements, lens.movements().into()),
            (Metric::Economy, tip.economy()),
            (Metric::Smoothness, tip.smoothness()),
            (Metric::ScopeSmoothness, lens.smoothness()),
            (Metric::BothMoving, self.hands.both_moving()),
            (Metric::Idle, self.hands.idle_s()),
            (Metric::ForceMax, self.force.max_n),
            (Metric::ForceMean, self.force.mean_n()),
            (Metric::Force95, self.force.quantile_n(0.95)),
            (Metric::ForceSaturated, self.force.saturated_s),
            (Metric::CauteryOn, self.cautery_s),
            (Metric::CauteryAir, self.cautery_air_s),
            (Metric::CauteryBlind, blind_s),
            (Metric::CauterySafe, 1.0 - unsafe_s / self.cautery_s),
            (Metric::ActsBlind, self.acts_blind.into()),
            (Metric::BurnLiver, liver),
            (Metric::BurnGallbladder, gallbladder),
            (Metric::BurnDuct, duct),
            (Metric::BurnVessel, vessel),
            (Metric::BurnTarget, target),
            (Metric::ClipsUsed, self.clips.len() as f64),
            (Metric::ClipsLost, self.clips_lost.into()),
            (Metric::ClipsMisplaced, self.clips_misplaced.into()),
            (Metric::Blood, self.blood_ml),
            (Metric::Bile, self.bile_ml),
            (Metric::StonesSpilled, spilled),
            (Metric::StonesRetrieved, retrieved),
            (Metric::StonesLeft, spilled - retrieved),
            (Metric::Perforations, self.perforations.into()),
            (Metric::Crushes, self.crushes.into()),
            (Metric::Slips, self.slips.into()),
            (Metric::OutOfView, self.out_of_view_s),
            (Metric::ScopeTurn, self.turn_rad.to_degrees()),
            (
                Metric::ScopeTilt,
                (self.tilt_rad_s / self.time_s).to_degrees(),
            ),
            (Metric::Exchanges, self.exchanges.into()),
            (
                Metric::CvsTriangle,
                self.removed(anatomy, &[Region::Triangle]),
            ),
            (Metric::CvsBed, self.removed(anatomy, &[Region::LowerBed])),
            (
                Metric::Bed,
                self.removed(anatomy, &[Region::LowerBed, Region::UpperBed]),
            ),
        ] {
            values.set(metric, value);
        }
        values
    }
}

/// Adds a stone that is not in the list yet.
fn note_once(stones: &mut Vec<u32>, stone: u32) {
    if !stones.contains(&stone) && stones.len() < STONES_MAX {
        stones.push(stone);
    }
}

/// Class of burnt tissue, an index into `burns_j`: liver, gallbladder, ducts, arteries, tissue to
/// dissect, all else.
fn burn_class(kind: Option<OrganKind>) -> usize {
    match kind {
        Some(OrganKind::Liver) => 0,
        Some(OrganKind::Gallbladder) => 1,
        Some(OrganKind::CysticDuct | OrganKind::BileDuct) => 2,
        Some(OrganKind::CysticArtery | OrganKind::Vessel) => 3,
        kind if is_target(kind) => 4,
        _ => 5,
    }
}

/// True for tissue that the trainee may remove.
pub(crate) fn is_target(kind: Option<OrganKind>) -> bool {
    matches!(kind, Some(OrganKind::Fat | OrganKind::ConnectiveTissue))
}

/// True for an organ that carries bile.
fn is_duct(kind: Option<OrganKind>) -> bool {
    let bile = [
        OrganKind::CysticDuct,
        OrganKind::BileDuct,
        OrganKind::Gallbladder,
    ];
    kind.is_some_and(|kind| bile.contains(&kind))
}
