//! A session read from the front, a chunk at a time: whole, cut off by a kill, or damaged.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use mcap::records::Record;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use shared_mem::inputs::{InputRecord, RunSetup};

use crate::describe::{INPUTS, OWN, SETUP};
use crate::file::{FILE_VERSION, SCENE};
use crate::info::{self, Info};
use crate::pack::unpack;

/// Longest record that is read: a scene of real anatomy is a few megabytes.
const RECORD_MAX_BYTES: usize = 64 << 20;

/// Why a session cannot be replayed.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The file cannot be opened or read.
    #[error("{path}: {source}; a session is what `calot run --record FILE` leaves")]
    Io {
        /// Which.
        path: PathBuf,
        /// The system's words.
        source: std::io::Error,
    },
    /// It is something else, or damaged before its first tick.
    #[error(
        "{path} is no session of Calot: {problem}; a session is what `calot run --record FILE` leaves"
    )]
    NotASession {
        /// Which.
        path: PathBuf,
        /// What is missing or wrong.
        problem: String,
    },
    /// Another version of Calot wrote it.
    #[error(
        "{path}: a session of version '{found}', this program reads {FILE_VERSION}; replay it with the program that recorded it"
    )]
    Version {
        /// Which.
        path: PathBuf,
        /// Its version.
        found: String,
    },
}

/// How a session ends.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum End {
    /// It was ended in order.
    Whole,
    /// It breaks off: the recorder was killed, the disk was full, or the file is damaged; why.
    BrokenOff(String),
}

/// A session, being read.
pub struct Session {
    path: PathBuf,
    bytes: u64,
    records: Records,
    /// What it says of itself.
    pub info: Info,
    /// What its run began with.
    pub setup: RunSetup,
    /// The compiled scene, if it is in it.
    pub scene: Option<Vec<u8>>,
    inputs: std::vec::IntoIter<InputRecord>,
}

impl core::fmt::Debug for Session {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Session")
            .field("path", &self.path)
            .field("info", &self.info)
            .finish_non_exhaustive()
    }
}

impl Session {
    /// Opens a session and reads as far as its first tick.
    ///
    /// # Errors
    /// As [`ReadError`] says.
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        let io = |source| ReadError::Io {
            path: path.to_owned(),
            source,
        };
        let file = File::open(path).map_err(io)?;
        let bytes = file.metadata().map_err(io)?.len();
        Self::read(path, bytes, Box::new(file))
    }

    /// The same from any source of bytes.
    ///
    /// # Errors
    /// As [`ReadError`] says.
    pub fn read(path: &Path, bytes: u64, source: Box<dyn Read>) -> Result<Self, ReadError> {
        let not = |problem: &str| ReadError::NotASession {
            path: path.to_owned(),
            problem: problem.to_owned(),
        };
        let mut records = Records::new(source);
        let (mut info, mut setup, mut scene) = (None, None, None);
        let inputs = loop {
            match records.next() {
                Some(Part::Info(map)) => {
                    info = Some(Info::from_map(&map).map_err(|found| ReadError::Version {
                        path: path.to_owned(),
                        found,
                    })?);
                }
                Some(Part::Setup(found)) => setup = Some(found),
                Some(Part::Scene(found)) => scene = Some(found),
                Some(Part::Inputs(found)) => break found,
                None => {
                    let end = match &records.end {
                        Some(End::BrokenOff(why)) => why.as_str(),
                        _ => "it has no ticks",
                    };
                    return Err(not(end));
                }
            }
        };
        Ok(Self {
            path: path.to_owned(),
            bytes,
            records,
            info: info.ok_or_else(|| not("it does not say what it is"))?,
            setup: setup.ok_or_else(|| not("its first tick comes before its setup"))?,
            scene,
            inputs: inputs.into_iter(),
        })
    }

    /// Where it lies.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Share of it that is read, 0 to 1.
    #[must_use]
    pub fn done(&self) -> f64 {
        self.records.read as f64 / self.bytes.max(1) as f64
    }

    /// How it ended; there once there are no more ticks.
    #[must_use]
    pub fn end(&self) -> Option<&End> {
        self.records.end.as_ref()
    }
}

impl Iterator for Session {
    type Item = InputRecord;

    fn next(&mut self) -> Option<InputRecord> {
        loop {
            if let Some(record) = self.inputs.next() {
                return Some(record);
            }
            match self.records.next()? {
                Part::Inputs(inputs) => self.inputs = inputs.into_iter(),
                Part::Info(_) | Part::Setup(_) | Part::Scene(_) => {}
            }
        }
    }
}

enum Part {
    Info(BTreeMap<String, String>),
    Setup(RunSetup),
    Scene(Vec<u8>),
    Inputs(Vec<InputRecord>),
}

/// The parts of a file that replay needs, in order.
struct Records {
    source: Box<dyn Read>,
    reader: LinearReader,
    setup: Option<u16>,
    inputs: Option<u16>,
    read: u64,
    end: Option<End>,
}

impl Records {
    fn new(source: Box<dyn Read>) -> Self {
        let options = LinearReaderOptions::default()
            .with_skip_end_magic(true)
            .with_prevalidate_chunk_crcs(true)
            .with_record_length_limit(RECORD_MAX_BYTES);
        Self {
            source,
            reader: LinearReader::new_with_options(options),
            setup: None,
            inputs: None,
            read: 0,
            end: None,
        }
    }

    /// The next part; none at the end, which `end` then tells of.
    fn next(&mut self) -> Option<Part> {
        if self.end.is_some() {
            return None;
        }
        loop {
            match self.step() {
                Ok(Some(part)) => return Some(part),
                Ok(None) if self.end.is_some() => return None,
                Ok(None) => {}
                Err(why) => {
                    self.end = Some(End::BrokenOff(why));
                    return None;
                }
            }
        }
    }

    fn step(&mut self) -> Result<Option<Part>, String> {
        let event = match self.reader.next_event() {
            Some(Ok(event)) => event,
            Some(Err(error)) => return Err(error.to_string()),
            None => return Err("no end mark".to_owned()),
        };
        match event {
            LinearReadEvent::ReadRequest(wanted) => {
                // A damaged length asks for much: memory grows only as bytes are there.
                let place = self.reader.insert(wanted.min(1 << 20));
                let read = self.source.read(place).map_err(|error| error.to_string())?;
                self.reader.notify_read(read);
                self.read += read as u64;
                Ok(None)
            }
            LinearReadEvent::Record { opcode, data } => {
                // What follows is an index; it is not needed.
                if opcode == mcap::records::op::DATA_END {
                    self.end = Some(End::Whole);
                    return Ok(None);
                }
                let record = mcap::parse_record(opcode, data).map_err(|error| error.to_string())?;
                part(record, &mut self.setup, &mut self.inputs)
            }
        }
    }
}

fn part(
    record: Record<'_>,
    setup: &mut Option<u16>,
    inputs: &mut Option<u16>,
) -> Result<Option<Part>, String> {
    match record {
        Record::Metadata(metadata) if metadata.name == info::NAME => {
            Ok(Some(Part::Info(metadata.metadata)))
        }
        Record::Attachment { header, data, .. } if header.name == SCENE => {
            Ok(Some(Part::Scene(data.into_owned())))
        }
        Record::Channel(channel) if channel.message_encoding == OWN => {
            if channel.topic == SETUP.name {
                *setup = Some(channel.id);
            } else if channel.topic == INPUTS.name {
                *inputs = Some(channel.id);
            }
            Ok(None)
        }
        Record::Message { header, data } if Some(header.channel_id) == *setup => {
            let setup = bytemuck::try_pod_read_unaligned(&data);
            let setup = setup.map_err(|_| "a setup of another size".to_owned())?;
            Ok(Some(Part::Setup(setup)))
        }
        Record::Message { header, data } if Some(header.channel_id) == *inputs => {
            let mut records = Vec::new();
            unpack(&data, &mut records).ok_or_else(|| "damaged inputs".to_owned())?;
            Ok(Some(Part::Inputs(records)))
        }
        _ => Ok(None),
    }
}
