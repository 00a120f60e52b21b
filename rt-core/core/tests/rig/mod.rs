//! Rig for tests, the bench and the examples: synthetic organs, and ports that the user fills. It
//! uses no files and no randomness, so it is equal on every machine.

#![allow(dead_code)] // every user takes what it needs

use rt_core::fault::FaultCounters;
use rt_core::math::{Pose, Quat, Vec3, norm};
use rt_core::port::{
    Buttons, DeviceCapabilities, DeviceSample, Findings, ForceCommand, PedalSample, Polled,
    TrackerSample,
};
use rt_core::procedure::clip::Clip;
use rt_core::procedure::heat::{Balance, HeatCode};
use rt_core::procedure::stones::Stone;
use rt_core::scene::{
    Anchor, Attachment, Inside, Link, Material, NO_VERTEX, Organ, RestSphere, Room, SKIN_BINDINGS,
    Scene, Skin, SkinVertex, Stones, Tetra, TetraBatch, Trocar, batches,
};
use rt_core::sim::{Digest, Ports, Samples, Stage, TickView};
use rt_core::tissue::Method;
use rt_core::tissue::paper::Paper;
use rt_core::tissue::suture::Suture;
use rt_core::tool::{Instrument, Kinematics};
use rt_core::words::{Event, SphereBits};

/// A Touch-class device.
pub(crate) const TOUCH: DeviceCapabilities = DeviceCapabilities::TOUCH;

/// Iterations of the method of the inner-sphere paper ("the paper").
pub(crate) const PAPER: u32 = 10;

/// Storage of the paper's method with this number of iterations; `None` for Calot's method.
pub(crate) fn paper(iterations: Option<u32>) -> Option<Box<Paper>> {
    iterations.map(|iterations| Box::new(Paper::new(iterations)))
}

/// The paper's method if there is storage for it, else Calot's.
pub(crate) fn method(paper: &mut Option<Box<Paper>>) -> Method<'_> {
    paper
        .as_mut()
        .map_or(Method::NeoHookean, |it| Method::Paper(it))
}

/// Soft tissue.
pub(crate) const SOFT: Material = Material {
    young_pa: 5000.0,
    poisson: 0.45,
    retardation_s: 0.002,
    stretch_stiffness: 0.02,
    laplacian_stiffness: 0.005,
    damping_per_s: 5.0,
    contact_stiffness_n_m: 400.0,
    friction: 0.1,
    toughness_j_m2: 0.0,
};

/// An organ without tetrahedra, all of whose links are elastic.
pub(crate) fn organ(spheres: [u32; 2], links: [u32; 2], material: Material) -> Organ {
    Organ {
        sphere_start: spheres[0],
        sphere_count: spheres[1],
        link_start: links[0],
        link_count: links[1],
        elastic_links: links[1],
        batch_start: 0,
        batch_count: 0,
        substeps: 1,
        gravity_share: 1.0,
        breath_m: Vec3::zeros(),
        inside: Inside::Solid,
        material,
    }
}

/// The port of the shaft, and its length.
pub(crate) const LEVER: Kinematics = Kinematics {
    port_m: Vec3::new(0.0, 0.0, 0.18),
    length_m: 0.33,
};

/// Arrays of a scene that is being built.
#[derive(Clone, Default)]
pub(crate) struct Anatomy {
    pub(crate) organs: Vec<Organ>,
    pub(crate) spheres: Vec<RestSphere>,
    pub(crate) links: Vec<Link>,
    pub(crate) batches: Vec<TetraBatch>,
    pub(crate) tetrahedra: Vec<Tetra>,
    pub(crate) attachments: Vec<Attachment>,
    pub(crate) skin_vertices: Vec<SkinVertex>,
    pub(crate) skin_fans: Vec<[u16; 2]>,
    pub(crate) skin_nearest: Vec<u16>,
    pub(crate) breath_s: f32,
    pub(crate) stones: Option<Stones>,
    /// Seal and wall at the instrument's port.
    pub(crate) trocar: Trocar,
    /// Rotation about the origin, applied to room and devices as well.
    pub(crate) turn: Quat,
}

impl Anatomy {
    /// Adds an ellipsoid of `count` spheres on a lattice with its `link_count` shortest links.
    /// Links are ordered so that most neighbours in the list share no sphere. The lowest tenth of
    /// the spheres is held.
    pub(crate) fn with_ellipsoid(
        mut self,
        center_m: Vec3,
        half_axes_m: Vec3,
        count: usize,
        link_count: usize,
    ) -> Self {
        let volume = 4.0 / 3.0 * std::f32::consts::PI * half_axes_m.product();
        let spacing_m = (volume / count as f32).cbrt();
        let inside = |p: &Vec3| p.component_div(&half_axes_m).norm_squared();
        let mut points = lattice(24);
        let cell_m = spacing_m * 2.0f32.cbrt();
        let at = |p: &[i32; 3]| Vec3::from(p.map(|x| 0.5 * cell_m * x as f32));
        points.sort_by(|a, b| inside(&at(a)).total_cmp(&inside(&at(b))));
        points.truncate(count);
        let centers: Vec<Vec3> = points.iter().map(at).collect();
        let mut lengths: Vec<(f32, u32, u32)> = Vec::new();
        for (i, a) in centers.iter().enumerate() {
            for (j, b) in centers.iter().enumerate().skip(i + 1) {
                lengths.push((norm(&(a - b)), i as u32, j as u32));
            }
        }
        lengths.sort_by(|a, b| a.0.total_cmp(&b.0).then((a.1, a.2).cmp(&(b.1, b.2))));
        lengths.truncate(link_count);
        let first = self.spheres.len() as u32;
        self.organs.push(Organ {
            elastic_links: 0,
            batch_start: self.batches.len() as u32,
            gravity_share: 0.0,
            ..organ(
                [first, centers.len() as u32],
                [self.links.len() as u32, lengths.len() as u32],
                SOFT,
            )
        });
        for (rest_length_m, a, b) in in_colours(&lengths, centers.len()) {
            self.links.push(Link {
                a: first + a,
                b: first + b,
                rest_length_m,
                compliance_m_n: 0.0,
            });
        }
        let mass_kg = 1060.0 * volume / count as f32;
        let mut heights: Vec<f32> = centers.iter().map(|c| c.z).collect();
        heights.sort_by(f32::total_cmp);
        let held_below = heights[count / 10];
        self.spheres.extend(centers.iter().map(|c| RestSphere {
            center_m: center_m + c,
            radius_m: 0.8 * spacing_m,
            mass_kg,
            held: c.z < held_below,
        }));
        let corners = in_batches(lattice_tetrahedra(&points));
        let volume_m3 = volume / corners.len() as f32;
        let carry = |t: [u32; 4]| Tetra {
            spheres: t.map(|i| first + i),
            volume_m3,
        };
        let tetrahedra: Vec<Tetra> = corners.into_iter().map(carry).collect();
        batches(&tetrahedra, &self.spheres, |batch| self.batches.push(batch)).expect("upright");
        self.tetrahedra.extend(tetrahedra);
        let organ = self.organs.last_mut().expect("pushed above");
        organ.batch_count = self.batches.len() as u32 - organ.batch_start;
        self
    }

    /// The paper's liver: 581 spheres, 3588 links, 1.2 litres, centred at the origin.
    pub(crate) fn liver() -> Self {
        let half_axes_m = Vec3::new(0.1, 0.06, 0.048);
        Self::default().with_ellipsoid(Vec3::zeros(), half_axes_m, 581, 3588)
    }

    /// The liver and, 1 mm above its left lobe, the paper's gallbladder (475, 3293).
    pub(crate) fn liver_and_gallbladder() -> Self {
        let half_axes_m = Vec3::new(0.04, 0.018, 0.018);
        Self::liver().with_ellipsoid(Vec3::new(-0.04, 0.0, 0.067), half_axes_m, 475, 3293)
    }

    /// Four organs with the paper's numbers of spheres and links (Table 1), side by side.
    pub(crate) fn four_organs() -> Self {
        let half_axes_m = Vec3::new(0.04, 0.018, 0.018);
        Self::liver()
            .with_ellipsoid(Vec3::new(0.3, 0.0, 0.0), half_axes_m, 475, 3293)
            .with_ellipsoid(Vec3::new(0.6, 0.0, 0.0), half_axes_m, 383, 2625)
            .with_ellipsoid(Vec3::new(0.9, 0.0, 0.0), half_axes_m, 452, 3161)
    }

    /// Adds contact skins: the boundary faces of the tetrahedra, through the centres of their
    /// spheres.
    pub(crate) fn with_skins(mut self) -> Self {
        let mut faces = std::collections::BTreeMap::new();
        for tet in &self.tetrahedra {
            let [a, b, c, d] = tet.spheres;
            // Anticlockwise seen from outside.
            for face in [[a, c, b], [a, b, d], [a, d, c], [b, c, d]] {
                let mut same = face;
                same.sort_unstable();
                if faces.remove(&same).is_none() {
                    faces.insert(same, face);
                }
            }
        }
        let mut outer: Vec<u32> = faces.values().flatten().copied().collect();
        outer.sort_unstable();
        outer.dedup();
        let number = |sphere: u32| outer.binary_search(&sphere).expect("it is outer") as u16;
        for &sphere in &outer {
            let fan_start = self.skin_fans.len() as u32;
            for face in faces.values() {
                if let Some(k) = face.iter().position(|i| *i == sphere) {
                    let corners = [face[(k + 1) % 3], face[(k + 2) % 3]];
                    self.skin_fans.push(corners.map(number));
                }
            }
            self.skin_vertices.push(SkinVertex {
                spheres: [sphere as u16; SKIN_BINDINGS],
                weights: core::array::from_fn(|i| if i == 0 { 1.0 } else { 0.0 }),
                fan_start,
                fan_count: self.skin_fans.len() as u32 - fan_start,
                patch_m: 0.012,
                curvature_per_m: 0.0,
            });
        }
        let organ_of = |sphere: u32| {
            let holds = |o: &Organ| sphere < o.sphere_start + o.sphere_count;
            self.organs.iter().position(holds)
        };
        let nearest = |sphere: u32| {
            let at = |i: u32| self.spheres[i as usize].center_m;
            let off = |i: &u32| (at(*i) - at(sphere)).norm_squared();
            let own = outer
                .iter()
                .copied()
                .filter(|i| organ_of(*i) == organ_of(sphere));
            own.min_by(|a, b| off(a).total_cmp(&off(b)))
                .map_or(NO_VERTEX, number)
        };
        self.skin_nearest = (0..self.spheres.len() as u32).map(nearest).collect();
        self
    }

    /// Rotates all organs about the origin, with the room and the devices.
    pub(crate) fn turned(mut self, turn: Quat) -> Self {
        for sphere in &mut self.spheres {
            sphere.center_m = turn * sphere.center_m;
        }
        for tie in &mut self.attachments {
            if let Anchor::World(at_m) = &mut tie.to {
                *at_m = turn * *at_m;
            }
        }
        self.batches.clear();
        let (all, packed) = (&self.tetrahedra, &mut self.batches);
        batches(all, &self.spheres, |batch| packed.push(batch)).expect("upright");
        self.turn = turn;
        self
    }

    /// The validated scene.
    pub(crate) fn scene(&self) -> Scene<'_> {
        let upright = room();
        let room = Room {
            breath_s: self.breath_s,
            gravity_m_s2: self.turn * upright.gravity_m_s2,
            world_from_device: Pose::from_parts(Vec3::zeros().into(), self.turn),
            instrument_port_m: self.turn * upright.instrument_port_m,
            trocar: self.trocar,
            ..upright
        };
        Scene::new(&self.organs, &self.spheres, &self.links, room)
            .and_then(|scene| scene.with_tetrahedra(&self.batches))
            .and_then(|scene| scene.with_attachments(&self.attachments))
            .and_then(|scene| {
                scene.with_skin(Skin {
                    vertices: &self.skin_vertices,
                    fans: &self.skin_fans,
                    nearest: &self.skin_nearest,
                })
            })
            .and_then(|scene| scene.with_stones(self.stones.unwrap_or(Stones::NONE)))
            .expect("a good scene")
    }
}

/// A room in which the base frames of the devices are the world frame.
pub(crate) fn room() -> Room {
    Room {
        gravity_m_s2: Vec3::new(0.0, 0.0, -9.81),
        world_from_device: Pose::identity(),
        world_from_tracker: Pose::identity(),
        instrument_port_m: LEVER.port_m,
        instrument_length_m: LEVER.length_m,
        endoscope_port_m: Vec3::new(0.05, 0.0, 0.18),
        world_from_camera: Pose::identity(),
        breath_s: 0.0,
        trocar: Trocar::NONE,
    }
}

/// Body-centred lattice around the origin, in half cells: corners even, centres odd.
fn lattice(side: i32) -> Vec<[i32; 3]> {
    let mut points = Vec::new();
    for x in -side..side {
        for y in -side..side {
            for z in -side..side {
                points.push([2 * x, 2 * y, 2 * z]);
                points.push([2 * x + 1, 2 * y + 1, 2 * z + 1]);
            }
        }
    }
    points
}

/// Delaunay tetrahedra of the lattice: four around each edge of a cell; their other corners are the
/// centres of neighbouring cells.
fn lattice_tetrahedra(points: &[[i32; 3]]) -> Vec<[u32; 4]> {
    let index: std::collections::BTreeMap<[i32; 3], u32> = points
        .iter()
        .enumerate()
        .map(|(i, p)| (*p, i as u32))
        .collect();
    let mut made = Vec::new();
    for p in points.iter().filter(|p| p[0] % 2 == 0) {
        for axis in 0..3 {
            let (next, after) = ((axis + 1) % 3, (axis + 2) % 3);
            let to = |along: i32, a: i32, b: i32| {
                let mut q = *p;
                q[axis] += along;
                q[next] += a;
                q[after] += b;
                index.get(&q).copied()
            };
            let around = [(1, 1), (-1, 1), (-1, -1), (1, -1)];
            for k in 0..4 {
                let ((a, b), (c, d)) = (around[k], around[(k + 1) % 4]);
                let corners = [to(0, 0, 0), to(2, 0, 0), to(1, a, b), to(1, c, d)];
                if let [Some(o), Some(e), Some(f), Some(g)] = corners {
                    made.push([o, e, f, g]);
                }
            }
        }
    }
    made
}

/// Tetrahedra ordered in batches of eight that share no sphere, as far as possible.
fn in_batches(mut left: Vec<[u32; 4]>) -> Vec<[u32; 4]> {
    let mut ordered = Vec::new();
    while !left.is_empty() {
        let mut batch: Vec<[u32; 4]> = Vec::new();
        left.retain(|t| {
            let free = t.iter().all(|s| !batch.as_flattened().contains(s));
            let taken = free && batch.len() < 8;
            if taken {
                batch.push(*t);
            }
            !taken
        });
        ordered.extend(batch);
    }
    ordered
}

/// Links ordered by colour; links of one colour share no sphere.
fn in_colours(links: &[(f32, u32, u32)], spheres: usize) -> Vec<(f32, u32, u32)> {
    let mut used = vec![0u64; spheres];
    let mut coloured: Vec<(u32, (f32, u32, u32))> = Vec::new();
    for &(length, a, b) in links {
        let colour = (used[a as usize] | used[b as usize]).trailing_ones();
        used[a as usize] |= 1 << colour;
        used[b as usize] |= 1 << colour;
        coloured.push((colour, (length, a, b)));
    }
    coloured.sort_by_key(|&(colour, _)| colour);
    coloured.into_iter().map(|(_, link)| link).collect()
}

/// A device sample with the instrument's tip at `tip_m`.
pub(crate) fn sample_at_tip(tip_m: &Vec3, buttons: Buttons, at_ns: u64) -> DeviceSample {
    DeviceSample {
        opening: None,
        device_from_handle: LEVER.handle_from_tip(tip_m, &Vec3::new(0.0, 1.0, 0.0)),
        velocity_m_s: None,
        buttons,
        sequence: (at_ns / 1_000_000) as u16,
        at_ns,
    }
}

/// Ports that a test fills before each tick and reads after it.
pub(crate) struct Bench {
    pub(crate) samples: Samples,
    /// Findings of the device's driver, equal in every tick until the test changes them.
    pub(crate) findings: Findings,
    pub(crate) sent: Vec<ForceCommand>,
    pub(crate) stages: Vec<Stage>,
    pub(crate) events: Vec<Event>,
    pub(crate) counters: FaultCounters,
    pub(crate) force_n: Vec3,
    pub(crate) contact_count: u32,
    pub(crate) grasped_count: u32,
    pub(crate) jaw: f32,
    pub(crate) clips: Vec<Clip>,
    pub(crate) clips_left: u32,
    pub(crate) sutures: Vec<(Suture, bool)>,
    pub(crate) stones: Vec<Stone>,
    pub(crate) camera: Pose,
    pub(crate) tip_m: Vec3,
    pub(crate) instrument: Instrument,
    pub(crate) centers_m: Vec<Vec3>,
    pub(crate) bits: Vec<SphereBits>,
    /// Temperature and damage of each sphere.
    pub(crate) heat: Vec<HeatCode>,
    pub(crate) balance: Balance,
    pub(crate) status: [rt_core::words::Status; 3],
    /// Digest of each tick.
    pub(crate) digests: Vec<Digest>,
}

impl Bench {
    pub(crate) fn new() -> Self {
        Self {
            samples: Samples {
                now_ns: 1_000_000,
                device: Polled::Nothing,
                tracker: Polled::Nothing,
                pedal: Polled::Nothing,
                command: None,
            },
            findings: Findings::default(),
            sent: Vec::new(),
            stages: Vec::new(),
            events: Vec::new(),
            counters: FaultCounters::ZERO,
            force_n: Vec3::zeros(),
            contact_count: 0,
            grasped_count: 0,
            jaw: 1.0,
            clips: Vec::new(),
            sutures: Vec::new(),
            stones: Vec::new(),
            clips_left: 0,
            camera: Pose::identity(),
            tip_m: Vec3::zeros(),
            instrument: Instrument::Grasper,
            digests: Vec::new(),
            centers_m: Vec::new(),
            bits: Vec::new(),
            heat: Vec::new(),
            balance: Balance::default(),
            status: [rt_core::words::Status::Absent; 3],
        }
    }

    /// Advances by one period without new samples; the caller may add some.
    pub(crate) fn next(&mut self) -> &mut Samples {
        self.samples = Samples {
            now_ns: self.samples.now_ns + 1_000_000,
            device: Polled::Nothing,
            tracker: Polled::Nothing,
            pedal: Polled::Nothing,
            command: None,
        };
        self.sent.clear();
        self.stages.clear();
        &mut self.samples
    }

    /// Advances by one period with the tip at `tip_m`.
    pub(crate) fn next_at(&mut self, tip_m: &Vec3, buttons: Buttons) -> &mut Samples {
        let samples = self.next();
        samples.device = Polled::Fresh(sample_at_tip(tip_m, buttons, samples.now_ns));
        samples
    }
}

impl Ports for Bench {
    fn sample(&mut self) -> Samples {
        self.samples
    }

    fn findings(&mut self) -> Findings {
        self.findings
    }

    fn send_force(&mut self, command: ForceCommand) {
        self.sent.push(command);
    }

    fn publish(&mut self, view: &TickView<'_>) {
        self.events.extend_from_slice(view.events);
        self.counters = *view.fault_counters;
        self.force_n = view.tool.force_n;
        self.contact_count = view.tool.contact_count;
        self.grasped_count = view.tool.grasped_count;
        self.jaw = view.tool.jaw;
        self.clips = view.clips.to_vec();
        self.clips_left = view.clips_left;
        self.sutures = view.sutures().map(|(it, is_cut)| (*it, is_cut)).collect();
        self.stones = view.stones().to_vec();
        self.camera = view.tool.world_from_camera;
        self.tip_m = view.tool.tip_m;
        self.instrument = view.tool.instrument;
        self.status = [view.device.status, view.tracker.status, view.pedal.status];
        self.digests.push(view.digest());
        self.centers_m.clear();
        self.bits.clear();
        self.heat.clear();
        self.balance = view.heat_balance();
        for sphere in view.spheres() {
            self.centers_m.push(sphere.center_m);
            self.bits.push(sphere.bits);
            self.heat.push(sphere.heat);
        }
    }

    fn stamp(&mut self, stage: Stage) {
        self.stages.push(stage);
    }
}

/// A tracker sample at `position_m`.
pub(crate) fn tracker_at(position_m: Vec3, at_ns: u64) -> TrackerSample {
    let tracker_from_sensor = Pose::from_parts(position_m.into(), Quat::identity());
    TrackerSample {
        tracker_from_sensor,
        at_ns,
    }
}

/// A pedal sample.
pub(crate) fn pedal(cut: bool, camera_lock: bool, at_ns: u64) -> PedalSample {
    PedalSample {
        cut,
        coagulate: false,
        camera_lock,
        at_ns,
    }
}
