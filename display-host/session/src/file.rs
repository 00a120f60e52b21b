//! Writer of a session's MCAP file.

use std::collections::BTreeMap;
use std::sync::mpsc::Sender;

use foxglove::messages::{FrameTransforms, Log, PoseInFrame};
use mcap::records::MessageHeader;
use mcap::write::{NoSeek, Writer};
use prost::Message;
use shared_mem::inputs::InputBatch;
use shared_mem::message::{ActMsg, CommandMsg, EventMsg, TimingBatch, ToolFrame};
use shared_mem::scene::{SceneFile, str_from_name};
use shared_mem::words::EventKind;

use crate::course::{self, Entry, EntryContent, Movement};
use crate::describe::{self, Topic};
use crate::identity::Seen;
use crate::info::{self, Assignment, Finish, Info};
use crate::pack::pack;
use crate::proto;
use crate::storage::{Outbox, Storage, Waiting};
use crate::viewer;

/// Version of a session's content; a reader refuses any other.
pub const FILE_VERSION: u32 = 3;

/// Name of the attachment that holds the compiled scene.
pub(crate) const SCENE: &str = "scene.calot";

/// Reason why a session cannot be started.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The file cannot be created.
    #[error("{path}: {source}; choose another place with --record or --out")]
    Create {
        /// Path of the file.
        path: std::path::PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// The services cannot be opened.
    #[error(transparent)]
    Service(#[from] shared_mem::service::ServiceError),
    /// The thread cannot be started.
    #[error("cannot start the recorder's thread: {0}")]
    Thread(std::io::Error),
    /// The MCAP library reports an error: a defect of this program.
    #[error("MCAP: {0}; please report this")]
    Mcap(#[from] mcap::McapError),
}

/// Counts of recorded and missing ticks.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Ticks {
    pub(crate) recorded: u64,
    /// Recorded ticks that are on disk.
    pub(crate) on_disk: u64,
    pub(crate) missing: u64,
    /// Number of ticks that ran, as the controller reported at its end.
    pub(crate) ran: Option<u64>,
    /// Ticks that the controller could not hand over.
    lost: u64,
    /// Number of the next tick.
    expected: u64,
}

/// Counts of missing events.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Events {
    pub(crate) missing: u64,
    /// Number of the next event.
    expected: u64,
}

/// A session being written. Bytes reach the disk only in [`SessionFile::flush`] and
/// [`SessionFile::finish`].
pub(crate) struct SessionFile {
    writer: Writer<NoSeek<Waiting>>,
    pub(crate) outbox: Outbox,
    channels: Channels,
    wall_from_host_ns: i64,
    organs: Vec<String>,
    has_setup: bool,
    pub(crate) ticks: Ticks,
    pub(crate) events: Events,
    /// Timing since the last flush.
    second: viewer::Second,
    /// Receiver of the course's entries, beside the file.
    listener: Option<Sender<Entry>>,
    sequence: u32,
    packed: Vec<u8>,
    /// Host time of the newest inputs, ns.
    newest_ns: u64,
    /// Stamp of each channel's newest message, by the channel's number, ns since 1970.
    stamped_ns: Vec<u64>,
}

struct Channels {
    setup: u16,
    inputs: u16,
    course: u16,
    poses: u16,
    tip: u16,
    tool: u16,
    events: u16,
    log: u16,
    timing: u16,
    stages: u16,
    gaps: u16,
}

impl SessionFile {
    /// Starts a session of `scene` in `storage`.
    pub(crate) fn begin(
        storage: Box<dyn Storage>,
        info: &Info,
        scene: &SceneFile,
    ) -> Result<Self, Error> {
        let (outbox, waiting) = Outbox::new(storage);
        let options = mcap::WriteOptions::new()
            .profile("")
            .library(info.build.clone())
            .chunk_size(None)
            .disable_seeking(true)
            .compression(None);
        let mut writer = Writer::with_options(NoSeek::new(waiting), options)?;
        writer.write_metadata(&mcap::records::Metadata {
            name: info::NAME.to_owned(),
            metadata: info.to_map(),
        })?;
        writer.attach(&mcap::Attachment {
            log_time: 0,
            create_time: 0,
            name: SCENE.to_owned(),
            media_type: "application/octet-stream".to_owned(),
            data: scene.bytes().into(),
        })?;
        let mut channel = |topic: &Topic| {
            let (name, encoding) = (&topic.schema_name, topic.schema_encoding);
            let schema = writer.add_schema(name, encoding, &topic.schema)?;
            writer.add_channel(schema, topic.name, topic.encoding, &BTreeMap::new())
        };
        let channels = Channels {
            setup: channel(&describe::SETUP)?,
            inputs: channel(&describe::INPUTS)?,
            course: channel(&describe::COURSE)?,
            poses: channel(&describe::foxglove::<FrameTransforms>(describe::POSES))?,
            tip: channel(&describe::foxglove::<PoseInFrame>(describe::TIP))?,
            tool: channel(&describe::TOOL)?,
            events: channel(&describe::EVENTS)?,
            log: channel(&describe::foxglove::<Log>(describe::LOG))?,
            timing: channel(&describe::TIMING)?,
            stages: channel(&describe::STAGES)?,
            gaps: channel(&describe::GAPS)?,
        };
        let name = |field: &[u8]| str_from_name(field).unwrap_or_default().to_owned();
        let mut file = Self {
            writer,
            outbox,
            channels,
            wall_from_host_ns: info.wall_from_host_ns,
            organs: scene.organs().iter().map(|it| name(&it.name)).collect(),
            has_setup: false,
            ticks: Ticks::default(),
            events: Events::default(),
            second: viewer::Second::default(),
            listener: None,
            sequence: 0,
            packed: Vec::new(),
            newest_ns: 0,
            stamped_ns: Vec::new(),
        };
        file.flush()?;
        Ok(file)
    }

    /// Writes the purpose of the session.
    pub(crate) fn assignment(&mut self, assignment: &Assignment) -> Result<(), Error> {
        Ok(self.writer.write_metadata(&mcap::records::Metadata {
            name: info::ASSIGNMENT.to_owned(),
            metadata: assignment.to_map(),
        })?)
    }

    /// From now on, sends every entry of the course to `course` as well, for a running assessment.
    pub(crate) fn tell(&mut self, course: Sender<Entry>) {
        self.listener = Some(course);
    }

    fn course(&mut self, entry: &Entry) -> Result<(), Error> {
        // If the receiver is gone, only the file takes the entries.
        let gone = |course: &Sender<Entry>| course.send(*entry).is_err();
        if self.listener.as_ref().is_some_and(gone) {
            self.listener = None;
        }
        let mut packed = core::mem::take(&mut self.packed);
        packed.clear();
        entry.pack(&mut packed);
        self.put(self.channels.course, entry.at_ns, &packed)?;
        self.packed = packed;
        Ok(())
    }

    /// Writes the inputs of ticks, and the resets and starts among them to the course. The first
    /// call also writes the run's setup.
    pub(crate) fn inputs(&mut self, batch: &InputBatch) -> Result<(), Error> {
        let Some(mut records) = batch.records() else {
            return Ok(());
        };
        if let (false, Some(first)) = (self.has_setup, records.first()) {
            let setup = bytemuck::bytes_of(&batch.setup);
            self.put(self.channels.setup, first.now_ns, setup)?;
            self.has_setup = true;
            let [force_max_n, ..] = batch.setup.device;
            if (0.0..1e3).contains(&force_max_n) {
                let what = EntryContent::Device { force_max_n };
                let (tick, at_ns) = (first.tick, first.now_ns);
                self.course(&Entry { tick, at_ns, what })?;
            }
        }
        for record in records {
            let what = match u32::from(record.command & 15) {
                CommandMsg::RESET => EntryContent::Reset,
                CommandMsg::START => EntryContent::Start {
                    task: record.command >> 4,
                },
                _ => continue,
            };
            self.course(&Entry {
                tick: record.tick,
                at_ns: record.now_ns,
                what,
            })?;
        }
        while let Some(first) = records.first() {
            if first.tick != self.ticks.expected {
                self.gap(first.tick, first.now_ns)?;
            }
            let mut packed = core::mem::take(&mut self.packed);
            packed.clear();
            let count = pack(records, &mut packed);
            self.newest_ns = first.now_ns;
            self.put(self.channels.inputs, first.now_ns, &packed)?;
            self.packed = packed;
            self.ticks.recorded += count as u64;
            // The sum saturates, because shared memory may hold any number.
            self.ticks.expected = first.tick.saturating_add(count as u64);
            records = records.get(count.max(1)..).unwrap_or_default();
        }
        self.ticks.lost = batch.lost;
        if batch.ran > 0 {
            self.ticks.ran = Some(batch.ran.into());
        }
        Ok(())
    }

    fn gap(&mut self, tick: u64, at_ns: u64) -> Result<(), Error> {
        let from = self.ticks.expected;
        // A restarted controller counts from 0 again. That gap counts as one missing tick.
        let missing = tick.saturating_sub(from).max(1);
        self.ticks.missing = self.ticks.missing.saturating_add(missing);
        self.missing(proto::gap::Of::Ticks, from, tick, at_ns)
    }

    /// Writes that the numbers from `from` on and before `to` are missing.
    fn missing(&mut self, of: proto::gap::Of, from: u64, to: u64, at_ns: u64) -> Result<(), Error> {
        let of = of.into();
        self.message(self.channels.gaps, at_ns, &proto::Gap { of, from, to })
    }

    /// Counts the missing events before this number. A number below the expected one comes from
    /// another controller and adds none.
    fn expect_event(&mut self, number: u64) -> u64 {
        let missing = number.saturating_sub(self.events.expected);
        self.events.missing = self.events.missing.saturating_add(missing);
        self.events.expected = number;
        missing
    }

    /// Takes the number of events that happened. Events after the last received one are missing.
    pub(crate) fn heard_of(&mut self, events: u64) {
        self.expect_event(events);
    }

    /// Writes the positions of the hands and the force. Skips a malformed frame.
    pub(crate) fn moved(&mut self, tools: &ToolFrame) -> Result<(), Error> {
        let Some(moved) = Movement::of(tools) else {
            return Ok(());
        };
        self.course(&Entry {
            tick: tools.tick,
            at_ns: tools.at_ns,
            what: EntryContent::Moved(moved),
        })?;
        let tool = viewer::tool(tools, &moved);
        self.message(self.channels.tool, tools.at_ns, &tool)
    }

    /// Writes the endoscope's view, which holds from the tick of `tools` on. Skips invalid angles.
    pub(crate) fn sight(
        &mut self,
        [off, turned]: [f32; 2],
        tools: &ToolFrame,
    ) -> Result<(), Error> {
        let (tick, at_ns) = (tools.tick, tools.at_ns);
        course::sight(off, turned).map_or(Ok(()), |what| self.course(&Entry { tick, at_ns, what }))
    }

    /// Writes what an identity image shows, at the tick of `tools`.
    pub(crate) fn seen(&mut self, seen: Seen, tools: &ToolFrame) -> Result<(), Error> {
        self.course(&Entry {
            tick: tools.tick,
            at_ns: tools.at_ns,
            what: EntryContent::Seen(seen),
        })
    }

    /// Writes an act of an instructor, which took place at `at_ns`, about the tick of `tools`.
    pub(crate) fn act(&mut self, act: &ActMsg, at_ns: u64, tools: &ToolFrame) -> Result<(), Error> {
        let what = EntryContent::Act(*act);
        let tick = tools.tick;
        self.course(&Entry { tick, at_ns, what })?;
        let line = viewer::act(act, self.wall_ns(at_ns));
        self.message(self.channels.log, at_ns, &line)
    }

    /// Writes the tools' poses, for viewers. Skips a malformed frame.
    pub(crate) fn tools(&mut self, tools: &ToolFrame) -> Result<(), Error> {
        let (at_ns, wall_ns) = (tools.at_ns, self.wall_ns(tools.at_ns));
        let Some(moved) = Movement::of(tools) else {
            return Ok(());
        };
        self.message(self.channels.poses, at_ns, &viewer::poses(tools, wall_ns))?;
        self.message(self.channels.tip, at_ns, &viewer::tip(&moved, wall_ns))
    }

    /// Writes an event.
    pub(crate) fn event(&mut self, event: &EventMsg) -> Result<(), Error> {
        let from = self.events.expected;
        if self.expect_event(event.sequence) > 0 {
            self.missing(proto::gap::Of::Events, from, event.sequence, event.at_ns)?;
        }
        self.events.expected = event.sequence.saturating_add(1);
        if let Some(entry) = Entry::of_event(event) {
            self.course(&entry)?;
        }
        let described = viewer::event(event, &self.organs);
        let line = viewer::line(
            &described,
            EventKind::try_from(event.kind).ok(),
            self.wall_ns(event.at_ns),
        );
        self.message(self.channels.events, event.at_ns, &described)?;
        self.message(self.channels.log, event.at_ns, &line)
    }

    /// Writes the times of ticks, and collects them for [`SessionFile::flush`].
    pub(crate) fn timing(&mut self, batch: &TimingBatch) -> Result<(), Error> {
        self.second.take(batch);
        let mut records = batch.records().unwrap_or_default();
        while let (Some(first), Some((stages, count))) = (records.first(), viewer::stages(records))
        {
            self.message(self.channels.stages, first.scheduled_ns, &stages)?;
            records = records.get(count..).unwrap_or_default();
        }
        Ok(())
    }

    /// Ends a chunk. Everything so far is then on disk, or waits in memory for the disk.
    pub(crate) fn flush(&mut self) -> Result<(), Error> {
        if self.newest_ns > 0 {
            let second = core::mem::take(&mut self.second);
            self.message(self.channels.timing, self.newest_ns, &second.message())?;
        }
        self.writer.flush()?;
        if self.outbox.send() {
            self.ticks.on_disk = self.ticks.recorded;
        }
        Ok(())
    }

    /// Ends the session with index and footer.
    pub(crate) fn finish(&mut self) -> Result<(), Error> {
        // Ticks that are missing at the end leave no gap, so count them here.
        let after_last = match self.ticks.ran {
            Some(ran) => ran.saturating_sub(self.ticks.expected),
            None => self.ticks.lost.saturating_sub(self.ticks.missing),
        };
        self.ticks.missing = self.ticks.missing.saturating_add(after_last);
        let finish = Finish {
            ran: self.ticks.ran,
            missing: self.ticks.missing,
            missing_events: self.events.missing,
        };
        self.writer.write_metadata(&mcap::records::Metadata {
            name: info::FINISH.to_owned(),
            metadata: finish.to_map(),
        })?;
        self.writer.finish()?;
        if self.outbox.finish() {
            self.ticks.on_disk = self.ticks.recorded;
        }
        Ok(())
    }

    fn wall_ns(&self, host_ns: u64) -> u64 {
        host_ns.saturating_add_signed(self.wall_from_host_ns)
    }

    fn message(&mut self, channel: u16, at_ns: u64, message: &impl Message) -> Result<(), Error> {
        self.put(channel, at_ns, &message.encode_to_vec())
    }

    /// Writes a message of this time. Its stamp is no earlier than the stamp of the channel's last
    /// message, because readers expect times in order. In the course, an event may arrive after a
    /// younger pose; the entry keeps its own time.
    fn put(&mut self, channel_id: u16, at_ns: u64, data: &[u8]) -> Result<(), Error> {
        let mut time = self.wall_ns(at_ns);
        let channel = usize::from(channel_id);
        if self.stamped_ns.len() <= channel {
            self.stamped_ns.resize(channel + 1, 0);
        }
        if let Some(newest_ns) = self.stamped_ns.get_mut(channel) {
            time = time.max(*newest_ns);
            *newest_ns = time;
        }
        let header = MessageHeader {
            channel_id,
            sequence: self.sequence,
            log_time: time,
            publish_time: time,
        };
        self.sequence = self.sequence.wrapping_add(1);
        Ok(self.writer.write_to_known_channel(&header, data)?)
    }
}
