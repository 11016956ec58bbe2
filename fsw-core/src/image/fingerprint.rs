//! By what an image is known again: the noise of its probes.
//!
//! In: the pixels of [`PROBES`] small windows. Out: whether it is an image from before, sold as a new one:
//! noise does not repeat itself. A digest is kept of every group of 32 pixels, so that bits turned
//! over on the way from the detector, one in a hundred pixels of both images, leave half of the groups as
//! they were; a quarter is enough.
//!
//! Of pixels that are all alike nothing is said. Where the noise is so low that neighbours are mostly equal
//! two images may have groups in common by chance; there all must be the same. Noise that is put onto an old
//! image hides it: such noise is larger than usual, which [`Fingerprint::noise`] tells, and does not come of
//! more light.

/// Number of probes.
pub const PROBES: usize = 5;
/// Pixels of a group.
const GROUP_PX: usize = 32;
/// Groups of a probe: 256 pixels.
const GROUPS: usize = 8;
/// Digest of a group that was not read.
const UNREAD: u16 = 0;
/// Share of neighbours that are equal above which the noise is low, of 5: there a group is the same by chance
/// once in 1,300, and a quarter of a single probe's once in 50,000.
const LOW_NOISE: u32 = 4;
/// Of the hash by Fowler, Noll and Vo, 32 bits.
const FNV_BASIS: u32 = 2_166_136_261;
const FNV_PRIME: u32 = 16_777_619;

/// Digests of an image's probes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Fingerprint {
    digests: [[u16; GROUPS]; PROBES],
    /// Pairs of neighbours, and of these the equal ones.
    pairs: u16,
    equal: u16,
    noise: Noise,
}

/// Noise and light of an image's probe with the least of both.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Noise {
    /// Sum of the steps between neighbours, counts.
    pub steps: u32,
    /// Sum of the pixels, counts.
    pub light: u32,
}

impl Fingerprint {
    /// Takes the pixels of a probe.
    pub fn take(&mut self, probe: usize, pixels: &[u16]) {
        let Some(digests) = self.digests.get_mut(probe) else { return };
        for (digest, group) in digests.iter_mut().zip(pixels.chunks(GROUP_PX)) {
            let hash =
                group.iter().fold(FNV_BASIS, |hash, raw| (hash ^ u32::from(*raw)).wrapping_mul(FNV_PRIME));
            *digest = ((hash ^ hash >> 16) as u16).max(UNREAD + 1);
            let equal = group.windows(2).filter(|pair| matches!(pair, [one, other] if one == other)).count();
            self.pairs = self.pairs.saturating_add(group.len().saturating_sub(1) as u16);
            self.equal = self.equal.saturating_add(equal as u16);
        }
        let step = |pair: &[u16]| match pair {
            [one, other] => u32::from(one.abs_diff(*other)),
            _ => 0,
        };
        let noise = Noise {
            steps: pixels.windows(2).map(step).sum(),
            light: pixels.iter().map(|raw| u32::from(*raw)).sum(),
        };
        // Not the steps alone: a disturbance makes those of a probe on the Earth as small as the sky's, and
        // the Earth's light would excuse it.
        if self.noise == Noise::default() || noise.steps + noise.light < self.noise.steps + self.noise.light {
            self.noise = noise;
        }
    }

    /// Noise of the probe with the least noise and light.
    pub fn noise(&self) -> Noise {
        self.noise
    }

    /// Whether both images have a probe that was read in both, so that one can be known again.
    pub fn compares_with(&self, other: &Self) -> bool {
        self.pairs_with(other).next().is_some()
    }

    /// The digests of the groups that were read of both images.
    fn pairs_with(&self, other: &Self) -> impl Iterator<Item = (u16, u16)> {
        let pairs = self.digests.as_flattened().iter().zip(other.digests.as_flattened());
        pairs.map(|(one, other)| (*one, *other)).filter(|(one, other)| *one != UNREAD && *other != UNREAD)
    }

    /// Whether this image is the one of another fingerprint.
    pub fn is_that_of(&self, other: &Self) -> bool {
        let (known, same) = self
            .pairs_with(other)
            .fold((0u32, 0u32), |(known, same), (one, other)| (known + 1, same + u32::from(one == other)));
        let quiet = 5 * u32::from(self.equal) > LOW_NOISE * u32::from(self.pairs);
        let varied = self.equal < self.pairs;
        let enough = if quiet { known } else { known.div_ceil(4) };
        varied && known > 0 && same >= enough
    }
}

#[cfg(test)]
mod tests;
