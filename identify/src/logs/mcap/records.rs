//! The messages of an MCAP file, in its order.
//!
//! ```text
//! file    magic, records, magic
//! record  opcode u8, length u64, content
//! chunk   records once more, maybe compressed
//! ```
//!
//! Integers are little-endian. Only schemas, channels and messages matter here;
//! the summary after the data is walked over. A file that ends before its
//! closing magic was cut off, which is an error. Memory: one chunk, of
//! [`LARGEST`] bytes at most, and the names of topics and types, [`NAMES`] bytes at most. A
//! chunk becomes at most [`EXPANSION`] times larger than it is, and all of a file [`FREE`] bytes
//! more, so that time is in proportion to the file, too.

use std::collections::HashMap;
use std::io::Read;
use std::ops::Range;
use std::sync::Arc;

use super::format::opcode::{CHANNEL, CHUNK, FOOTER, MESSAGE, SCHEMA};
use super::format::{MAGIC, OWN_POSTURES};

/// Larger records are refused, bytes. Recorders write chunks of about 1 MiB,
/// images included.
const LARGEST: u64 = 64 << 20;

/// Unpacked bytes of a file that need no packed ones, and how many times larger its chunks become
/// beyond: joint states pack ten to one.
const FREE: u64 = 1 << 20;
const EXPANSION: u64 = 200;

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
    /// Whether each message is a posture of its own, or its reading.
    pub own_postures: bool,
}

/// A message: where it is from, and where its bytes are.
#[derive(Debug)]
pub(super) struct Message {
    channel: u16,
    /// s
    pub log_time: f64,
    content: Range<usize>,
}

/// The records of a file.
pub(super) struct Records<R> {
    input: R,
    schemas: HashMap<u16, String>,
    channels: HashMap<u16, Arc<Channel>>,
    /// Bytes of names that were kept.
    names: usize,
    /// The record that was read last, or the chunk that is being walked.
    buffer: Vec<u8>,
    /// Where the next record of the chunk starts.
    at: usize,
    in_chunk: bool,
    ended: bool,
    /// What is left of [`FREE`].
    free: u64,
}

impl<R: Read> Records<R> {
    /// Start at the magic.
    pub fn new(mut input: R) -> Result<Records<R>, String> {
        let mut magic = [0; 8];
        input.read_exact(&mut magic).map_err(|e| cut_off(&e))?;
        if &magic != MAGIC {
            return Err("a version of MCAP other than 0; convert it with the `mcap` tool".into());
        }
        Ok(Records {
            input,
            schemas: HashMap::new(),
            channels: HashMap::new(),
            names: 0,
            buffer: Vec::new(),
            at: 0,
            in_chunk: false,
            ended: false,
            free: FREE,
        })
    }

    /// The next message; nothing at the end of the file.
    pub fn next(&mut self) -> Result<Option<Message>, String> {
        while let Some((opcode, content)) = self.record()? {
            match opcode {
                SCHEMA => self.schema(content)?,
                CHANNEL => self.channel(content)?,
                CHUNK => self.open_chunk(content)?,
                MESSAGE => {
                    let mut fields = Fields(&self.buffer[content.clone()]);
                    let channel = fields.u16()?;
                    fields.take(4)?; // sequence
                    let log_time = fields.u64()? as f64 * 1e-9;
                    fields.take(8)?; // publish time
                    let start = content.end - fields.0.len();
                    return Ok(Some(Message {
                        channel,
                        log_time,
                        content: start..content.end,
                    }));
                }
                FOOTER if !self.in_chunk => self.finish()?,
                _ => {}
            }
        }
        Ok(None)
    }

    /// Bytes of the message that was read last.
    pub fn data(&self, message: &Message) -> &[u8] {
        &self.buffer[message.content.clone()]
    }

    /// Channel of a message; a message may come without.
    pub fn channel_of(&self, message: &Message) -> Option<Arc<Channel>> {
        self.channels.get(&message.channel).cloned()
    }

    /// Topics and types that were announced so far.
    pub fn channels(&self) -> impl Iterator<Item = &Channel> {
        self.channels.values().map(|channel| &**channel)
    }

    /// The next record of the chunk or else of the file: its opcode and where
    /// in the buffer its content is.
    fn record(&mut self) -> Result<Option<(u8, Range<usize>)>, String> {
        if self.in_chunk {
            if self.at < self.buffer.len() {
                let mut fields = Fields(&self.buffer[self.at..]);
                let opcode = fields.u8()?;
                let length = fields.length()?;
                fields.take(length)?;
                let start = self.at + 9;
                self.at = start + length;
                return Ok(Some((opcode, start..self.at)));
            }
            self.in_chunk = false;
        }
        if self.ended {
            return Ok(None);
        }
        let mut head = [0; 9];
        self.input.read_exact(&mut head).map_err(|e| cut_off(&e))?;
        let mut fields = Fields(&head);
        let (opcode, length) = (fields.u8()?, fields.u64()?);
        if length > LARGEST {
            return Err(format!(
                "a record of {length} bytes, more than {} MiB; the file is damaged",
                LARGEST >> 20
            ));
        }
        // Taken as it comes: a false length does not reserve memory.
        self.buffer.clear();
        let taken = (&mut self.input).take(length).read_to_end(&mut self.buffer);
        match taken {
            Ok(n) if n as u64 == length => Ok(Some((opcode, 0..n))),
            Ok(_) => Err(cut_off(&std::io::ErrorKind::UnexpectedEof.into())),
            Err(error) => Err(cut_off(&error)),
        }
    }

    /// The closing magic, and whatever follows it.
    fn finish(&mut self) -> Result<(), String> {
        let mut magic = [0; 8];
        self.input.read_exact(&mut magic).map_err(|e| cut_off(&e))?;
        if &magic != MAGIC {
            return Err("no closing mark; the file is damaged".into());
        }
        self.ended = true;
        // The hash is of the whole file.
        std::io::copy(&mut self.input, &mut std::io::sink())
            .map(|_| ())
            .map_err(|error| cut_off(&error))
    }

    fn schema(&mut self, content: Range<usize>) -> Result<(), String> {
        let mut fields = Fields(&self.buffer[content]);
        let id = fields.u16()?;
        let name = fields.name()?;
        let names = name.len();
        self.schemas.insert(id, name);
        self.keep(names)
    }

    /// Count what is kept until the end.
    fn keep(&mut self, bytes: usize) -> Result<(), String> {
        self.names += bytes;
        match self.names > NAMES {
            true => Err(format!(
                "topics and types of more than {} MiB; the file is damaged",
                NAMES >> 20
            )),
            false => Ok(()),
        }
    }

    fn channel(&mut self, content: Range<usize>) -> Result<(), String> {
        let mut fields = Fields(&self.buffer[content]);
        let (id, schema) = (fields.u16()?, fields.u16()?);
        let channel = Channel {
            topic: fields.name()?,
            encoding: fields.name()?,
            schema: self.schemas.get(&schema).cloned().unwrap_or_default(),
            own_postures: fields.has(OWN_POSTURES),
        };
        let names = channel.topic.len() + channel.encoding.len() + channel.schema.len();
        self.channels.insert(id, Arc::new(channel));
        self.keep(names)
    }

    fn open_chunk(&mut self, content: Range<usize>) -> Result<(), String> {
        if self.in_chunk {
            return Err("a chunk within a chunk; the file is damaged".into());
        }
        let mut fields = Fields(&self.buffer[content]);
        fields.take(16)?; // first and last time
        let size = fields.u64()?;
        let checksum = fields.u32()?;
        let compression = fields.name()?;
        let length = fields.length()?;
        let packed = fields.take(length)?;
        let beyond = size.saturating_sub(EXPANSION.saturating_mul(packed.len() as u64));
        if size > LARGEST || beyond > self.free {
            let packed = packed.len();
            return Err(format!(
                "a chunk of {packed} bytes that claims to unpack to {size}; the file is damaged"
            ));
        }
        self.free -= beyond;
        let records = unpack(&compression, packed, size)?;
        if records.len() as u64 != size || (checksum != 0 && crc32(&records) != checksum) {
            return Err("a chunk that does not match its checksum; the file is damaged".into());
        }
        (self.buffer, self.at, self.in_chunk) = (records, 0, true);
        Ok(())
    }
}

pub(super) fn crc32(bytes: &[u8]) -> u32 {
    let mut crc = flate2::Crc::new();
    crc.update(bytes);
    crc.sum()
}

/// The records of a chunk; `size` bounds what they may grow to.
pub(super) fn unpack(compression: &str, packed: &[u8], size: u64) -> Result<Vec<u8>, String> {
    let mut records = Vec::new();
    let done = match compression {
        "" => {
            records.extend(packed);
            Ok(0)
        }
        "lz4" => lz4_flex::frame::FrameDecoder::new(packed)
            .take(size + 1)
            .read_to_end(&mut records),
        "zstd" => match ruzstd::decoding::StreamingDecoder::new(packed) {
            Ok(decoder) => decoder.take(size + 1).read_to_end(&mut records),
            Err(error) => Err(std::io::Error::other(error.to_string())),
        },
        other => {
            return Err(format!(
                "chunks packed with `{}`; repack it with `mcap compress --compression zstd`",
                super::super::names::short(other)
            ));
        }
    };
    match done {
        Ok(_) => Ok(records),
        Err(error) => Err(format!(
            "a chunk cannot be unpacked ({error}); the file is damaged"
        )),
    }
}

fn cut_off(error: &std::io::Error) -> String {
    match error.kind() {
        std::io::ErrorKind::UnexpectedEof => {
            "the recording is cut off; mend it with `mcap recover`".to_string()
        }
        _ => format!("cannot be read on: {error}"),
    }
}

/// The fields of a record, one after the other.
struct Fields<'a>(&'a [u8]);

impl<'a> Fields<'a> {
    fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        let (taken, rest) = self
            .0
            .split_at_checked(count)
            .ok_or("a record shorter than what it claims; the file is damaged")?;
        self.0 = rest;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let mut bytes = [0; N];
        bytes.copy_from_slice(self.take(N)?);
        Ok(bytes)
    }

    fn u8(&mut self) -> Result<u8, String> {
        Ok(self.array::<1>()?[0])
    }

    fn u16(&mut self) -> Result<u16, String> {
        Ok(u16::from_le_bytes(self.array()?))
    }

    fn u32(&mut self) -> Result<u32, String> {
        Ok(u32::from_le_bytes(self.array()?))
    }

    fn u64(&mut self) -> Result<u64, String> {
        Ok(u64::from_le_bytes(self.array()?))
    }

    /// A length that this machine can address.
    fn length(&mut self) -> Result<usize, String> {
        Ok(usize::try_from(self.u64()?).unwrap_or(usize::MAX))
    }

    fn name(&mut self) -> Result<String, String> {
        let length = self.u32()? as usize;
        if length > NAME {
            return Err(format!("a name of {length} bytes; the file is damaged"));
        }
        Ok(String::from_utf8_lossy(self.take(length)?).into_owned())
    }

    /// Whether a map of texts, which may be missing, has this entry.
    fn has(&mut self, [key, value]: [&str; 2]) -> bool {
        let entries = self.u32().and_then(|length| self.take(length as usize));
        let mut entries = Fields(entries.unwrap_or_default());
        let mut text = || {
            let length = entries.u32().ok()?;
            entries.take(length as usize).ok()
        };
        while let (Some(own), Some(said)) = (text(), text()) {
            if own == key.as_bytes() {
                return said == value.as_bytes();
            }
        }
        false
    }
}
