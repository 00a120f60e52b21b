//! Reads the records of a session's file. Each record is checked before use, because the file may
//! come from anywhere. The MCAP library parses only records whose lengths were checked here. A
//! wrong length would make the library allocate any amount of memory, or panic.

use std::collections::{BTreeMap, VecDeque};
use std::io::Read;

use mcap::read::ChunkReader;
use mcap::records::{Record, op};
use shared_mem::inputs::{InputRecord, RunSetup};

use crate::course::Entry;
use crate::describe::{COURSE, INPUTS, OWN, PROTOBUF, SETUP, STAGES};
use crate::file::SCENE;
use crate::info::{self, Assignment, Finish, printable};
use crate::pack::unpack;
use crate::times::{self, TickTimes};

/// Longest record accepted, bytes: a scene of real anatomy is a few megabytes.
pub(crate) const RECORD_MAX_BYTES: u64 = 64 << 20;
/// Size of the opcode and the length before each record, bytes.
pub(crate) const HEAD_BYTES: usize = 9;
/// Size of a chunk's head without the name of the compression, bytes.
pub(crate) const CHUNK_HEAD_BYTES: u64 = 40;

/// Text with which the description of a repaired session's end begins.
const REPAIRED: &str = "before its repair ";

/// End of a session.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum End {
    /// The session was ended properly.
    Whole,
    /// The session breaks off at this place: the recorder was killed, or the disk was full.
    /// Everything before it is as recorded. If the length of the last record outside a chunk is
    /// damaged, the session also reads as broken off.
    BrokenOff(String),
    /// The session was ended properly, and lost these parts before it was repaired.
    Lost(String),
    /// The session is damaged at this place, in this way, or the disk cannot read it. Nothing after
    /// it is read.
    Damaged(String),
}

/// A part of a file that replay and assessment need.
pub(crate) enum Part {
    Info(BTreeMap<String, String>),
    Setup(RunSetup),
    Scene(Vec<u8>),
    Inputs(Vec<InputRecord>),
    Course(Entry),
    Times(Vec<TickTimes>),
    Assignment(Assignment),
    Finish(Finish),
}

impl Part {
    pub(crate) fn inputs(self) -> Option<Vec<InputRecord>> {
        match self {
            Self::Inputs(inputs) => Some(inputs),
            _ => None,
        }
    }

    pub(crate) fn times(self) -> Option<Vec<TickTimes>> {
        match self {
            Self::Times(times) => Some(times),
            _ => None,
        }
    }

    pub(crate) fn entry(self) -> Option<Entry> {
        match self {
            Self::Course(entry) => Some(entry),
            _ => None,
        }
    }
}

/// Iterator over the parts of a file, in order.
pub(crate) struct Records {
    source: Box<dyn Read>,
    setup: Option<u16>,
    inputs: Option<u16>,
    course: Option<u16>,
    stages: Option<u16>,
    /// Parts that a repair found missing.
    repaired: Option<End>,
    parts: VecDeque<Part>,
    /// Bytes read so far.
    pub(crate) at: u64,
    pub(crate) end: Option<End>,
}

impl Records {
    pub(crate) fn new(source: Box<dyn Read>) -> Self {
        Self::from_byte(0, source)
    }

    /// Reads from byte `at` on. A record, or the file itself, must begin there.
    pub(crate) fn from_byte(at: u64, source: Box<dyn Read>) -> Self {
        Self {
            source,
            setup: None,
            inputs: None,
            course: None,
            stages: None,
            repaired: None,
            parts: VecDeque::new(),
            at,
            end: None,
        }
    }

    /// Next part; `None` at the end, which `end` describes.
    pub(crate) fn next(&mut self) -> Option<Part> {
        loop {
            if let Some(part) = self.parts.pop_front() {
                return Some(part);
            }
            if self.end.is_some() {
                return None;
            }
            let at = self.at;
            self.end = match self.record() {
                Ok(()) => None,
                Err(end) => Some(self.placed(end, at)),
            };
        }
    }

    /// The end with its place. The record that ended the reading begins at byte `at`.
    pub(crate) fn placed(&self, end: End, at: u64) -> End {
        match end {
            End::Whole | End::Lost(_) => end,
            End::BrokenOff(what) if was_repaired(&what) => End::BrokenOff(what),
            End::BrokenOff(what) => {
                End::BrokenOff(format!("the file ends at byte {}, in {what}", self.at))
            }
            End::Damaged(what) => End::Damaged(format!("at byte {at}: {}", printable(&what))),
        }
    }

    /// Reads the next record of the file: its kind and its content, whose lengths are checked.
    pub(crate) fn raw(&mut self) -> Result<(u8, Vec<u8>), End> {
        if self.at == 0 && self.take(mcap::MAGIC.len() as u64)? != mcap::MAGIC {
            return Err(damaged("not an MCAP file"));
        }
        let head = self.take(HEAD_BYTES as u64)?;
        let (Some(&opcode), Some(length)) = (head.first(), u64_at(&head, 1)) else {
            return cut("a record's head");
        };
        if length > RECORD_MAX_BYTES {
            return Err(damaged(format!(
                "a record of {length} bytes; at most {RECORD_MAX_BYTES} are read"
            )));
        }
        let known = [
            op::HEADER,
            op::CHUNK,
            op::MESSAGE_INDEX,
            op::ATTACHMENT,
            op::METADATA,
            op::DATA_END,
        ];
        if !known.contains(&opcode) {
            return Err(damaged(format!(
                "a record of kind {opcode:#04x}, which is not allowed outside a chunk"
            )));
        }
        let body = self.take(length)?;
        // This check precedes the one for completeness: a wrong length is damage, not a cut.
        let agrees = match opcode {
            op::CHUNK => u64_at(&body, 32)
                .is_none_or(|size| size.checked_add(CHUNK_HEAD_BYTES) == Some(length)),
            op::MESSAGE_INDEX => u32_at(&body, 2).is_none_or(|size| u64::from(size) + 6 == length),
            op::DATA_END => length == 4,
            _ => true,
        };
        if !agrees {
            return Err(damaged("a record's length disagrees with its content"));
        }
        if (body.len() as u64) < length {
            return cut("a record");
        }
        let has_texts = [op::ATTACHMENT, op::METADATA].contains(&opcode);
        if has_texts && !is_sound(opcode, &body) {
            return Err(damaged("a record's texts exceed it"));
        }
        Ok((opcode, body))
    }

    fn record(&mut self) -> Result<(), End> {
        let (opcode, body) = self.raw()?;
        match opcode {
            op::CHUNK => {
                let mut parts = Vec::new();
                for record in chunk(&body)? {
                    parts.extend(self.part(record)?);
                }
                self.parts.extend(parts);
                Ok(())
            }
            op::ATTACHMENT | op::METADATA => {
                let record = parsed(opcode, &body)?;
                let found = self.part(record)?;
                self.parts.extend(found);
                Ok(())
            }
            // Only an index follows the data; it is not needed.
            op::DATA_END => Err(self.repaired.take().unwrap_or(End::Whole)),
            _ => Ok(()),
        }
    }

    /// Reads this many bytes, or as many as there are: memory grows only with the bytes present.
    fn take(&mut self, wanted: u64) -> Result<Vec<u8>, End> {
        let mut bytes = Vec::new();
        let read = (&mut self.source).take(wanted).read_to_end(&mut bytes);
        self.at += bytes.len() as u64;
        read.map_err(|error| damaged(error.to_string()))?;
        Ok(bytes)
    }

    fn part(&mut self, record: Record<'_>) -> Result<Option<Part>, End> {
        Ok(match record {
            Record::Metadata(metadata) if metadata.name == info::NAME => {
                Some(Part::Info(metadata.metadata))
            }
            Record::Metadata(metadata) if metadata.name == info::ASSIGNMENT => {
                Some(Part::Assignment(Assignment::from_map(&metadata.metadata)))
            }
            Record::Metadata(metadata) if metadata.name == info::REPAIRED => {
                let text = |key| metadata.metadata.get(key).map(|it: &String| printable(it));
                self.repaired = Some(match (text(info::WHY), text(info::LOST)) {
                    (None, Some(lost)) => End::Lost(format!("{REPAIRED}{lost}")),
                    (why, lost) => {
                        let all: Vec<String> = why.into_iter().chain(lost).collect();
                        End::BrokenOff(format!("{REPAIRED}{}", all.join("; ")))
                    }
                });
                None
            }
            Record::Metadata(metadata) if metadata.name == info::FINISH => {
                let finish = Finish::from_map(&metadata.metadata);
                Some(Part::Finish(
                    finish.ok_or_else(|| damaged("a final record of another form"))?,
                ))
            }
            Record::Attachment { header, data, .. } if header.name == SCENE => {
                Some(Part::Scene(data.into_owned()))
            }
            Record::Channel(channel)
                if channel.message_encoding == PROTOBUF && channel.topic == STAGES.name =>
            {
                self.stages = Some(channel.id);
                None
            }
            Record::Channel(channel) if channel.message_encoding == OWN => {
                if channel.topic == SETUP.name {
                    self.setup = Some(channel.id);
                } else if channel.topic == INPUTS.name {
                    self.inputs = Some(channel.id);
                } else if channel.topic == COURSE.name {
                    self.course = Some(channel.id);
                }
                None
            }
            Record::Message { header, data } if Some(header.channel_id) == self.setup => {
                let setup = bytemuck::try_pod_read_unaligned(&data);
                Some(Part::Setup(
                    setup.map_err(|_| damaged("a setup of another size"))?,
                ))
            }
            Record::Message { header, data } if Some(header.channel_id) == self.inputs => {
                let mut records = Vec::new();
                unpack(&data, &mut records).ok_or_else(|| damaged("inputs of another form"))?;
                Some(Part::Inputs(records))
            }
            Record::Message { header, data } if Some(header.channel_id) == self.course => {
                let entry = Entry::unpack(&data);
                Some(Part::Course(entry.ok_or_else(|| {
                    damaged("an entry of the course of another form")
                })?))
            }
            Record::Message { header, data } if Some(header.channel_id) == self.stages => {
                let times = times::read(&data);
                Some(Part::Times(
                    times.ok_or_else(|| damaged("times of ticks of another form"))?,
                ))
            }
            _ => None,
        })
    }
}

/// Records of a whole chunk, or none of them.
pub(crate) fn chunk(body: &[u8]) -> Result<Vec<Record<'static>>, End> {
    // Layout of the head: start and end time 8 bytes each, size 8, CRC 4, length of the
    // compression's name 4 and the name, compressed size 8.
    if u32_at(body, 28) != Some(0) {
        return Err(damaged("a compressed chunk; sessions have none"));
    }
    let Ok(Record::Chunk { header, data }) = mcap::parse_record(op::CHUNK, body) else {
        return Err(damaged("a chunk's head"));
    };
    if header.uncompressed_size != data.len() as u64 {
        return Err(damaged("a chunk's two sizes differ"));
    }
    let mut rest = &*data;
    while let Some(&opcode) = rest.first() {
        let length = u64_at(rest, 1).and_then(|length| usize::try_from(length).ok());
        let inner = length.and_then(|length| rest.get(HEAD_BYTES..)?.split_at_checked(length));
        let known = [op::SCHEMA, op::CHANNEL, op::MESSAGE];
        rest = match inner {
            Some((inner, after)) if known.contains(&opcode) && is_sound(opcode, inner) => after,
            _ => {
                return Err(damaged(
                    "a record that exceeds its chunk, or is of an unknown kind",
                ));
            }
        };
    }
    // After the last record, the reader checks the CRC of the chunk, if there is one.
    let read = ChunkReader::new(header, &data).map_err(|error| damaged(error.to_string()))?;
    read.map(|record| record.map(Record::into_owned))
        .collect::<Result<_, _>>()
        .map_err(|error| damaged(error.to_string()))
}

/// Parses the content of a record, which [`Records::raw`] has checked.
pub(crate) fn parsed(opcode: u8, body: &[u8]) -> Result<Record<'_>, End> {
    mcap::parse_record(opcode, body).map_err(|error| damaged(error.to_string()))
}

/// True if these words are the end of a repaired session.
pub(crate) fn was_repaired(why: &str) -> bool {
    why.starts_with(REPAIRED)
}

/// True if the texts of a record lie inside it, which the MCAP library takes for granted.
pub(crate) fn is_sound(opcode: u8, body: &[u8]) -> bool {
    let end = match opcode {
        op::SCHEMA => return after_texts(body, 2, 2).is_some(),
        // Ids 2 bytes each, topic, encoding.
        op::CHANNEL => after_texts(body, 4, 2).and_then(|at| after_map(body, at)),
        op::METADATA => after_texts(body, 0, 1).and_then(|at| after_map(body, at)),
        // Log and creation time 8 bytes each, name, media type, data, CRC 4.
        op::ATTACHMENT => after_texts(body, 16, 2).and_then(|at| {
            let data = usize::try_from(u64_at(body, at)?).ok()?;
            data.checked_add(at + 8 + 4)
        }),
        _ => return true,
    };
    end == Some(body.len())
}

/// End of `count` texts, if they are complete.
fn after_texts(body: &[u8], mut at: usize, count: usize) -> Option<usize> {
    for _ in 0..count {
        at += 4 + u32_at(body, at)? as usize;
    }
    (at <= body.len()).then_some(at)
}

/// End of a map of texts, if it is complete.
fn after_map(body: &[u8], at: usize) -> Option<usize> {
    let end = at + 4 + u32_at(body, at)? as usize;
    let mut at = at + 4;
    while at < end {
        at = after_texts(body, at, 2)?;
    }
    (at == end).then_some(at)
}

pub(crate) fn u32_at(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(*bytes.get(at..)?.first_chunk()?))
}

pub(crate) fn u64_at(bytes: &[u8], at: usize) -> Option<u64> {
    Some(u64::from_le_bytes(*bytes.get(at..)?.first_chunk()?))
}

fn damaged(why: impl Into<String>) -> End {
    End::Damaged(why.into())
}

fn cut<T>(what: &str) -> Result<T, End> {
    Err(End::BrokenOff(what.to_owned()))
}
