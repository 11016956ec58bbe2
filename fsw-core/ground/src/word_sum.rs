//! Sum of the words of numbers, modulo 2^32: what tells that an upset has turned bits of one of them.
//!
//! Turned bits of one word change the sum, whichever they are: they change the word by less than 2^32 and
//! not by 0. Three cycles a word on the target, where a CRC takes 32.

/// The sum of single numbers.
#[inline(never)]
pub fn of_singles(numbers: &[f32]) -> u32 {
    numbers.iter().fold(0, |sum: u32, number| sum.wrapping_add(number.to_bits()))
}

/// The sum of double numbers.
#[inline(never)]
pub fn of_doubles(numbers: &[f64]) -> u32 {
    numbers.iter().fold(0, |sum: u32, number| sum.wrapping_add(of_long(number.to_bits())))
}

/// The sum of the two words of a number.
pub fn of_long(number: u64) -> u32 {
    (number as u32).wrapping_add((number >> 32) as u32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn any_bits_of_a_word_change_the_sum(
            singles in prop::collection::vec(any::<f32>(), 1..40),
            doubles in prop::collection::vec(any::<f64>(), 1..40),
            place in any::<prop::sample::Index>(),
            bits in 1u32..,
            high in any::<bool>(),
        ) {
            let mut turned = singles.clone();
            let one = &mut turned[place.index(singles.len())];
            *one = f32::from_bits(one.to_bits() ^ bits);
            prop_assert_ne!(of_singles(&turned), of_singles(&singles));
            let mut turned = doubles.clone();
            let one = &mut turned[place.index(doubles.len())];
            *one = f64::from_bits(one.to_bits() ^ u64::from(bits) << if high { 32 } else { 0 });
            prop_assert_ne!(of_doubles(&turned), of_doubles(&doubles));
        }
    }
}
