//! Thrift's compact protocol, walked without reserving anything.
//!
//! ```text
//! structure   fields, 0            field   delta of id << 4 | type, or type and id; value
//! list        items << 4 | type, or 15 << 4 | type and count; values
//! map         count, key type << 4 | value type; pairs
//! ```

/// A value that was met.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum ThriftValue {
    /// A whole number of any width.
    Number(i64),
    /// Text or bytes.
    Bytes,
}

/// Structures within each other; those of Parquet are a few levels deep.
const DEPTH: usize = 32;

use super::kinds::Kind;

/// A walk over bytes.
pub(super) struct Walk<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Ids of the fields from the root; items of lists have that of the list.
    path: Vec<i16>,
    depth: usize,
    /// What the fields of a path have to be, where that is known.
    kinds: fn(&[i16]) -> Option<Kind>,
}

impl<'a> Walk<'a> {
    pub fn new(bytes: &'a [u8], kinds: fn(&[i16]) -> Option<Kind>) -> Walk<'a> {
        Walk {
            bytes,
            kinds,
            at: 0,
            path: Vec::new(),
            depth: 0,
        }
    }

    /// Bytes that were walked over.
    pub fn taken(&self) -> usize {
        self.at
    }

    /// A structure: `see` hears of every value with the path of its fields.
    pub fn structure(&mut self, see: &mut dyn FnMut(&[i16], ThriftValue)) -> Result<(), String> {
        self.depth += 1;
        if self.depth > DEPTH {
            return Err(format!("structures nested more than {DEPTH} deep"));
        }
        let mut id = 0i16;
        loop {
            let head = self.byte()?;
            let kind = head & 0x0f;
            if kind == 0 {
                break;
            }
            id = match head >> 4 {
                0 => i16::try_from(self.number()?).map_err(|_| "a field without a name")?,
                delta => id.saturating_add(i16::from(delta)),
            };
            self.path.push(id);
            if (self.kinds)(&self.path).is_some_and(|known| !known.has_head(kind)) {
                return Err(self.other_kind());
            }
            // In a field a flag is its own value.
            if kind > 2 {
                self.value(kind, see)?;
            }
            self.path.pop();
        }
        self.depth -= 1;
        Ok(())
    }

    fn value(&mut self, kind: u8, see: &mut dyn FnMut(&[i16], ThriftValue)) -> Result<(), String> {
        match kind {
            1..=3 => self.take(1),
            4..=6 => {
                let n = self.number()?;
                see(&self.path, ThriftValue::Number(n));
                Ok(())
            }
            7 => self.take(8),
            8 => {
                let length = self.varint()?;
                self.take(usize::try_from(length).unwrap_or(usize::MAX))?;
                see(&self.path, ThriftValue::Bytes);
                Ok(())
            }
            9 | 10 => {
                let head = self.byte()?;
                let count = match head >> 4 {
                    15 => self.varint()?,
                    few => u64::from(few),
                };
                self.check_count(count)?;
                let known = (self.kinds)(&self.path);
                if count > 0 && known.is_some_and(|known| !known.has_items(head & 0x0f)) {
                    return Err(self.other_kind());
                }
                // Readers disagree on how long these are.
                if count > 0 && matches!(head & 0x0f, 1 | 2) {
                    return Err("a list of flags".into());
                }
                (0..count).try_for_each(|_| self.item(head & 0x0f, see))
            }
            // The format has no maps, and readers disagree on how long flags in them are.
            11 => match self.varint()? {
                0 => Ok(()),
                _ => Err("a map, of which the format has none".into()),
            },
            12 => self.structure(see),
            // An identifier of 16 bytes.
            13 => self.take(16),
            _ => Err("a value of an unknown kind".into()),
        }
    }

    /// An item of a list; lists of lists count as structures within each other.
    fn item(&mut self, kind: u8, see: &mut dyn FnMut(&[i16], ThriftValue)) -> Result<(), String> {
        self.depth += 1;
        if self.depth > DEPTH {
            return Err(format!("structures nested more than {DEPTH} deep"));
        }
        self.value(kind, see)?;
        self.depth -= 1;
        Ok(())
    }

    fn other_kind(&self) -> String {
        let ids: Vec<String> = self.path.iter().map(i16::to_string).collect();
        format!(
            "field {} of another kind than the format has it",
            ids.join(".")
        )
    }

    /// Every item takes a byte or more.
    fn check_count(&self, count: u64) -> Result<(), String> {
        let left = self.bytes.len() - self.at;
        match usize::try_from(count).is_ok_and(|count| count <= left) {
            true => Ok(()),
            false => Err(format!("a list that claims {count} items in {left} bytes")),
        }
    }

    fn take(&mut self, count: usize) -> Result<(), String> {
        match count <= self.bytes.len() - self.at {
            true => {
                self.at += count;
                Ok(())
            }
            false => Err("a header that ends too soon".into()),
        }
    }

    fn byte(&mut self) -> Result<u8, String> {
        self.take(1)?;
        Ok(self.bytes[self.at - 1])
    }

    fn varint(&mut self) -> Result<u64, String> {
        let mut n = 0u64;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            n |= u64::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Ok(n);
            }
        }
        Err("a number of more than 64 bits".into())
    }

    /// A signed number, zigzag.
    fn number(&mut self) -> Result<i64, String> {
        let n = self.varint()?;
        Ok((n >> 1) as i64 ^ -((n & 1) as i64))
    }
}
