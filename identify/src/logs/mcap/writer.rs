//! Writing an MCAP file, with the index that viewers ask for.
//!
//! ```text
//! file     magic, header, chunks each with its message indexes, end of data,
//!          summary, footer, magic
//! chunk    messages; the first one begins with schemas and channels
//! summary  schemas, channels, statistics, an index of each chunk, where each group stands
//! ```
//!
//! Chunks are packed with LZ4. The same messages give the same bytes: there is no date in them.

use std::io::{self, Write};

use super::format::opcode::{
    CHANNEL, CHUNK, CHUNK_INDEX, END_OF_DATA, FOOTER, HEADER, MESSAGE, MESSAGE_INDEX, SCHEMA,
    STATISTICS, SUMMARY_OFFSET,
};
use super::format::{MAGIC, OWN_POSTURES};
use super::records::crc32;

/// Bytes of messages in a chunk before they are packed; recorders have as many.
const LARGEST: usize = 1 << 20;

/// How the chunks are packed.
const PACKED: &str = "lz4";

/// A topic that is written.
pub(super) struct Topic<'a> {
    pub name: &'a str,
    /// Place of its type among the types, from 0.
    pub schema: usize,
    /// Whether each message is a posture of its own, or its reading.
    pub own_postures: bool,
}

/// Fields of a record, one after the other.
#[derive(Default)]
struct Fields(Vec<u8>);

impl Fields {
    fn u16(mut self, x: u16) -> Fields {
        self.0.extend(x.to_le_bytes());
        self
    }

    fn u32(mut self, x: u32) -> Fields {
        self.0.extend(x.to_le_bytes());
        self
    }

    fn u64(mut self, x: u64) -> Fields {
        self.0.extend(x.to_le_bytes());
        self
    }

    fn bytes(mut self, bytes: &[u8]) -> Fields {
        self.0.extend(bytes);
        self
    }

    fn text(self, text: &str) -> Fields {
        self.u32(text.len() as u32).bytes(text.as_bytes())
    }

    /// A list or a map: its length in bytes, and its entries.
    fn list(self, entries: &Fields) -> Fields {
        self.u32(entries.0.len() as u32).bytes(&entries.0)
    }

    fn record(self, opcode: u8) -> Vec<u8> {
        let length = (self.0.len() as u64).to_le_bytes();
        [&[opcode][..], &length, &self.0].concat()
    }
}

/// The messages that wait to be packed.
#[derive(Default)]
struct Waiting {
    records: Vec<u8>,
    /// Time (ns) and place in `records` of the messages of each topic.
    index: Vec<Vec<[u64; 2]>>,
    /// First and last time, ns.
    times: Option<[u64; 2]>,
}

/// A file being written.
pub(super) struct McapWriter<W> {
    out: W,
    /// Bytes that were written.
    at: u64,
    schemas: Vec<u8>,
    channels: Vec<u8>,
    schema_count: u16,
    waiting: Waiting,
    chunk_indexes: Vec<u8>,
    chunks: u32,
    /// Messages of each topic.
    counts: Vec<u64>,
    times: Option<[u64; 2]>,
}

/// Number of the type or topic at this place; 0 stands for none.
fn number(place: usize) -> u16 {
    place as u16 + 1
}

fn wider(times: Option<[u64; 2]>, time: u64) -> Option<[u64; 2]> {
    let [first, last] = times.unwrap_or([time, time]);
    Some([first.min(time), last.max(time)])
}

impl<W: Write> McapWriter<W> {
    /// Begin a file with types, by name and text, and topics.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn begin(
        out: W,
        types: impl Iterator<Item = (&'static str, String)>,
        topics: &[Topic],
    ) -> io::Result<McapWriter<W>> {
        let (mut schemas, mut channels, mut schema_count) = (Vec::new(), Vec::new(), 0);
        for (k, (name, text)) in types.enumerate() {
            schema_count += 1;
            let fields = Fields::default().u16(number(k)).text(name);
            schemas.extend(fields.text("ros2msg").text(&text).record(SCHEMA));
        }
        for (k, topic) in topics.iter().enumerate() {
            let mut about = Fields::default();
            if topic.own_postures {
                let [key, value] = OWN_POSTURES;
                about = about.text(key).text(value);
            }
            let fields = Fields::default().u16(number(k)).u16(number(topic.schema));
            let fields = fields.text(topic.name).text("cdr").list(&about);
            channels.extend(fields.record(CHANNEL));
        }
        let mut writer = McapWriter {
            out,
            at: 0,
            schema_count,
            waiting: Waiting {
                records: [&schemas[..], &channels].concat(),
                index: vec![Vec::new(); topics.len()],
                times: None,
            },
            schemas,
            channels,
            chunk_indexes: Vec::new(),
            chunks: 0,
            counts: vec![0; topics.len()],
            times: None,
        };
        writer.put(MAGIC)?;
        let header = Fields::default().text("ros2");
        let header = header.text(concat!("sesc ", env!("CARGO_PKG_VERSION")));
        writer.put(&header.record(HEADER))?;
        Ok(writer)
    }

    /// Append a message of a topic, by its place among the topics, at a time in ns.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn message(&mut self, topic: usize, time: u64, data: &[u8]) -> io::Result<()> {
        let waiting = &mut self.waiting;
        waiting.index[topic].push([time, waiting.records.len() as u64]);
        waiting.times = wider(waiting.times, time);
        self.times = wider(self.times, time);
        let fields = Fields::default().u16(number(topic));
        // The sequence number begins at 0 in each topic; it is published when it is logged.
        let fields = fields.u32(self.counts[topic] as u32).u64(time).u64(time);
        let record = fields.bytes(data).record(MESSAGE);
        waiting.records.extend(record);
        self.counts[topic] += 1;
        match self.waiting.records.len() < LARGEST {
            true => Ok(()),
            false => self.pack(),
        }
    }

    /// Write the messages that wait.
    fn pack(&mut self) -> io::Result<()> {
        let empty = Waiting {
            index: vec![Vec::new(); self.counts.len()],
            ..Waiting::default()
        };
        let Waiting {
            records,
            index,
            times,
        } = std::mem::replace(&mut self.waiting, empty);
        let [first, last] = times.unwrap_or_default();
        let mut packer = lz4_flex::frame::FrameEncoder::new(Vec::new());
        packer.write_all(&records)?;
        let packed = packer.finish().map_err(io::Error::other)?;
        let chunk = Fields::default().u64(first).u64(last);
        let chunk = chunk.u64(records.len() as u64).u32(crc32(&records));
        let chunk = chunk.text(PACKED).u64(packed.len() as u64).bytes(&packed);
        let start = self.at;
        self.put(&chunk.record(CHUNK))?;
        let end = self.at;
        let mut places = Fields::default();
        for (topic, messages) in index.iter().enumerate() {
            if messages.is_empty() {
                continue;
            }
            places = places.u16(number(topic)).u64(self.at);
            let entries = messages
                .iter()
                .fold(Fields::default(), |entries, [time, at]| {
                    entries.u64(*time).u64(*at)
                });
            let fields = Fields::default().u16(number(topic)).list(&entries);
            self.put(&fields.record(MESSAGE_INDEX))?;
        }
        let about = Fields::default().u64(first).u64(last);
        let about = about.u64(start).u64(end - start).list(&places);
        let about = about.u64(self.at - end).text(PACKED);
        let about = about.u64(packed.len() as u64).u64(records.len() as u64);
        self.chunk_indexes.extend(about.record(CHUNK_INDEX));
        self.chunks += 1;
        Ok(())
    }

    /// Complete the file.
    ///
    /// # Errors
    /// When it cannot be written to its end.
    pub fn finish(mut self) -> io::Result<W> {
        if !self.waiting.records.is_empty() {
            self.pack()?;
        }
        // Without a checksum of all data: each chunk has its own.
        self.put(&Fields::default().u32(0).record(END_OF_DATA))?;
        let [first, last] = self.times.unwrap_or_default();
        let counts = self.counts.iter().enumerate();
        let counts = counts.fold(Fields::default(), |counts, (topic, count)| {
            counts.u16(number(topic)).u64(*count)
        });
        let statistics = Fields::default().u64(self.counts.iter().sum());
        let statistics = statistics.u16(self.schema_count);
        // Neither attachments nor metadata.
        let statistics = statistics.u32(self.counts.len() as u32).u32(0).u32(0);
        let statistics = statistics.u32(self.chunks).u64(first).u64(last);
        let groups = [
            (SCHEMA, std::mem::take(&mut self.schemas)),
            (CHANNEL, std::mem::take(&mut self.channels)),
            (STATISTICS, statistics.list(&counts).record(STATISTICS)),
            (CHUNK_INDEX, std::mem::take(&mut self.chunk_indexes)),
        ];
        let start = self.at;
        let (mut summary, mut offsets) = (Vec::new(), Vec::new());
        for (opcode, group) in groups {
            let (from, length) = (start + summary.len() as u64, group.len() as u64);
            let place = Fields::default().bytes(&[opcode]).u64(from).u64(length);
            offsets.extend(place.record(SUMMARY_OFFSET));
            summary.extend(group);
        }
        let offsets_start = start + summary.len() as u64;
        summary.extend(offsets);
        // The checksum is of everything before it, the beginning of the footer included.
        let footer = Fields::default().u64(start).u64(offsets_start).u32(0);
        let footer = footer.record(FOOTER);
        summary.extend(&footer[..footer.len() - 4]);
        let checksum = crc32(&summary).to_le_bytes();
        summary.extend(checksum);
        self.put(&summary)?;
        self.put(MAGIC)?;
        Ok(self.out)
    }

    fn put(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.out.write_all(bytes)?;
        self.at += bytes.len() as u64;
        Ok(())
    }
}
