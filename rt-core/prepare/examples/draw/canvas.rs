//! A picture of several panels, with a depth buffer.

use std::path::Path;

use scene_prepare::Vec3;
use shared_mem::message::PoseMsg;

pub(crate) struct Canvas {
    size: usize,
    columns: usize,
    rows: usize,
    color: Vec<[u8; 3]>,
    depth: Vec<f64>,
}

/// Viewpoint of a panel.
pub(crate) struct View {
    eye: Vec3,
    right: Vec3,
    up: Vec3,
    forward: Vec3,
    /// Half of the visible height: in perspective as a share of the distance, otherwise in metres.
    half: f64,
    perspective: bool,
}

impl View {
    pub(crate) fn along(middle: Vec3, forward: Vec3, up: Vec3, half: f64) -> Self {
        let right = forward.cross(&up).normalize();
        let up = right.cross(&forward);
        Self {
            eye: middle - forward,
            right,
            up,
            forward,
            half,
            perspective: false,
        }
    }

    pub(crate) fn camera(pose: &PoseMsg) -> Self {
        let [x, y, z, w] = pose.orientation.map(f64::from);
        let q = nalgebra::Quaternion::new(w, x, y, z);
        let turn = nalgebra::UnitQuaternion::new_normalize(q);
        Self {
            eye: Vec3::from(pose.position_m.map(f64::from)),
            right: turn * Vec3::x(),
            up: turn * Vec3::y(),
            forward: turn * -Vec3::z(),
            half: 0.62,
            perspective: true,
        }
    }

    /// Coordinates of a point in the panel, to the right and up, from −1 to 1 inside the panel; and
    /// its depth, m.
    fn project(&self, p: &Vec3) -> Option<[f64; 3]> {
        let q = p - self.eye;
        let depth = q.dot(&self.forward);
        let scale = if self.perspective {
            self.half * depth
        } else {
            self.half
        };
        (depth > 1e-3).then(|| [q.dot(&self.right) / scale, q.dot(&self.up) / scale, depth])
    }

    fn shade(&self, p: &Vec3, normal: &Vec3) -> f64 {
        let to_eye = if self.perspective {
            (self.eye - p).normalize()
        } else {
            -self.forward
        };
        let light = (to_eye + self.up * 0.35 - self.right * 0.2).normalize();
        let facing = normal.dot(&to_eye);
        let diffuse = normal.dot(&light).max(0.0);
        let gloss = normal.dot(&(light + to_eye).normalize()).max(0.0).powi(40);
        if facing < 0.0 {
            0.05
        } else {
            0.15 + 0.85 * diffuse + 0.35 * gloss
        }
    }
}

impl Canvas {
    pub(crate) fn new(size: usize, columns: usize, rows: usize) -> Self {
        let pixels = size * columns * size * rows;
        Self {
            size,
            columns,
            rows,
            color: vec![[28; 3]; pixels],
            depth: vec![f64::INFINITY; pixels],
        }
    }

    fn pixel(&self, column: usize, row: usize, x: f64, y: f64) -> [f64; 2] {
        let half = self.size as f64 / 2.0;
        [
            (column * self.size) as f64 + half + x * half,
            (row * self.size) as f64 + half - y * half,
        ]
    }

    fn panel(&self, column: usize, row: usize, low: [f64; 2], high: [f64; 2]) -> [usize; 4] {
        let clamp =
            |v: f64, start: usize| v.clamp(start as f64, (start + self.size - 1) as f64) as usize;
        let (x0, y0) = (column * self.size, row * self.size);
        [
            clamp(low[0], x0),
            clamp(high[0], x0),
            clamp(low[1], y0),
            clamp(high[1], y0),
        ]
    }

    fn put(&mut self, x: usize, y: usize, depth: f64, color: [u8; 3], shade: f64) {
        let i = x + y * self.size * self.columns;
        if depth < self.depth[i] {
            self.depth[i] = depth;
            self.color[i] = color.map(|c| (f64::from(c) * shade).min(255.0) as u8);
        }
    }

    pub(crate) fn triangle(
        &mut self,
        column: usize,
        row: usize,
        view: &View,
        corners: [(Vec3, Vec3); 3],
        color: [u8; 3],
    ) {
        let Some(q) = corners
            .iter()
            .map(|(p, _)| view.project(p))
            .collect::<Option<Vec<_>>>()
        else {
            return;
        };
        let at: Vec<[f64; 2]> = q
            .iter()
            .map(|q| self.pixel(column, row, q[0], q[1]))
            .collect();
        let low = [0, 1].map(|k| at.iter().map(|p| p[k]).fold(f64::INFINITY, f64::min));
        let high = [0, 1].map(|k| at.iter().map(|p| p[k]).fold(f64::NEG_INFINITY, f64::max));
        let [x0, x1, y0, y1] = self.panel(column, row, low, high);
        let cross = |a: [f64; 2], b: [f64; 2], p: [f64; 2]| {
            (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0])
        };
        let area = cross(at[0], at[1], at[2]);
        for y in y0..=y1 {
            for x in x0..=x1 {
                let p = [x as f64 + 0.5, y as f64 + 0.5];
                let w = [
                    cross(at[1], at[2], p) / area,
                    cross(at[2], at[0], p) / area,
                    cross(at[0], at[1], p) / area,
                ];
                if w.iter().all(|w| *w >= 0.0) {
                    let depth: f64 = (0..3).map(|k| w[k] * q[k][2]).sum();
                    let place: Vec3 = (0..3).map(|k| corners[k].0 * w[k]).sum();
                    let normal: Vec3 = (0..3).map(|k| corners[k].1 * w[k]).sum();
                    self.put(x, y, depth, color, view.shade(&place, &normal.normalize()));
                }
            }
        }
    }

    pub(crate) fn ball(
        &mut self,
        column: usize,
        row: usize,
        view: &View,
        center: Vec3,
        radius: f64,
        color: [u8; 3],
    ) {
        let Some(c) = view.project(&center) else {
            return;
        };
        let scale = if view.perspective {
            view.half * c[2]
        } else {
            view.half
        };
        let pixels = radius / scale * self.size as f64 / 2.0;
        let at = self.pixel(column, row, c[0], c[1]);
        let low = at.map(|v| v - pixels);
        let high = at.map(|v| v + pixels);
        let [x0, x1, y0, y1] = self.panel(column, row, low, high);
        for y in y0..=y1 {
            for x in x0..=x1 {
                let dx = (x as f64 + 0.5 - at[0]) / pixels;
                let dy = (at[1] - y as f64 - 0.5) / pixels;
                let r2 = dx * dx + dy * dy;
                if r2 < 1.0 {
                    let dz = (1.0 - r2).sqrt();
                    let normal = view.right * dx + view.up * dy - view.forward * dz;
                    let shade = view.shade(&(center + normal * radius), &normal);
                    self.put(x, y, c[2] - dz * radius, color, shade);
                }
            }
        }
    }

    pub(crate) fn line(
        &mut self,
        column: usize,
        row: usize,
        view: &View,
        a: Vec3,
        b: Vec3,
        color: [u8; 3],
    ) {
        for step in 0..=200 {
            let Some(q) = view.project(&a.lerp(&b, f64::from(step) / 200.0)) else {
                continue;
            };
            if q[0].abs() < 1.0 && q[1].abs() < 1.0 {
                let [x, y] = self.pixel(column, row, q[0], q[1]);
                self.put(x as usize, y as usize, q[2] - 1e-4, color, 1.0);
            }
        }
    }

    pub(crate) fn save(&self, path: &Path) -> Result<(), Box<dyn std::error::Error>> {
        let (width, height) = (self.size * self.columns, self.size * self.rows);
        let bytes: Vec<u8> = self.color.as_flattened().to_vec();
        image::save_buffer(
            path,
            &bytes,
            width as u32,
            height as u32,
            image::ColorType::Rgb8,
        )?;
        Ok(())
    }
}
