//! Copies the undamaged parts of a session, and reports what is lost.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, Seek as _, SeekFrom};
use std::path::Path;

use mcap::records::{Metadata, Record, op};
use mcap::write::{NoSeek, Writer};

use crate::file::SCENE;
use crate::index::Index;
use crate::info;
use crate::lost::{Lost, Tracker};
use crate::records::{self, End, Records};
use crate::salvage;
use crate::storage::create_private;

/// Reason for a repair of a session whose data are whole.
const NO_INDEX: &str = "its index is missing or damaged; its data are whole";
/// Length of the record that ends the data, with its head, bytes.
const DATA_END_BYTES: u64 = 13;

/// A copy that was made.
pub(crate) struct Copied {
    /// Messages in the copy.
    pub(crate) messages: u64,
    /// Place where the session broke off or is first damaged.
    pub(crate) why: String,
    /// Bytes of the session that the copy lacks.
    pub(crate) left_out_bytes: u64,
    pub(crate) lost: Lost,
}

/// A repaired session under construction.
pub(crate) struct Copy {
    from: File,
    bytes: u64,
    /// The damaged session's index, if it is whole.
    index: Option<Index>,
    writer: Writer<NoSeek<File>>,
    /// Topics of the channels that the copy has.
    topics: BTreeMap<u16, String>,
    tracker: Tracker,
    /// Scene that replaces the session's damaged one.
    scene: Option<Vec<u8>>,
    /// True once the session's description is copied.
    has_info: bool,
    /// True once the session's scene is copied.
    has_scene: bool,
    /// Description, by an earlier repair, of the parts that the session lacks.
    before: BTreeMap<String, String>,
    left_out_bytes: u64,
}

impl Copy {
    /// Starts a copy of the `bytes` bytes of `from`, at `to`. `scene` replaces the session's own if
    /// that is damaged.
    pub(crate) fn create(
        (from, bytes): (File, u64),
        index: Option<Index>,
        scene: Option<Vec<u8>>,
        to: &Path,
    ) -> Result<Self, String> {
        let file = create_private(to).map_err(|error| error.to_string())?;
        let options = mcap::WriteOptions::new()
            .profile("")
            .library("calot replay --repair")
            .chunk_size(None)
            .disable_seeking(true)
            .compression(None);
        let writer = Writer::with_options(NoSeek::new(file), options);
        Ok(Self {
            from,
            bytes,
            tracker: Tracker::new(index.as_ref()),
            index,
            writer: writer.map_err(|it| words(&it))?,
            topics: BTreeMap::new(),
            scene,
            has_info: false,
            has_scene: false,
            before: BTreeMap::new(),
            left_out_bytes: 0,
        })
    }

    /// Copies all whole records.
    pub(crate) fn run(mut self) -> Result<Copied, String> {
        let mut records = self.read_from(0)?;
        let end = loop {
            let at = records.at;
            let end = match self.next(&mut records) {
                Ok(()) => {
                    self.writer.flush().map_err(|it| words(&it))?;
                    continue;
                }
                Err(Problem::Write(problem)) => return Err(words(&problem)),
                Err(Problem::Chunk(end)) => {
                    // The chunk's length is right, so the next record follows it.
                    let End::Damaged(why) = records.placed(end, at) else {
                        continue;
                    };
                    self.tracker.damage(why);
                    self.left_out_bytes += records.at - at;
                    continue;
                }
                Err(Problem::Read(End::Whole)) => break End::Whole,
                Err(Problem::Read(end)) => records.placed(end, at),
            };
            let Some(next) = self.resume(at + 1) else {
                self.left_out_bytes += self.bytes.saturating_sub(at);
                break end;
            };
            self.tracker.damage(match end {
                End::BrokenOff(_) => format!("at byte {at}: a record with a wrong length"),
                End::Damaged(why) | End::Lost(why) => why,
                End::Whole => String::new(),
            });
            self.left_out_bytes += next - at;
            records = self.read_from(next)?;
        };
        self.finish(end)
    }

    fn read_from(&self, at: u64) -> Result<Records, String> {
        let io = |error: std::io::Error| error.to_string();
        let mut source = self.from.try_clone().map_err(io)?;
        source.seek(SeekFrom::Start(at)).map_err(io)?;
        Ok(Records::from_byte(at, Box::new(BufReader::new(source))))
    }

    /// Byte at which the reading can go on behind a damaged place.
    fn resume(&self, from: u64) -> Option<u64> {
        let data_end = self
            .index
            .as_ref()
            .map(|it| it.begins.saturating_sub(DATA_END_BYTES));
        let until = data_end.unwrap_or(self.bytes);
        let next = salvage::next_record(&self.from, from, until);
        next.or(data_end.filter(|it| *it >= from))
    }

    /// Copies the next records of the file: a whole chunk of them, or a single one.
    fn next(&mut self, records: &mut Records) -> Result<(), Problem> {
        let (opcode, body) = records.raw().map_err(Problem::Read)?;
        match opcode {
            op::CHUNK => {
                for record in records::chunk(&body).map_err(Problem::Chunk)? {
                    self.take(record)?;
                }
            }
            op::ATTACHMENT | op::METADATA => {
                let record = records::parsed(opcode, &body).map_err(Problem::Chunk)?;
                self.take(record)?;
            }
            op::MESSAGE_INDEX => {
                let channel = body.first_chunk().map(|it| u16::from_le_bytes(*it));
                let bytes = records::u32_at(&body, 2).unwrap_or(0);
                if let Some(channel) = channel {
                    self.tracker.index_of_chunk(channel, u64::from(bytes / 16));
                }
            }
            op::DATA_END => return Err(Problem::Read(End::Whole)),
            _ => {}
        }
        Ok(())
    }

    /// Writes a record with its own numbers of schema and channel.
    fn take(&mut self, record: Record<'_>) -> mcap::McapResult<()> {
        let writer = &mut self.writer;
        match record {
            Record::Schema { header, data } => writer
                .add_schema_with_id(header.id, &header.name, &header.encoding, &data)
                .map(|_| ()),
            Record::Channel(it) => {
                self.topics.insert(it.id, it.topic.clone());
                let (topic, encoding) = (&it.topic, &it.message_encoding);
                writer
                    .add_channel_with_id(it.id, it.schema_id, topic, encoding, &it.metadata)
                    .map(|_| ())
            }
            Record::Message { header, data } => {
                if !self.topics.contains_key(&header.channel_id)
                    && !self.describe(header.channel_id)?
                {
                    return Ok(());
                }
                self.tracker.keep(&header);
                self.writer.write_to_known_channel(&header, &data)
            }
            // The copy gets its own description of what it lacks.
            Record::Metadata(metadata) if metadata.name == info::REPAIRED => {
                self.before = metadata.metadata;
                Ok(())
            }
            Record::Metadata(metadata) => {
                writer.write_metadata(&metadata)?;
                self.has_info |= metadata.name == info::NAME;
                // Readers expect the scene right behind the description.
                match self.scene.take().filter(|_| self.has_info) {
                    Some(data) => {
                        self.has_scene = true;
                        writer.attach(&scene_of(data))
                    }
                    None => Ok(()),
                }
            }
            Record::Attachment { header, data, .. } => {
                self.has_scene |= header.name == SCENE;
                writer.attach(&mcap::Attachment {
                    log_time: header.log_time,
                    create_time: header.create_time,
                    name: header.name,
                    media_type: header.media_type,
                    data,
                })
            }
            _ => Ok(()),
        }
    }

    /// Takes the description of a channel from the index, if the chunk with the description is
    /// lost. Returns false if the index lacks it.
    fn describe(&mut self, channel: u16) -> mcap::McapResult<bool> {
        let index = self.index.as_ref();
        let channels = index.map(|it| it.channels.get(&channel));
        let Some((index, channel)) = index.zip(channels.flatten()) else {
            return Ok(false);
        };
        if let Some((header, data)) = index.schemas.get(&channel.schema_id) {
            self.writer
                .add_schema_with_id(header.id, &header.name, &header.encoding, data)?;
        }
        self.writer.add_channel_with_id(
            channel.id,
            channel.schema_id,
            &channel.topic,
            &channel.message_encoding,
            &channel.metadata,
        )?;
        self.topics.insert(channel.id, channel.topic.clone());
        Ok(true)
    }

    /// Ends the copy with a description of what it lacks.
    fn finish(mut self, end: End) -> Result<Copied, String> {
        let messages = self.tracker.kept();
        let mut topics = self.topics;
        for (id, channel) in self.index.iter().flat_map(|it| &it.channels) {
            topics.entry(*id).or_insert_with(|| channel.topic.clone());
        }
        let has_scene = self.has_scene || !self.has_info;
        let lost = self.tracker.end(self.index.as_ref(), &topics, has_scene);
        let mut lacks = self.before;
        if let End::BrokenOff(why) | End::Damaged(why) = &end {
            lacks.insert(info::WHY.to_owned(), why.clone());
        }
        if !lost.is_nothing() {
            lacks.insert(info::LOST.to_owned(), format!("lost {}", lost.in_words()));
            for (topic, count) in &lost.topics {
                lacks.insert(format!("{} {topic}", info::LOST), count.to_string());
            }
        }
        let why = match (end, lost.damage.first()) {
            (_, Some(damage)) if !lost.is_nothing() => damage.clone(),
            (End::BrokenOff(why) | End::Damaged(why), _) => why,
            (_, Some(damage)) => format!("{damage}; nothing of the data is lost"),
            (_, None) => NO_INDEX.to_owned(),
        };
        if !lacks.is_empty() {
            let (name, metadata) = (info::REPAIRED.to_owned(), lacks);
            let written = self.writer.write_metadata(&Metadata { name, metadata });
            written.map_err(|it| words(&it))?;
        }
        self.writer.finish().map_err(|it| words(&it))?;
        Ok(Copied {
            messages,
            why,
            left_out_bytes: self.left_out_bytes,
            lost,
        })
    }
}

/// Reason why a record is not copied.
enum Problem {
    /// Reading cannot continue at the next record.
    Read(End),
    /// The record is damaged, and its length is right.
    Chunk(End),
    Write(mcap::McapError),
}

impl From<mcap::McapError> for Problem {
    fn from(error: mcap::McapError) -> Self {
        Self::Write(error)
    }
}

/// A session's scene as it is attached.
fn scene_of(data: Vec<u8>) -> mcap::Attachment<'static> {
    mcap::Attachment {
        log_time: 0,
        create_time: 0,
        name: SCENE.to_owned(),
        media_type: "application/octet-stream".to_owned(),
        data: data.into(),
    }
}

fn words(error: &mcap::McapError) -> String {
    error.to_string()
}
