//! What a Parquet file claims, held against its bytes before the library acts on it.
//!
//! The library reserves memory for what headers claim, recurses as deep as a schema is nested, and
//! passes over unknown lists item by item, of which flags take no bytes: 400 bytes keep it busy for
//! hours. Footer and page headers are walked beforehand:
//!
//! ```text
//! footer             ≤ 64 MiB, every list ≤ its bytes, no lists of flags, no maps
//! schema             200 columns may hold columns
//! columns, chunks    ≤ 500 000, together no longer than the file
//! rows               ≤ 10⁶ + 1000 per byte of the file
//! page that is read  unpacked ≤ 64 MiB and ≤ 4 MiB + 200 × packed
//! dictionary         entries ≤ its bytes
//! ```
//!
//! Both are in Thrift's compact protocol:
//!
//! ```text
//! structure   fields, 0            field   delta of id << 4 | type; value
//! list        items << 4 | type, or 15 << 4 | type and count; values
//! ```

use std::io::{self, Read};
use std::sync::Arc;

use parquet::basic::Compression;
use parquet::column::page::PageReader;
use parquet::errors::{ParquetError, Result};
use parquet::file::metadata::{ColumnChunkMetaData, ParquetMetaData, ParquetMetaDataReader};
use parquet::file::reader::ChunkReader;
use parquet::file::serialized_reader::SerializedPageReader;

/// An unpacked page, bytes.
const PAGE: i64 = 64 << 20;
/// What is said of a file that is encrypted.
pub(super) const ENCRYPTED: &str = "encrypted";

fn refused<T>(message: String) -> Result<T> {
    Err(ParquetError::General(message))
}

/// The file's footer, and the rows of its groups.
///
/// # Errors
/// What a file of its length cannot hold, in a sentence.
pub(super) fn footer(input: &impl ChunkReader) -> Result<(ParquetMetaData, u64)> {
    let length = input.len();
    let Some(end) = length.checked_sub(8) else {
        return refused("it has less than eight bytes".into());
    };
    let tail = input.get_bytes(end, 8)?;
    let size = u64::from(u32::from_le_bytes([tail[0], tail[1], tail[2], tail[3]]));
    match &tail[4..] {
        b"PAR1" if size <= end.min(64 << 20) => {}
        b"PAR1" => return refused(format!("its footer claims {size} bytes")),
        b"PARE" => return refused(ENCRYPTED.into()),
        _ => return refused("it does not end like one".into()),
    }
    let footer = input.get_bytes(end - size, size as usize)?;
    let (mut nested, mut chunks, mut is_encrypted) = (0, 0, false);
    Walk::new(&footer, kinds_of_footer).structure(&mut |path, n| match path {
        // Whatever is left of a number of more bits than it should have.
        [2, 5] if n != 0 => nested += 1,
        [2] | [4] | [4, 1] => chunks += n,
        [8] => is_encrypted = true,
        _ => {}
    })?;
    if is_encrypted {
        return refused(ENCRYPTED.into());
    } else if nested > 200 {
        return refused(format!("{nested} nested columns; a log is a flat table"));
    } else if chunks > 500_000 {
        return refused(format!(
            "{chunks} columns of row groups; write larger groups"
        ));
    }
    let about = ParquetMetaDataReader::decode_metadata(&footer)?;
    let add = |sum: u64, n: i64| sum.saturating_add(n.max(0) as u64);
    let groups = about.row_groups().iter();
    let rows = groups.clone().map(|group| group.num_rows()).fold(0, add);
    if rows > 1_000_000_u64.saturating_add(length.saturating_mul(1000)) {
        return refused(format!("it claims {rows} rows in {length} bytes"));
    }
    let chunks = groups.flat_map(|group| group.columns());
    let packed = chunks.map(|chunk| chunk.compressed_size()).fold(0, add);
    if packed > length {
        return refused(format!("its columns claim {packed} bytes of {length}"));
    }
    Ok((about, rows))
}

/// The pages of a chunk of a column, each held against its bytes before it is unpacked.
pub(super) fn pages<R: ChunkReader + 'static>(
    input: &Arc<R>,
    chunk: &ColumnChunkMetaData,
    rows: usize,
) -> Result<Box<dyn PageReader>> {
    let (mut at, length) = chunk.byte_range();
    let end = at.saturating_add(length);
    let is_gzip = matches!(chunk.compression(), Compression::GZIP(_));
    while at < end {
        at = check_page(&**input, at, is_gzip)?;
    }
    let pages = SerializedPageReader::new(input.clone(), chunk, rows, None)?;
    Ok(Box::new(pages))
}

/// Check the page whose header begins at `at`; where the next one begins.
fn check_page(input: &impl ChunkReader, at: u64, is_gzip: bool) -> Result<u64> {
    let left = usize::try_from(input.len().saturating_sub(at)).unwrap_or(usize::MAX);
    let [mut unpacked, mut packed, mut entries, mut levels] = [0i64; 4];
    // Mostly a header is short; statistics with long texts are rare.
    let mut window = 256;
    let header = loop {
        let bytes = input.get_bytes(at, left.min(window))?;
        let mut walk = Walk::new(&bytes, kinds_of_page);
        let walked = walk.structure(&mut |path, n| match path {
            [2] => unpacked = n,
            [3] => packed = n,
            [7, 1] => entries = n,
            [8, 5 | 6] => levels += n.clamp(0, PAGE + 1),
            _ => {}
        });
        match walked {
            Ok(()) => break bytes.len() - walk.left.len(),
            Err(error) if left <= window || window >= 1 << 20 => return Err(error),
            Err(_) => (window, levels) = (window * 16, 0),
        }
    };
    let most = packed.max(0).saturating_mul(200).saturating_add(4 << 20);
    if unpacked > PAGE.min(most) || unpacked < levels || packed < 0 {
        return refused(format!(
            "a page of {packed} bytes claims to unpack to {unpacked}; write pages of a few MiB"
        ));
    }
    if entries > unpacked || entries < 0 {
        return refused(format!(
            "a dictionary of {unpacked} bytes claims {entries} entries"
        ));
    }
    let at = at + header as u64;
    // The other ways of packing keep to what the header says.
    if is_gzip && packed > levels {
        let page = input.get_bytes(at + levels as u64, (packed - levels) as usize)?;
        let mut page = flate2::read::MultiGzDecoder::new(&*page).take(unpacked as u64 + 1);
        if io::copy(&mut page, &mut io::sink()).is_ok_and(|size| size > unpacked as u64) {
            return refused(format!(
                "a page unpacks to more than the {unpacked} it claims"
            ));
        }
    }
    Ok(at + packed as u64)
}

/// Kinds of the fields of a structure by their ids from 1: number, y for a byte, bytes, structure,
/// list; a full stop is whatever the library checks itself. It takes a field for what the format
/// says, whatever the field's head says: where the two differ, lists that this walk never saw
/// would be the library's. `path` has the ids of the fields from `FileMetaData`.
fn kinds_of_footer(path: &[i16]) -> &'static [u8] {
    match path {
        [] => b"nlnllblsb",
        // SchemaElement, its LogicalType, and what these hold.
        [2] => b"nnnbnnnnns",
        [2, 10] => &[b's'; 24],
        [2, 10, 5] => b"nn",
        [2, 10, 7 | 8] => b".s",
        [2, 10, 7 | 8, 2] | [7] => b"sss",
        [2, 10, 10] => b"y.",
        [2, 10, 16] => b"y",
        [2, 10, 17 | 18] => b"bn",
        // KeyValue, of the file and of a column.
        [5] | [4, 1, 3, 8] => b"bb",
        // RowGroup, its SortingColumn, ColumnChunk, and its ColumnMetaData.
        [4] => b"lnnlnnn",
        [4, 4] => b"n..",
        [4, 1] => b"bnsnnnnsb",
        [4, 1, 3] => b"nllnnnnlnnnslnnss",
        [4, 1, 3, 12] => STATISTICS,
        // PageEncodingStats, SizeStatistics, GeospatialStatistics and its BoundingBox.
        [4, 1, 3, 13] => b"nnn",
        [4, 1, 3, 16] => b"nll",
        [4, 1, 3, 17] => b"sl",
        [4, 1, 3, 17, 1] => b"dddddddd",
        _ => b"",
    }
}

/// The same from `PageHeader`.
fn kinds_of_page(path: &[i16]) -> &'static [u8] {
    match path {
        [] => b"nnnnssss",
        [5] => b"nnnns",
        [7] => b"nn.",
        [8] => b"nnnnnn.s",
        [5, 5] | [8, 8] => STATISTICS,
        _ => b"",
    }
}

/// Kinds by their numbers in the heads of fields, from 0; of some the format has no field.
const KINDS: [u8; 16] = *b"???ynnndbl??s???";

/// Statistics, in the footer and before a page.
const STATISTICS: &[u8] = b"bbnnbb..n";

/// A walk over bytes.
struct Walk<'a> {
    left: &'a [u8],
    /// Ids of the fields from the root; items of lists have that of the list.
    path: Vec<i16>,
    kinds: fn(&[i16]) -> &'static [u8],
}

/// Hears of every number, of how many items a list has, and of structures.
type See<'a> = &'a mut dyn FnMut(&[i16], i64);

impl<'a> Walk<'a> {
    fn new(left: &'a [u8], kinds: fn(&[i16]) -> &'static [u8]) -> Walk<'a> {
        Walk {
            left,
            path: Vec::new(),
            kinds,
        }
    }

    fn structure(&mut self, see: See) -> Result<()> {
        if self.path.len() > 32 {
            return refused("structures nested more than 32 deep".into());
        }
        let kinds = (self.kinds)(&self.path);
        let mut id = 0i16;
        loop {
            let head = self.take(1)?[0];
            let (delta, kind) = (i16::from(head >> 4), head & 15);
            if kind == 0 {
                return Ok(());
            }
            id = id.saturating_add(delta);
            let known = kinds.get(id as usize - usize::from(id > 0));
            let is_so = known.is_none_or(|own| [b'.', KINDS[usize::from(kind)]].contains(own));
            self.path.push(id);
            // Ids that do not follow each other are written in another way.
            if delta == 0 || !is_so {
                let ids: Vec<String> = self.path.iter().map(i16::to_string).collect();
                let field = ids.join(".");
                return refused(format!(
                    "field {field} of another kind than the format has it"
                ));
            }
            self.value(kind, see)?;
            self.path.pop();
        }
    }

    fn value(&mut self, kind: u8, see: See) -> Result<()> {
        match kind {
            // In a field a flag is its own value.
            1 | 2 => {}
            3 => drop(self.take(1)?),
            4..=6 => {
                let n = self.varint()?;
                see(&self.path, (n >> 1) as i64 ^ -((n & 1) as i64));
            }
            7 => drop(self.take(8)?),
            8 => {
                let length = self.varint()?;
                self.take(usize::try_from(length).unwrap_or(usize::MAX))?;
            }
            9 => {
                let head = self.take(1)?[0];
                let count = match head >> 4 {
                    15 => self.varint()?,
                    few => u64::from(few),
                };
                let left = self.left.len();
                if count > left as u64 {
                    return refused(format!("a list that claims {count} items in {left} bytes"));
                }
                see(&self.path, count as i64);
                // Of flags readers disagree on how long they are.
                if count > 0 && !matches!(head & 15, 3..=8 | 12) {
                    return refused("a list of flags or lists".into());
                }
                (0..count).try_for_each(|_| self.value(head & 15, see))?;
            }
            12 => {
                see(&self.path, 0);
                self.structure(see)?;
            }
            _ => return refused("a map, of which the format has none".into()),
        }
        Ok(())
    }

    fn take(&mut self, count: usize) -> Result<&'a [u8]> {
        let Some((taken, left)) = self.left.split_at_checked(count) else {
            return refused("a header that ends too soon".into());
        };
        self.left = left;
        Ok(taken)
    }

    fn varint(&mut self) -> Result<u64> {
        let mut n = 0u64;
        for shift in (0..64).step_by(7) {
            let byte = self.take(1)?[0];
            n |= u64::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Ok(n);
            }
        }
        refused("a number of more than 64 bits".into())
    }
}
