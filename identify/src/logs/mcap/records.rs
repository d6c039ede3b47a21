//! The messages of an MCAP file that say anything of joints or the CoP, in its order.
//!
//! The crate `mcap` reads the records; chunks that are packed are unpacked here. A file that ends
//! before its closing magic was cut off, which is an error; its summary, which may be missing, is
//! walked over. Memory: a chunk, of [`LARGEST`] bytes at most, packed and unpacked, and the names
//! of topics and types, [`NAMES`] bytes at most. A chunk becomes at most 200 times
//! larger than it is, and all of one packing a MiB more, so that time is in proportion to the
//! file, too.

use std::collections::HashMap;
use std::io::{self, Cursor, Read};
use std::sync::Arc;

use mcap::records::{Record, op};
use mcap::sans_io::decompressor::{DecompressResult, Decompressor};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{McapError, McapResult, parse_record};

use super::cdr::{self, Cdr};
use super::{POINT, STATE, WRENCH};
use crate::logs::input::Metered;
use crate::logs::names::short;

/// Larger records are refused, bytes. Recorders write chunks of about 1 MiB,
/// images included.
const LARGEST: usize = 64 << 20;

/// Bytes of one name of a topic, type or encoding, and of all that are kept.
const NAME: usize = 1024;
const NAMES: usize = 16 << 20;

/// What a channel carries.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Channel {
    pub topic: String,
    /// Name of the message's type.
    pub schema: String,
    /// How its messages are written, such as `cdr`.
    pub encoding: String,
}

/// A message.
pub(super) struct Message {
    pub channel: Arc<Channel>,
    /// s
    log_time: f64,
    data: Vec<u8>,
}

impl Message {
    /// Its time, s, and what `decode` makes of its bytes.
    ///
    /// # Errors
    /// What is wrong with it, and its topic.
    pub(super) fn decoded<T>(
        &self,
        decode: impl FnOnce(&mut Cdr) -> Result<T, String>,
    ) -> Result<(f64, String, T), String> {
        let channel = &self.channel;
        let decoded = match channel.encoding.as_str() {
            "cdr" => cdr::decoded(&self.data, decode),
            other => Err(format!(
                "messages written as `{}`; record with ROS 2, which writes `cdr`",
                short(other)
            )),
        };
        match decoded {
            Ok((stamp, frame, content)) => Ok((stamp.unwrap_or(self.log_time), frame, content)),
            Err(said) => Err(format!("topic {}: {said}", short(&channel.topic))),
        }
    }
}

/// The records of a file.
pub(super) struct Records {
    pub input: Metered,
    reader: LinearReader,
    schemas: HashMap<u16, String>,
    channels: HashMap<u16, Arc<Channel>>,
    /// Bytes of names that were kept.
    names: usize,
}

impl Records {
    /// Start at the magic.
    pub(super) fn new(mut input: Metered) -> Result<Records, String> {
        let mut magic = [0; 8];
        input.read_exact(&mut magic).map_err(|e| unread(&e))?;
        if magic != mcap::MAGIC {
            return Err("a version of MCAP other than 0; convert it with the `mcap` tool".into());
        }
        let options = LinearReaderOptions::default()
            .with_skip_start_magic(true)
            .with_prevalidate_chunk_crcs(true)
            .with_record_length_limit(LARGEST);
        let mut reader = LinearReader::new_with_options(options);
        for name in ["lz4", "zstd"] {
            let unpacker = Unpacker {
                name,
                free: 1 << 20,
                records: Cursor::default(),
            };
            reader.add_decompressor(unpacker).map_err(fault)?;
        }
        Ok(Records {
            input,
            reader,
            schemas: HashMap::new(),
            channels: HashMap::new(),
            names: 0,
        })
    }

    /// The next message of joints or of a CoP; nothing at the end of the file.
    pub(super) fn next(&mut self) -> Result<Option<Message>, String> {
        while let Some(event) = self.reader.next_event() {
            let (opcode, content) = match event.map_err(fault)? {
                LinearReadEvent::Record { opcode, data } => (opcode, data),
                LinearReadEvent::ReadRequest(_) => {
                    // A piece at a time: a false length does not reserve memory.
                    match self.input.read(self.reader.insert(64 << 10)) {
                        Ok(n) => self.reader.notify_read(n),
                        Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                        Err(error) => return Err(unread(&error)),
                    }
                    continue;
                }
            };
            match opcode {
                op::CHUNK => return Err("a chunk within a chunk; the file is damaged".into()),
                // What publishers promise of a topic has some KiB.
                op::CHANNEL if content.len() > 1 << 20 => {
                    return Err("a topic of more than 1 MiB; the file is damaged".into());
                }
                op::SCHEMA | op::CHANNEL | op::MESSAGE => {}
                _ => continue,
            }
            match parse_record(opcode, content).map_err(fault)? {
                Record::Schema { header, .. } => {
                    keep(&mut self.names, &header.name)?;
                    self.schemas.insert(header.id, header.name);
                }
                Record::Channel(channel) => {
                    let schema = self.schemas.get(&channel.schema_id).cloned();
                    let schema = schema.unwrap_or_default();
                    for name in [&channel.topic, &channel.message_encoding, &schema] {
                        keep(&mut self.names, name)?;
                    }
                    let own = Channel {
                        topic: channel.topic,
                        schema,
                        encoding: channel.message_encoding,
                    };
                    self.channels.insert(channel.id, Arc::new(own));
                }
                Record::Message { header, data } => {
                    let channel = self.channels.get(&header.channel_id);
                    let read = |own: &&Arc<Channel>| [STATE, WRENCH, POINT].contains(&&*own.schema);
                    if let Some(channel) = channel.filter(read) {
                        return Ok(Some(Message {
                            channel: Arc::clone(channel),
                            log_time: header.log_time as f64 * 1e-9,
                            data: data.into_owned(),
                        }));
                    }
                }
                _ => {}
            }
        }
        // Whatever follows the closing magic: the hash is of the whole file.
        let rest = io::copy(&mut self.input, &mut io::sink());
        rest.map(|_| None).map_err(|error| unread(&error))
    }

    /// Topics and types that were announced so far.
    pub(super) fn channels(&self) -> impl Iterator<Item = &Channel> {
        self.channels.values().map(|channel| &**channel)
    }
}

/// Add the length of a name to that of all `names`.
fn keep(names: &mut usize, text: &str) -> Result<(), String> {
    *names += text.len();
    match text.len() {
        length if length > NAME => Err(format!("a name of {length} bytes; the file is damaged")),
        _ if *names > NAMES => Err(format!(
            "topics and types of more than {} MiB; the file is damaged",
            NAMES >> 20
        )),
        _ => Ok(()),
    }
}

/// Unpacks chunks, each at once.
struct Unpacker {
    name: &'static str,
    /// Unpacked bytes of all chunks that need no packed ones: what is left of them.
    free: u64,
    /// The records of the chunk, and how many bytes of them were given out.
    records: Cursor<Vec<u8>>,
}

impl Unpacker {
    /// Unpack a chunk, which claims to have `claimed` bytes of records.
    fn unpack(&mut self, packed: &[u8], claimed: u64) -> McapResult<()> {
        let refused = |claimed: u64| {
            let packed = packed.len();
            let message = format!("a chunk of {packed} bytes that claims to unpack to {claimed}");
            McapError::DecompressionError(message)
        };
        let allowed = 200_u64.saturating_mul(packed.len() as u64);
        let most = allowed.saturating_add(self.free);
        if claimed > most {
            return Err(refused(claimed));
        }
        let mut records = Vec::new();
        let unpacked = match self.name {
            "lz4" => lz4_flex::frame::FrameDecoder::new(packed)
                .take(most + 1)
                .read_to_end(&mut records),
            _ => match ruzstd::decoding::StreamingDecoder::new(packed) {
                Ok(decoder) => decoder.take(most + 1).read_to_end(&mut records),
                Err(error) => Err(io::Error::other(error.to_string())),
            },
        };
        let size = unpacked.map_err(|error| {
            McapError::DecompressionError(format!("a chunk cannot be unpacked ({error})"))
        })? as u64;
        if size > most {
            return Err(refused(size));
        }
        self.free -= size.saturating_sub(allowed);
        self.records = Cursor::new(records);
        Ok(())
    }
}

impl Decompressor for Unpacker {
    /// The whole chunk.
    fn next_read_size(&self) -> usize {
        usize::MAX
    }

    fn decompress(&mut self, packed: &[u8], to: &mut [u8]) -> McapResult<DecompressResult> {
        if !packed.is_empty() {
            self.unpack(packed, to.len() as u64)?;
        }
        Ok(DecompressResult {
            consumed: packed.len(),
            wrote: self.records.read(to)?,
        })
    }

    fn reset(&mut self) -> McapResult<()> {
        let records = std::mem::take(&mut self.records);
        if records.position() < records.get_ref().len() as u64 {
            let message = "a chunk that has more bytes than it claims";
            return Err(McapError::DecompressionError(message.into()));
        }
        Ok(())
    }

    fn name(&self) -> &'static str {
        self.name
    }
}

fn fault(error: McapError) -> String {
    let what = match error {
        McapError::UnexpectedEof => return unread(&io::ErrorKind::UnexpectedEof.into()),
        McapError::UnsupportedCompression(name) => {
            let name = short(&name);
            return format!(
                "chunks packed with `{name}`; repack it with `mcap compress --compression zstd`"
            );
        }
        McapError::BadMagic => "no closing mark".to_string(),
        McapError::RecordTooLarge { len, .. } => {
            format!("a record of {len} bytes, more than {} MiB", LARGEST >> 20)
        }
        McapError::ChunkTooLarge(size) => format!("a chunk that claims to unpack to {size} bytes"),
        McapError::BadChunkCrc { .. } => "a chunk that does not match its checksum".to_string(),
        McapError::DecompressionError(message) => message,
        other => other.to_string(),
    };
    format!("{what}; the file is damaged")
}

fn unread(error: &io::Error) -> String {
    match error.kind() {
        io::ErrorKind::UnexpectedEof => {
            "the recording is cut off; mend it with `mcap recover`".to_string()
        }
        _ => format!("cannot be read on: {error}"),
    }
}
