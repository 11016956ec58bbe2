//! The tag by which a telecommand shows that it comes from who holds the key.
//!
//! In: a packet up to its tag (headers, fields, counter) and the tag. Out: whether they belong together. The
//! tag is the whole CMAC of AES-128 (NIST SP 800-38B, RFC 4493), 16 bytes; of the MACs at hand it takes the
//! least flash (5.4 kB built for size, HMAC-SHA-256 9.6 kB). It is compared in constant time, and the cipher
//! has no tables.
//!
//! The counter, u32, must rise from packet to packet, so that none can be sent twice. The spacecraft stores
//! the last one ([`CommandLink::counter`](super::CommandLink::counter)) where it outlasts a loss of power,
//! before the command is done, and hands it over when the link is made.

use aes::Aes128;
use cmac::{Cmac, KeyInit, Mac};
use core::fmt;

/// Length of the tag.
pub const TAG_BYTES: usize = 16;
/// Length of counter and tag.
pub const TRAILER_BYTES: usize = 4 + TAG_BYTES;

/// A key of AES-128.
#[derive(Clone, Copy)]
pub struct Key([u8; 16]);

/// The key is not told.
impl fmt::Debug for Key {
    fn fmt(&self, out: &mut fmt::Formatter) -> fmt::Result {
        out.write_str("Key")
    }
}

impl Key {
    /// The key of these bytes.
    pub const fn new(bytes: [u8; 16]) -> Self {
        Self(bytes)
    }

    fn cmac(&self, message: &[u8]) -> Cmac<Aes128> {
        let mut cmac = Cmac::<Aes128>::new(&self.0.into());
        cmac.update(message);
        cmac
    }

    /// The tag of a message.
    pub fn tag(&self, message: &[u8]) -> [u8; TAG_BYTES] {
        self.cmac(message).finalize().into_bytes().into()
    }

    /// Whether this is the tag of the message; takes the same time for every tag.
    pub fn verifies(&self, message: &[u8], tag: &[u8; TAG_BYTES]) -> bool {
        self.cmac(message).verify(tag.into()).is_ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn hex<const N: usize>(text: &str) -> [u8; N] {
        core::array::from_fn(|k| u8::from_str_radix(&text[2 * k..2 * k + 2], 16).unwrap())
    }

    /// RFC 4493, section 4.
    #[test]
    fn the_tags_are_those_of_rfc_4493() {
        let key = Key::new(hex("2b7e151628aed2a6abf7158809cf4f3c"));
        let message: [u8; 64] = hex("6bc1bee22e409f96e93d7e117393172aae2d8a571e03ac9c9eb76fac45af8e51\
             30c81c46a35ce411e5fbc1191a0a52eff69f2445df4f9b17ad2b417be66c3710");
        for (length, tag) in [
            (0, "bb1d6929e95937287fa37d129b756746"),
            (16, "070a16b46b4d4144f79bdd9dd04a287c"),
            (40, "dfa66747de9ae63030ca32611497c827"),
            (64, "51f0bebf7e3b9d92fc49741779363cfe"),
        ] {
            assert_eq!(key.tag(&message[..length]), hex(tag), "{length}");
            assert!(key.verifies(&message[..length], &hex(tag)));
        }
    }

    proptest! {
        #[test]
        fn a_changed_bit_of_message_tag_or_key_is_refused(
            key in any::<[u8; 16]>(),
            message in prop::collection::vec(any::<u8>(), 1..80),
            place in any::<prop::sample::Index>(),
            bit in 0u8..8,
        ) {
            let tag = Key::new(key).tag(&message);
            let flipped = |bytes: &[u8]| {
                let mut bytes = bytes.to_vec();
                let place = place.index(bytes.len());
                bytes[place] ^= 1u8 << bit;
                bytes
            };
            prop_assert!(!Key::new(key).verifies(&flipped(&message), &tag));
            prop_assert!(!Key::new(key).verifies(&message, &flipped(&tag).try_into().unwrap()));
            prop_assert!(!Key::new(flipped(&key).try_into().unwrap()).verifies(&message, &tag));
        }
    }
}
