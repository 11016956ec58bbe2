use super::*;
use crate::oracle::Generator;
use std::vec::Vec;

/// Probes of a dark sky: noise of so many counts.
fn probes(generator: &mut Generator, sigma: f64) -> Vec<[u16; 256]> {
    (0..PROBES).map(|_| [0; 256].map(|_: u16| (40.3 + sigma * generator.gaussian()).round() as u16)).collect()
}

fn fingerprint(probes: &[[u16; 256]]) -> Fingerprint {
    let mut fingerprint = Fingerprint::default();
    for (index, pixels) in probes.iter().enumerate() {
        fingerprint.take(index, pixels);
    }
    fingerprint
}

/// The same with a bit turned over in this share of the pixels.
fn flipped(generator: &mut Generator, probes: &[[u16; 256]], share: f64) -> Vec<[u16; 256]> {
    let mut flip = |pixel: u16| {
        let bit = generator.between(0.0, 10.0) as u32;
        if generator.between(0.0, 1.0) < share { pixel ^ 1 << bit } else { pixel }
    };
    probes.iter().map(|pixels| pixels.map(&mut flip)).collect()
}

#[test]
fn an_image_is_known_again_with_bits_turned_over_and_no_new_one_is() {
    let mut generator = Generator::new(71);
    for sigma in [0.1, 0.2, 0.3, 0.5, 1.0, 4.0, 20.0] {
        let (mut known, mut false_alarms) = (0, 0);
        for _ in 0..500 {
            let before = probes(&mut generator, sigma);
            let again = flipped(&mut generator, &before, 0.01);
            let (before, again) = (fingerprint(&before), fingerprint(&again));
            known += usize::from(again.is_that_of(&before));
            let new = fingerprint(&probes(&mut generator, sigma));
            false_alarms += usize::from(new.is_that_of(&before));
        }
        std::println!("noise of {sigma} counts: known again in {known} of 500, {false_alarms} false");
        assert_eq!(false_alarms, 0);
        // Of pixels that are nearly all alike every group must be the same.
        assert!(known >= 495 || sigma < 0.3);
    }
}

#[test]
fn without_bits_turned_over_low_noise_is_enough_and_no_noise_is_none() {
    let mut generator = Generator::new(72);
    for sigma in [0.1, 0.2] {
        let image = probes(&mut generator, sigma);
        assert!(fingerprint(&image).is_that_of(&fingerprint(&image)));
    }
    let even = std::vec![[40; 256]; PROBES];
    assert!(!fingerprint(&even).is_that_of(&fingerprint(&even)));
    assert!(!Fingerprint::default().is_that_of(&Fingerprint::default()));
}

#[test]
fn what_was_not_delivered_says_nothing() {
    let mut generator = Generator::new(73);
    let image = probes(&mut generator, 0.5);
    let (whole, mut part) = (fingerprint(&image), Fingerprint::default());
    part.take(3, &image[3]);
    part.take(PROBES, &image[0]);
    assert!(part.is_that_of(&whole) && whole.is_that_of(&part));
    let mut other = Fingerprint::default();
    other.take(2, &image[2]);
    assert!(!other.is_that_of(&part));
}

/// A burst makes the steps of every probe alike; the noise told is that of the sky, not of the probe on the
/// Earth that happens to be the calmest.
#[test]
fn the_noise_is_that_of_the_sky_where_the_earth_is_as_calm() {
    let mut generator = Generator::new(74);
    let mut calmest_on_earth = 0;
    for _ in 0..200 {
        let mut image = probes(&mut generator, 4.0);
        for pixels in &mut image[3..] {
            pixels.iter_mut().for_each(|raw| *raw += 22);
        }
        let steps =
            |pixels: &[u16; 256]| pixels.windows(2).map(|pair| pair[0].abs_diff(pair[1])).sum::<u16>();
        let calmest = (0..PROBES).min_by_key(|probe| steps(&image[*probe])).unwrap();
        calmest_on_earth += usize::from(calmest >= 3);
        let noise = fingerprint(&image).noise();
        assert!(noise.light < 42 * 256, "{noise:?}");
    }
    assert!(calmest_on_earth > 50, "{calmest_on_earth}");
}

#[test]
fn images_compare_where_a_probe_was_read_of_both() {
    let mut generator = Generator::new(73);
    let probes = probes(&mut generator, 2.0);
    let of = |read: &[usize]| {
        let mut fingerprint = Fingerprint::default();
        read.iter().for_each(|index| fingerprint.take(*index, &probes[*index]));
        fingerprint
    };
    assert!(of(&[0, 1, 2]).compares_with(&of(&[2, 3])));
    assert!(!of(&[0, 1, 2]).compares_with(&of(&[3, 4])) && !of(&[0]).compares_with(&Fingerprint::default()));
    // One that does not compare is not known again, though it is the same.
    assert!(of(&[0, 1, 2]).is_that_of(&of(&[2, 3])) && !of(&[0, 1, 2]).is_that_of(&of(&[3, 4])));
}
