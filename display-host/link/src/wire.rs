//! Messages on the line: the plain records of shared memory, cut to their used part.
//!
//! | kind | asked with | answered with |
//! |---|---|---|
//! | [`LOOK`] | [`Ask`] | [`Head`], then state, tools, task, events and batches as it states |
//! | [`SCENE`] | [`SceneAsk`] | [`SceneHead`], then a part of the compiled scene |
//!
//! The length (four bytes) and the kind (one byte) precede each message. An answer has the kind of
//! its question; answers come in the order of the questions. All numbers are little-endian, as on
//! every computer that Calot runs on. All bytes are untrusted until [`Answer::read`] or
//! [`scene_part`] has checked them.

use bytemuck::{Pod, Zeroable};
use shared_mem::message::{
    ClipMsg, EventMsg, MAX_CELLS, MAX_CLIPPED, MAX_SPHERES, MAX_STONES, SphereState, StateFrame,
    TickRecord, TimingBatch, ToolFrame,
};
use shared_mem::task::{TASK_TEXT, TaskMsg};

use crate::error::LinkError;

const _: () = assert!(cfg!(target_endian = "little"));

/// Kind of a question for the newest data.
pub const LOOK: u8 = 1;
/// Kind of a question for a part of the compiled scene.
pub const SCENE: u8 = 2;
/// First bytes of every message. They change when any record changes, including those of shared
/// memory.
pub const MAGIC: [u8; 8] = *b"CALOTLK4";
/// Largest number of events in an answer.
pub const EVENTS_MAX: usize = 256;
/// Largest number of timing batches in an answer.
pub const BATCHES_MAX: usize = 16;
/// Largest number of bytes of a scene in an answer. A watcher asks for fewer on a slow line,
/// because the newest data wait behind them.
pub const SCENE_PART: usize = 512 << 10;
/// Longest compiled scene, bytes.
pub const SCENE_MAX: u64 = 256 << 20;
/// Longest message that a watcher accepts, bytes.
pub const ANSWER_MAX: usize = 1 << 20;
/// Longest message that a station accepts, bytes.
pub const ASK_MAX: usize = 4 << 10;

/// Bytes of a state before its spheres.
const STATE_HEAD: usize = core::mem::offset_of!(StateFrame, spheres);
/// Bytes of a task before its text.
const TASK_HEAD: usize = core::mem::offset_of!(TaskMsg, text);
/// Bytes of a timing batch before its records.
const BATCH_HEAD: usize = core::mem::offset_of!(TimingBatch, records);

/// A watcher's question for everything newer than its own data.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub struct Ask {
    /// [`MAGIC`].
    pub magic: [u8; 8],
    /// [`Head::server`] to which the following numbers belong; numbers of another server are
    /// ignored.
    pub server: u64,
    /// First event that the watcher lacks, in the server's count.
    pub events_from: u64,
    /// First timing batch that the watcher lacks, in the server's count.
    pub batches_from: u64,
    /// [`StateFrame::at_ns`] of the watcher's newest state.
    pub state_at_ns: u64,
    /// [`ToolFrame::at_ns`] of the watcher's newest tools.
    pub tools_at_ns: u64,
    /// [`TaskMsg::at_ns`] of the watcher's newest task message.
    pub task_at_ns: u64,
}

/// Start of an answer.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub struct Head {
    /// [`MAGIC`].
    pub magic: [u8; 8],
    /// Identity of the server: its start time on its own clock.
    pub server: u64,
    /// Number of this answer, in the server's count.
    pub number: u64,
    /// Time of this answer on the server's clock.
    pub now_ns: u64,
    /// Number of the first event, in the server's count. If it exceeds the requested number, the
    /// events between are lost.
    pub first_event: u64,
    /// Number of the first batch, in the server's count.
    pub first_batch: u64,
    /// Bytes of the state; 0: none is newer.
    pub state_bytes: u32,
    /// 1 if tools follow; 0: none are newer.
    pub tools: u32,
    /// Number of events that follow.
    pub events: u32,
    /// Number of batches that follow. The head of a batch has the number of its records.
    pub batches: u32,
    /// Bytes of the task message; 0: none is newer.
    pub task_bytes: u32,
    /// Always 0.
    pub reserved: u32,
}

/// Question for a part of a scene.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub struct SceneAsk {
    /// [`MAGIC`].
    pub magic: [u8; 8],
    /// First half of the scene's identity.
    pub scene_id: [u8; 16],
    /// First byte of the part.
    pub offset: u64,
    /// Longest part that the watcher wants, bytes; a station sends at most [`SCENE_PART`].
    pub part_bytes: u32,
    /// Zero.
    pub reserved: u32,
}

/// Start of an answer with a part of a scene.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
pub struct SceneHead {
    /// [`MAGIC`].
    pub magic: [u8; 8],
    /// Bytes of the whole scene; 0: the server cannot find it.
    pub total: u64,
    /// Offset of this part, bytes.
    pub offset: u64,
}

/// A checked answer.
#[derive(Debug)]
pub struct Answer {
    /// Head of the answer.
    pub head: Head,
    /// The newest state, if newer than the asker's.
    pub state: Option<Box<StateFrame>>,
    /// The newest tools, if newer than the asker's.
    pub tools: Option<Box<ToolFrame>>,
    /// Progress of the task, if newer than the asker's.
    pub task: Option<Box<TaskMsg>>,
    /// Events, oldest first.
    pub events: Vec<EventMsg>,
    /// Timing batches, oldest first.
    pub batches: Vec<TimingBatch>,
}

/// Reads a record and removes it from the front.
pub(crate) fn take<T: Pod>(bytes: &mut &[u8], what: &'static str) -> Result<T, LinkError> {
    let record = cut(bytes, size_of::<T>(), what)?;
    Ok(bytemuck::pod_read_unaligned(record))
}

fn cut<'a>(bytes: &mut &'a [u8], count: usize, what: &'static str) -> Result<&'a [u8], LinkError> {
    let (part, rest) = bytes
        .split_at_checked(count)
        .ok_or(LinkError::Malformed { what })?;
    *bytes = rest;
    Ok(part)
}

pub(crate) fn check(magic: [u8; 8]) -> Result<(), LinkError> {
    match magic == MAGIC {
        true => Ok(()),
        false => Err(LinkError::Malformed {
            what: "a message of another version",
        }),
    }
}

impl Answer {
    /// Parses an answer.
    ///
    /// # Errors
    /// [`LinkError::Malformed`]: another version, a wrong length, or counts or numbers out of
    /// range.
    pub fn read(mut bytes: &[u8]) -> Result<Self, LinkError> {
        let head: Head = take(&mut bytes, "an answer without a head")?;
        check(head.magic)?;
        let (events, batches) = (head.events as usize, head.batches as usize);
        if events > EVENTS_MAX || batches > BATCHES_MAX || head.tools > 1 {
            return Err(LinkError::Malformed {
                what: "an answer with too many events or batches",
            });
        }
        let state = match head.state_bytes {
            0 => None,
            count => Some(state(cut(&mut bytes, count as usize, "half a state")?)?),
        };
        let tools = match head.tools {
            0 => None,
            _ => Some(tools(&mut bytes)?),
        };
        let task = match head.task_bytes {
            0 => None,
            count => Some(task(cut(&mut bytes, count as usize, "half a task")?)?),
        };
        let events = (0..events)
            .map(|_| take(&mut bytes, "half an event"))
            .collect::<Result<_, _>>()?;
        let batches = (0..batches)
            .map(|_| batch(&mut bytes))
            .collect::<Result<_, _>>()?;
        match bytes {
            [] => Ok(Self {
                head,
                state,
                tools,
                task,
                events,
                batches,
            }),
            _ => Err(LinkError::Malformed {
                what: "an answer longer than its head states",
            }),
        }
    }
}

/// Appends the used part of a state and returns its length in bytes. `None` if the state is
/// malformed.
pub(crate) fn put_state(to: &mut Vec<u8>, frame: &StateFrame) -> Option<u32> {
    let (spheres, clips, cells) = (frame.spheres()?, frame.clips()?, frame.cells()?);
    let stones = frame.stones()?;
    frame.sutures()?;
    let before = to.len();
    to.extend_from_slice(bytemuck::bytes_of(frame).get(..STATE_HEAD)?);
    to.extend_from_slice(bytemuck::cast_slice(spheres));
    to.extend_from_slice(bytemuck::cast_slice(clips));
    to.extend_from_slice(frame.parted.get(..parted_bytes(frame)?)?);
    to.extend_from_slice(cells);
    to.extend_from_slice(bytemuck::cast_slice(stones));
    u32::try_from(to.len() - before).ok()
}

/// Number of bytes with the links in use. `None` if the frame claims too many links.
fn parted_bytes(frame: &StateFrame) -> Option<usize> {
    let links = frame.parted()?.count();
    Some(links.div_ceil(8))
}

fn state(mut bytes: &[u8]) -> Result<Box<StateFrame>, LinkError> {
    const WHAT: LinkError = LinkError::Malformed {
        what: "a state whose counts or numbers are out of range",
    };
    let mut frame: Box<StateFrame> = bytemuck::zeroed_box();
    let head = cut(&mut bytes, STATE_HEAD, "half a state")?;
    if let Some(to) = bytemuck::bytes_of_mut(&mut *frame).get_mut(..STATE_HEAD) {
        to.copy_from_slice(head);
    }
    let [spheres, clips, cells] =
        [frame.sphere_count, frame.clip_count, frame.cell_count].map(|count| count as usize);
    let stones = frame.stone_count as usize;
    let are_few = clips <= MAX_CLIPPED && stones <= MAX_STONES;
    if spheres > MAX_SPHERES || cells > MAX_CELLS || !are_few {
        return Err(WHAT);
    }
    for to in frame.spheres.iter_mut().take(spheres) {
        *to = take::<SphereState>(&mut bytes, "half a state")?;
    }
    for to in frame.clips.iter_mut().take(clips) {
        *to = take::<ClipMsg>(&mut bytes, "half a state")?;
    }
    let parted = parted_bytes(&frame).ok_or(WHAT)?;
    if let Some(to) = frame.parted.get_mut(..parted) {
        to.copy_from_slice(cut(&mut bytes, parted, "half a state")?);
    }
    for to in frame.cells.iter_mut().take(cells) {
        *to = take(&mut bytes, "half a state")?;
    }
    for to in frame.stones.iter_mut().take(stones) {
        *to = take(&mut bytes, "half a state")?;
    }
    let is_sane = bytes.is_empty()
        && frame.spheres().is_some()
        && frame.clips().is_some()
        && frame.sutures().is_some()
        && frame.cells().is_some()
        && frame.stones().is_some();
    is_sane.then_some(frame).ok_or(WHAT)
}

fn tools(bytes: &mut &[u8]) -> Result<Box<ToolFrame>, LinkError> {
    let frame: Box<ToolFrame> = Box::new(take(bytes, "half a tool frame")?);
    let is_sane = frame.capsules().is_some() && frame.dents().is_some();
    is_sane.then_some(frame).ok_or(LinkError::Malformed {
        what: "tools whose counts or numbers are out of range",
    })
}

/// Appends the used part of a task message and returns its length in bytes. `None` if its text is
/// malformed.
pub(crate) fn put_task(to: &mut Vec<u8>, task: &TaskMsg) -> Option<u32> {
    let text = task.text()?;
    to.extend_from_slice(bytemuck::bytes_of(task).get(..TASK_HEAD)?);
    to.extend_from_slice(text.as_bytes());
    u32::try_from(TASK_HEAD + text.len()).ok()
}

fn task(mut bytes: &[u8]) -> Result<Box<TaskMsg>, LinkError> {
    const WHAT: LinkError = LinkError::Malformed {
        what: "a task message whose text is invalid",
    };
    let mut task: Box<TaskMsg> = bytemuck::zeroed_box();
    let head = cut(&mut bytes, TASK_HEAD, "half a task")?;
    if bytes.len() > TASK_TEXT {
        return Err(WHAT);
    }
    let whole = bytemuck::bytes_of_mut(&mut *task).iter_mut();
    for (to, from) in whole.zip(head.iter().chain(bytes)) {
        *to = *from;
    }
    let is_sane = task.length as usize == bytes.len() && task.text().is_some();
    is_sane.then_some(task).ok_or(WHAT)
}

/// Appends the used part of a timing batch, if it is valid.
pub(crate) fn put_batch(to: &mut Vec<u8>, batch: &TimingBatch) -> Option<()> {
    let records = batch.records()?;
    to.extend_from_slice(bytemuck::bytes_of(batch).get(..BATCH_HEAD)?);
    to.extend_from_slice(bytemuck::cast_slice(records));
    Some(())
}

fn batch(bytes: &mut &[u8]) -> Result<TimingBatch, LinkError> {
    let mut batch = TimingBatch::zeroed();
    let head = cut(bytes, BATCH_HEAD, "half a timing batch")?;
    if let Some(to) = bytemuck::bytes_of_mut(&mut batch).get_mut(..BATCH_HEAD) {
        to.copy_from_slice(head);
    }
    let count = batch.count as usize;
    if count > batch.records.len() {
        return Err(LinkError::Malformed {
            what: "a timing batch with more records than it holds",
        });
    }
    for to in batch.records.iter_mut().take(count) {
        *to = take::<TickRecord>(bytes, "half a timing batch")?;
    }
    Ok(batch)
}

/// Splits an answer into the scene's total length, the offset of this part, and its bytes.
///
/// # Errors
/// [`LinkError::Malformed`].
pub fn scene_part(mut bytes: &[u8]) -> Result<(u64, u64, &[u8]), LinkError> {
    let head: SceneHead = take(&mut bytes, "a part of a scene without a head")?;
    check(head.magic)?;
    let end = head.offset.checked_add(bytes.len() as u64);
    if head.total > SCENE_MAX || bytes.len() > SCENE_PART || end.is_none_or(|it| it > head.total) {
        return Err(LinkError::Malformed {
            what: "a part that lies outside its scene",
        });
    }
    Ok((head.total, head.offset, bytes))
}
