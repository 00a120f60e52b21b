//! Contact of tools with organs without a contact skin: ducts and vessels, as beads (balls) along a
//! line.
//!
//! Stage `contact` ([`TubeContacts::find`]) sweeps the motion of a tick: it follows every part of a
//! tool past every bead near it, so that a fast part does not jump through a tube. O(beads of
//! organs near · parts).

mod sweep;
#[cfg(test)]
mod tests;

use heapless::Vec;

use crate::capacity::{MAX_CAPSULES, MAX_ORGANS, MAX_TUBE_CONTACTS};
use crate::contact::constraint::{
    CANDIDATE_MARGIN_M, CachedForce, Candidate, ContactConstraints, ContactModel, ContactSite,
};
use crate::contact::friction::tangential_over_normal_compliance;
use crate::contact::part_box::part_box;
use crate::contact::patch::Patch;
use crate::contact::separation::FilteredSeparation;
use crate::contact::skin::SLIP_M;
use crate::fault::{Fault, FaultSet};
use crate::math::{self, Vec3};
use crate::scene::{Material, Scene};
use crate::time::TICK_S;
use crate::tissue::tubes::{Ball, Bead};
use crate::tissue::{Bodies, Bounds};
use crate::tool::{Capsule, Role};
use crate::words::SphereBits;
use sweep::{Axis, Motion, Side};

/// Distance from a tool within which a bead is tracked, m: the travel of tool and bead in a tick.
const TRACKING_RANGE_M: f32 = 0.0065;
/// Separation below which a bead goes to the solver, because it may touch before the tick ends, m:
/// the travel of the fastest sphere in a tick.
const NEAR_M: f32 = 0.003;

/// In a tick, the lagging direction of a tube changes by this share of its difference from the true
/// direction. A force that turned with the tube at once would be a follower load, under which a
/// thin tube flutters (Beck's column, Bolotin 1963). With a larger share the force follows faster,
/// and is closer to flutter.
const DIRECTION_UPDATE_SHARE: f32 = 0.02;
/// Compression at which a tube is flat, in radii of the tube. Its walls take the rest of its
/// diameter.
const FLAT_COMPRESSION_RADII: f32 = 1.6;
/// Depth beyond which a part counts as having passed through a tube, in multiples of the sum of
/// both radii. [`PASSED_TRAVELS`] adds to this depth.
const PASSED_REACHES: f32 = 2.0;
/// Addition to the depth of `PASSED_REACHES`, in multiples of the travel of part and bead in the
/// tick.
const PASSED_TRAVELS: f32 = 2.0;
/// Largest offset of a contact that opens, m: a tube that is farther from the tool than this does
/// not push.
const OPENING_MAX_M: f32 = 0.000_3;

/// Share of the remaining fade that one tick makes. The force on a bead in the jaws fades out, and
/// the force on a released bead fades in. With this share, three quarters of a fade take 0.2 s.
const HOLD_FADE_SHARE: f32 = 0.007;

/// Contact of a part of a tool with a bead near it, at the end of a tick.
#[derive(Debug, Clone, Copy)]
struct PersistentContact {
    bead: u16,
    part: Role,
    side: Side,
    bead_m: Vec3,
    /// Direction of the tube at the bead, which lags behind the true direction
    /// ([`DIRECTION_UPDATE_SHARE`]).
    along: Vec3,
    separation: FilteredSeparation,
    cached: CachedForce,
    /// Share of the contact force that acts: it fades to 0 while the jaws hold the bead, and back
    /// to 1 afterwards.
    free_share: f32,
    /// Share of the bead's full stiffness that acts now: `free_share` × [`Side::weight`] × the
    /// share of the tissue that is neither damaged nor removed.
    weight: f32,
}

impl PersistentContact {
    /// Weighted overlap, m: a measure of the load, by which neighbouring beads are compared.
    fn load_m(&self) -> f32 {
        self.weight * (-self.separation.separation_m).max(0.0)
    }
}

/// Contacts of the last tick, with the place of one bead among them.
#[derive(Clone, Copy)]
struct LastTick<'a> {
    /// Sorted by bead.
    contacts: &'a [PersistentContact],
    /// Index of the first contact of this bead or a later one.
    start: usize,
}

impl<'a> LastTick<'a> {
    fn contact(&self, bead: u16, part: Role) -> Option<&'a PersistentContact> {
        let own = self.contacts.get(self.start..)?.iter();
        let mut own = own.take_while(|contact| contact.bead == bead);
        own.find(|contact| contact.part == part)
    }
}

/// All beads near the tools.
#[derive(Debug, Clone, Default)]
pub(crate) struct TubeContacts {
    /// Sorted by bead.
    contacts: Vec<PersistentContact, MAX_TUBE_CONTACTS>,
    /// Parts of the tools in the last tick.
    parts: Vec<Capsule, MAX_CAPSULES>,
}

impl TubeContacts {
    /// Forgets everything.
    pub(crate) fn clear(&mut self) {
        self.contacts.clear();
        self.parts.clear();
    }

    /// Spheres that carry the beads near a tool.
    pub(crate) fn near_spheres(&self, bodies: &Bodies) -> impl Iterator<Item = u32> {
        let beads = self
            .contacts
            .iter()
            .filter_map(|t| bodies.beads.get(t.bead));
        beads.flat_map(|bead| [u32::from(bead.a), u32::from(bead.b)])
    }

    /// Finds the beads near `parts` and adds their constraints, before the solve.
    pub(crate) fn find(
        &mut self,
        parts: &[Capsule],
        scene: &Scene<'_>,
        bounds: &[Bounds; MAX_ORGANS],
        bodies: &Bodies,
        constraints: &mut ContactConstraints,
        faults: &mut FaultSet,
    ) {
        let before = core::mem::take(&mut self.contacts);
        let mut cursor = before.iter();
        for ((organ, it), bounds) in (0u8..).zip(scene.organs).zip(bounds) {
            let mut near: Vec<&Capsule, MAX_CAPSULES> = Vec::new();
            for part in parts {
                if part_box(part).is_near(bounds, TRACKING_RANGE_M) {
                    let _ = near.push(part); // room for all parts
                }
            }
            if near.is_empty() {
                continue;
            }
            for (number, bead) in bodies.beads.of(organ) {
                let ball = bead.present_ball(bodies);
                while cursor.as_slice().first().is_some_and(|t| t.bead < number) {
                    let _ = cursor.next();
                }
                let last_tick = LastTick {
                    contacts: &before,
                    start: before.len() - cursor.len(),
                };
                for part in near.iter().filter(|part| may_touch(part, &ball)) {
                    let last = last_tick.contact(number, part.role);
                    let along = last.map_or(ball.along, |last| lagged(&last.along, &ball.along));
                    let ball = Ball { along, ..ball };
                    let (mut contact, travel_m) =
                        self.track(part, (number, bead), &ball, last_tick, bodies);
                    let is_in_jaws = is_in_jaws(bead, bodies);
                    let free_share = if is_in_jaws { 0.0 } else { 1.0 };
                    // A bead in the jaws that does not touch the part has no force that must fade,
                    // so its stiffness vanishes at once. Otherwise the closing jaws would squeeze
                    // it out.
                    let fade = match is_in_jaws && contact.separation.separation_m > 0.0 {
                        true => 1.0,
                        false => HOLD_FADE_SHARE,
                    };
                    contact.free_share += fade * (free_share - contact.free_share);
                    let link_share = bead
                        .link
                        .map_or(1.0, |link| bodies.damage.intact_of_link(link));
                    let [a, b] = [bead.a, bead.b].map(|i| bodies.cells.remaining_share(i.into()));
                    let intact_share = link_share * a.min(b);
                    contact.weight = intact_share
                        * contact.free_share
                        * contact.side.weight(
                            &axis(part),
                            &ball.center_m,
                            &ball.along,
                            ball.radius_m + part.radius_m,
                        );
                    if contact.separation.separation_m < NEAR_M && contact.weight > 0.0 {
                        let site = ContactSite::Tube {
                            bead: number,
                            part: part.role,
                        };
                        let found = candidate(
                            (organ, &it.material),
                            site,
                            (bead, contact.weight),
                            (part, ball.radius_m),
                            &contact,
                            bodies,
                        );
                        constraints.add(Candidate { travel_m, ..found }, bodies, faults);
                    }
                    self.keep(contact, faults);
                }
            }
        }
        self.parts.clear();
        let _ = self.parts.extend_from_slice(parts); // room for all parts
    }

    /// Tracks a part past a bead; returns the contact and the travel of the part's point, m.
    fn track(
        &self,
        part: &Capsule,
        (number, bead): (u16, &Bead),
        ball: &Ball,
        last_tick: LastTick<'_>,
        bodies: &Bodies,
    ) -> (PersistentContact, Vec3) {
        let reach_m = ball.radius_m + part.radius_m;
        let now = axis(part);
        let first = Side::first(&now, &ball.center_m, &ball.along);
        let separation_m = |side: &Side| side.separation_m(&now, &ball.center_m, reach_m);
        let last = last_tick.contact(number, part.role);
        let before = self.parts.iter().find(|before| before.role == part.role);
        let motion = last.zip(before).map(|(last, before)| Motion {
            axis: [axis(before), now],
            bead_m: [last.bead_m, ball.center_m],
            along: ball.along,
            reach_m,
            slip_m: SLIP_M,
        });
        // A part deeper than `PASSED_REACHES` has passed through the tube and loses its old side,
        // unless the motion of this tick alone brought it so deep (`PASSED_TRAVELS`), or its depth
        // decreases.
        let moved_m = motion.as_ref().map_or(0.0, Motion::travel_m);
        let last_separation_m = last.map_or(0.0, |last| last.separation.measured_m());
        let is_this_side = |side: &Side| {
            let separation_m = separation_m(side);
            separation_m > -PASSED_REACHES * reach_m - PASSED_TRAVELS * moved_m
                || separation_m > last_separation_m
        };
        let side = last
            .zip(motion)
            .and_then(|(last, motion)| last.side.follow(&motion))
            .filter(is_this_side);
        let travel_m = before.map_or_else(Vec3::zeros, |before| {
            travel_m(before, part, side.unwrap_or(first).share)
        });
        // All of a tube lies on one side of a tool. Of the two neighbours of a bead, the neighbour
        // under the larger load is the leader. The bead takes the leader's side if it is on the
        // opposite side and bears less load, or if it had no side or no weight.
        let leader = leader_of(last_tick, (number, bead), part.role, bodies);
        let led_side = leader.map(|it| {
            it.side
                .at_neighbour(&now, &ball.center_m, &ball.along, reach_m)
        });
        let led_side = led_side.filter(is_this_side);
        let acting = last.filter(|last| last.weight > 0.0);
        let must_switch = |side: &Side, leader: &PersistentContact| {
            let is_stronger = acting.is_none_or(|own| own.load_m() < leader.load_m());
            is_stronger && side.normal.dot(&leader.side.normal) < 0.0
        };
        let new = PersistentContact {
            bead: number,
            part: part.role,
            side: first,
            bead_m: ball.center_m,
            along: ball.along,
            separation: FilteredSeparation::NONE,
            cached: CachedForce::ZERO,
            free_share: last.map_or(1.0, |last| last.free_share),
            weight: 0.0,
        };
        let contact = match (side, acting, leader, led_side) {
            (Some(side), _, Some(leader), Some(led_side)) if must_switch(&side, leader) => {
                PersistentContact {
                    side: led_side,
                    separation: FilteredSeparation::first(separation_m(&led_side)),
                    ..new
                }
            }
            (Some(side), Some(last), _, _) => {
                let travel_m = motion.as_ref().map_or(0.0, Motion::travel_m);
                PersistentContact {
                    side,
                    bead_m: ball.center_m,
                    along: ball.along,
                    separation: last
                        .separation
                        .next(separation_m(&side), travel_m, OPENING_MAX_M),
                    ..*last
                }
            }
            (_, _, Some(leader), Some(led_side)) => PersistentContact {
                side: led_side,
                separation: leader.separation.moved_to(separation_m(&led_side)),
                ..new
            },
            (side, ..) => {
                let side = side.unwrap_or(new.side);
                PersistentContact {
                    side,
                    separation: FilteredSeparation::first(separation_m(&side)),
                    ..new
                }
            }
        };
        (contact, travel_m)
    }

    /// Stores a contact, sorted by bead. When there is no room, the shallowest is dropped.
    fn keep(&mut self, contact: PersistentContact, faults: &mut FaultSet) {
        let Err(contact) = self.contacts.push(contact) else {
            return;
        };
        let separations = self
            .contacts
            .iter()
            .map(|contact| contact.separation.separation_m)
            .enumerate();
        let shallowest = separations.reduce(|a, b| if b.1 > a.1 { b } else { a });
        let mut lost_m = contact.separation.separation_m;
        if let Some((i, separation_m)) =
            shallowest.filter(|(_, separation_m)| *separation_m > contact.separation.separation_m)
        {
            lost_m = separation_m;
            let mut number = 0;
            self.contacts.retain(|_| {
                number += 1;
                number != i + 1
            });
            let _ = self.contacts.push(contact); // there is room for one
        }
        faults.raise_if(lost_m < CANDIDATE_MARGIN_M, Fault::ContactOverflow);
    }

    /// Stores the force between a part and a bead for the next tick.
    pub(crate) fn store(&mut self, bead: u16, part: Role, cached: CachedForce) {
        let mut contacts = self.contacts.iter_mut();
        let same = contacts.find(|contact| contact.bead == bead && contact.part == part);
        if let Some(contact) = same {
            contact.cached = cached;
        }
    }
}

/// The lagging direction of a tube, a tick later ([`DIRECTION_UPDATE_SHARE`]).
fn lagged(last: &Vec3, now: &Vec3) -> Vec3 {
    math::unit(&(last + (now - last) * DIRECTION_UPDATE_SHARE)).unwrap_or(*now)
}

/// Last contact of this part with a neighbour of this bead on its tube; of two neighbours, the
/// neighbour under the larger load.
fn leader_of<'a>(
    last_tick: LastTick<'a>,
    (number, bead): (u16, &Bead),
    part: Role,
    bodies: &Bodies,
) -> Option<&'a PersistentContact> {
    let LastTick { contacts, start } = last_tick;
    let (before, after) = contacts.split_at(start.min(contacts.len()));
    let beads = &bodies.beads;
    let last = number.checked_sub(1).filter(|last| {
        let last = beads.get(*last);
        last.is_some_and(|last| last.is_followed_by(bead))
    });
    let next = number.checked_add(1).filter(|next| {
        let next = beads.get(*next);
        next.is_some_and(|next| bead.is_followed_by(next))
    });
    let acts = |it: &&PersistentContact| it.part == part && it.weight > 0.0;
    let before = before.iter().rev();
    let before = before.take_while(|it| Some(it.bead) == last).find(acts);
    let after = after.iter().skip_while(|it| it.bead == number);
    let after = after.take_while(|it| Some(it.bead) == next).find(acts);
    match (before, after) {
        (Some(before), Some(after)) if after.load_m() > before.load_m() => Some(after),
        (before, after) => before.or(after),
    }
}

/// Contact candidate of a part on a bead; `weight` is the share of the bead's stiffness that acts.
fn candidate(
    (organ, material): (u8, &Material),
    site: ContactSite,
    (bead, weight): (&Bead, f32),
    (part, ball_radius_m): (&Capsule, f32),
    contact: &PersistentContact,
    bodies: &Bodies,
) -> Candidate {
    let mut patch = Patch::default();
    patch.add(u32::from(bead.a), 1.0 - bead.share);
    patch.add(u32::from(bead.b), bead.share);
    let backing_compliance_m_n = backing_compliance_m_n(&patch, material, bodies);
    let center_m = contact.side.at_m(&axis(part));
    let wall_n_m = material.contact_stiffness_n_m * bead.stiffness_share * weight;
    Candidate {
        organ,
        site,
        patch,
        normal: contact.side.normal,
        center_m,
        half_m: Vec3::zeros(),
        radius_m: part.radius_m,
        at_m: center_m - contact.side.normal * part.radius_m,
        model: ContactModel::Wall {
            wall_n_m,
            flat_m: FLAT_COMPRESSION_RADII * ball_radius_m,
            backing_compliance_m_n,
        },
        separation_m: contact.separation.separation_m,
        travel_m: Vec3::zeros(),
        friction: material.friction,
        bristle_stiffness_n_m: wall_n_m / tangential_over_normal_compliance(material.poisson),
        cached: contact.cached,
    }
}

/// Compliance of the tissue behind a bead within a tick, m/N. A sphere of the bead resists with its
/// mass, and with twice the stiffness of a ball embedded in its tissue, because it may lie on other
/// tissue.
fn backing_compliance_m_n(patch: &Patch, material: &Material, bodies: &Bodies) -> f32 {
    let compliance_m_n = |(sphere, weight): (u32, f32)| {
        let inverse_mass_per_kg = bodies.nodes.at(sphere).inverse_mass_per_kg();
        let embedding_n_m = 2.0 * embedded_n_m(material, *bodies.radius_m.at(sphere));
        // Equal to `1 / (embedding_n_m + m / T²)`, and defined for a fixed sphere as well.
        let free_m_n = inverse_mass_per_kg * TICK_S * TICK_S;
        weight * weight * free_m_n / (1.0 + embedding_n_m * free_m_n)
    };
    patch.spheres().map(compliance_m_n).sum()
}

/// Stiffness of a rigid ball in infinite elastic tissue, N/m: `24 π G (1 − ν) r / (5 − 6 ν)` (Lur'e
/// 1964).
fn embedded_n_m(material: &Material, radius_m: f32) -> f32 {
    let poisson = material.poisson;
    let shear_pa = material.young_pa / (2.0 * (1.0 + poisson));
    24.0 * core::f32::consts::PI * shear_pa * (1.0 - poisson) * radius_m / (5.0 - 6.0 * poisson)
}

fn may_touch(part: &Capsule, ball: &Ball) -> bool {
    let range_m = ball.radius_m + part.radius_m + TRACKING_RANGE_M;
    axis(part).distance_squared_m2(&ball.center_m) < range_m * range_m
}

/// True while the jaws hold the bead.
fn is_in_jaws(bead: &Bead, bodies: &Bodies) -> bool {
    let held = |sphere: u16| {
        let bits = bodies.bits.at(u32::from(sphere));
        bits.contains(SphereBits::GRASPED)
    };
    held(bead.a) || held(bead.b)
}

/// Travel of the point of a part that is now at this share of its axis, m. The distance from `b_m`
/// identifies the point, because the `a_m` of a shaft is the port, through which the shaft slides.
fn travel_m(before: &Capsule, now: &Capsule, share: f32) -> Vec3 {
    let from_end_m = (1.0 - share) * math::norm(&(now.b_m - now.a_m));
    let place = |part: &Capsule| {
        let back = math::unit(&(part.a_m - part.b_m)).unwrap_or_else(Vec3::zeros);
        part.b_m + back * from_end_m
    };
    place(now) - place(before)
}

fn axis(part: &Capsule) -> Axis {
    Axis {
        a_m: part.a_m,
        b_m: part.b_m,
    }
}
