//! The messages of a record, in the order of the file.

use anyhow::{Context as _, Result};
use mcap::McapError;
use mcap::parse_record;
use mcap::records::Record as Entry;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use std::collections::HashMap;
use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The largest entry of a file that is read.
const MAX_ENTRY: usize = 1 << 30;

/// A topic of a record.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Topic {
    /// Its name.
    pub name: String,
    /// The type of its messages, such as `sensor_msgs/msg/Image`.
    pub of: String,
    /// How they are encoded, `cdr` in ROS 2.
    pub encoding: String,
}

/// A message.
pub struct Message {
    /// Its topic.
    pub topic: Arc<Topic>,
    /// When it was recorded, in nanoseconds.
    pub log_time: u64,
    /// Its bytes; none if they are not wanted.
    pub data: Vec<u8>,
}

/// Reads a record from its beginning, a chunk at a time.
pub struct Messages {
    path: PathBuf,
    file: File,
    reader: LinearReader,
    types: HashMap<u16, String>,
    topics: HashMap<u16, Arc<Topic>>,
    /// Whether the file ended before its own end.
    pub is_cut: bool,
}

impl Messages {
    /// Opens a file.
    pub fn open(path: &Path) -> Result<Self> {
        let file = File::open(path).with_context(|| format!("{path:?} cannot be read"))?;
        let options =
            LinearReaderOptions::default().with_record_length_limit(MAX_ENTRY).with_prevalidate_chunk_crcs(true);
        let reader = LinearReader::new_with_options(options);
        let (types, topics) = (HashMap::new(), HashMap::new());
        Ok(Self { path: path.into(), file, reader, types, topics, is_cut: false })
    }

    /// The next message; with its bytes if `wants` its topic.
    pub fn next(&mut self, wants: impl Fn(&Topic) -> bool) -> Result<Option<Message>> {
        let damaged = |error: McapError, path: &Path| {
            anyhow::anyhow!("{path:?} is damaged ({error}); repair it, for example with mcap recover")
        };
        loop {
            let (opcode, data) = match self.reader.next_event() {
                None => return Ok(None),
                Some(Ok(LinearReadEvent::ReadRequest(count))) => {
                    let space = self.reader.insert(count);
                    let read = self.file.read(space).with_context(|| format!("{:?} cannot be read", self.path))?;
                    self.reader.notify_read(read);
                    continue;
                }
                Some(Ok(LinearReadEvent::Record { data, opcode })) => (opcode, data),
                Some(Err(McapError::UnexpectedEof)) => {
                    self.is_cut = true;
                    return Ok(None);
                }
                Some(Err(error)) => return Err(damaged(error, &self.path)),
            };
            match parse_record(opcode, data).map_err(|error| damaged(error, &self.path))? {
                Entry::Schema { header, .. } => {
                    self.types.insert(header.id, header.name);
                }
                Entry::Channel(channel) => {
                    let of = self.types.get(&channel.schema_id).cloned().unwrap_or_default();
                    let topic = Topic { name: channel.topic, of, encoding: channel.message_encoding };
                    self.topics.insert(channel.id, Arc::new(topic));
                }
                Entry::Message { header, data } => {
                    let Some(topic) = self.topics.get(&header.channel_id) else { continue };
                    let data = if wants(topic) { data.into_owned() } else { Vec::new() };
                    return Ok(Some(Message { topic: Arc::clone(topic), log_time: header.log_time, data }));
                }
                _ => {}
            }
        }
    }
}
