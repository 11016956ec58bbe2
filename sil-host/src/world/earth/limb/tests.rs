//! The blurred profile against direct integration, and against what is known of the Earth's limb.

use super::*;

fn limb() -> Limb {
    Limb::new(&EarthModel::default())
}

impl Limb {
    /// The profile at one height.
    pub fn at(&self, height_km: f32, sigma_km: f32) -> Blurred {
        let (mut depth, mut share, mut glow) = ([height_km], [0.0], [0.0]);
        self.read([&[sigma_km], &[0.0]], [&mut depth, &mut share, &mut glow]);
        Blurred { share: share[0], depth_km: depth[0], glow: glow[0] }
    }
}

/// Height at which `share` falls to `level`, by halving.
fn height_of(share: impl Fn(f64) -> f64, level: f64) -> f64 {
    let (mut low, mut high) = (-100.0, 100.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if share(middle) > level { low = middle } else { high = middle }
    }
    low
}

#[test]
fn the_limb_is_half_bright_at_3_to_6_km_and_20_km_wide() {
    let limb = limb();
    let profile = limb.profile();
    let half = height_of(|h| profile.share(h), 0.5);
    let width = height_of(|h| profile.share(h), 0.1) - height_of(|h| profile.share(h), 0.9);
    println!("sharp: half at {half:.2} km, 10-90 % {width:.2} km");
    assert!((3.0..6.0).contains(&half) && (18.0..22.0).contains(&width));
    for sigma in [0.75, 1.0, 11.0] {
        let share = |h: f64| f64::from(limb.at(h as f32, sigma).share);
        let half = height_of(share, 0.5);
        let width = height_of(share, 0.1) - height_of(share, 0.9);
        println!("blurred by {sigma} km: half at {half:.2} km, 10-90 % {width:.2} km");
        if sigma < 2.0 {
            assert!((3.0..6.0).contains(&half) && (18.0..22.0).contains(&width));
        }
    }
}

#[test]
fn shorter_waves_stand_higher() {
    // Light of one wavelength alone: clouds taken away, the height at which half of the thick air's light is
    // left.
    let of = |molecules: f64, particles: f64| {
        let slant = |h: f64, scale: f64| (2.0 * PI * RADIUS_KM / scale).sqrt() * (-h / scale).exp();
        height_of(|h| 1.0 - (-(slant(h, 8.0) * molecules + slant(h, 2.0) * particles)).exp(), 0.5)
    };
    let [green, red, infrared] = BANDS.map(|(_, molecules, particles)| of(molecules, particles));
    println!("550 nm {green:.1} km, 700 nm {red:.1} km, 850 nm {infrared:.1} km");
    // H ln(tau / ln 2) of the molecules alone: 18.4, 10.5 and 4.3 km; haze alone reaches 5 km in the
    // infrared.
    assert!((green - 18.4).abs() < 0.2 && (10.5..11.5).contains(&red) && (5.0..8.0).contains(&infrared));
}

#[test]
fn the_tables_are_the_convolution() {
    let limb = limb();
    let steps = 40_000;
    let mut worst = (0.0f64, 0.0f64);
    for sigma in [0.31, 0.75, 1.03, 3.3, 11.0, 40.0] {
        for place in [-4.9, -2.3, -0.7, 0.1, 1.1, 2.9, 6.0, 9.7, 17.0, 40.0, 80.0] {
            let height = place * if place < 3.0 { sigma } else { 1.0 };
            let (mut share, mut depth) = (0.0, 0.0);
            for k in 0..steps {
                let t = (f64::from(k) + 0.5) / f64::from(steps) * 16.0 - 8.0;
                let weight = (-0.5 * t * t).exp() * 16.0 / f64::from(steps) / (2.0 * PI).sqrt();
                share += weight * limb.profile().share(height + sigma * t);
                depth += weight * (-height - sigma * t).max(0.0);
            }
            let found = limb.at(height as f32, sigma as f32);
            let error = (f64::from(found.share) - share).abs();
            worst = (worst.0.max(error), worst.1.max((f64::from(found.depth_km) - depth).abs() / sigma));
        }
    }
    println!("share {:.1e}, depth {:.1e} sigma", worst.0, worst.1);
    assert!(worst.0 < 2e-3 && worst.1 < 4e-3, "{worst:?}");
}

#[test]
fn the_ends_of_the_tables_are_the_surface_and_nothing() {
    let limb = limb();
    let deep = limb.at(-300.0, 1.0);
    assert!(deep.share == 1.0 && deep.depth_km == 300.0);
    assert_eq!(limb.at(105.2, 1.0), Blurred::default());
}

#[test]
fn the_night_sky_is_a_bright_line_at_its_layer() {
    let limb = limb();
    let glow = |h: f32| f64::from(limb.at(h, 1.0).glow);
    let brightest = (0..100).max_by(|a, b| glow(*a as f32).total_cmp(&glow(*b as f32))).unwrap();
    assert!((84..=90).contains(&brightest), "{brightest}");
    // 10 kR under 1.76e21 photons/m²/s that the Sun sends: 1.4e-8 straight down; 2 (2 R 4 km)^(1/2) / 8.8 km,
    // some 50 times that along the limb.
    let zenith = 1e4 * 7.9577e8 * PI / (500.0 / 2.84e-19);
    let gain = glow(brightest as f32) / zenith;
    println!("gain along the limb {gain:.1} at {brightest} km");
    assert!((45.0..70.0).contains(&gain));
    let dark = Limb::new(&EarthModel { airglow: false, ..EarthModel::default() });
    assert_eq!(dark.at(88.0, 1.0).glow, 0.0);
}
