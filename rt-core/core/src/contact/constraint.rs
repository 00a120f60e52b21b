//! Contact constraints between tools and tissue, and their solver.
//!
//! A constraint demands that a tool and the tissue under it do not overlap. Two things take up the
//! overlap: the spheres move away, and the contact model makes a dent. The model is a half-space
//! ([`crate::contact::law`]) or the wall of a tube. The contact force pushes the spheres, and the
//! hand feels it. The constraints of an organ are solved by Gauss–Seidel in every substep, starting
//! from the last forces (warm start).

use heapless::Vec;

use crate::capacity::{INSTRUMENT_POINTS, MAX_CONTACT_CONSTRAINTS, MAX_ORGANS};
use crate::contact::dent::Dent;
use crate::contact::friction::Bristle;
use crate::contact::influence::{Influences, LoadedContact};
use crate::contact::law::Law;
use crate::contact::patch::Patch;
use crate::fault::{Fault, FaultSet};
use crate::math::{self, Vec3};
use crate::time::TICK_S;
use crate::tissue::Bodies;
use crate::tool::{Role, Tool};

/// Gauss–Seidel passes over an organ's contact constraints in a substep. More passes couple
/// contacts on one skin better, and cost time in proportion.
const PASSES: u32 = 4;
/// Share of the last contact forces that acts on a solid before the solid's constraints are solved;
/// the rest acts after them. [`crate::contact`] gives the reason. The share is fitted to
/// gallbladders of 250 to 2500 spheres. Their exact force is the one with twelve times as many
/// substeps. With ¾, the force is nearly exact; with 0, it is up to 17 % too small. `evaluate
/// force` shows the remaining difference to finite elements.
const WARM_START_SHARE: f32 = 0.75;

/// Damping of a tube under a tool, per second. It stands for the fluid and tissue around a thin
/// tube. Without damping, the tube would vibrate on its wall spring and bounce off the tool. The
/// damping acts on the speed relative to the world, so it holds back a tube that the tool carries
/// along, with a force of mass × this rate × speed: a few mN for a duct. A larger rate damps the
/// tube more and holds it back more.
const DAMPING_PER_S: f32 = 1500.0;

/// Separation, m, below which a candidate may touch before the tick ends. A fault is raised if such
/// a candidate is dropped for lack of room.
pub(crate) const CANDIDATE_MARGIN_M: f32 = 0.001;

/// Pair of places, on a tool and on tissue, that identifies a contact from tick to tick.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum ContactSite {
    /// A point of the tools on the skin of the constraint's organ.
    Skin { point: u8 },
    /// A part of the tools on a bead of a tube.
    Tube { bead: u16, part: Role },
}

/// Model of the dent by which tissue yields more than its spheres do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum ContactModel {
    /// A half-space under a tool of this shape.
    HalfSpace(Law),
    /// The wall of a tube: a spring that stiffens as the tube is pressed flat.
    Wall {
        /// Stiffness at first touch, N/m.
        wall_n_m: f32,
        /// Compression, m, at which the tube would be flat. There the wall is three times as stiff
        /// as at first touch.
        flat_m: f32,
        /// Compliance of the tissue behind the wall within a tick, m/N: an estimate that is never
        /// too large.
        backing_compliance_m_n: f32,
    },
}

impl ContactModel {
    /// Share of the last force that acts before the constraints are solved.
    const fn warm_start_share(&self) -> f32 {
        match self {
            Self::HalfSpace(_) => WARM_START_SHARE,
            Self::Wall { .. } => 0.0,
        }
    }

    /// Stiffness that the tool feels, N/m: a spring of `stiffness_n_m` in series with the tissue
    /// behind it.
    fn felt_stiffness_n_m(&self, stiffness_n_m: f32) -> f32 {
        match self {
            Self::HalfSpace(_) => stiffness_n_m,
            Self::Wall {
                backing_compliance_m_n,
                ..
            } => stiffness_n_m / (1.0 + stiffness_n_m * backing_compliance_m_n),
        }
    }

    /// Force F ≥ 0, N, that removes the overlap at this separation, and its slope, N/m. The
    /// separation is negative where tool and tissue overlap. The spheres yield with
    /// `sphere_compliance_m_n` within the step.
    fn force_n(&self, separation_m: f32, sphere_compliance_m_n: f32) -> (f32, f32) {
        match self {
            Self::HalfSpace(law) => law.force_n(separation_m, sphere_compliance_m_n),
            Self::Wall {
                wall_n_m, flat_m, ..
            } if separation_m < 0.0 => {
                let (force_n, slope_n_m) =
                    wall_force(*wall_n_m, *flat_m, -separation_m, sphere_compliance_m_n);
                (force_n, self.felt_stiffness_n_m(slope_n_m))
            }
            Self::Wall { .. } => (0.0, 0.0),
        }
    }
}

/// Force, N, and stiffness, N/m, of a wall under the compression d: `F = k d (1 + d / D)`. The
/// spheres behind the wall yield by `y F` within the step. So `d + y F` equals the overlap, a
/// quadratic equation in d.
fn wall_force(
    wall_n_m: f32,
    flat_m: f32,
    overlap_m: f32,
    sphere_compliance_m_n: f32,
) -> (f32, f32) {
    let per_flat_m = flat_m.max(1.0e-6).recip();
    let a = sphere_compliance_m_n * wall_n_m * per_flat_m;
    let b = 1.0 + sphere_compliance_m_n * wall_n_m;
    // This form of the root has no cancellation of digits.
    let compression_m = 2.0 * overlap_m / (b + math::sqrt(b * b + 4.0 * a * overlap_m));
    let force_n = wall_n_m * compression_m * (1.0 + compression_m * per_flat_m);
    (force_n, wall_n_m * (1.0 + 2.0 * compression_m * per_flat_m))
}

/// A persistent contact's force, carried to the next tick.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct CachedForce {
    /// Along the normal, N.
    pub(crate) force_n: f32,
    pub(crate) bristle: Bristle,
}

impl CachedForce {
    /// The force of no contact.
    pub(crate) const ZERO: Self = Self {
        force_n: 0.0,
        bristle: Bristle::RELAXED,
    };
}

/// A tool near or on tissue, and the force between them.
#[derive(Debug, Clone)]
pub(crate) struct ContactConstraint {
    pub(crate) organ: u8,
    pub(crate) site: ContactSite,
    /// Spheres that bear the contact.
    pub(crate) patch: Patch,
    /// Unit vector from tissue to tool.
    pub(crate) normal: Vec3,
    /// Point of the tool's axis at the contact, world frame, m.
    pub(crate) center_m: Vec3,
    /// Vector from `center_m` to one end of the piece of the axis that touches, m. It is zero for a
    /// round end, and on a tube.
    half_m: Vec3,
    /// Radius of the tool here, m.
    radius_m: f32,
    /// Contact point on the tissue, world frame, m.
    pub(crate) at_m: Vec3,
    pub(crate) model: ContactModel,
    /// Separation before the solve, m; negative where tool and tissue overlap.
    pub(crate) separation_m: f32,
    /// Travel of the tool's point in this tick, m.
    pub(crate) travel_m: Vec3,
    /// Coefficient of friction μ.
    pub(crate) friction: f32,
    pub(crate) bristle: Bristle,
    /// Normal force of the tissue on the tool in the last substep, N.
    pub(crate) force_n: f32,
    friction_n: Vec3,
    /// Normal force, N, summed over the substeps so far, each weighted by its share of the tick. At
    /// the end of the tick this is the mean force, which the tool feels.
    pub(crate) mean_force_n: f32,
    /// Friction, N, summed as `mean_force_n`.
    pub(crate) mean_friction_n: Vec3,
    /// Stiffness along the normal, N/m.
    pub(crate) stiffness_n_m: f32,
    /// Stiffness of the friction along the skin, N/m; 0 while the contact slides.
    pub(crate) friction_stiffness_n_m: f32,
    /// Position of the patch before the solve, m.
    patch_start_m: Vec3,
    /// Height of `center_m` over the patch at which the separation is zero, m. On skin it is the
    /// tool's radius, plus the height of the curved skin over the patch, minus the depth by which
    /// the skin has sunk, minus the offset of [`crate::contact::separation`].
    touching_height_m: f32,
    inverse_mass_per_kg: f32,
}

/// A contact before it is solved; becomes a [`ContactConstraint`].
#[derive(Debug, Clone)]
pub(crate) struct Candidate {
    pub(crate) organ: u8,
    pub(crate) site: ContactSite,
    pub(crate) patch: Patch,
    pub(crate) normal: Vec3,
    pub(crate) center_m: Vec3,
    pub(crate) half_m: Vec3,
    pub(crate) radius_m: f32,
    pub(crate) at_m: Vec3,
    pub(crate) model: ContactModel,
    pub(crate) separation_m: f32,
    pub(crate) travel_m: Vec3,
    pub(crate) friction: f32,
    /// Stiffness of the friction bristle, N/m.
    pub(crate) bristle_stiffness_n_m: f32,
    pub(crate) cached: CachedForce,
}

impl ContactSite {
    /// Tool that touches here.
    pub(crate) fn tool(self) -> Tool {
        match self {
            Self::Skin { point } if usize::from(point) >= INSTRUMENT_POINTS => Tool::Endoscope,
            Self::Skin { .. } => Tool::Instrument,
            Self::Tube { part, .. } => part.tool(),
        }
    }
}

impl ContactConstraint {
    /// Data of this contact that give its displacement of the other contacts. `number` is the index
    /// of this contact among all constraints.
    fn loaded(&self, number: usize) -> LoadedContact {
        let law = match self.model {
            ContactModel::HalfSpace(law) => Some(law),
            ContactModel::Wall { .. } => None,
        };
        LoadedContact::new(number, self.normal, self.at_m, self.force_n, law)
    }

    fn new(candidate: Candidate, bodies: &Bodies) -> Self {
        let patch_m = candidate.patch.at_m(bodies);
        let (normal, force_n) = (candidate.normal, candidate.cached.force_n);
        let bristle = candidate
            .cached
            .bristle
            .on(&normal, candidate.bristle_stiffness_n_m);
        // Friction begins with the force of the last tick, within its new limit.
        let friction_n = bristle.pull_n(&Vec3::zeros(), &normal, 0.0, candidate.friction * force_n);
        Self {
            organ: candidate.organ,
            site: candidate.site,
            normal,
            center_m: candidate.center_m,
            half_m: candidate.half_m,
            radius_m: candidate.radius_m,
            at_m: candidate.at_m,
            model: candidate.model,
            separation_m: candidate.separation_m,
            travel_m: candidate.travel_m,
            friction: candidate.friction,
            bristle,
            force_n,
            friction_n,
            mean_force_n: 0.0,
            mean_friction_n: Vec3::zeros(),
            stiffness_n_m: 0.0,
            friction_stiffness_n_m: 0.0,
            patch_start_m: patch_m,
            touching_height_m: normal.dot(&(candidate.center_m - patch_m)) - candidate.separation_m,
            inverse_mass_per_kg: candidate.patch.inverse_mass_per_kg(bodies),
            patch: candidate.patch,
        }
    }

    /// The dent after the solve: the overlap that is left when the spheres have moved. `None` if
    /// the tool does not press.
    fn dent(&self, bodies: &Bodies) -> Option<Dent> {
        let height_m = (self.normal).dot(&(self.center_m - self.patch.at_m(bodies)));
        let depth_m = self.touching_height_m - height_m;
        (self.mean_force_n > 0.0 && depth_m > 0.0).then_some(Dent {
            organ: self.organ,
            center_m: self.center_m,
            half_m: self.half_m,
            radius_m: self.radius_m,
            normal: self.normal,
            depth_m,
        })
    }

    /// Force and bristle for the next tick.
    pub(crate) fn cached(&self) -> CachedForce {
        CachedForce {
            force_n: self.force_n,
            bristle: self.bristle.after(&self.friction_n),
        }
    }
}

/// All contact constraints of a tick.
#[derive(Debug, Clone, Default)]
pub(crate) struct ContactConstraints {
    all: Vec<ContactConstraint, MAX_CONTACT_CONSTRAINTS>,
    /// For each organ, one bit per constraint in `all` that belongs to it. So an organ without
    /// constraints costs no search.
    constraint_bits: [u64; MAX_ORGANS],
}

const _: () = assert!(MAX_CONTACT_CONSTRAINTS <= 64, "each constraint needs a bit");

/// The bits that are set, the lowest first.
fn set_bits(mut bits: u64) -> impl Iterator<Item = usize> {
    core::iter::from_fn(move || {
        let lowest = (bits != 0).then(|| bits.trailing_zeros() as usize);
        bits &= bits.wrapping_sub(1);
        lowest
    })
}

impl ContactConstraints {
    pub(crate) fn clear(&mut self) {
        self.all.clear();
        self.constraint_bits = [0; MAX_ORGANS];
    }

    /// Constraints of an organ, each with its number, in their order.
    fn of_organ(&self, organ: u8) -> impl Iterator<Item = (usize, &ContactConstraint)> {
        let bits = self.constraint_bits.get(usize::from(organ));
        let numbers = set_bits(bits.copied().unwrap_or(0));
        numbers.filter_map(|number| Some((number, self.all.get(number)?)))
    }

    /// Records whether the constraint with this number belongs to `organ`.
    fn set_owner_bit(&mut self, number: usize, organ: u8, is_own: bool) {
        if let Some(bits) = self.constraint_bits.get_mut(usize::from(organ)) {
            let bit = 1 << (number & 63);
            *bits = if is_own { *bits | bit } else { *bits & !bit };
        }
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = &ContactConstraint> {
        self.all.iter()
    }

    /// The dents of the tools in the tissue, after the solve.
    pub(crate) fn dents(&self, bodies: &Bodies) -> impl Iterator<Item = Dent> {
        self.iter().filter_map(|constraint| constraint.dent(bodies))
    }

    /// Adds a constraint. When there is no room, the shallowest constraint is dropped.
    pub(crate) fn add(&mut self, candidate: Candidate, bodies: &Bodies, faults: &mut FaultSet) {
        let (organ, number) = (candidate.organ, self.all.len());
        let Err(constraint) = self.all.push(ContactConstraint::new(candidate, bodies)) else {
            self.set_owner_bit(number, organ, true);
            return;
        };
        let mut dropped_separation_m = constraint.separation_m;
        let shallowest = self.all.iter_mut().enumerate().reduce(|a, b| {
            if b.1.separation_m > a.1.separation_m {
                b
            } else {
                a
            }
        });
        if let Some((number, shallowest)) =
            shallowest.filter(|it| it.1.separation_m > constraint.separation_m)
        {
            dropped_separation_m = shallowest.separation_m;
            let removed = shallowest.organ;
            *shallowest = constraint;
            self.set_owner_bit(number, removed, false);
            self.set_owner_bit(number, organ, true);
        }
        faults.raise_if(
            dropped_separation_m < CANDIDATE_MARGIN_M,
            Fault::ContactOverflow,
        );
    }

    /// Pushes organ `organ` with a share of the last forces ([`WARM_START_SHARE`]), in a substep of
    /// `step_s`, before the organ's constraints are solved. Tubes are damped instead. Friction has
    /// no warm start: it would drag tissue that has slid since the last substep, and make the
    /// tissue shake.
    pub(crate) fn warm_start(&self, organ: u8, step_s: f32, bodies: &mut Bodies) {
        let is_loaded = |(_, constraint): &(usize, &ContactConstraint)| constraint.force_n > 0.0;
        for (_, constraint) in self.of_organ(organ).filter(is_loaded) {
            if let ContactModel::Wall { .. } = constraint.model {
                constraint
                    .patch
                    .damp((DAMPING_PER_S * step_s).min(1.0), bodies);
                continue;
            }
            let push = constraint.normal
                * (-constraint.force_n * constraint.model.warm_start_share() * step_s * step_s);
            constraint.patch.push(&push, bodies);
        }
    }

    /// Solves the constraints of organ `organ`, in a substep of `step_s`, after
    /// [`ContactConstraints::warm_start`].
    pub(crate) fn solve(&mut self, organ: u8, step_s: f32, bodies: &mut Bodies) {
        let step_squared_s2 = step_s * step_s;
        // First the rest of the last forces acts, so that the passes compute only changes.
        let is_loaded = |(_, constraint): &(usize, &ContactConstraint)| constraint.force_n > 0.0;
        for (_, constraint) in self.of_organ(organ).filter(is_loaded) {
            let remaining_n = (1.0 - constraint.model.warm_start_share()) * constraint.force_n;
            let push = (constraint.normal * remaining_n + constraint.friction_n) * -step_squared_s2;
            constraint.patch.push(&push, bodies);
        }
        let mut influences = Influences::new(
            self.of_organ(organ)
                .map(|(i, constraint)| constraint.loaded(i)),
        );
        for _ in 0..PASSES {
            for index in 0..influences.len() {
                let Some(constraint) = influences.constraint(index).and_then(|i| self.all.get(i))
                else {
                    continue;
                };
                let sphere_compliance_m_n = constraint.inverse_mass_per_kg * step_squared_s2;
                let patch_m = constraint.patch.at_m(bodies);
                let height_m = constraint.normal.dot(&(constraint.center_m - patch_m));
                // The separation without this contact's own force.
                let separation_m = height_m
                    - constraint.touching_height_m
                    - sphere_compliance_m_n * constraint.force_n;
                if separation_m >= 0.0 && constraint.force_n <= 0.0 {
                    // This contact has no force and gets none, because the others can only press
                    // the skin away from it.
                    continue;
                }
                let separation_m = separation_m + influences.displacement_by_others_m(index);
                let (force_n, stiffness_n_m) = constraint
                    .model
                    .force_n(separation_m, sphere_compliance_m_n);
                // The travel of the tool relative to the tissue, if this contact had no friction.
                // The bristle uses its part along the skin.
                let relative_travel_m = constraint.travel_m
                    - (patch_m - constraint.patch_start_m)
                    - constraint.friction_n * sphere_compliance_m_n;
                let friction_max_n = constraint.friction * force_n;
                let friction_n = constraint.bristle.pull_n(
                    &relative_travel_m,
                    &constraint.normal,
                    sphere_compliance_m_n,
                    friction_max_n,
                );
                let change_n = constraint.normal * (constraint.force_n - force_n)
                    + (constraint.friction_n - friction_n);
                constraint.patch.push(&(change_n * step_squared_s2), bodies);
                influences.set_force(index, force_n);
                if let Some(constraint) = influences
                    .constraint(index)
                    .and_then(|i| self.all.get_mut(i))
                {
                    constraint.force_n = force_n;
                    constraint.stiffness_n_m = stiffness_n_m;
                    constraint.friction_n = friction_n;
                    // A sliding or frictionless contact adds no stiffness along the skin.
                    let sticks = math::norm(&friction_n) < 0.999 * friction_max_n;
                    // `backing_compliance_m_n` of a wall already includes the compliance of the
                    // spheres.
                    let felt_stiffness_n_m = match constraint.model {
                        ContactModel::HalfSpace(_) => {
                            constraint.bristle.felt_stiffness_n_m(sphere_compliance_m_n)
                        }
                        ContactModel::Wall { .. } => constraint
                            .model
                            .felt_stiffness_n_m(constraint.bristle.felt_stiffness_n_m(0.0)),
                    };
                    constraint.friction_stiffness_n_m =
                        if sticks { felt_stiffness_n_m } else { 0.0 };
                }
            }
        }
        let share = step_s / TICK_S;
        for index in 0..influences.len() {
            if let Some(constraint) = influences
                .constraint(index)
                .and_then(|i| self.all.get_mut(i))
            {
                constraint.mean_force_n += constraint.force_n * share;
                constraint.mean_friction_n += constraint.friction_n * share;
            }
        }
    }
}
