//! The bytes of a factor file.
//!
//! ```text
//! gzip of {"format":"sesc factor 4", robot, unit, options, logs, folds: parameters and rows of factors …}
//! upper triangles row by row, 64-bit floats, little-endian: fold by fold, weighted, then plain
//! ```
//!
//! The header may also stand as it is, with a newline behind it.
//! Format 3 knew neither the unit nor the options that shaped the sums, and is of the same bytes
//! otherwise. Of the formats before it, the triangles stood in the JSON; 1 knew neither visits nor what rows
//! are worth, and its rows are taken as independent.

use std::io::{Read as _, Write as _};

use flate2::Compression;
use flate2::bufread::GzDecoder;
use flate2::write::GzEncoder;
use serde::Deserialize;
use serde_json::{Value, json};

use super::Part;
use crate::lsq::factor::Factor;

/// First words of every file of this kind, with the version of its layout.
pub(super) const FORMAT: &str = "sesc factor 4";
/// The one before it, of the same layout.
const ALIKE: &str = "sesc factor 3";
/// Those before, which are JSON throughout.
const BEFORE: [&str; 2] = ["sesc factor 1", "sesc factor 2"];

/// First bytes of gzip.
const GZIP: [u8; 2] = [0x1f, 0x8b];
/// A packed header is at most so many times larger unpacked, beyond a mebibyte.
const PACKED: u64 = 64;

/// Largest file of a format before, which had its numbers as text: a robot of 40 joints takes
/// 2 MB.
const OLDER: usize = 16 << 20;

/// Bytes of one number.
const NUMBER: usize = size_of::<f64>();

#[derive(Deserialize)]
struct Kind {
    format: String,
}

/// How many numbers a header says that follow it.
#[derive(Deserialize)]
struct Sizes {
    gathered: Folds,
}

#[derive(Deserialize)]
struct Folds {
    folds: Vec<Fold>,
}

#[derive(Deserialize)]
struct Fold {
    weighted: Size,
    plain: Option<Size>,
}

#[derive(Deserialize)]
struct Size {
    params: usize,
}

impl Sizes {
    /// None where they cannot be counted.
    fn bytes(&self) -> Option<usize> {
        let folds = self.gathered.folds.iter();
        let mut sizes = folds.flat_map(|fold| [Some(&fold.weighted), fold.plain.as_ref()]);
        let sum = sizes.try_fold(0_usize, |sum, size| match size {
            Some(size) => sum.checked_add(Factor::numbers_of(size.params)?),
            None => Some(sum),
        });
        sum?.checked_mul(NUMBER)
    }
}

/// The bytes of a part.
pub(super) fn written(part: &Part) -> Result<Vec<u8>, serde_json::Error> {
    let header = serde_json::to_vec(part)?;
    let mut packed = GzEncoder::new(Vec::new(), Compression::default());
    let packed = packed.write_all(&header).and_then(|()| packed.finish());
    let mut bytes = match packed {
        Ok(packed) if header.len() as u64 <= most_unpacked(packed.len()) => packed,
        _ => [&header[..], b"\n"].concat(),
    };
    for fold in &part.gathered.folds {
        for factor in [Some(&fold.weighted), fold.plain.as_ref()] {
            let numbers = factor.into_iter().flat_map(Factor::numbers);
            bytes.extend(numbers.flat_map(f64::to_le_bytes));
        }
    }
    Ok(bytes)
}

/// Largest header that so many packed bytes may hold.
fn most_unpacked(packed: usize) -> u64 {
    (1 << 20) + PACKED * packed as u64
}

/// A part from its bytes, of this format or one before.
pub(super) fn read(bytes: &[u8]) -> Result<Part, String> {
    if bytes.starts_with(&GZIP) {
        let mut decoder = GzDecoder::new(bytes);
        let (mut header, most) = (Vec::new(), most_unpacked(bytes.len()));
        let read = decoder.by_ref().take(most + 1).read_to_end(&mut header);
        read.map_err(damaged)?;
        if header.len() as u64 > most {
            return Err(damaged("its header is too long"));
        }
        return current(&header, decoder.into_inner());
    }
    let foreign =
        |error: serde_json::Error| format!("no factor file of a fit that only gathers: {error}");
    let mut kinds = serde_json::Deserializer::from_slice(bytes).into_iter::<Kind>();
    let kind = match kinds.next() {
        Some(kind) => kind.map_err(foreign)?,
        None => return Err("no factor file of a fit that only gathers: it is empty".to_string()),
    };
    let (header, rest) = bytes.split_at(kinds.byte_offset());
    let mut part: Part = match kind.format.as_str() {
        FORMAT | ALIKE => return current(header, rest.strip_prefix(b"\n").unwrap_or(rest)),
        before if !BEFORE.contains(&before) => {
            return Err(newer(before));
        }
        _ if bytes.len() > OLDER => {
            return Err(format!(
                "a factor file of an older format is not longer than {} MiB; gather the log again",
                OLDER >> 20
            ));
        }
        _ if !rest.trim_ascii().is_empty() => {
            return Err("more than a factor file; gather the log again".to_string());
        }
        before if before == BEFORE[0] => {
            let value = serde_json::from_slice(header).map_err(foreign)?;
            let value = with_samples(value).ok_or("it lacks sums; gather the log again")?;
            serde_json::from_value(value).map_err(foreign)?
        }
        _ => serde_json::from_slice(header).map_err(foreign)?,
    };
    part.format = FORMAT.to_string();
    Ok(part)
}

fn damaged(reason: impl std::fmt::Display) -> String {
    format!("a damaged factor file: {reason}; gather the log again")
}

fn newer(format: &str) -> String {
    format!(
        "it is `{format}`, and this version of sesc reads formats up to `{FORMAT}`; take the \
         version that wrote it, or gather the log again"
    )
}

fn current(header: &[u8], numbers: &[u8]) -> Result<Part, String> {
    let kind: Kind = serde_json::from_slice(header).map_err(damaged)?;
    if kind.format != FORMAT && kind.format != ALIKE {
        return Err(newer(&kind.format));
    }
    // Counted before anything as large is made.
    let sizes: Sizes = serde_json::from_slice(header).map_err(damaged)?;
    if sizes.bytes() != Some(numbers.len()) {
        return Err(damaged(format!(
            "{} bytes of numbers follow its header, which says {}",
            numbers.len(),
            sizes.bytes().map_or("more".to_string(), |n| n.to_string())
        )));
    }
    let mut part: Part = serde_json::from_slice(header).map_err(damaged)?;
    part.format = FORMAT.to_string();
    let (numbers, _) = numbers.as_chunks::<NUMBER>();
    let mut numbers = numbers.iter().map(|bytes| f64::from_le_bytes(*bytes));
    for fold in &mut part.gathered.folds {
        for factor in [Some(&mut fold.weighted), fold.plain.as_mut()] {
            let Some(factor) = factor else { continue };
            let count = Factor::numbers_of(factor.params()).unwrap_or(0);
            factor.fill(numbers.by_ref().take(count));
        }
    }
    Ok(part)
}

/// What format 1 did not know: rows are independent, and repeats are of one visit each.
fn with_samples(mut part: Value) -> Option<Value> {
    let gathered = part.get_mut("gathered")?;
    let number = |value: &Value, key: &str| value.get(key)?.as_f64();
    let rows = gathered.get("readings")?.as_u64()?;
    let stated = number(gathered, "stated")?;
    let repeats = gathered.get("replicates")?;
    let half = |key: &str| number(repeats, key).map(|sum| [0.5 * sum; 2]);
    let squares = json!({
        "sum": half("sum")?,
        "weighted": half("weighted_sum")?,
        "df": repeats.get("df")?.as_u64()? / 2,
    });
    let postures = repeats.get("groups")?.as_u64()?;
    let variances = match stated > 0.0 {
        true => 0.5 * stated,
        false => rows as f64,
    };
    let known = json!({
        "replicates": {
            "about_postures": squares,
            "about_visits": squares,
            "postures": postures,
            "visits": postures,
            "rows": rows,
        },
        "samples": {
            "rows": rows,
            "independent": rows as f64,
            "correlation_s": 0.0,
            "assumed": true,
        },
        "axes": [variances, variances],
        "correlated": false,
    });
    for (key, value) in known.as_object()? {
        gathered[key.as_str()] = value.clone();
    }
    Some(part)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A part of the format before: 40 readings of 20 postures of a pole of 2 kg.
    const MONDAY: &[u8] = include_bytes!("monday-2.part");
    /// The same one, written in format 3.
    const MONDAY_3: &[u8] = include_bytes!("monday-3.part");

    /// The packed header of a part, as JSON, and the numbers behind it.
    fn header(bytes: &[u8]) -> (Value, Vec<u8>) {
        let mut decoder = GzDecoder::new(bytes);
        let mut text = String::new();
        decoder.read_to_string(&mut text).unwrap();
        (
            serde_json::from_str(&text).unwrap(),
            decoder.into_inner().to_vec(),
        )
    }

    fn with_header(header: &Value, numbers: &[u8]) -> Vec<u8> {
        [header.to_string().as_bytes(), b"\n", numbers].concat()
    }

    #[test]
    fn parts_of_the_format_before_are_read_and_written_anew() {
        let part = Part::from_bytes(MONDAY, "monday.part").unwrap();
        assert_eq!((part.postures(), part.support.as_str()), (20, "foot"));
        let bytes = part.to_bytes().unwrap();
        let again = Part::from_bytes(&bytes, "monday.part").unwrap();
        assert_eq!(again.gathered, part.gathered);
        assert_eq!(again.urdf, part.urdf);
        // Two triangles of six columns in each of ten folds, to the bit.
        let (mut header, numbers) = header(&bytes);
        assert_eq!(numbers.len(), 2 * 10 * 21 * 8);
        let before: Value = serde_json::from_slice(MONDAY).unwrap();
        let first = &before["gathered"]["folds"][0]["weighted"]["triangle"];
        for (k, x) in first.as_array().unwrap().iter().enumerate() {
            let bytes = numbers[8 * k..][..8].try_into().unwrap();
            assert_eq!(x.as_f64(), Some(f64::from_le_bytes(bytes)));
        }
        // A header that is not packed is read too.
        let plain = Part::from_bytes(&with_header(&header, &numbers), "plain").unwrap();
        assert_eq!(plain.gathered, part.gathered);
        header["format"] = "sesc factor 5".into();
        let said = read(&with_header(&header, &numbers)).unwrap_err();
        assert!(said.contains("`sesc factor 5`"), "{said}");
        assert!(said.contains("take the version that wrote it"), "{said}");
    }

    #[test]
    fn parts_of_format_3_are_read_and_do_not_say_how_they_were_gathered() {
        let part = Part::from_bytes(MONDAY_3, "monday.part").unwrap();
        assert_eq!((part.postures(), part.support.as_str()), (20, "foot"));
        assert_eq!((&part.unit, &part.options), (&None, &None));
        // The same readings as in format 2, to the bit.
        let before = Part::from_bytes(MONDAY, "monday.part").unwrap();
        assert_eq!(part.gathered, before.gathered);
        let (written, _) = header(&part.to_bytes().unwrap());
        assert_eq!(written["format"], "sesc factor 4");
    }

    #[test]
    fn parts_of_format_1_have_independent_rows() {
        let mut older: Value = serde_json::from_slice(MONDAY).unwrap();
        older["format"] = "sesc factor 1".into();
        let gathered = older["gathered"].as_object_mut().unwrap();
        for key in [
            "samples",
            "axes",
            "correlated",
            "motion",
            "closure",
            "again",
        ] {
            gathered.remove(key);
        }
        let squares = gathered["replicates"]["about_postures"].clone();
        let sum = |key: &str| {
            let axes = squares[key].as_array().unwrap();
            axes.iter().map(|x| x.as_f64().unwrap()).sum::<f64>()
        };
        gathered["replicates"] = json!({
            "sum": sum("sum"),
            "weighted_sum": sum("weighted"),
            "df": 2 * squares["df"].as_u64().unwrap(),
            "groups": 20,
        });
        let part = Part::from_bytes(older.to_string().as_bytes(), "older.part").unwrap();
        let now = Part::from_bytes(MONDAY, "monday.part").unwrap();
        assert_eq!(part.gathered.folds, now.gathered.folds);
        assert_eq!(part.postures(), 20);
        let (older, now) = (part.gathered.repeats, now.gathered.repeats);
        assert_eq!(older.about_postures.df, now.about_postures.df);
        let both = |axes: [f64; 2]| axes[0] + axes[1];
        let (older, now) = (older.about_postures.sum, now.about_postures.sum);
        assert!((both(older) - both(now)).abs() < 1e-12 * both(now));
    }

    #[test]
    fn damaged_parts_are_refused_before_memory_is_taken() {
        let bytes = Part::from_bytes(MONDAY, "monday.part").unwrap();
        let bytes = bytes.to_bytes().unwrap();
        let (whole, numbers) = header(&bytes);
        for cut in [1, 8, 4000, bytes.len() - 5] {
            let said = read(&bytes[..bytes.len() - cut]).unwrap_err();
            assert!(said.contains("damaged"), "{cut}: {said}");
        }
        let mut changed = whole.clone();
        changed["gathered"]["folds"][0]["weighted"]["params"] = 1_000_000_000_u64.into();
        let said = read(&with_header(&changed, &numbers)).unwrap_err();
        assert!(said.contains("3360 bytes of numbers"), "{said}");
        let mut odd = numbers.clone();
        odd[..8].copy_from_slice(&f64::NAN.to_le_bytes());
        let said = Part::from_bytes(&with_header(&whole, &odd), "odd.part").unwrap_err();
        assert!(said.to_string().contains("`triangle`"), "{said}");
        let mut bomb = GzEncoder::new(Vec::new(), Compression::best());
        bomb.write_all(&vec![b' '; 1 << 24]).unwrap();
        let said = read(&bomb.finish().unwrap()).unwrap_err();
        assert!(said.contains("too long"), "{said}");
    }
}
