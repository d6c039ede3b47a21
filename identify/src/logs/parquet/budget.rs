//! What a Parquet file claims, held against its bytes before they are believed.
//!
//! The library behind this reserves memory for what headers claim, recurses as deep as a
//! schema is nested, and skips unknown lists item by item. Here footer and page headers are
//! walked without any of that:
//!
//! ```text
//! every list         items ≤ bytes left            nesting ≤ 32
//! schema             columns ≤ 20 000, nested ≤ 32 deep
//! rows               ≤ 10⁶ + 1000 per byte of the file
//! column chunks      together no longer than the file
//! page that is read  unpacked ≤ 64 MiB and ≤ 4 MiB + 200 × packed
//! dictionary         entries ≤ its bytes
//! ```
//!
//! Footers and headers are in Thrift's compact protocol.

use std::io::{Read, Seek, SeekFrom};

use super::kinds;
use super::thrift::{ThriftValue, Walk};

/// Columns and groups of columns of a schema.
const COLUMNS: usize = 20_000;
/// Groups of columns within each other.
const DEPTH: usize = 32;
/// Rows that need no bytes: constant columns pack well.
const FREE_ROWS: u64 = 1_000_000;
/// Rows per byte beyond these.
const ROWS_PER_BYTE: u64 = 1000;
/// A footer is not longer, nor the header of a page.
const FOOTER: u64 = 64 << 20;
const HEADER: u64 = 1 << 20;
/// An unpacked page.
const PAGE: i64 = 64 << 20;
/// Bytes of a page that need no packed ones, and how many times larger it becomes beyond.
const FREE_BYTES: i64 = 4 << 20;
const EXPANSION: i64 = 200;

const MAGIC: &[u8; 4] = b"PAR1";

/// Fields of `FileMetaData`, `SchemaElement`, `RowGroup`, `ColumnChunk`, `ColumnMetaData` and
/// `PageHeader`, by the ids of parquet.thrift, as paths from the root.
mod field {
    pub(super) const CHILDREN: &[i16] = &[2, 5];
    pub(super) const SCHEMA_NAME: &[i16] = &[2, 4];
    pub(super) const ROWS: &[i16] = &[3];
    pub(super) const GROUP_ROWS: &[i16] = &[4, 3];
    pub(super) const PACKED: &[i16] = &[4, 1, 3, 7];
    pub(super) const DATA_PAGE: &[i16] = &[4, 1, 3, 9];
    pub(super) const DICTIONARY_PAGE: &[i16] = &[4, 1, 3, 11];
    pub(super) const PAGE_UNPACKED: &[i16] = &[2];
    pub(super) const PAGE_PACKED: &[i16] = &[3];
    pub(super) const DICTIONARY_VALUES: &[i16] = &[7, 1];
}

/// What the footer of a file claims.
#[derive(Default)]
pub(super) struct Footer {
    /// Number of children of every schema element, groups before what they hold.
    children: Vec<i64>,
    elements: usize,
    /// Number of rows of the file, then of its row groups.
    rows: Vec<i64>,
    /// Group by group, column by column.
    chunks: Vec<Chunk>,
    /// Bytes of the file.
    length: u64,
}

/// Where a column of a row group is.
#[derive(Clone, Copy, Default)]
struct Chunk {
    data: i64,
    dictionary: Option<i64>,
    packed: i64,
}

impl Footer {
    /// Read and check the footer; an empty one of files whose end is not Parquet's, which
    /// others refuse.
    ///
    /// # Errors
    /// What a file of its length cannot hold, in a sentence.
    pub fn read<R: Read + Seek>(input: &mut R) -> Result<Footer, String> {
        let length = input.seek(SeekFrom::End(0)).map_err(unread)?;
        if length < 12 {
            return Ok(Footer::default());
        }
        let mut end = [0; 8];
        input.seek(SeekFrom::Start(length - 8)).map_err(unread)?;
        input.read_exact(&mut end).map_err(unread)?;
        let size = u64::from(u32::from_le_bytes([end[0], end[1], end[2], end[3]]));
        if end[4..] != MAGIC[..] || size > length - 8 {
            return Ok(Footer::default());
        }
        if size > FOOTER {
            return Err(format!("its footer claims {size} bytes"));
        }
        let start = length - 8 - size;
        input.seek(SeekFrom::Start(start)).map_err(unread)?;
        let mut bytes = Vec::new();
        input.take(size).read_to_end(&mut bytes).map_err(unread)?;
        let footer = Footer {
            length,
            ..Footer::of(&bytes)?
        };
        footer.check(length)?;
        Ok(footer)
    }

    /// Check the pages of the columns `wanted`, of `columns` that the file has.
    ///
    /// # Errors
    /// What cannot be had of the bytes of a page.
    pub fn check_pages<R: Read + Seek>(
        &self,
        input: &mut R,
        columns: usize,
        wanted: impl Fn(usize) -> bool,
    ) -> Result<(), String> {
        let chunks = self.chunks.iter().enumerate();
        let mut wanted = chunks.filter(|(k, _)| wanted(k % columns.max(1)));
        wanted.try_for_each(|(_, chunk)| pages(input, *chunk, self.length))
    }

    fn of(bytes: &[u8]) -> Result<Footer, String> {
        let mut footer = Footer::default();
        let mut walk = Walk::new(bytes, kinds::of_footer);
        walk.structure(&mut |path, found| match (path, found) {
            (field::SCHEMA_NAME, ThriftValue::Bytes) => footer.elements += 1,
            (field::CHILDREN, ThriftValue::Number(n)) => {
                // The name of an element stands before its children.
                footer.children.resize(footer.elements, 0);
                if let Some(own) = footer.children.last_mut() {
                    *own = n;
                }
            }
            (field::ROWS | field::GROUP_ROWS, ThriftValue::Number(n)) => footer.rows.push(n),
            (field::PACKED, ThriftValue::Number(n)) => footer.chunks.push(Chunk {
                packed: n,
                ..Chunk::default()
            }),
            (field::DATA_PAGE, ThriftValue::Number(n)) => {
                footer
                    .chunks
                    .iter_mut()
                    .last()
                    .into_iter()
                    .for_each(|chunk| chunk.data = n);
            }
            (field::DICTIONARY_PAGE, ThriftValue::Number(n)) => {
                let chunk = footer.chunks.iter_mut().last();
                chunk
                    .into_iter()
                    .for_each(|chunk| chunk.dictionary = Some(n));
            }
            _ => {}
        })?;
        // What is not walked over is not looked at, and may be read all the same.
        if walk.taken() != bytes.len() {
            let after = bytes.len() - walk.taken();
            return Err(format!("its footer has {after} bytes after its end"));
        }
        footer.children.resize(footer.elements, 0);
        Ok(footer)
    }

    fn check(&self, length: u64) -> Result<(), String> {
        if self.elements > COLUMNS {
            return Err(format!("{} columns; a log has a few dozen", self.elements));
        }
        // Columns that are still to come, group within group.
        let mut open: Vec<i64> = Vec::new();
        for children in &self.children {
            while open.last() == Some(&0) {
                open.pop();
            }
            if let Some(left) = open.last_mut() {
                *left -= 1;
            }
            if *children > 0 {
                open.push(*children);
            }
            if open.len() > DEPTH {
                return Err(format!(
                    "columns nested more than {DEPTH} deep; a log is a flat table"
                ));
            }
        }
        let most = FREE_ROWS.saturating_add(ROWS_PER_BYTE.saturating_mul(length));
        let claimed = |rows: &&i64| u64::try_from(**rows).is_ok_and(|rows| rows > most);
        if let Some(rows) = self.rows.iter().find(claimed) {
            return Err(format!("it claims {rows} rows in {length} bytes"));
        }
        let packed = self.chunks.iter().map(|chunk| chunk.packed.max(0));
        let packed = packed.fold(0i64, i64::saturating_add);
        match u64::try_from(packed).is_ok_and(|packed| packed <= length) {
            true => Ok(()),
            false => Err(format!("its columns claim {packed} bytes of {length}")),
        }
    }
}

/// The pages of a column chunk, header by header.
fn pages<R: Read + Seek>(input: &mut R, chunk: Chunk, length: u64) -> Result<(), String> {
    let first = chunk.dictionary.filter(|at| *at > 0 && *at < chunk.data);
    let start = u64::try_from(first.unwrap_or(chunk.data)).unwrap_or(0);
    let end = start.saturating_add(u64::try_from(chunk.packed).unwrap_or(0));
    if end > length {
        return Err("a column that goes on past the end of the file".into());
    }
    let mut at = start;
    let mut header = Vec::new();
    while at < end {
        // Mostly a header is short; statistics with long texts are rare.
        let mut page = Page::default();
        let mut window = 256;
        let size = loop {
            input.seek(SeekFrom::Start(at)).map_err(unread)?;
            header.clear();
            let most = window.min(end - at);
            input.take(most).read_to_end(&mut header).map_err(unread)?;
            match page.read(&header) {
                Ok(size) => break size,
                Err(message) if most == end - at || window >= HEADER => return Err(message),
                Err(_) => window *= 16,
            }
        };
        page.check()?;
        let packed = u64::try_from(page.packed).map_err(|_| "a page of no size".to_string())?;
        at = at.saturating_add(size).saturating_add(packed);
    }
    Ok(())
}

/// What the header of a page claims.
#[derive(Default)]
struct Page {
    unpacked: i64,
    packed: i64,
    /// Entries.
    dictionary: i64,
}

impl Page {
    /// Read the header that `bytes` begin with; how long it is.
    fn read(&mut self, bytes: &[u8]) -> Result<u64, String> {
        *self = Page::default();
        let mut walk = Walk::new(bytes, kinds::of_page);
        walk.structure(&mut |path, found| {
            let ThriftValue::Number(n) = found else {
                return;
            };
            match path {
                field::PAGE_UNPACKED => self.unpacked = n,
                field::PAGE_PACKED => self.packed = n,
                field::DICTIONARY_VALUES => self.dictionary = n,
                _ => {}
            }
        })?;
        Ok(walk.taken() as u64)
    }

    fn check(&self) -> Result<(), String> {
        let most = FREE_BYTES.saturating_add(EXPANSION.saturating_mul(self.packed.max(0)));
        if self.unpacked > PAGE.min(most) || self.unpacked < 0 {
            return Err(format!(
                "a page of {} bytes claims to unpack to {}; write pages of a few MiB",
                self.packed, self.unpacked
            ));
        }
        if self.dictionary > self.unpacked || self.dictionary < 0 {
            return Err(format!(
                "a dictionary of {} bytes claims {} entries",
                self.unpacked, self.dictionary
            ));
        }
        Ok(())
    }
}

fn unread(error: std::io::Error) -> String {
    format!("cannot be read ({error})")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    fn varint(mut n: u64, out: &mut Vec<u8>) {
        while n >= 0x80 {
            out.push(n as u8 | 0x80);
            n >>= 7;
        }
        out.push(n as u8);
    }

    /// A file of `pages` before a footer.
    fn file(pages: &[u8], footer: &[u8]) -> Cursor<Vec<u8>> {
        let mut bytes = MAGIC.to_vec();
        bytes.extend(pages);
        bytes.extend(footer);
        bytes.extend((footer.len() as u32).to_le_bytes());
        bytes.extend(MAGIC);
        Cursor::new(bytes)
    }

    /// `FileMetaData` of one group: rows, and a chunk of `packed` bytes from byte 4.
    fn footer(rows: i64, packed: i64) -> Vec<u8> {
        let zigzag = |n: i64| ((n << 1) ^ (n >> 63)) as u64;
        let mut out = vec![0x36];
        varint(zigzag(rows), &mut out);
        // row_groups: a list of one structure; columns: a list of one; meta_data.
        out.extend([0x19, 0x1c, 0x19, 0x1c, 0x3c, 0x76]);
        varint(zigzag(packed), &mut out);
        out.push(0x26);
        varint(zigzag(4), &mut out);
        out.extend([0, 0, 0x26]);
        varint(zigzag(rows), &mut out);
        out.extend([0, 0]);
        out
    }

    /// The header of a dictionary page.
    fn dictionary(unpacked: i64, packed: i64, entries: i64) -> Vec<u8> {
        let mut out = vec![0x15, 0x04, 0x15];
        varint((unpacked << 1) as u64, &mut out);
        out.push(0x15);
        varint((packed << 1) as u64, &mut out);
        out.extend([0x4c, 0x15]);
        varint((entries << 1) as u64, &mut out);
        out.extend([0, 0]);
        out
    }

    #[test]
    fn claims_beyond_the_bytes_are_refused() {
        let page = |unpacked, entries| {
            let mut page = dictionary(unpacked, 8, entries);
            page.extend([0; 8]);
            page
        };
        let good = page(8, 1);
        let with = |page: &[u8], rows, packed| {
            let mut file = file(page, &footer(rows, packed));
            Footer::read(&mut file)?.check_pages(&mut file, 1, |_| true)
        };
        let size = good.len() as i64;
        assert_eq!(with(&good, 100, size), Ok(()));
        let refused = |page: &[u8], rows, word: &str| {
            let message = with(page, rows, page.len() as i64).unwrap_err();
            assert!(message.contains(word), "{message}");
        };
        refused(&page(8, i64::from(i32::MAX)), 100, "entries");
        refused(&page(1 << 30, 1), 100, "unpack");
        refused(&good, i64::from(i32::MAX), "rows");
        // A field that the format lacks: a map of one flag to a number.
        let mut mapped = good.clone();
        mapped.truncate(mapped.len() - 9);
        mapped.extend([0x2b, 1, 0x25, 1, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
        refused(&mapped, 100, "map");
        assert!(with(&good, 100, 1 << 40).unwrap_err().contains("bytes"));
    }

    #[test]
    fn lists_and_schemas_without_end_are_refused() {
        // Unknown lists of 2³¹ − 1 flags, as `skip` would count them.
        let mut endless = vec![0x09, 0x28, 0xf1];
        varint((1 << 31) - 1, &mut endless);
        assert!(Footer::read(&mut file(&[], &endless)).is_err());
        // Groups of one group each: num_children (5) and name (4) of every element.
        let mut deep = vec![0x29, 0xfc];
        varint(10_000, &mut deep);
        for _ in 0..10_000 {
            deep.extend([0x48, 0x01, b'a', 0x15, 0x02, 0]);
        }
        deep.push(0);
        let message = Footer::read(&mut file(&[], &deep)).err().unwrap();
        assert!(message.contains("nested"), "{message}");
        // Structures within each other, in fields that the format lacks.
        let within = [0xfc].repeat(100_000);
        let message = Footer::read(&mut file(&[], &within)).err().unwrap();
        assert!(message.contains("nested"), "{message}");
    }
}
