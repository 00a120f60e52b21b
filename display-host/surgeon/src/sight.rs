//! Positions of the organs: a compiled scene moved by its latest frame.

use shared_mem::message::{ClipMsg, SphereState, StateFrame};
use shared_mem::scene::{AttachmentRecord, OrganKind, SceneFile, WORLD, str_from_name};

use crate::vector::{Vec3, wide};

/// A position, m, and the direction of the tube there, if any.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Place {
    pub(crate) at: Vec3,
    pub(crate) along: Option<Vec3>,
}

/// A segment of a structure, and its radius, m.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bar {
    pub(crate) ends: [Vec3; 2],
    pub(crate) radius_m: f64,
    /// True if no instrument may even touch the structure.
    pub(crate) is_touchy: bool,
    /// For a duct or vessel: the sphere at its first end.
    pub(crate) tube: Option<usize>,
    /// Temperature of a duct or vessel above the body's, K; 0 for other structures.
    pub(crate) rise_k: f64,
}

/// A surgeon's knowledge of a scene.
#[derive(Debug)]
pub(crate) struct Sight {
    scene: SceneFile,
    /// Bands that fasten ducts and vessels to other organs. Current burns such a band as it burns
    /// the tube, and the band is as wide as the tube.
    bands: Vec<AttachmentRecord>,
}

impl Sight {
    pub(crate) fn new(scene: SceneFile) -> Self {
        let mut sight = Self {
            bands: Vec::new(),
            scene,
        };
        let organs = 0..sight.scene.organs().len();
        let tubes = organs.filter(|organ| sight.is_tube(*organ));
        let own: Vec<_> = tubes.map(|organ| sight.spheres_of(organ)).collect();
        let all = sight.scene.attachments().iter();
        let of_tubes = all.filter(|band| own.iter().any(|own| own.contains(&(band.a as usize))));
        sight.bands = of_tubes.copied().collect();
        sight
    }

    pub(crate) fn scene(&self) -> &SceneFile {
        &self.scene
    }

    /// Cystic duct and cystic artery.
    pub(crate) fn two(&self) -> [Option<usize>; 2] {
        [OrganKind::CysticDuct, OrganKind::CysticArtery].map(|kind| self.organ(kind))
    }

    pub(crate) fn port(&self) -> Vec3 {
        wide(self.scene.room().instrument_port_m)
    }

    /// True if an instrument touches the organ of this sphere.
    pub(crate) fn is_touched(&self, sphere: usize, state: &StateFrame) -> bool {
        let organs = 0..self.scene.organs().len();
        let mut own = organs.map(|organ| self.spheres_of(organ));
        let spheres = own.find(|own| own.contains(&sphere));
        let spheres = spheres.and_then(|own| state.spheres.get(own));
        let touched = |it: &SphereState| it.bits & SphereState::CONTACT != 0;
        spheres.is_some_and(|spheres| spheres.iter().any(touched))
    }

    /// First organ of a kind.
    pub(crate) fn organ(&self, kind: OrganKind) -> Option<usize> {
        let mut organs = self.scene.organs().iter();
        organs.position(|organ| organ.kind == kind as u32)
    }

    /// The organ of this name.
    pub(crate) fn named(&self, name: &str) -> Option<usize> {
        let mut organs = self.scene.organs().iter();
        organs.position(|organ| str_from_name(&organ.name) == Some(name))
    }

    pub(crate) fn is_tube(&self, organ: usize) -> bool {
        let organ = self.scene.organs().get(organ);
        matches!(
            organ.and_then(|it| OrganKind::from_u32(it.kind)),
            Some(
                OrganKind::CysticDuct
                    | OrganKind::CysticArtery
                    | OrganKind::BileDuct
                    | OrganKind::Vessel
            )
        )
    }

    pub(crate) fn spheres_of(&self, organ: usize) -> std::ops::Range<usize> {
        let organ = self.scene.organs().get(organ);
        let [first, count] = organ.map_or([0, 0], |it| it.spheres.map(|number| number as usize));
        first..first + count
    }

    /// Present middle of an organ's spheres, m.
    pub(crate) fn middle(&self, organ: usize, state: &StateFrame) -> Vec3 {
        let own = self.spheres_of(organ);
        let count = own.len().max(1) as f64;
        own.map(|sphere| self.now(sphere, state)).sum::<Vec3>() / count
    }

    /// Share of the lumen closed by the last clip on an organ.
    pub(crate) fn last_clip_closes(&self, kind: OrganKind, state: &StateFrame) -> Option<f32> {
        let own = self.spheres_of(self.organ(kind)?);
        let clips = state.clips()?.iter();
        let on_it = clips.filter(|clip| own.contains(&(clip.spheres[0] as usize)));
        on_it.max_by_key(|clip| clip.number).map(|clip| clip.closed)
    }

    /// Present positions of the clips, m.
    pub(crate) fn clips(&self, state: &StateFrame) -> Vec<Vec3> {
        let clips = state.clips().into_iter().flatten();
        let place = |clip: &ClipMsg| {
            let [a, b] = clip.spheres.map(|sphere| self.now(sphere as usize, state));
            a.lerp(&b, clip.share.into())
        };
        clips.map(place).collect()
    }

    fn rest(&self, sphere: usize) -> Vec3 {
        let sphere = self.scene.spheres().get(sphere);
        sphere.map_or_else(Vec3::zeros, |it| wide(it.center_m))
    }

    /// Present position of a sphere, m.
    pub(crate) fn now(&self, sphere: usize, state: &StateFrame) -> Vec3 {
        let sphere = state.spheres.get(sphere);
        sphere.map_or_else(Vec3::zeros, |it| wide(it.center_m))
    }

    /// Displacement of a sphere from rest, m.
    pub(crate) fn moved(&self, sphere: usize, state: &StateFrame) -> Vec3 {
        self.now(sphere, state) - self.rest(sphere)
    }

    /// Sphere of an organ that is nearest to a place.
    pub(crate) fn nearest(&self, organ: usize, to: Vec3, state: &StateFrame) -> Option<usize> {
        let off_m = |sphere: &usize| (self.now(*sphere, state) - to).norm();
        let own = self.spheres_of(organ);
        own.min_by(|a, b| off_m(a).total_cmp(&off_m(b)))
    }

    /// Place along a tube whose spheres are in order. The share is 0 at the end away from the
    /// gallbladder and rises towards the gallbladder; at 1 it reaches the last sphere but one.
    pub(crate) fn along(&self, kind: OrganKind, share: f64, state: &StateFrame) -> Option<Place> {
        let own = self.spheres_of(self.organ(kind)?);
        let bag = self
            .organ(OrganKind::Gallbladder)
            .map(|it| self.spheres_of(it));
        let to_bag_m = |sphere: usize| {
            let away = bag.iter().flat_map(Clone::clone);
            let away = away.map(|it| (self.rest(it) - self.rest(sphere)).norm());
            away.fold(f64::MAX, f64::min)
        };
        let last = own.end.checked_sub(1)?;
        let is_back = to_bag_m(own.start) < to_bag_m(last);
        let links = own.len().checked_sub(1)?;
        let exact = share.clamp(0.0, 1.0) * links.saturating_sub(1) as f64;
        let at = |place: usize| match (is_back, place.min(links)) {
            (true, place) => self.now(last - place, state),
            (false, place) => self.now(own.start + place, state),
        };
        let (a, b) = (at(exact as usize), at(exact as usize + 1));
        Some(Place {
            at: a.lerp(&b, exact.fract()),
            along: (b - a).try_normalize(1e-9),
        })
    }

    /// All ducts and vessels except the first organ of a kind, segment by segment.
    pub(crate) fn tubes_beside(&self, kind: OrganKind, state: &StateFrame) -> Vec<Bar> {
        let wanted = self.organ(kind);
        let organs = 0..self.scene.organs().len();
        let others = organs.filter(|organ| self.is_tube(*organ) && Some(*organ) != wanted);
        let pieces = others.flat_map(|organ| {
            let own = self.spheres_of(organ);
            let last = own.end.saturating_sub(1);
            own.map(move |sphere| [sphere, (sphere + 1).min(last)])
        });
        let radius_m = |sphere: usize| {
            let sphere = self.scene.spheres().get(sphere);
            sphere.map_or(0.0, |it| f64::from(it.radius_m))
        };
        let bar = |piece: [usize; 2]| Bar {
            ends: piece.map(|sphere| self.now(sphere, state)),
            radius_m: piece.map(radius_m).into_iter().fold(0.0, f64::max),
            is_touchy: false,
            tube: None,
            rise_k: 0.0,
        };
        pieces.map(bar).collect()
    }

    /// Structures near a place that current must not touch: ducts, vessels, their bands, bowels.
    pub(crate) fn delicate(&self, near: Vec3, within_m: f64, state: &StateFrame) -> Vec<Bar> {
        let mut bars = Vec::new();
        for (index, organ) in self.scene.organs().iter().enumerate() {
            let kind = OrganKind::from_u32(organ.kind);
            let is_tube = self.is_tube(index);
            let is_bowel = matches!(kind, Some(OrganKind::Stomach | OrganKind::Intestine));
            let is_own = matches!(kind, Some(OrganKind::CysticDuct | OrganKind::CysticArtery));
            if !is_tube && !is_bowel {
                continue;
            }
            let own = self.spheres_of(index);
            for sphere in own.clone() {
                let at = self.now(sphere, state);
                let radius = self.scene.spheres().get(sphere);
                let radius_m = radius.map_or(0.0, |it| f64::from(it.radius_m));
                if (at - near).norm() - radius_m > within_m {
                    continue;
                }
                let next = is_tube && sphere + 1 < own.end;
                let other = self
                    .scene
                    .spheres()
                    .get(if next { sphere + 1 } else { sphere });
                let radii = [radius, other].into_iter().flatten();
                bars.push(Bar {
                    ends: [at, self.now(if next { sphere + 1 } else { sphere }, state)],
                    radius_m: radii.fold(0.0, |most, it| f64::max(most, it.radius_m.into())),
                    is_touchy: !is_own,
                    tube: is_tube.then_some(sphere),
                    rise_k: match is_tube {
                        true => rise_k(sphere, state),
                        false => 0.0,
                    },
                });
            }
        }
        let bands = self.bands.iter().map(|band| self.band(band, state));
        bars.extend(bands.filter(|bar| off_line(near, bar.ends) - bar.radius_m < within_m));
        bars
    }

    fn band(&self, band: &AttachmentRecord, state: &StateFrame) -> Bar {
        let from = self.scene.spheres().get(band.a as usize);
        let to = match band.b {
            WORLD => wide(band.anchor_m),
            sphere => self.now(sphere as usize, state),
        };
        Bar {
            ends: [self.now(band.a as usize, state), to],
            radius_m: from.map_or(0.0, |it| f64::from(it.radius_m)),
            // Instruments pass through a band.
            is_touchy: false,
            tube: None,
            rise_k: 0.0,
        }
    }

    /// True if no organ's sphere comes within this distance of a segment.
    pub(crate) fn is_clear(&self, ends: [Vec3; 2], within_m: f64, state: &StateFrame) -> bool {
        let mut spheres = self.scene.spheres().iter().enumerate();
        spheres.all(|(index, sphere)| {
            let off_m = off_line(self.now(index, state), ends);
            off_m > f64::from(sphere.radius_m) + within_m
        })
    }

    /// Structures near a place that no instrument may even touch.
    pub(crate) fn touchy(&self, near: Vec3, within_m: f64, state: &StateFrame) -> Vec<Bar> {
        let mut bars = self.delicate(near, within_m, state);
        bars.retain(|bar| bar.is_touchy);
        bars
    }

    /// Solid organs that obstruct a shaft: liver and gallbladder, sphere by sphere.
    pub(crate) fn solid(&self, state: &StateFrame) -> Vec<Bar> {
        let kinds = [OrganKind::Liver, OrganKind::Gallbladder];
        let organs = kinds.into_iter().filter_map(|kind| self.organ(kind));
        let spheres = organs.flat_map(|organ| self.spheres_of(organ));
        let bar = |sphere: usize| Bar {
            ends: [self.now(sphere, state); 2],
            radius_m: (self.scene.spheres().get(sphere)).map_or(0.0, |it| f64::from(it.radius_m)),
            is_touchy: false,
            tube: None,
            rise_k: 0.0,
        };
        spheres.map(bar).collect()
    }
}

/// Temperature of a sphere's tissue above the body's, K.
fn rise_k(sphere: usize, state: &StateFrame) -> f64 {
    let now = state.spheres.get(sphere);
    now.map_or(0.0, |it| f64::from(it.rise_k()))
}

/// Distance between a point and a segment, m.
pub(crate) fn off_line(point: Vec3, [a, b]: [Vec3; 2]) -> f64 {
    let way = b - a;
    let share = (point - a).dot(&way) / way.norm_squared().max(1e-12);
    (point - a - way * share.clamp(0.0, 1.0)).norm()
}

/// Shortest vector from the second segment to the first segment, m.
pub(crate) fn between([a, b]: [Vec3; 2], [c, d]: [Vec3; 2]) -> Vec3 {
    let (own, other, apart) = (b - a, d - c, a - c);
    let (own2, other2) = (own.norm_squared(), other.norm_squared());
    let (along, on_own, on_other) = (own.dot(&other), own.dot(&apart), other.dot(&apart));
    let share = |way: f64, whole: f64| (way / whole.max(1e-12)).clamp(0.0, 1.0);
    let s = share(
        along * on_other - on_own * other2,
        own2 * other2 - along * along,
    );
    let t = share(on_other + s * along, other2);
    let s = share(t * along - on_own, own2);
    apart + own * s - other * t
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_as_far_apart_as_their_nearest_places() {
        let line = |a: [f64; 3], b: [f64; 3]| [Vec3::from(a), Vec3::from(b)];
        let level = line([-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]);
        for (other, way) in [
            // A line across `level`, one in line with it, one parallel to it, and a point.
            (line([0.3, -1.0, 2.0], [0.3, 1.0, 2.0]), [0.0, 0.0, -2.0]),
            (line([3.0, 0.0, 0.0], [4.0, 0.0, 0.0]), [-2.0, 0.0, 0.0]),
            (line([-1.0, 1.0, 0.0], [1.0, 1.0, 0.0]), [0.0, -1.0, 0.0]),
            (line([0.5, 0.5, 0.0], [0.5, 0.5, 0.0]), [0.0, -0.5, 0.0]),
        ] {
            let found = between(level, other);
            assert!((found - Vec3::from(way)).norm() < 1.0e-9, "{found}");
        }
    }
}
