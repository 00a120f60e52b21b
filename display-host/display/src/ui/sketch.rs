//! Moving pictures of steps and tasks, drawn as the endoscope would show them.

use assess::Step;
use egui::{Color32, Painter, Pos2, Rect, Sense, Shape, Stroke, Ui, Vec2, pos2, vec2};

/// Time that a picture takes before it begins again, s.
const CYCLE_S: f64 = 3.2;
/// Interval between two drawings, s.
const REDRAW_S: f32 = 0.05;
const LIVER: Color32 = Color32::from_rgb(122, 46, 40);
const BAG: Color32 = Color32::from_rgb(112, 146, 104);
const DUCT: Color32 = Color32::from_rgb(200, 186, 96);
const STRAND: Color32 = Color32::from_rgb(226, 206, 150);
const METAL: Color32 = Color32::from_rgb(200, 204, 210);
const SIGHT: Color32 = Color32::from_rgb(120, 215, 150);
const SPARK: Color32 = Color32::from_rgb(255, 236, 140);

/// Content of a moving picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Sketch {
    Camera,
    Meet,
    Grasp,
    Clip,
    Cut,
    Current,
    Peel,
    Touch,
    Carry,
}

/// Steps of the whole operation, shown one after the other.
const WHOLE: [Sketch; 4] = [Sketch::Current, Sketch::Clip, Sketch::Cut, Sketch::Peel];
/// The first steps, shown one after the other.
const BASICS: [Sketch; 5] = [
    Sketch::Camera,
    Sketch::Meet,
    Sketch::Grasp,
    Sketch::Clip,
    Sketch::Current,
];

/// The drills on the phantom, shown one after the other.
const PHANTOM: [Sketch; 5] = [
    Sketch::Touch,
    Sketch::Carry,
    Sketch::Clip,
    Sketch::Cut,
    Sketch::Current,
];

impl Sketch {
    /// Pictures of a task, by its name.
    fn of_task(task: &str) -> &'static [Self] {
        match task {
            "basics" => &BASICS,
            "phantom" => &PHANTOM,
            "scope" => &[Self::Camera],
            "identify" => &[Self::Current],
            "clamp" => &[Self::Clip],
            "cut" => &[Self::Cut],
            "disconnect" => &[Self::Peel],
            "full" => &WHOLE,
            _ => &[Self::Grasp],
        }
    }

    /// Picture of a step.
    pub(super) fn of_step(step: &Step) -> Self {
        match step {
            Step::Show { .. } | Step::ShowView { .. } => Self::Camera,
            Step::Meet => Self::Meet,
            Step::Hang { .. } | Step::Grasp { .. } | Step::Collect { .. } => Self::Grasp,
            Step::Clip { .. } => Self::Clip,
            Step::Divide { .. } => Self::Cut,
            Step::Triangle | Step::LeaveWhole | Step::Coagulate => Self::Current,
            Step::LowerBed | Step::Free => Self::Peel,
            Step::Touch { .. } => Self::Touch,
            Step::Carry { .. } => Self::Carry,
            Step::Clear { .. } => Self::Current,
        }
    }
}

/// Adds the moving picture of a task.
pub(super) fn task(ui: &mut Ui, task: &str, size: Vec2, text: &str) {
    let time_s = ui.input(|input| input.time);
    let all = Sketch::of_task(task);
    let turn = (time_s / CYCLE_S) as usize;
    if let Some(sketch) = all.get(turn % all.len().max(1)) {
        show(ui, *sketch, size, text);
    }
}

/// Adds a moving picture, which a screen reader reads as `text`.
pub(super) fn show(ui: &mut Ui, sketch: Sketch, size: Vec2, text: &str) {
    let (rect, response) = ui.allocate_exact_size(size, Sense::hover());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, text));
    let phase = (ui.input(|input| input.time) % CYCLE_S / CYCLE_S) as f32;
    let scene = Scene::of(ui.painter().with_clip_rect(rect), rect);
    scene.draw(sketch, phase);
    let redraw = std::time::Duration::from_secs_f32(REDRAW_S);
    ui.ctx().request_repaint_after(redraw);
}

/// A round picture. Places in it are given in shares of its radius, y up.
struct Scene {
    painter: Painter,
    middle: Pos2,
    radius: f32,
}

/// Progress of a movement that begins at the phase `from` and ends at `to`: 0 before, 1 after, and
/// eased at both ends.
fn between(phase: f32, from: f32, to: f32) -> f32 {
    let share = ((phase - from) / (to - from)).clamp(0.0, 1.0);
    share * share * (3.0 - 2.0 * share)
}

impl Scene {
    fn of(painter: Painter, rect: Rect) -> Self {
        let (middle, radius) = (rect.center(), 0.5 * rect.height());
        painter.rect_filled(rect, 6.0, Color32::BLACK);
        painter.circle_filled(middle, radius, Color32::from_rgb(66, 24, 22));
        Self {
            painter,
            middle,
            radius,
        }
    }

    fn at(&self, [x, y]: [f32; 2]) -> Pos2 {
        pos2(
            self.middle.x + x * self.radius,
            self.middle.y - y * self.radius,
        )
    }

    fn line(&self, ends: [[f32; 2]; 2], width: f32, colour: Color32) {
        let ends = ends.map(|it| self.at(it));
        let width = width * self.radius;
        self.painter.line_segment(ends, Stroke::new(width, colour));
        for end in ends {
            self.painter.circle_filled(end, 0.5 * width, colour);
        }
    }

    fn blob(&self, at: [f32; 2], size: [f32; 2], colour: Color32) {
        let size = vec2(size[0], size[1]) * self.radius;
        self.painter
            .add(Shape::ellipse_filled(self.at(at), size, colour));
    }

    /// Liver and, below it, gallbladder, moved by `[x, y]`.
    fn organs(&self, [x, y]: [f32; 2]) {
        self.blob([x, y + 0.85], [1.1, 0.62], LIVER);
        self.blob([x - 0.05, y + 0.1], [0.42, 0.26], BAG);
    }

    /// A tube from left to right.
    fn tube(&self, height: f32) {
        self.line([[-0.95, height - 0.08], [0.95, height + 0.08]], 0.2, DUCT);
    }

    /// An instrument from the upper right, as in the endoscope's picture, with jaws opened by
    /// `open`.
    fn jaws(&self, tip: [f32; 2], open: f32, colour: Color32) {
        let [x, y] = tip;
        self.line([[x + 0.9, y + 0.9], [x + 0.16, y + 0.16]], 0.09, METAL);
        let spread = 0.14 * open;
        let joint = [x + 0.16, y + 0.16];
        self.line([joint, [x - spread, y - spread * 0.4 + 0.02]], 0.05, colour);
        self.line(
            [joint, [x + spread * 0.4 + 0.02, y - spread + 0.02]],
            0.05,
            colour,
        );
    }

    /// A hook from the upper right. Its bend lies under the strand at its tip.
    fn hook(&self, tip: [f32; 2]) {
        let [x, y] = tip;
        self.line([[x + 0.9, y + 0.9], [x + 0.08, y + 0.08]], 0.08, METAL);
        self.line([[x + 0.08, y + 0.08], [x + 0.05, y - 0.06]], 0.045, METAL);
        self.line([[x + 0.05, y - 0.06], [x - 0.07, y - 0.05]], 0.045, METAL);
    }

    fn spark(&self, at: [f32; 2], phase: f32) {
        let long = 0.1 + 0.05 * (phase * 60.0).sin().abs();
        for [x, y] in [[1.0, 0.0], [0.0, 1.0], [0.7, 0.7], [-0.7, 0.7]] {
            let ray = |by: f32| [at[0] + by * x * long, at[1] + by * y * long];
            self.line([ray(-1.0), ray(1.0)], 0.025, SPARK);
        }
    }

    /// Ring in the middle, of which `share` is filled.
    fn ring(&self, share: f32) {
        let at = self.at([0.0, 0.0]);
        let radius = 0.34 * self.radius;
        let stroke = Stroke::new(1.5, Color32::WHITE);
        self.painter.circle_stroke(at, radius, stroke);
        let point = |step: u32| {
            let turn = core::f32::consts::TAU * share * step as f32 / 40.0;
            at + vec2(turn.sin(), -turn.cos()) * radius
        };
        let arc: Vec<Pos2> = (0..=40).map(point).collect();
        self.painter.add(Shape::line(arc, Stroke::new(4.0, SIGHT)));
    }

    fn draw(&self, sketch: Sketch, phase: f32) {
        match sketch {
            Sketch::Camera => {
                let off = 1.0 - between(phase, 0.0, 0.55);
                self.organs([0.55 * off, -0.1 - 0.3 * off]);
                self.ring(between(phase, 0.55, 0.95));
            }
            Sketch::Meet => {
                self.organs([0.0, 0.25]);
                let off = 1.0 - between(phase, 0.0, 0.55);
                self.ring(between(phase, 0.55, 0.95));
                self.jaws([0.55 * off, 0.5 * off], 0.3, METAL);
            }
            Sketch::Grasp => self.grasp(phase),
            Sketch::Clip => self.clip(phase),
            Sketch::Cut => self.cut(phase),
            Sketch::Current => self.current(phase),
            Sketch::Peel => self.peel(phase),
            Sketch::Touch => self.touch(phase),
            Sketch::Carry => self.carry(phase),
        }
    }

    fn touch(&self, phase: f32) {
        let balls = [[-0.5, 0.35], [-0.5, -0.35], [0.4, 0.0f32]];
        let time = 3.0 * phase.min(0.999);
        let (number, share) = (time as usize, time.fract());
        for (ball, at) in balls.into_iter().enumerate() {
            let is_touched = ball < number || ball == number && share > 0.6;
            self.blob(at, [0.19, 0.19], if is_touched { SIGHT } else { LIVER });
        }
        let goal = balls.get(number).copied().unwrap_or_default();
        let off = 1.0 - between(share, 0.0, 0.6) + between(share, 0.75, 1.0);
        self.jaws(
            [goal[0] + 0.15 + 0.4 * off, goal[1] + 0.13 + 0.4 * off],
            0.0,
            METAL,
        );
    }

    fn carry(&self, phase: f32) {
        let (near, shut) = (between(phase, 0.0, 0.3), between(phase, 0.32, 0.42));
        let way = between(phase, 0.45, 0.85);
        self.blob([0.5, -0.45], [0.2, 0.2], LIVER);
        let end = [0.1 + 0.18 * way, 0.45 - 0.6 * way];
        self.line([[-0.7, 0.5], [-0.3, 0.52]], 0.16, BAG);
        self.line([[-0.3, 0.52], end], 0.16, BAG);
        let tip = [end[0] + 0.5 * (1.0 - near), end[1] + 0.5 * (1.0 - near)];
        self.jaws(tip, 1.0 - shut, METAL);
    }

    fn grasp(&self, phase: f32) {
        let (near, shut) = (between(phase, 0.0, 0.35), between(phase, 0.4, 0.55));
        let drawn = 0.14 * between(phase, 0.6, 0.9);
        self.organs([0.0, 0.0]);
        let tip = [
            0.3 + 0.45 * (1.0 - near) + drawn,
            0.05 + 0.5 * (1.0 - near) + drawn,
        ];
        if drawn > 0.0 {
            self.line([[0.2, 0.08], tip], 0.16, BAG);
        }
        self.jaws(tip, 1.0 - shut, METAL);
    }

    fn clip(&self, phase: f32) {
        let (near, shut) = (between(phase, 0.0, 0.35), between(phase, 0.4, 0.55));
        let back = between(phase, 0.65, 0.9);
        self.blob([-0.9, 0.1], [0.4, 0.5], BAG);
        self.tube(0.05);
        let tip = [
            0.5 * (1.0 - near) + 0.6 * back,
            0.55 * (1.0 - near) + 0.65 * back,
        ];
        if shut > 0.5 {
            self.line([[0.0, -0.1], [0.04, 0.19]], 0.06, Color32::WHITE);
        }
        self.jaws(tip, 1.2 * (1.0 - shut).max(back), METAL);
    }

    fn cut(&self, phase: f32) {
        let (near, shut) = (between(phase, 0.0, 0.35), between(phase, 0.4, 0.5));
        let gap = 0.1 * between(phase, 0.5, 0.75);
        self.line([[-0.95, -0.03], [-gap, 0.05]], 0.2, DUCT);
        self.line([[gap, 0.05], [0.95, 0.13]], 0.2, DUCT);
        for x in [-0.45, -0.28, 0.28, 0.45f32] {
            let y = 0.05 + 0.08 * x;
            self.line([[x, y - 0.14], [x + 0.03, y + 0.14]], 0.05, Color32::WHITE);
        }
        let tip = [0.5 * (1.0 - near), 0.02 + 0.55 * (1.0 - near)];
        self.jaws(tip, 1.2 * (1.0 - shut), METAL);
    }

    fn current(&self, phase: f32) {
        let (near, lift) = (between(phase, 0.0, 0.3), between(phase, 0.35, 0.5));
        let burns = (0.55..0.75).contains(&phase);
        self.blob([-0.75, 0.0], [0.35, 0.75], BAG);
        self.blob([0.8, 0.25], [0.4, 0.7], LIVER);
        for (number, height) in [-0.25f32, 0.0, 0.25].into_iter().enumerate() {
            let by = if number == 1 { 0.16 * lift } else { 0.0 };
            if number == 1 && phase > 0.75 {
                self.line([[-0.5, height], [-0.35, height - 0.05]], 0.05, STRAND);
                self.line([[0.5, height], [0.35, height - 0.05]], 0.05, STRAND);
                continue;
            }
            self.line([[-0.5, height], [0.0, height + by]], 0.05, STRAND);
            self.line([[0.0, height + by], [0.5, height]], 0.05, STRAND);
        }
        let away = 1.0 - near;
        let tip = [0.4 * away, 0.16 * lift + 0.4 * away];
        self.hook(tip);
        if burns {
            self.spark([0.0, 0.18], phase);
        }
    }

    fn peel(&self, phase: f32) {
        let done = between(phase, 0.1, 0.9);
        self.blob([0.0, 0.95], [1.1, 0.62], LIVER);
        self.blob([0.0, -0.35 - 0.12 * done], [0.75, 0.36], BAG);
        let front = -0.6 + 1.2 * done;
        for number in 0..9 {
            let x = -0.6 + 0.15 * number as f32;
            if x > front {
                self.line([[x, 0.36], [x, 0.0]], 0.05, STRAND);
            }
        }
        self.hook([front, 0.18]);
        if phase > 0.1 && phase < 0.9 {
            self.spark([front - 0.05, 0.24], phase);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_task_has_a_picture_of_its_own() {
        let tasks = assess::Task::ALL.map(|it| Sketch::of_task(it.name()));
        assert!(tasks.iter().all(|it| !it.is_empty()));
        let mut own: Vec<_> = tasks.iter().map(|it| format!("{it:?}")).collect();
        own.sort();
        own.dedup();
        assert_eq!(own.len(), tasks.len(), "{own:?}");
    }

    #[test]
    fn a_movement_begins_and_ends_at_rest() {
        assert!(between(0.0, 0.2, 0.6) < 1e-6 && between(0.7, 0.2, 0.6) > 1.0 - 1e-6);
        assert!((between(0.4, 0.2, 0.6) - 0.5).abs() < 1e-6);
        assert!(between(0.22, 0.2, 0.6) < 0.05, "it starts slowly");
    }
}
