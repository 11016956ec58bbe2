//! The frames of a telemetry stream, found again behind bytes that are damaged.
//!
//! In: bytes as they come, from a file or a link; frames each led by their length (u16, little-endian). Out:
//! [`Piece`] after piece, each as soon as its last byte is there. A frame whose checksum does not match may
//! have a wrong length; the stream goes on with the next place at which a length, the version [`VERSION`] and
//! a checksum match. No more than the longest frame is waited for.

use fsw_core::packet::PacketError;
use fsw_core::telemetry::{MAX_FRAME_BYTES, Report, VERSION, decode};
use std::io::{self, Read};

/// Bytes in front of a frame.
const LENGTH_BYTES: usize = 2;
/// Bytes of the shortest packet: version and checksum.
const SHORTEST: usize = 5;
/// Bytes read at a time at most.
const CHUNK_BYTES: usize = 8192;

/// What stands next in a stream.
#[derive(Debug)]
pub enum Piece {
    /// A frame, its length in bytes, and what it holds or why it is not read; its checksum matches.
    Frame(usize, Result<Box<Report>, PacketError>),
    /// So many bytes that are no frame; a frame follows.
    Skipped(usize),
    /// So many bytes up to the end, in which no frame is whole.
    Rest(usize),
}

/// A stream being read.
#[derive(Debug)]
pub struct TelemetryStream<R> {
    source: R,
    ended: bool,
    /// What was read and not yet given.
    held: Vec<u8>,
    /// Place of the first byte held.
    at: u64,
}

/// What stands at the beginning of bytes.
enum Front {
    /// A packet of so many bytes whose checksum matches, and what it holds.
    Packet(usize, Result<Box<Report>, PacketError>),
    /// None.
    Nothing,
    /// More bytes will tell.
    Open,
}

impl<R: Read> TelemetryStream<R> {
    /// Of bytes that come from `source`.
    pub fn new(source: R) -> Self {
        Self { source, ended: false, held: Vec::new(), at: 0 }
    }

    /// The next piece and the place of its first byte; `None` at the end.
    ///
    /// # Errors
    /// When the source cannot be read.
    pub fn piece(&mut self) -> io::Result<Option<(u64, Piece)>> {
        let mut skipped = 0;
        loop {
            match self.front(skipped) {
                Front::Packet(..) if skipped > 0 => {
                    return Ok(Some(self.given(skipped, Piece::Skipped(skipped))));
                }
                Front::Packet(length, frame) => {
                    return Ok(Some(self.given(LENGTH_BYTES + length, Piece::Frame(length, frame))));
                }
                Front::Nothing => skipped += 1,
                Front::Open if self.ended && skipped >= self.held.len() => {
                    let rest = self.held.len();
                    return Ok((rest > 0).then(|| self.given(rest, Piece::Rest(rest))));
                }
                Front::Open if self.ended => skipped += 1,
                Front::Open => self.read()?,
            }
        }
    }

    /// What stands behind so many of the bytes held. Behind skipped ones a packet of another version is none:
    /// its version byte is not looked for.
    fn front(&self, skipped: usize) -> Front {
        let bytes = &self.held[skipped.min(self.held.len())..];
        let Some((length, packet)) = bytes.split_first_chunk::<LENGTH_BYTES>() else { return Front::Open };
        let length = usize::from(u16::from_le_bytes(*length));
        let foreign = skipped > 0 && packet.first().is_some_and(|version| *version != VERSION);
        if foreign || !(SHORTEST..=MAX_FRAME_BYTES).contains(&length) {
            return Front::Nothing;
        }
        match packet.get(..length).map(decode) {
            None => Front::Open,
            Some(Err(PacketError::Checksum)) => Front::Nothing,
            Some(read) => Front::Packet(length, read.map(Box::new)),
        }
    }

    /// Takes bytes out, as a piece.
    fn given(&mut self, bytes: usize, piece: Piece) -> (u64, Piece) {
        let at = self.at;
        self.held.drain(..bytes);
        self.at += bytes as u64;
        (at, piece)
    }

    /// Waits for more bytes.
    fn read(&mut self) -> io::Result<()> {
        let held = self.held.len();
        self.held.resize(held + CHUNK_BYTES, 0);
        let read = loop {
            match self.source.read(&mut self.held[held..]) {
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                read => break read,
            }
        };
        self.held.truncate(held + *read.as_ref().unwrap_or(&0));
        self.ended = read? == 0;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fsw_core::telemetry::encode;

    /// A stream of so many frames, and where each begins.
    fn stream(count: u32) -> (Vec<u8>, Vec<usize>) {
        let (mut bytes, mut begins) = (Vec::new(), Vec::new());
        for cycle in 0..count {
            let mut buffer = [0; MAX_FRAME_BYTES];
            let frame = encode(&Report { cycle, ..Report::default() }, &mut buffer).unwrap();
            begins.push(bytes.len());
            bytes.extend(u16::try_from(frame.len()).unwrap().to_le_bytes());
            bytes.extend(frame);
        }
        (bytes, begins)
    }

    /// Cycles read, and what was left out: place, bytes, whether a frame follows.
    fn read(bytes: &[u8]) -> (Vec<u32>, Vec<(u64, usize, bool)>) {
        let mut stream = TelemetryStream::new(bytes);
        let (mut cycles, mut left_out) = (Vec::new(), Vec::new());
        while let Some((at, piece)) = stream.piece().unwrap() {
            match piece {
                Piece::Frame(_, report) => cycles.push(report.unwrap().cycle),
                Piece::Skipped(bytes) => left_out.push((at, bytes, true)),
                Piece::Rest(bytes) => left_out.push((at, bytes, false)),
            }
        }
        (cycles, left_out)
    }

    #[test]
    fn a_damaged_byte_wherever_it_is_costs_its_frame_alone() {
        let (whole, begins) = stream(6);
        assert_eq!(read(&whole), ((0..6).collect(), vec![]));
        let (from, until) = (begins[2], begins[3]);
        for place in from..until {
            for flipped in [0x01, 0x40, 0xff] {
                let mut bytes = whole.clone();
                bytes[place] ^= flipped;
                let (cycles, left_out) = read(&bytes);
                assert_eq!(cycles, [0, 1, 3, 4, 5], "byte {place}");
                assert_eq!(left_out, [(from as u64, until - from, true)], "byte {place}");
            }
        }
    }

    #[test]
    fn bytes_lost_or_put_between_cost_what_they_touch() {
        let (whole, begins) = stream(5);
        let lost = [&whole[..begins[1] + 3], &whole[begins[1] + 9..]].concat();
        assert_eq!(read(&lost).0, [0, 2, 3, 4]);
        let more = [&whole[..begins[3]], &[0xff; 700], &whole[begins[3]..]].concat();
        assert_eq!(read(&more), ((0..5).collect(), vec![(begins[3] as u64, 700, true)]));
        let torn = &whole[..whole.len() - 4];
        assert_eq!(read(torn), ((0..4).collect(), vec![(begins[4] as u64, torn.len() - begins[4], false)]));
        assert_eq!(read(b"no frames in here"), (vec![], vec![(0, 17, false)]));
        assert_eq!(read(b""), (vec![], vec![]));
    }

    /// Gives its bytes one at a time, and fails where more are asked for.
    struct Link<'a>(&'a [u8]);

    impl Read for Link<'_> {
        fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
            let (first, rest) = self.0.split_first().ok_or(io::ErrorKind::WouldBlock)?;
            (into[0], self.0) = (*first, rest);
            Ok(1)
        }
    }

    #[test]
    fn a_frame_is_given_before_the_next_one_comes() {
        let (whole, _) = stream(3);
        let mut stream = TelemetryStream::new(Link(&whole));
        for cycle in 0..3 {
            let (_, piece) = stream.piece().unwrap().unwrap();
            assert!(matches!(piece, Piece::Frame(_, Ok(report)) if report.cycle == cycle));
        }
        assert!(stream.piece().is_err());
    }
}
