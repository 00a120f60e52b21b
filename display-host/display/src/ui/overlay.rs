//! The engineering view: the simulation, drawn over the endoscope's picture.

use egui::{Color32, Painter, Pos2, Rect, Stroke, vec2};
use glam::{Mat4, Vec2, Vec3};
use shared_mem::message::{SphereState, ToolFrame};
use shared_mem::scene::{SceneFile, str_from_name};
use shared_mem::words::CapsuleRole;

use crate::render::camera::Scope;
use crate::words::Words;

/// Length of the force's arrow per newton, m.
const ARROW_M_PER_N: f32 = 0.02;

/// Meaning of a mark.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mark {
    /// Sphere of a sleeping organ.
    Asleep,
    /// Sphere being simulated.
    Awake,
    /// Sphere in contact with a tool.
    Contact,
    /// Sphere between the jaws.
    Grasped,
    /// Sphere that the constraints do not move.
    Held,
    /// Link between two spheres.
    Link,
    /// Collision shape of a tool.
    Tool,
    /// Force on the hand.
    Force,
    /// Position at which the hand holds the instrument. Tissue may keep the tool away from it.
    Device,
}

/// A circle on the picture. Places and lengths are in half heights of the picture, from its middle,
/// y up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Circle {
    /// Centre.
    pub at: Vec2,
    /// Radius.
    pub radius: f32,
    /// Its meaning.
    pub mark: Mark,
}

/// A line on the picture.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Line {
    /// Ends.
    pub ends: [Vec2; 2],
    /// Thickness, in half heights. 0 stands for a hairline.
    pub width: f32,
    /// Its meaning.
    pub mark: Mark,
}

/// Counts of the model, and the awake organs.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Notes {
    /// Number of spheres, links, tetrahedra, and touched spheres.
    pub counts: [usize; 4],
    /// Number of organs in the scene.
    pub organs: usize,
    /// Names of the awake organs.
    pub awake: Vec<String>,
}

/// Content of the engineering view.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Overlay {
    /// Spheres, farthest first.
    pub circles: Vec<Circle>,
    /// Links, tool, force.
    pub lines: Vec<Line>,
    /// Text of the view.
    pub notes: Notes,
}

impl Overlay {
    /// The view of a moment through the scope. Spheres outside the endoscope's circle are left out.
    /// So are lines of which an end lies outside it.
    #[must_use]
    pub fn of(
        scene: &SceneFile,
        spheres: &[SphereState],
        tools: &ToolFrame,
        scope: &Scope,
    ) -> Self {
        let camera = scope.world_from_view(tools).inverse();
        let mut overlay = Self::default();
        overlay.add_links(scene, spheres, &camera, scope);
        overlay.add_spheres(scene, spheres, &camera, scope);
        for capsule in tools.capsules().unwrap_or(&[]) {
            let ends = [capsule.a_m, capsule.b_m].map(Vec3::from);
            let near = camera.transform_point3(ends[1]).length().max(1e-3);
            let width = 2.0 * scope.on_picture((capsule.radius_m / near).min(1.0).asin());
            overlay.add_line(&camera, scope, ends, width, Mark::Tool);
        }
        overlay.add_device(scene, tools, &camera, scope);
        overlay.notes = Notes::of(scene, spheres);
        let force = Vec3::from(tools.force_n) * ARROW_M_PER_N;
        let start = Vec3::from(tools.world_from_instrument.position_m);
        if force.length() > 1e-4 {
            let end = start + force;
            overlay.add_line(&camera, scope, [start, end], 0.0, Mark::Force);
            let side = force.any_orthonormal_vector() * force.length() * 0.15;
            for side in [side, -side] {
                let barb = [end, end - force * 0.25 + side];
                overlay.add_line(&camera, scope, barb, 0.0, Mark::Force);
            }
        }
        overlay
    }

    /// Removes links and untouched spheres, because the view inside the organs draws them itself.
    pub fn leave_to_picture(&mut self) {
        self.lines.retain(|line| line.mark != Mark::Link);
        let touched = |c: &Circle| matches!(c.mark, Mark::Contact | Mark::Grasped | Mark::Device);
        self.circles.retain(touched);
    }

    fn add_spheres(
        &mut self,
        scene: &SceneFile,
        spheres: &[SphereState],
        camera: &Mat4,
        scope: &Scope,
    ) {
        let mut seen: Vec<(f32, Circle)> = spheres
            .iter()
            .zip(scene.spheres())
            .filter_map(|(now, rest)| {
                let at = camera.transform_point3(Vec3::from(now.center_m));
                let (far, radius_m) = (at.length(), rest.radius_m);
                let circle = Circle {
                    at: scope.project(at)?,
                    radius: scope.on_picture((radius_m / far.max(1e-4)).min(1.0).asin()),
                    mark: mark(now.bits, rest.held != 0),
                };
                Some((far, circle))
            })
            .collect();
        seen.sort_by(|a, b| b.0.total_cmp(&a.0));
        self.circles = seen.into_iter().map(|(_, circle)| circle).collect();
    }

    fn add_links(
        &mut self,
        scene: &SceneFile,
        spheres: &[SphereState],
        camera: &Mat4,
        scope: &Scope,
    ) {
        for link in scene.links() {
            let end = |i: u32| spheres.get(i as usize).map(|s| Vec3::from(s.center_m));
            if let (Some(a), Some(b)) = (end(link.a), end(link.b)) {
                self.add_line(camera, scope, [a, b], 0.0, Mark::Link);
            }
        }
    }

    /// Adds the end of the shaft at the position at which the hand holds it, and a circle at its
    /// tip. A line joins this tip to the nearest part of the tool other than the shaft.
    fn add_device(&mut self, scene: &SceneFile, tools: &ToolFrame, camera: &Mat4, scope: &Scope) {
        let room = scene.room();
        let handle = Vec3::from(tools.world_from_handle.position_m);
        let port = Vec3::from(room.instrument_port_m);
        let along = (port - handle).normalize_or_zero();
        let tip = handle + along * room.instrument_length_m;
        if along == Vec3::ZERO || !tip.is_finite() {
            return;
        }
        self.add_line(camera, scope, [tip - along * 0.04, tip], 0.0, Mark::Device);
        let ends = tools
            .capsules()
            .unwrap_or(&[])
            .iter()
            .filter(|c| !c.is(CapsuleRole::Shaft));
        let ends = ends.map(|c| Vec3::from(c.b_m));
        let nearest = ends.min_by(|a, b| a.distance(tip).total_cmp(&b.distance(tip)));
        if let Some(tool) = nearest {
            self.add_line(camera, scope, [tip, tool], 0.0, Mark::Device);
        }
        let at = camera.transform_point3(tip);
        if let Some(on) = scope.project(at) {
            self.circles.push(Circle {
                at: on,
                radius: scope.on_picture((0.0015 / at.length().max(1e-3)).min(1.0).asin()),
                mark: Mark::Device,
            });
        }
    }

    fn add_line(&mut self, camera: &Mat4, scope: &Scope, ends: [Vec3; 2], width: f32, mark: Mark) {
        let [a, b] = ends.map(|end| scope.project(camera.transform_point3(end)));
        if let (Some(a), Some(b)) = (a, b) {
            self.lines.push(Line {
                ends: [a, b],
                width,
                mark,
            });
        }
    }

    /// Draws the view over the endoscope's picture in `picture`.
    pub(super) fn paint(&self, painter: &Painter, picture: Rect) {
        let unit = picture.height() / 2.0;
        let place = |at: Vec2| -> Pos2 { picture.center() + vec2(at.x, -at.y) * unit };
        let painter = painter.with_clip_rect(picture);
        for line in &self.lines {
            let (colour, least) = colour(line.mark);
            let stroke = Stroke::new((line.width * unit).max(least), colour);
            painter.line_segment(line.ends.map(place), stroke);
        }
        for circle in &self.circles {
            let (colour, width) = colour(circle.mark);
            let (at, radius) = (place(circle.at), circle.radius * unit);
            painter.circle_stroke(at, radius, Stroke::new(width, colour));
            if matches!(circle.mark, Mark::Contact | Mark::Grasped) {
                painter.circle_filled(at, (radius * 0.35).max(2.0), colour);
            }
        }
    }

    /// Text of the view: the model's counts, the awake organs, the meaning of the colours.
    pub(super) fn said(&self, words: &Words) -> String {
        format!("{}\n{}", self.notes.said(words), words.say("inside-legend"))
    }
}

impl Notes {
    fn of(scene: &SceneFile, spheres: &[SphereState]) -> Self {
        let touched = spheres
            .iter()
            .filter(|s| s.bits & SphereState::CONTACT != 0);
        let awake = scene.organs().iter().filter(|organ| {
            let [first, count] = organ.spheres.map(|x| x as usize);
            let own = spheres.get(first..first + count).unwrap_or(&[]);
            own.iter().any(|s| s.bits & SphereState::AWAKE != 0)
        });
        Self {
            counts: [
                spheres.len(),
                scene.links().len(),
                scene.tetrahedra().len(),
                touched.count(),
            ],
            organs: scene.organs().len(),
            awake: awake
                .filter_map(|organ| str_from_name(&organ.name))
                .map(str::to_owned)
                .collect(),
        }
    }

    fn said(&self, words: &Words) -> String {
        let [spheres, links, tetrahedra, touched] = self.counts.map(|it| it.to_string().into());
        let counts = [
            ("spheres", spheres),
            ("links", links),
            ("tetrahedra", tetrahedra),
            ("touched", touched),
        ];
        let names: Vec<String> = self.awake.iter().map(|it| words.organ(it)).collect();
        let awake = [
            ("awake", names.len().to_string().into()),
            ("organs", self.organs.to_string().into()),
            ("names", names.join(", ").into()),
        ];
        let id = if names.is_empty() {
            "inside-asleep"
        } else {
            "inside-awake"
        };
        let counts = words.say_with("inside-counts", &counts);
        format!("{counts}\n{}", words.say_with(id, &awake))
    }
}

fn mark(bits: u32, held: bool) -> Mark {
    let has = |bit: u32| bits & bit != 0;
    if has(SphereState::GRASPED) {
        Mark::Grasped
    } else if has(SphereState::CONTACT) {
        Mark::Contact
    } else if held {
        Mark::Held
    } else if has(SphereState::AWAKE) {
        Mark::Awake
    } else {
        Mark::Asleep
    }
}

fn colour(mark: Mark) -> (Color32, f32) {
    let shade = Color32::from_rgba_unmultiplied;
    match mark {
        Mark::Asleep => (shade(150, 150, 150, 110), 1.0),
        Mark::Awake => (shade(120, 180, 255, 150), 1.0),
        Mark::Held => (shade(255, 255, 255, 130), 1.0),
        Mark::Contact => (shade(255, 160, 40, 255), 2.0),
        Mark::Grasped => (shade(255, 110, 190, 255), 2.0),
        Mark::Link => (shade(160, 210, 160, 60), 0.7),
        Mark::Tool => (shade(90, 230, 230, 70), 1.0),
        Mark::Force => (shade(255, 235, 60, 255), 3.0),
        Mark::Device => (shade(255, 90, 255, 220), 1.5),
    }
}
