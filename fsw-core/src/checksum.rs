//! CRC-32 (ISO-HDLC), the checksum of everything that is stored or sent: catalogue, calibration, parameter
//! tables, telemetry.
//!
//! Reflected polynomial `0xEDB8_8320`, register all ones at first, inverted at the end. A byte a step with a
//! table of 256 words, 1 KiB of flash, at about 8 cycles a byte on the target.

/// Remainder of the polynomial's division for each value of a byte.
const TABLE: [u32; 256] = {
    let mut table = [0; 256];
    let mut byte = 0;
    while byte < 256 {
        let (mut register, mut bit) = (byte, 0);
        while bit < 8 {
            register = register >> 1 ^ if register & 1 == 1 { 0xEDB8_8320 } else { 0 };
            bit += 1;
        }
        #[expect(clippy::indexing_slicing, reason = "evaluated by the compiler")]
        {
            table[byte as usize] = register;
        }
        byte += 1;
    }
    table
};

/// The CRC-32 of bytes that come piece by piece.
#[derive(Clone, Copy, Debug)]
pub struct Crc32 {
    register: u32,
}

impl Default for Crc32 {
    fn default() -> Self {
        Self { register: u32::MAX }
    }
}

impl Crc32 {
    /// Adds a piece.
    #[inline(never)]
    pub fn add(&mut self, bytes: &[u8]) {
        self.register = bytes.iter().fold(self.register, |register, byte| {
            let remainder = TABLE.get(usize::from(register as u8 ^ byte));
            // 256 words for a byte: there is always one.
            register >> 8 ^ remainder.copied().unwrap_or(0)
        });
    }

    /// That of all pieces so far.
    pub fn value(&self) -> u32 {
        !self.register
    }
}

/// The CRC-32 of bytes that are passed a slice at a time, the same bytes in every call.
#[derive(Clone, Debug, Default)]
pub struct SlicedCrc32 {
    passed: usize,
    /// Of the bytes passed.
    pub(crate) crc: Crc32,
}

impl SlicedCrc32 {
    /// Passes the next slice, of at most so many bytes.
    pub fn pass(&mut self, bytes: &[u8], most: usize) {
        let rest = bytes.get(self.passed..).unwrap_or(&[]);
        let slice = rest.get(..most).unwrap_or(rest);
        self.crc.add(slice);
        self.passed = self.passed.saturating_add(slice.len());
    }

    /// The CRC, once all bytes are passed.
    pub fn of_all(&self, bytes: &[u8]) -> Option<u32> {
        (self.passed >= bytes.len()).then(|| self.crc.value())
    }
}

/// The CRC-32 of these bytes.
pub fn crc32(bytes: &[u8]) -> u32 {
    let mut crc = Crc32::default();
    crc.add(bytes);
    crc.value()
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn the_published_check_value_comes_out() {
        assert_eq!(crc32(b"123456789"), 0xCBF4_3926);
        assert_eq!(crc32(b""), 0);
    }

    proptest! {
        #[test]
        fn it_is_that_of_another_implementation(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
            let other = crc::Crc::<u32>::new(&crc::CRC_32_ISO_HDLC);
            prop_assert_eq!(crc32(&bytes), other.checksum(&bytes));
        }

        #[test]
        fn pieces_give_what_the_whole_gives(
            bytes in prop::collection::vec(any::<u8>(), 0..300),
            length in 1..100usize,
        ) {
            let mut crc = Crc32::default();
            bytes.chunks(length).for_each(|piece| crc.add(piece));
            prop_assert_eq!(crc.value(), crc32(&bytes));
        }
    }
}
