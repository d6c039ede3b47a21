//! What readers and writers of MCAP files share: marks and numbers of records.

/// How a file begins and ends.
pub(super) const MAGIC: &[u8; 8] = b"\x89MCAP0\r\n";

/// Key and value in the description of a topic each message of which is a posture of its own, or
/// the reading that belongs to it, however short the robot held still.
pub(super) const OWN_POSTURES: [&str; 2] = ["sesc", "a message is a posture"];

/// Numbers of records.
pub(super) mod opcode {
    pub const HEADER: u8 = 0x01;
    pub const FOOTER: u8 = 0x02;
    pub const SCHEMA: u8 = 0x03;
    pub const CHANNEL: u8 = 0x04;
    pub const MESSAGE: u8 = 0x05;
    pub const CHUNK: u8 = 0x06;
    pub const MESSAGE_INDEX: u8 = 0x07;
    pub const CHUNK_INDEX: u8 = 0x08;
    pub const STATISTICS: u8 = 0x0b;
    pub const SUMMARY_OFFSET: u8 = 0x0e;
    pub const END_OF_DATA: u8 = 0x0f;
}
