//! Recordings whose records are put together byte by byte, as the standard says; the bytes of
//! messages are held against it where they are read and written.

mod moving;

use super::super::tests::{dofs, log, read_file};
use super::*;
use crate::tests::says;

/// A record: opcode, length, content.
fn record(opcode: u8, content: &[u8]) -> Vec<u8> {
    let mut bytes = vec![opcode];
    bytes.extend((content.len() as u64).to_le_bytes());
    bytes.extend(content);
    bytes
}

fn string(text: &str) -> Vec<u8> {
    let mut bytes = (text.len() as u32).to_le_bytes().to_vec();
    bytes.extend(text.as_bytes());
    bytes
}

fn schema(id: u16, name: &str) -> Vec<u8> {
    let content = [
        &id.to_le_bytes()[..],
        &string(name),
        &string("ros2msg"),
        &string(""),
    ];
    record(0x03, &content.concat())
}

fn channel(id: u16, schema: u16, topic: &str, encoding: &str) -> Vec<u8> {
    let content = [
        &id.to_le_bytes()[..],
        &schema.to_le_bytes(),
        &string(topic),
        &string(encoding),
        &0u32.to_le_bytes(),
    ];
    record(0x04, &content.concat())
}

fn message(channel: u16, t: f64, data: &[u8]) -> Vec<u8> {
    let time = ((t * 1e9) as u64).to_le_bytes();
    record(
        0x05,
        &[&channel.to_le_bytes()[..], &[0; 4], &time, &time, data].concat(),
    )
}

fn file(records: &[u8]) -> Vec<u8> {
    let magic = &b"\x89MCAP0\r\n"[..];
    let head = record(0x01, &[string("ros2"), string("test")].concat());
    let end = record(0x0f, &[0; 4]);
    let foot = record(0x02, &[0; 20]);
    [magic, &head, records, &end, &foot, magic].concat()
}

fn chunk(records: &[u8], compression: &str) -> Vec<u8> {
    use std::io::Write as _;
    let packed = match compression {
        "lz4" => {
            let mut packed = lz4_flex::frame::FrameEncoder::new(Vec::new());
            packed.write_all(records).unwrap();
            packed.finish().unwrap()
        }
        "zstd" => {
            ruzstd::encoding::compress_to_vec(records, ruzstd::encoding::CompressionLevel::Fastest)
        }
        _ => records.to_vec(),
    };
    let mut crc = flate2::Crc::new();
    crc.update(records);
    let content = [
        &[0; 16][..],
        &(records.len() as u64).to_le_bytes(),
        &crc.sum().to_le_bytes(),
        &string(compression),
        &(packed.len() as u64).to_le_bytes(),
        &packed,
    ];
    record(0x06, &content.concat())
}

/// A message being put together, little end first, without the name of the encoding.
struct Cdr(Vec<u8>);

impl Cdr {
    /// A message that begins with a header: `stamp` is in ns.
    fn stamped(stamp: u64, frame: &str) -> Cdr {
        let mut cdr = Cdr(Vec::new());
        cdr.u32((stamp / 1_000_000_000) as u32);
        cdr.u32((stamp % 1_000_000_000) as u32);
        cdr.text(frame);
        cdr
    }

    fn align(&mut self, size: usize) {
        self.0.resize(self.0.len().next_multiple_of(size), 0);
    }

    fn u32(&mut self, x: u32) {
        self.align(4);
        self.0.extend(x.to_le_bytes());
    }

    fn f64(&mut self, x: f64) {
        self.align(8);
        self.0.extend(x.to_le_bytes());
    }

    /// A length counts the closing zero.
    fn text(&mut self, text: &str) {
        self.u32(text.len() as u32 + 1);
        self.0.extend(text.bytes().chain([0]));
    }

    fn bytes(self) -> Vec<u8> {
        [&[0, 1, 0, 0][..], &self.0].concat()
    }
}

/// A point (m) of the plane z = 0 in a frame; `stamp` is in ns.
fn in_plane(stamp: u64, frame: &str, [x, y]: [f64; 2]) -> Vec<u8> {
    let mut cdr = Cdr::stamped(stamp, frame);
    [x, y, 0.0].into_iter().for_each(|x| cdr.f64(x));
    cdr.bytes()
}

/// Bytes written out by hand from the standard: `f` takes two, and the doubles begin two later.
#[test]
fn a_point_has_the_bytes_of_the_standard() {
    let bytes = in_plane(7_500_000_000, "f", [0.25, -2.0]);
    let mut expected = vec![0, 1, 0, 0, 7, 0, 0, 0];
    expected.extend(500_000_000_u32.to_le_bytes());
    expected.extend([2, 0, 0, 0, b'f', 0, 0, 0]);
    for x in [0.25_f64, -2.0, 0.0] {
        expected.extend(x.to_le_bytes());
    }
    assert_eq!(bytes, expected);
    let (stamp, frame, at) = cdr::decoded(&bytes, cdr::point).unwrap();
    assert_eq!((stamp, &*frame), (Some(7.5), "f"));
    assert_eq!(at, [0.25, -2.0, 0.0]);
}

/// Nanoseconds of a time, s.
fn stamp(t: f64) -> u64 {
    (t * 1e9).round() as u64
}

fn state(t: f64, names: &[&str], q: &[f64]) -> Vec<u8> {
    let mut cdr = Cdr::stamped(stamp(t), "");
    cdr.u32(names.len() as u32);
    names.iter().for_each(|name| cdr.text(name));
    cdr.u32(q.len() as u32);
    q.iter().for_each(|q| cdr.f64(*q));
    // Neither velocities nor efforts.
    cdr.u32(0);
    cdr.u32(0);
    cdr.bytes()
}

fn wrench(t: f64, force: [f64; 3], torque: [f64; 3]) -> Vec<u8> {
    let mut cdr = Cdr::stamped(stamp(t), "sole");
    let all = force.into_iter().chain(torque);
    all.for_each(|x| cdr.f64(x));
    cdr.bytes()
}

/// Two postures of half a second, a motion between them, a foot in the air.
fn records() -> Vec<u8> {
    let mut records = [
        schema(1, STATE),
        schema(2, WRENCH),
        channel(10, 1, "/joint_states", "cdr"),
        channel(20, 2, "/sole/wrench", "cdr"),
    ]
    .concat();
    for k in 0..60 {
        let t = 10.0 + f64::from(k) * 0.025;
        let knee = match k {
            0..20 => 0.5,
            20..40 => 0.5 - f64::from(k - 19) * 0.05,
            _ => -0.5,
        };
        records.extend(message(
            10,
            t,
            &state(t, &["knee", "wheel", "hip"], &[knee, t, 0.25]),
        ));
        if k & 1 == 0 {
            let f = if k == 4 { 0.1 } else { 30.0 };
            let reading = wrench(t + 0.001, [1.0, 2.0, f], [30.0 * 0.02, -30.0 * 0.01, 0.0]);
            records.extend(message(20, t, &reading));
        }
    }
    records
}

pub(in crate::logs) fn recording(compression: &str) -> Vec<u8> {
    file(&chunk(&records(), compression))
}

fn read(bytes: &[u8], sidecar: &str) -> Result<(super::super::Block, Vec<crate::Message>), Error> {
    let (_folder, path) = log("log.mcap", bytes, sidecar);
    let options = Options {
        links: vec!["sole".into()],
        ..Options::default()
    };
    read_file(&path, &dofs(&["hip", "knee"]), &options)
}

/// A file of a few hundred bytes unpacks to a megabyte and no more.
#[test]
fn what_chunks_of_zeros_unpack_to_is_counted_over_the_file() {
    // Records of no opcode and no length, which say nothing.
    let empty = |bytes: usize| chunk(&vec![0; bytes / 9 * 9], "zstd");
    let of =
        |count: usize| file(&[empty(400_000).repeat(count), chunk(&records(), "zstd")].concat());
    read(&of(2), "").unwrap();
    assert!(of(3).len() < 20_000);
    says(
        read(&of(3), "").unwrap_err(),
        &["claims to unpack to 399996"],
    );
}

#[test]
fn stretches_of_rest_become_postures() {
    let (expected, warnings) = read(&file(&records()), "").unwrap();
    // 20 states of 25 ms: ten readings, the last not confirmed, one in the air.
    says(&warnings[0], &["1 of 30 readings"]);
    let (first, second): (Vec<i64>, Vec<i64>) = expected.pose.iter().partition(|p| **p == 0);
    assert!((8..=9).contains(&first.len()), "{:?}", expected.pose);
    assert!(second.len() >= 9 && second.iter().all(|pose| *pose == 1));
    assert_eq!(expected.q[..2], [0.25, 0.5]);
    assert!((expected.q[expected.q.len() - 1] + 0.5).abs() < 1e-9);
    let [x, y] = expected.reading.as_ref().unwrap()[0];
    assert!((x - 0.01).abs() < 1e-15 && (y - 0.02).abs() < 1e-15);
    assert_eq!(&*expected.support.as_ref().unwrap()[0], "sole");
    assert!((expected.t.as_ref().unwrap()[0] - 10.001).abs() < 1e-9);
    for compression in ["", "lz4", "zstd"] {
        let (block, _) = read(&recording(compression), "").unwrap();
        assert!(block == expected, "{compression}");
        let (block, _) = read(&file(&unchecked(records(), compression)), "").unwrap();
        assert!(block == expected, "{compression}, without a checksum");
    }
}

/// A chunk without a checksum.
fn unchecked(records: Vec<u8>, compression: &str) -> Vec<u8> {
    let mut chunk = chunk(&records, compression);
    // After opcode, length, two times and the size.
    chunk[33..37].fill(0);
    chunk
}

#[test]
fn claims_of_records_and_chunks_are_held_against_their_bytes() {
    let claim = |length: u64| [&[0x05][..], &length.to_le_bytes()].concat();
    let mut short = unchecked(records(), "lz4");
    short[25] = short[25].wrapping_sub(1);
    let mut long = unchecked(records(), "lz4");
    long[25] = long[25].wrapping_add(1);
    let nested = chunk(&chunk(&records(), ""), "lz4");
    let one_more = "a record of 67108865 bytes, more than 64 MiB";
    for (records, word) in [
        (claim((64 << 20) + 1), one_more),
        (claim(u64::MAX), "more than 64 MiB"),
        (chunk(&claim(1 << 40), "lz4"), "more than 64 MiB"),
        (nested, "a chunk within a chunk"),
        (chunk(&records(), "brotli"), "`brotli`; repack it"),
        (short, "damaged"),
        (long, "damaged"),
    ] {
        says(read(&file(&records), "").unwrap_err(), &[word]);
    }
}

#[test]
fn without_readings_a_posture_is_a_row() {
    let (_folder, path) = log("log.mcap", &recording("lz4"), "");
    let options = Options {
        readings: crate::logs::Readings::Ignored,
        ..Options::default()
    };
    let (block, _) = read_file(&path, &dofs(&["hip", "knee"]), &options).unwrap();
    assert_eq!((block.pose.len(), block.reading), (2, None));
}

#[test]
fn faults_say_what_to_do() {
    let whole = recording("lz4");
    let moving = |t: f64| state(t, &["hip", "knee"], &[t, 0.0]);
    let states: Vec<u8> = (0..50)
        .flat_map(|k| message(10, 0.0, &moving(1.0 + f64::from(k) * 0.1)))
        .collect();
    let head = [schema(1, STATE), channel(10, 1, "/js", "cdr")].concat();
    let ros1 = [schema(1, STATE), channel(10, 1, "/js", "ros1")].concat();
    let second = [
        channel(21, 2, "/left", "cdr"),
        message(21, 10.2, &wrench(10.2, [0.0; 3], [0.0; 3])),
    ];
    let both = [records(), second.concat()].concat();
    let stray = [channel(30, 9, "/chatter", "cdr"), message(30, 1.0, &[])].concat();
    let still = file(&[head, states.clone()].concat());
    let cut = &whole[..whole.len() - 20];
    let elsewhere = "topic = '/nowhere'";
    for (bytes, sidecar, words) in [
        (cut, "", &["cut off", "mcap recover"][..]),
        (&whole[..200], "", &["cut off"]),
        (
            &file(&stray),
            "",
            &["no sensor_msgs/msg/JointState", "/chatter"],
        ),
        (&still, "", &["no posture is held", "0.02 rad/s"]),
        (&file(&[ros1, states].concat()), "", &["`ros1`", "ROS 2"]),
        (
            &file(&both),
            "",
            &["`/sole/wrench` and on `/left`", "topic"],
        ),
        (&whole, elsewhere, &["`/nowhere`", "/sole/wrench"]),
    ] {
        says(read(bytes, sidecar).unwrap_err(), words);
    }
    assert!(read(&file(&both), "topic = '/sole/wrench'").is_ok());
    let mut damaged = recording("");
    let at = damaged.len() / 2;
    damaged[at] ^= 1;
    says(read(&damaged, "").unwrap_err(), &["damaged"]);
}
