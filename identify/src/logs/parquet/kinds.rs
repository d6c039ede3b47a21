//! Of what kind the fields of Parquet's structures are, by the ids of parquet.thrift.
//!
//! A reader that takes a field for what the format says it is, and a walk that takes it for
//! what its head says, part ways where the two differ: lists that one of them never saw would
//! be the other's. Such a file is refused.

/// What a field holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Kind {
    /// A whole number of 16 to 64 bits.
    Number,
    Flag,
    Bytes,
    Structure,
    Numbers,
    Texts,
    Structures,
}

use Kind::{Bytes, Flag, Number, Numbers, Structure, Structures, Texts};

impl Kind {
    /// Whether a head of Thrift's compact protocol says so.
    pub fn has_head(self, head: u8) -> bool {
        match self {
            Number => (4..=6).contains(&head),
            Flag => matches!(head, 1 | 2),
            Bytes => head == 8,
            Structure => head == 12,
            Numbers | Texts | Structures => head == 9,
        }
    }

    /// Whether a list has items of this head.
    pub fn has_items(self, head: u8) -> bool {
        match self {
            Numbers => Number.has_head(head),
            Texts => Bytes.has_head(head),
            Structures => Structure.has_head(head),
            Number | Flag | Bytes | Structure => false,
        }
    }
}

/// A field of `FileMetaData`, by the ids from the root.
pub(super) fn of_footer(path: &[i16]) -> Option<Kind> {
    Some(match path {
        [1 | 3] => Number,
        [2 | 4 | 5 | 7] => Structures,
        [6 | 9] => Bytes,
        [8] => Structure,
        // Elements of the schema.
        [2, 1..=3 | 5..=9] => Number,
        [2, 4] => Bytes,
        [2, 10] => Structure,
        // Keys and values, of the file and of a column.
        [5, 1 | 2] | [4, 1, 3, 8, 1 | 2] => Bytes,
        // Row groups, and how they are sorted.
        [4, 1 | 4] => Structures,
        [4, 2 | 3 | 5..=7] | [4, 4, 1] => Number,
        [4, 4, 2 | 3] => Flag,
        // Chunks of columns.
        [4, 1, 1 | 9] => Bytes,
        [4, 1, 2 | 4..=7] => Number,
        [4, 1, 3 | 8] => Structure,
        // What is said of them.
        [4, 1, 3, 1 | 4..=7 | 9..=11 | 14 | 15] => Number,
        [4, 1, 3, 2] => Numbers,
        [4, 1, 3, 3] => Texts,
        [4, 1, 3, 8 | 13] => Structures,
        [4, 1, 3, 12 | 16 | 17] => Structure,
        [4, 1, 3, 12, id] => return statistics(*id),
        [4, 1, 3, 13, 1..=3] | [4, 1, 3, 16, 1] => Number,
        [4, 1, 3, 16, 2 | 3] => Numbers,
        _ => return None,
    })
}

/// A field of `PageHeader`.
pub(super) fn of_page(path: &[i16]) -> Option<Kind> {
    Some(match path {
        [1..=4] | [5, 1..=4] | [7, 1 | 2] | [8, 1..=6] => Number,
        [5..=8] | [5, 5] | [8, 8] => Structure,
        [7, 3] | [8, 7] => Flag,
        [5, 5, id] | [8, 8, id] => return statistics(*id),
        _ => return None,
    })
}

fn statistics(id: i16) -> Option<Kind> {
    Some(match id {
        1 | 2 | 5 | 6 => Bytes,
        3 | 4 => Number,
        7 | 8 => Flag,
        _ => return None,
    })
}
