//! Counts what a session lost where it is damaged.

use std::collections::BTreeMap;

use mcap::records::MessageHeader;

use crate::index::Index;

/// Largest number of time spans that [`Lost::in_words`] names.
const SPANS_SAID: usize = 3;

/// Parts that a session lost where it is damaged, other than its end.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Lost {
    /// Lost messages, as far as they are known.
    pub messages: u64,
    /// True if more messages may be lost than are counted, because nothing behind the last damage
    /// gives its number of messages.
    pub is_more: bool,
    /// Lost messages of each topic, as far as they are known.
    pub topics: BTreeMap<String, u64>,
    /// Begin and end of each span without messages, ns since the session's first message.
    pub spans_ns: Vec<[u64; 2]>,
    /// True if the compiled scene is lost.
    pub scene: bool,
    /// Places and kinds of the damage.
    pub damage: Vec<String>,
}

impl Lost {
    /// True if nothing is lost, because only parts of the index are damaged.
    #[must_use]
    pub fn is_nothing(&self) -> bool {
        self.messages == 0 && !self.is_more && !self.scene
    }

    /// Text that names the lost messages, their time spans, and the scene.
    #[must_use]
    pub fn in_words(&self) -> String {
        let mut words = Vec::new();
        if self.messages > 0 {
            let seconds = |ns: u64| ns as f64 / 1e9;
            let span = |[from, to]: &[u64; 2]| {
                format!("from {:.2} to {:.2} s", seconds(*from), seconds(*to))
            };
            let spans: Vec<String> = self.spans_ns.iter().take(SPANS_SAID).map(span).collect();
            let more = match self.spans_ns.len().saturating_sub(SPANS_SAID) {
                0 => String::new(),
                more => format!(" and {more} more spans"),
            };
            let messages = self.messages;
            let least = if self.is_more { "at least " } else { "" };
            words.push(format!(
                "{least}{messages} messages {}{more}",
                spans.join(", ")
            ));
        } else if self.is_more {
            words.push("an unknown number of messages at the session's end".to_owned());
        }
        if self.scene {
            words.push("the compiled scene".to_owned());
        }
        words.join(", and ")
    }
}

/// Follows the messages of a session and counts those that are missing.
#[derive(Debug)]
pub(crate) struct Tracker {
    lost: Lost,
    /// Number that the next message should have. The recorder numbers the messages of all channels
    /// together.
    expected: u32,
    first_ns: Option<u64>,
    newest_ns: u64,
    /// True behind a damaged place, until the next message.
    is_behind_damage: bool,
    /// True if the index of a chunk came behind the last damaged place.
    is_named: bool,
    /// Number of kept messages of each channel.
    kept: BTreeMap<u16, u64>,
    /// Number of messages of each channel in damaged chunks, from the indices of these chunks.
    named: BTreeMap<u16, u64>,
}

impl Tracker {
    /// Starts with the time of the first message from the session's index, if there is one.
    pub(crate) fn new(index: Option<&Index>) -> Self {
        Self {
            lost: Lost::default(),
            expected: 0,
            first_ns: index.map(|it| it.first_ns).filter(|it| *it > 0),
            newest_ns: 0,
            is_behind_damage: false,
            is_named: false,
            kept: BTreeMap::new(),
            named: BTreeMap::new(),
        }
    }

    /// Notes a damaged place, which the copy leaves out.
    pub(crate) fn damage(&mut self, what: String) {
        self.is_behind_damage = true;
        self.is_named = false;
        self.lost.damage.push(what);
    }

    /// Takes the number of a channel's messages from the index of a chunk. If the chunk is damaged,
    /// these messages are lost.
    pub(crate) fn index_of_chunk(&mut self, channel: u16, messages: u64) {
        if self.is_behind_damage {
            *self.named.entry(channel).or_default() += messages;
            self.is_named = true;
        }
    }

    /// Notes a message that is kept.
    pub(crate) fn keep(&mut self, header: &MessageHeader) {
        let time_ns = header.log_time;
        if self.is_behind_damage {
            self.is_behind_damage = false;
            let missing = header.sequence.wrapping_sub(self.expected);
            // Numbers that decrease do not come from the recorder.
            if (1..=u32::MAX / 2).contains(&missing) {
                self.lost.messages += u64::from(missing);
                self.span(time_ns);
            }
        }
        let begins_ns = *self.first_ns.get_or_insert(time_ns);
        self.newest_ns = self.newest_ns.max(time_ns).max(begins_ns);
        self.expected = header.sequence.wrapping_add(1);
        *self.kept.entry(header.channel_id).or_default() += 1;
    }

    /// Notes a span without messages, from the newest message to this time.
    fn span(&mut self, to_ns: u64) {
        let first_ns = *self.first_ns.get_or_insert(to_ns);
        let [from, to] = [self.newest_ns.max(first_ns), to_ns.max(self.newest_ns)];
        self.lost.spans_ns.push([from, to].map(|it| it - first_ns));
    }

    /// Number of messages that are kept.
    pub(crate) fn kept(&self) -> u64 {
        self.kept.values().sum()
    }

    /// Everything that is lost. `has_scene` is false if the session should have a scene and has
    /// none. `topics` are the names of known channels.
    pub(crate) fn end(
        mut self,
        index: Option<&Index>,
        topics: &BTreeMap<u16, String>,
        has_scene: bool,
    ) -> Lost {
        if self.lost.damage.is_empty() {
            return self.lost;
        }
        let mut missing = self.named.clone();
        if let Some(index) = index.filter(|it| !it.counts.is_empty()) {
            let of = |(channel, count): (&u16, &u64)| {
                (
                    *channel,
                    count.saturating_sub(self.kept.get(channel).copied().unwrap_or(0)),
                )
            };
            missing = index.counts.iter().map(of).collect();
            let sum = missing.values().sum();
            if self.is_behind_damage && sum > self.lost.messages {
                self.span(index.last_ns);
            }
            self.lost.messages = sum;
        } else {
            self.lost.is_more = self.is_behind_damage && !self.is_named;
        }
        self.lost.messages = self.lost.messages.max(missing.values().sum());
        let named = missing.into_iter().filter(|(_, count)| *count > 0);
        let named =
            named.filter_map(|(channel, count)| Some((topics.get(&channel)?.clone(), count)));
        self.lost.topics = named.collect();
        self.lost.scene = !has_scene;
        self.lost
    }
}
