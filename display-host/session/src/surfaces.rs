//! A file for viewers in Foxglove's schemas: the organs' surfaces over time, and pictures.

use std::fs::File;
use std::io::BufWriter;
use std::path::{Path, PathBuf};

use foxglove::messages::{
    Color, CompressedImage, FrameTransforms, Point3, SceneEntity, SceneUpdate,
    TriangleListPrimitive,
};
use mcap::records::MessageHeader;
use mcap::write::Writer;
use prost::Message;
use shared_mem::message::ToolFrame;

use crate::course::Movement;
use crate::describe::{self, Topic};
use crate::error::ReadError;
use crate::storage::create_private;
use crate::viewer;

/// Words before the program's version at the head of a file of surfaces. They distinguish it from a
/// recording.
pub const SURFACES_BY: &str = "surfaces by calot:";
/// Topic of the surfaces.
const ORGANS: &str = "/organs";
/// Topic of pictures.
const PICTURES: &str = "/pictures";
/// Frame of a picture, with Foxglove's axes: x to the right, y down, z into the picture. The frame
/// `camera` has other axes.
const OPTICAL: &str = "camera_optical";

/// Surface of an organ at one moment, world frame.
#[derive(Debug, Clone, Default)]
pub struct Surface {
    /// Name of the organ.
    pub name: String,
    /// Red, green and blue, 0 to 1.
    pub color: [f32; 3],
    /// Places of the vertices, m.
    pub points_m: Vec<[f32; 3]>,
    /// Triangles, counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
}

/// A file of surfaces under construction.
pub struct SurfaceFile {
    path: PathBuf,
    writer: Writer<BufWriter<File>>,
    channels: [u16; 3],
    /// Channel of pictures, once there is one.
    pictures: Option<u16>,
    sequence: u32,
}

impl core::fmt::Debug for SurfaceFile {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("SurfaceFile")
            .field("path", &self.path)
            .finish_non_exhaustive()
    }
}

impl SurfaceFile {
    /// Creates the file, which no other user can read. `build` is the program that writes.
    ///
    /// # Errors
    /// [`ReadError::Write`].
    pub fn create(path: &Path, build: &str) -> Result<Self, ReadError> {
        Self::begin(path, build).map_err(|problem| refused(path, problem))
    }

    fn begin(path: &Path, build: &str) -> Result<Self, String> {
        let words = |error: mcap::McapError| error.to_string();
        let file = create_private(path).map_err(|error| error.to_string())?;
        let options = mcap::WriteOptions::new()
            .profile("")
            .library(format!("{SURFACES_BY} {build}"))
            .compression(None);
        let mut writer = Writer::with_options(BufWriter::new(file), options).map_err(words)?;
        let mut channel = |topic: &Topic| {
            let (name, encoding) = (&topic.schema_name, topic.schema_encoding);
            let schema = writer.add_schema(name, encoding, &topic.schema)?;
            writer.add_channel(schema, topic.name, topic.encoding, &Default::default())
        };
        let channels = [
            channel(&describe::foxglove::<SceneUpdate>(ORGANS)).map_err(words)?,
            channel(&describe::foxglove::<FrameTransforms>(describe::POSES)).map_err(words)?,
            channel(&describe::TOOL).map_err(words)?,
        ];
        Ok(Self {
            path: path.to_owned(),
            writer,
            channels,
            pictures: None,
            sequence: 0,
        })
    }

    /// Adds a moment: the organs' surfaces, and the tools.
    ///
    /// # Errors
    /// [`ReadError::Write`].
    pub fn add(
        &mut self,
        wall_ns: u64,
        surfaces: &[Surface],
        tools: &ToolFrame,
    ) -> Result<(), ReadError> {
        let update = SceneUpdate {
            deletions: Vec::new(),
            entities: surfaces.iter().map(|it| entity(it, wall_ns)).collect(),
        };
        let [organs, poses, tool] = self.channels;
        self.put(organs, wall_ns, &update)?;
        self.put(poses, wall_ns, &viewer::poses(tools, wall_ns))?;
        match Movement::of(tools) {
            Some(moved) => self.put(tool, wall_ns, &viewer::tool(tools, &moved)),
            None => Ok(()),
        }
    }

    /// Adds a picture (PNG). Pictures come in order of time.
    ///
    /// # Errors
    /// [`ReadError::Write`].
    pub fn picture(&mut self, wall_ns: u64, png: Vec<u8>) -> Result<(), ReadError> {
        let channel = match self.pictures {
            Some(channel) => channel,
            None => self
                .begin_pictures()
                .map_err(|error| refused(&self.path, error.to_string()))?,
        };
        self.pictures = Some(channel);
        let image = CompressedImage {
            timestamp: viewer::timestamp(wall_ns),
            frame_id: OPTICAL.to_owned(),
            data: png.into(),
            format: "png".to_owned(),
        };
        self.put(channel, wall_ns, &image)
    }

    fn begin_pictures(&mut self) -> mcap::McapResult<u16> {
        let topic = describe::foxglove::<CompressedImage>(PICTURES);
        let (name, encoding) = (&topic.schema_name, topic.schema_encoding);
        let schema = self.writer.add_schema(name, encoding, &topic.schema)?;
        self.writer
            .add_channel(schema, topic.name, topic.encoding, &Default::default())
    }

    /// Completes the file.
    ///
    /// # Errors
    /// [`ReadError::Write`].
    pub fn end(mut self) -> Result<(), ReadError> {
        let ended = self.writer.finish();
        ended
            .map(|_| ())
            .map_err(|error| refused(&self.path, error.to_string()))
    }

    fn put(&mut self, channel_id: u16, time: u64, message: &impl Message) -> Result<(), ReadError> {
        let header = MessageHeader {
            channel_id,
            sequence: self.sequence,
            log_time: time,
            publish_time: time,
        };
        self.sequence = self.sequence.wrapping_add(1);
        let data = message.encode_to_vec();
        let written = self.writer.write_to_known_channel(&header, &data);
        written.map_err(|error| refused(&self.path, error.to_string()))
    }
}

fn refused(path: &Path, problem: String) -> ReadError {
    ReadError::Write {
        path: path.to_owned(),
        problem,
    }
}

/// An organ with its present surface. A later entity of the same name replaces it.
fn entity(surface: &Surface, wall_ns: u64) -> SceneEntity {
    let [r, g, b] = surface.color.map(f64::from);
    let point = |[x, y, z]: [f32; 3]| Point3 {
        x: x.into(),
        y: y.into(),
        z: z.into(),
    };
    let triangles = TriangleListPrimitive {
        pose: Some(viewer::origin()),
        points: surface.points_m.iter().copied().map(point).collect(),
        color: Some(Color { r, g, b, a: 1.0 }),
        colors: Vec::new(),
        indices: surface.triangles.iter().flatten().copied().collect(),
    };
    SceneEntity {
        timestamp: viewer::timestamp(wall_ns),
        frame_id: viewer::WORLD.to_owned(),
        id: surface.name.clone(),
        triangles: vec![triangles],
        ..SceneEntity::default()
    }
}
