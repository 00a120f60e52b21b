//! Where organs are now: a compiled scene as the newest frame of it shows it.

use shared_mem::message::StateFrame;
use shared_mem::scene::{OrganKind, SceneFile};

use crate::work::Vec3;

/// A place, m, and which way what lies there runs, if it does.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Place {
    pub(crate) at: Vec3,
    pub(crate) along: Option<Vec3>,
}

/// A stretch of something between two spheres, and its radius, m.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Bar {
    pub(crate) ends: [Vec3; 2],
    pub(crate) radius_m: f64,
    /// Not even an instrument may touch it.
    pub(crate) is_touchy: bool,
}

/// What a surgeon knows of a scene.
#[derive(Debug)]
pub(crate) struct Sight {
    scene: SceneFile,
    /// Of each sphere of a tube, how far the skin is off the middle from there to the next, m; of others nothing.
    /// Spheres lie within the skin, and that is what is seen and touched.
    thick_m: Vec<f64>,
}

impl Sight {
    pub(crate) fn new(scene: SceneFile) -> Self {
        let mut sight = Self {
            thick_m: vec![0.0; scene.spheres().len()],
            scene,
        };
        (0..sight.scene.organs().len()).for_each(|organ| sight.measure(organ));
        sight
    }

    /// How thick a tube is, from its skin at rest.
    fn measure(&mut self, organ: usize) {
        let Some(record) = self.scene.organs().get(organ) else {
            return;
        };
        let own = self.spheres_of(organ);
        if !is_tube(record.kind) || own.is_empty() {
            return;
        }
        let [first, count] = record.vertices.map(|number| number as usize);
        let steps = own.start..own.end - 1;
        for vertex in self.scene.vertices().iter().skip(first).take(count) {
            let at = wide(vertex.position_m);
            let offs = steps.clone().map(|sphere| {
                let ends = [self.rest(sphere), self.rest(sphere + 1)];
                (off_line(at, ends), sphere)
            });
            let Some((off_m, sphere)) = offs.min_by(|a, b| a.0.total_cmp(&b.0)) else {
                continue;
            };
            if let Some(thick_m) = self.thick_m.get_mut(sphere) {
                *thick_m = thick_m.max(off_m);
            }
        }
    }

    pub(crate) fn port(&self) -> Vec3 {
        wide(self.scene.room().instrument_port_m)
    }

    /// The first organ of a kind.
    pub(crate) fn organ(&self, kind: OrganKind) -> Option<usize> {
        let mut organs = self.scene.organs().iter();
        organs.position(|organ| organ.kind == kind as u32)
    }

    fn spheres_of(&self, organ: usize) -> std::ops::Range<usize> {
        let organ = self.scene.organs().get(organ);
        let [first, count] = organ.map_or([0, 0], |it| it.spheres.map(|number| number as usize));
        first..first + count
    }

    /// Share of the inside of an organ that the clip closes which was put on it last.
    pub(crate) fn last_clip_closes(&self, kind: OrganKind, state: &StateFrame) -> Option<f32> {
        let own = self.spheres_of(self.organ(kind)?);
        let clips = state.clips()?.iter();
        let on_it = clips.filter(|clip| own.contains(&(clip.spheres[0] as usize)));
        on_it.max_by_key(|clip| clip.number).map(|clip| clip.closed)
    }

    fn rest(&self, sphere: usize) -> Vec3 {
        let sphere = self.scene.spheres().get(sphere);
        sphere.map_or_else(Vec3::zeros, |it| wide(it.center_m))
    }

    /// Where a sphere is now.
    pub(crate) fn now(&self, sphere: usize, state: &StateFrame) -> Vec3 {
        let sphere = state.spheres.get(sphere);
        sphere.map_or_else(Vec3::zeros, |it| wide(it.center_m))
    }

    /// How far a sphere has gone from where it was at rest.
    pub(crate) fn moved(&self, sphere: usize, state: &StateFrame) -> Vec3 {
        self.now(sphere, state) - self.rest(sphere)
    }

    /// A place along a tube, whose spheres stand in line; shares count towards the gallbladder.
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
        let exact = share * own.len().saturating_sub(2) as f64;
        let at = |place: usize| match is_back {
            true => self.now(last.saturating_sub(place), state),
            false => self.now(own.start + place, state),
        };
        let (a, b) = (at(exact as usize), at(exact as usize + 1));
        Some(Place {
            at: a.lerp(&b, exact.fract()),
            along: Some((b - a).normalize()),
        })
    }

    /// Ducts, vessels and bowels near a place: what current must not touch.
    pub(crate) fn delicate(&self, near: Vec3, within_m: f64, state: &StateFrame) -> Vec<Bar> {
        let mut bars = Vec::new();
        for (index, organ) in self.scene.organs().iter().enumerate() {
            let kind = OrganKind::from_u32(organ.kind);
            let is_tube = is_tube(organ.kind);
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
                let thick_m = self.thick_m.get(sphere).copied().unwrap_or_default();
                let radii = [radius, other].into_iter().flatten();
                bars.push(Bar {
                    ends: [at, self.now(if next { sphere + 1 } else { sphere }, state)],
                    radius_m: radii.fold(thick_m, |most, it| f64::max(most, it.radius_m.into())),
                    is_touchy: !is_own,
                });
            }
        }
        bars
    }

    /// What must not even be touched.
    pub(crate) fn touchy(&self, near: Vec3, within_m: f64, state: &StateFrame) -> Vec<Bar> {
        let mut bars = self.delicate(near, within_m, state);
        bars.retain(|bar| bar.is_touchy);
        bars
    }

    /// Solid organs that stand in the way of a shaft: liver and gallbladder, sphere by sphere.
    pub(crate) fn solid(&self, state: &StateFrame) -> Vec<Bar> {
        let kinds = [OrganKind::Liver, OrganKind::Gallbladder];
        let organs = kinds.into_iter().filter_map(|kind| self.organ(kind));
        let spheres = organs.flat_map(|organ| self.spheres_of(organ));
        let bar = |sphere: usize| Bar {
            ends: [self.now(sphere, state); 2],
            radius_m: (self.scene.spheres().get(sphere)).map_or(0.0, |it| f64::from(it.radius_m)),
            is_touchy: false,
        };
        spheres.map(bar).collect()
    }
}

fn is_tube(kind: u32) -> bool {
    matches!(
        OrganKind::from_u32(kind),
        Some(
            OrganKind::CysticDuct
                | OrganKind::CysticArtery
                | OrganKind::BileDuct
                | OrganKind::Vessel
        )
    )
}

/// How far a point is from a straight line from end to end, m.
pub(crate) fn off_line(point: Vec3, [a, b]: [Vec3; 2]) -> f64 {
    let way = b - a;
    let share = (point - a).dot(&way) / way.norm_squared().max(1e-12);
    (point - a - way * share.clamp(0.0, 1.0)).norm()
}

pub(crate) fn wide(v: [f32; 3]) -> Vec3 {
    Vec3::from(v.map(f64::from))
}
