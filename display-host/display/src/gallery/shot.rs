//! The gallery's pictures: content and viewpoint of each.

mod bed;
mod effect;
mod held;
mod stones;
mod sutures;

pub use self::stones::lying;

use glam::{Quat, Vec3};
use shared_mem::message::{
    CapsuleMsg, ClipMsg, PoseMsg, SphereState, StateFrame, StoneMsg, SutureMsg, ToolFrame,
};
use shared_mem::scene::{OrganKind, OrganRecord, SceneFile, str_from_name};

use crate::effects::Effect;
use crate::render::camera::{Scope, looking, matrix};
use crate::render::gpu::Gpu;
use crate::render::inside::Inside;
use crate::render::lens::Lens;
use crate::render::{Renderer, Shown};
use crate::ui::instrument_id;
use crate::words::Words;

/// Number of directions from which the best view of an organ is chosen.
const SIDES: usize = 48;
/// Largest number of an organ's vertices by which a direction of view is rated.
const JUDGES: usize = 160;
/// Largest distance from which an organ is viewed in place, m.
const IN_PLACE_MAX_M: f32 = 0.19;
/// Angle of a fully open jaw, rad.
const JAW_RAD: f32 = 0.4;

/// Number of rounds in which an inclined endoscope finds its place, and the share of the error that
/// each round corrects.
const INCLINED: usize = 24;
const INCLINED_SHARE: f32 = 0.3;

/// Time step of the effects, s.
const FRAME_S: f32 = 0.05;

/// Chapter of a picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Chapter {
    /// The view through the endoscope, and the simulation itself.
    Views,
    /// Each organ in place.
    Organs,
    /// Each organ alone.
    Alone,
    /// The instruments.
    Instruments,
    /// Smoke, blood and other effects.
    Effects,
}

impl Chapter {
    /// All chapters, in the order of the page.
    pub(super) const ALL: [Self; 5] = [
        Self::Views,
        Self::Organs,
        Self::Alone,
        Self::Instruments,
        Self::Effects,
    ];

    /// Heading.
    pub(super) fn title(self) -> &'static str {
        match self {
            Self::Views => "Views",
            Self::Organs => "Organs in place",
            Self::Alone => "Single organs",
            Self::Instruments => "Instruments",
            Self::Effects => "Effects",
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Views => "view",
            Self::Organs => "organ",
            Self::Alone => "alone",
            Self::Instruments => "instrument",
            Self::Effects => "effect",
        }
    }
}

/// A picture to draw.
pub(super) struct Shot {
    pub(super) title: String,
    pub(super) chapter: Chapter,
    pub(super) tools: ToolFrame,
    shown: Shown,
    inside: Option<Inside>,
    scope: Scope,
    lens: Lens,
    /// Effects to start, and the time for which they run before the picture, s.
    effects: (Vec<Effect>, f32),
    clips: Vec<ClipMsg>,
    stones: Vec<StoneMsg>,
    /// Sutures, if they differ from the scene's.
    sutures: Option<Vec<SutureMsg>>,
    /// States of the cells of layered tissue; empty if all are whole.
    cells: Vec<u8>,
    /// Positions of the spheres, if the tissue is not at rest.
    pub(super) spheres: Option<Vec<SphereState>>,
}

impl Shot {
    fn new(chapter: Chapter, title: impl Into<String>, tools: ToolFrame) -> Self {
        Self {
            title: title.into(),
            chapter,
            tools,
            shown: Shown::Everything,
            inside: None,
            scope: Scope::default(),
            lens: Lens::warm(),
            effects: (Vec::new(), 0.0),
            clips: Vec::new(),
            stones: Vec::new(),
            sutures: None,
            cells: Vec::new(),
            spheres: None,
        }
    }

    /// File name: chapter, number and title, in characters that every file system accepts. The
    /// number tells apart titles that differ in punctuation alone.
    pub(super) fn file(&self, number: usize) -> String {
        let plain = |c: char| if c.is_ascii_alphanumeric() { c } else { '-' };
        let title: String = self.title.to_lowercase().chars().map(plain).collect();
        format!("{}-{number:03}-{title}.png", self.chapter.name())
    }

    /// Passes everything in the picture except the tools to the renderer.
    pub(super) fn set_up(&self, gpu: &Gpu, renderer: &mut Renderer, spheres: &[SphereState]) {
        renderer.effects_mut().clear();
        let (begin, seconds) = &self.effects;
        let frames = (seconds / FRAME_S) as u32;
        for frame in 0..frames {
            let begin = if frame == 0 { begin.as_slice() } else { &[] };
            renderer.play(spheres, begin, FRAME_S);
        }
        let whole = vec![0; renderer.cell_count()];
        let cells = if self.cells.is_empty() {
            &whole
        } else {
            &self.cells
        };
        renderer.set_cells(gpu, cells);
        *renderer.scope_mut() = self.scope;
        *renderer.lens_mut() = self.lens;
        renderer.set_clips(&self.clips, spheres);
        renderer.set_stones(&self.stones);
        renderer.set_sutures(self.sutures.as_deref());
        renderer.show(self.shown);
        renderer.set_inside(gpu, self.inside);
    }
}

/// Three clips along a cystic duct or artery, and none along other organs.
fn clips_on(organ: &OrganRecord) -> Vec<ClipMsg> {
    let clipped = [OrganKind::CysticDuct, OrganKind::CysticArtery];
    let is_clipped = OrganKind::from_u32(organ.kind).is_some_and(|kind| clipped.contains(&kind));
    let [first, count] = organ.spheres;
    let places = [count * 2 / 5, count / 2, count * 7 / 10].map(|place| first + place);
    let on = (0u32..).zip(places).filter(|_| is_clipped);
    let clip = |(number, sphere): (u32, u32)| ClipMsg {
        spheres: [sphere, sphere + 1],
        share: 0.5,
        closed: 1.0,
        legs: [0.0, -0.6, -0.8],
        number,
    };
    on.map(clip).collect()
}

/// All pictures of a scene.
pub(super) fn all(scene: &SceneFile, size: [u32; 2]) -> Vec<Shot> {
    let mut shots = views(scene);
    let organs = scene.organs().iter().enumerate();
    for (number, organ) in organs.clone() {
        let from = best_side(scene, organ, true);
        shots.push(Shot::new(
            Chapter::Organs,
            organ_name(organ, number),
            facing(scene, organ, from, size, IN_PLACE_MAX_M),
        ));
    }
    for (number, organ) in organs.clone() {
        let clips = clips_on(organ);
        if !clips.is_empty() {
            let from = best_side(scene, organ, true);
            let title = format!("{} with clips", organ_name(organ, number));
            let tools = facing(scene, organ, from, size, 0.06);
            shots.push(Shot {
                clips,
                ..Shot::new(Chapter::Effects, title, tools)
            });
        }
        // Connective tissue lies between two organs and is hidden until they are pulled apart, as
        // in `bed`.
        if organ.kind != OrganKind::ConnectiveTissue as u32 {
            shots.extend(dissected(scene, (number, organ), size));
        }
    }
    shots.extend(bed::open(scene));
    for (number, organ) in organs {
        let from = best_side(scene, organ, false);
        shots.push(Shot {
            shown: Shown::Organ(number),
            ..Shot::new(
                Chapter::Alone,
                organ_name(organ, number),
                facing(scene, organ, from, size, f32::INFINITY),
            )
        });
    }
    for instrument in 0..4 {
        for (jaw, how) in [(1.0, "open"), (0.0, "closed")] {
            // A hook has no jaws to open.
            if instrument == 1 && jaw < 0.5 {
                continue;
            }
            let title = format!("{}, {how}", Words::default().say(instrument_id(instrument)));
            let title = title.trim_end_matches(", open").to_owned();
            shots.push(Shot::new(
                Chapter::Instruments,
                title,
                close_up(scene, instrument, jaw),
            ));
        }
    }
    shots.push(Shot::new(
        Chapter::Instruments,
        "Trocar",
        at_the_port(scene),
    ));
    shots.extend(held::shot(scene));
    shots.extend(sutures::shots(scene));
    shots.extend(effect::all(scene));
    shots
}

/// Two pictures of an organ of layered tissue. In the first, the third of its cells nearest to the
/// viewer is removed; in the second, all of them. An organ without cells gives no picture.
fn dissected(
    scene: &SceneFile,
    (number, organ): (usize, &OrganRecord),
    size: [u32; 2],
) -> Vec<Shot> {
    let spheres = organ.spheres[0]..organ.spheres[0] + organ.spheres[1];
    let cells = scene.cells().iter().enumerate();
    let own = cells.filter(|(_, cell)| spheres.contains(&u32::from(cell.spheres[0])));
    let from = best_side(scene, organ, true);
    let tools = facing(scene, organ, from, size, IN_PLACE_MAX_M);
    let height = |at: [f32; 3]| Vec3::from(at).dot(from);
    let mut own: Vec<(usize, f32)> = own.map(|(i, cell)| (i, height(cell.center_m))).collect();
    own.sort_by(|a, b| b.1.total_cmp(&a.1));
    let with = |states: &dyn Fn(f32) -> u8| {
        let mut all = vec![0; scene.cells().len()];
        for (k, (cell, _)) in own.iter().enumerate() {
            all[*cell] = states(k as f32 / own.len() as f32);
        }
        all
    };
    let name = organ_name(organ, number);
    let third = with(&|share| match share {
        ..0.33 => StateFrame::GONE,
        ..0.45 => ((0.45 - share) / 0.12 * 250.0) as u8,
        _ => 0,
    });
    let shots = [
        (format!("{name}, a third removed"), third),
        (format!("{name}, gone"), with(&|_| StateFrame::GONE)),
    ];
    let all = shots.into_iter().map(|(title, cells)| Shot {
        cells,
        ..Shot::new(Chapter::Organs, title, tools)
    });
    if own.is_empty() {
        Vec::new()
    } else {
        all.collect()
    }
}

fn views(scene: &SceneFile) -> Vec<Shot> {
    let room = scene.room();
    let start = camera_only(scene, room.world_from_camera);
    let view = |title: String, tools| Shot::new(Chapter::Views, title, tools);
    let subject = subject(scene);
    let eye = Vec3::from(room.world_from_camera.position_m);
    let nearer = PoseMsg {
        position_m: eye.lerp(subject, 0.5).to_array(),
        ..room.world_from_camera
    };
    let angled = |degrees: f32| Shot {
        scope: Scope {
            angle: degrees.to_radians(),
            ..Scope::default()
        },
        ..view(
            format!("Endoscope of {degrees}°"),
            camera_only(scene, inclined(scene, degrees.to_radians(), subject)),
        )
    };
    vec![
        view("Initial view of the endoscope".to_owned(), start),
        angled(30.0),
        angled(45.0),
        Shot {
            lens: Lens {
                fog: 0.6,
                ..Lens::cold()
            },
            ..view("Lens fogged".to_owned(), start)
        },
        Shot {
            lens: Lens {
                soot: 0.4,
                ..Lens::warm()
            },
            ..view("Lens sooted".to_owned(), start)
        },
        Shot {
            scope: Scope {
                focus_m: 0.015,
                ..Scope::default()
            },
            ..view("Focused too near".to_owned(), start)
        },
        view(
            "Closer view of the target".to_owned(),
            camera_only(scene, nearer),
        ),
        Shot {
            inside: Some(Inside::VIEW),
            ..view("Spheres and springs".to_owned(), start)
        },
    ]
}

/// The middle of the initial view at the target's depth. A patient's initial view looks at the
/// triangle, and the target lies on the gallbladder.
fn subject(scene: &SceneFile) -> Vec3 {
    let start = &scene.room().world_from_camera;
    let eye = Vec3::from(start.position_m);
    let ahead = matrix(start).transform_vector3(Vec3::NEG_Z);
    eye + ahead
        * (Vec3::from(scene.room().target_m) - eye)
            .dot(ahead)
            .max(0.03)
}

/// Pose of an endoscope's shaft. The view is inclined downwards by this angle, rad, and has `place`
/// in its middle. The shaft passes through its port, as deep as at the beginning.
fn inclined(scene: &SceneFile, angle: f32, place: Vec3) -> PoseMsg {
    let room = scene.room();
    let port = Vec3::from(room.endoscope_port_m);
    let deep_m = port.distance(Vec3::from(room.world_from_camera.position_m));
    let mut pose = room.world_from_camera;
    // The place is off the view's middle by an angle. Each round turns the shaft by a share of this
    // angle. The lens moves with the shaft, so the place moves about three times as far across the
    // picture.
    for _ in 0..INCLINED {
        let shaft = matrix(&pose);
        let to = shaft.inverse().transform_point3(place);
        let down = (-to.y).atan2(-to.z);
        let aside = to.x.atan2(-to.z);
        let [right, up] = [aside, angle - down].map(|off| INCLINED_SHARE * off);
        let turn = Quat::from_array(pose.orientation)
            * Quat::from_rotation_x(up)
            * Quat::from_rotation_y(-right);
        pose = PoseMsg {
            position_m: (port + turn * Vec3::NEG_Z * deep_m).to_array(),
            orientation: turn.normalize().to_array(),
        };
    }
    pose
}

fn organ_name(organ: &OrganRecord, number: usize) -> String {
    let name = str_from_name(&organ.name).unwrap_or("");
    if name.is_empty() {
        format!("organ {number}")
    } else {
        let mut letters = name.chars();
        let first = letters.next().map(|c| c.to_uppercase().to_string());
        first.unwrap_or_default() + letters.as_str()
    }
}

/// Tools with the camera at this pose and no instrument in view.
fn camera_only(scene: &SceneFile, world_from_camera: PoseMsg) -> ToolFrame {
    let away = PoseMsg {
        position_m: (Vec3::from(world_from_camera.position_m)
            + matrix(&world_from_camera).transform_vector3(Vec3::Z) * 10.0)
            .to_array(),
        orientation: world_from_camera.orientation,
    };
    // The shaft extends backwards from the joint, away from the camera.
    ToolFrame {
        scene_id: scene.short_id(),
        world_from_camera,
        world_from_instrument: away,
        world_from_handle: away,
        ..bytemuck::Zeroable::zeroed()
    }
}

/// Sample vertices of an organ: position and normal.
fn judges(scene: &SceneFile, organ: &OrganRecord) -> Vec<(Vec3, Vec3)> {
    let [first, count] = organ.vertices.map(|x| x as usize);
    let step = count.div_ceil(JUDGES).max(1);
    let vertices = scene.vertices().get(first..first + count).unwrap_or(&[]);
    let chosen = vertices.iter().step_by(step);
    chosen
        .map(|v| (Vec3::from(v.position_m), Vec3::from(v.normal)))
        .collect()
}

/// Direction from which most of an organ is visible. If other organs are `there`, they hide parts
/// of it.
fn best_side(scene: &SceneFile, organ: &OrganRecord, there: bool) -> Vec3 {
    let judges = judges(scene, organ);
    let eye = Vec3::from(scene.room().world_from_camera.position_m);
    let (low, high) = bounds(&judges);
    let home = (eye - (low + high) / 2.0).normalize_or(Vec3::Z);
    let others = match there {
        true => others(scene, organ),
        false => Vec::new(),
    };
    let seen = |from: Vec3| {
        let free = judges
            .iter()
            .filter(|(at, normal)| normal.dot(from) > 0.1 && is_free(*at, from, &others));
        // Prefer the direction of the endoscope.
        free.count() as f32 * (1.0 + 0.6 * from.dot(home))
    };
    sides()
        .map(|side| (seen(side), side))
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map_or(home, |(_, side)| side)
}

/// Directions distributed evenly over a sphere.
fn sides() -> impl Iterator<Item = Vec3> {
    (0..SIDES).map(|i| {
        let height = 1.0 - (i as f32 + 0.5) / SIDES as f32 * 2.0;
        let turn = i as f32 * 2.399_963_2;
        let flat = (1.0 - height * height).sqrt();
        Vec3::new(flat * turn.cos(), height, flat * turn.sin())
    })
}

/// Spheres of all other organs: centre and radius, m.
fn others(scene: &SceneFile, organ: &OrganRecord) -> Vec<(Vec3, f32)> {
    let own = organ.spheres[0] as usize..(organ.spheres[0] + organ.spheres[1]) as usize;
    let all = scene.spheres().iter().enumerate();
    all.filter(|(i, _)| !own.contains(i))
        .map(|(_, s)| (Vec3::from(s.center_m), s.radius_m))
        .collect()
}

/// True if a point is visible from a direction, because none of these spheres hides it.
fn is_free(at: Vec3, from: Vec3, others: &[(Vec3, f32)]) -> bool {
    others.iter().all(|(centre, radius)| {
        let to = *centre - at;
        let along = to.dot(from);
        along < 0.0 || to.length_squared() - along * along > radius * radius
    })
}

/// Tools whose camera shows the whole organ from this direction, if a distance of `far_max_m` is
/// enough.
fn facing(
    scene: &SceneFile,
    organ: &OrganRecord,
    from: Vec3,
    [width, height]: [u32; 2],
    far_max_m: f32,
) -> ToolFrame {
    let judges = judges(scene, organ);
    let (low, high) = bounds(&judges);
    let middle = (low + high) / 2.0;
    let scope = Scope::default();
    // Half the angle of view of the picture's shorter side, with a margin.
    let aspect = width as f32 / height as f32;
    let half = scope.half_angle / scope.circle.max(1.0) * aspect.min(1.0) * 0.86;
    let far = judges.iter().map(|(at, _)| {
        let d = *at - middle;
        let across = (d - from * d.dot(from)).length();
        d.dot(from) + across / half.tan()
    });
    // A camera at a greater distance may be behind the cavity's wall.
    let far = far.fold(0.03, f32::max).min(far_max_m);
    camera_only(scene, looking(middle + from * far, middle))
}

/// An instrument in front of the target, seen from the side.
fn close_up(scene: &SceneFile, instrument: u32, jaw: f32) -> ToolFrame {
    let room = scene.room();
    let normal = Vec3::from(room.target_normal).normalize_or(Vec3::Y);
    let tip = Vec3::from(room.target_m) + normal * 0.008;
    near(scene, (tip, normal), instrument, jaw)
}

/// An instrument with its tip here, over skin with this normal, seen from the side.
fn near(scene: &SceneFile, (tip, normal): (Vec3, Vec3), instrument: u32, jaw: f32) -> ToolFrame {
    let room = scene.room();
    let port = Vec3::from(room.instrument_port_m);
    let back = (port - tip).normalize_or(normal);
    let joint = tip + back * 0.018;
    let eye = Vec3::from(room.world_from_camera.position_m);
    let beside = (eye - joint).reject_from(back).normalize_or(normal);
    let from = (beside + back * 0.35).normalize();
    // The jaws open across the line of sight.
    let x = from.reject_from(back).normalize_or(Vec3::X);
    let y = back.cross(x);
    let turn = Quat::from_mat3(&glam::Mat3::from_cols(x, y, back));
    let mut tools = camera_only(
        scene,
        looking(joint - back * 0.006 + from * 0.055, joint - back * 0.006),
    );
    tools.world_from_instrument = PoseMsg {
        position_m: joint.to_array(),
        orientation: turn.normalize().to_array(),
    };
    tools.world_from_handle = tools.world_from_instrument;
    (tools.instrument, tools.jaw) = (instrument, jaw);
    let capsule = |a: Vec3, b: Vec3, radius_m, role| CapsuleMsg {
        a_m: a.to_array(),
        radius_m,
        b_m: b.to_array(),
        role,
    };
    tools.capsule_count = 3;
    tools.capsules[0] = capsule(joint + back * 0.3, joint, 0.0025, 0);
    for (slot, (role, side)) in [(1, 1.0), (2, -1.0)].into_iter().enumerate() {
        let along = turn * Quat::from_rotation_x(side * JAW_RAD * jaw) * Vec3::NEG_Z;
        tools.capsules[slot + 1] = capsule(joint, joint + along * 0.02, 0.0012, role);
    }
    tools
}

/// The trocar from inside, with a grasper in it.
fn at_the_port(scene: &SceneFile) -> ToolFrame {
    let mut tools = close_up(scene, 0, 0.3);
    let port = Vec3::from(scene.room().instrument_port_m);
    let turn = Quat::from_array(tools.world_from_instrument.orientation);
    let (inwards, across) = (turn * Vec3::NEG_Z, turn * Vec3::X);
    let joint = port + inwards * 0.05;
    tools.world_from_instrument.position_m = joint.to_array();
    tools.capsule_count = 0;
    let at = port + inwards * 0.032;
    tools.world_from_camera = looking(at + across * 0.055 + inwards * 0.055, at);
    tools
}

fn bounds(judges: &[(Vec3, Vec3)]) -> (Vec3, Vec3) {
    let none = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    let (low, high) = judges
        .iter()
        .fold(none, |(low, high), (at, _)| (low.min(*at), high.max(*at)));
    if low.is_finite() {
        (low, high)
    } else {
        (Vec3::ZERO, Vec3::ZERO)
    }
}
