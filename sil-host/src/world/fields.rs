//! Centroid lists with their truth, for testing identification without pixels.
//!
//! In: a camera, a star list, a seed. Out: [`Field`]s; field `index` depends only on (seed, index). The
//! attitude is uniform over all rotations; every star to the magnitude limit whose image is on the detector
//! is moved by Gaussian noise of the given width per axis (and dropped where that takes it off the detector),
//! false stars are uniform over the detector, and the list is shuffled. A rectangular or square field comes
//! from the camera's sides. Truth and projection are the world's own (f64), apart from the solver.
//!
//! Lines: `{"id","centroids":[[x,y,brightness],..]}` as `identify` reads it, and the truth
//! `{"id","hip":[number or null,..],"q":[x,y,z,w]}`. Brightness is `10^(-0.4 V)`, larger is brighter.

use super::noise::{Noise, Stream};
use super::scene::WorldStar;
use crate::formats::camera_file::CameraFile;
use crate::world::attitude::{self, dot};
use crate::world::lens::optics::Optics;
use serde_json::json;

/// What the fields are like.
#[derive(Debug, Clone, PartialEq)]
pub struct FieldSettings {
    /// The camera; rectilinear.
    pub camera: CameraFile,
    /// Faintest magnitude.
    pub limit_v: f64,
    /// Standard deviation of a centroid in each axis, px.
    pub noise_px: f64,
    /// Number of false stars in each field; their magnitudes are uniform over the four below the limit.
    pub false_stars: u32,
    /// Whether the centroids carry a brightness.
    pub brightness: bool,
    /// Seed of attitudes and noise.
    pub seed: u64,
}

/// A centroid with its truth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FieldStar {
    /// Measured place, px.
    pub pixel: [f64; 2],
    /// Brightness relative to V = 0.
    pub brightness: f64,
    /// Hipparcos number; `None` for a false star.
    pub hip: Option<u32>,
}

/// A field and its truth.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    /// Number of the field.
    pub id: u64,
    /// True attitude, ICRS to sensor.
    pub quaternion: [f64; 4],
    /// The centroids, shuffled.
    pub stars: Vec<FieldStar>,
    brightness: bool,
}

impl Field {
    /// The line `identify` reads.
    pub fn input_line(&self) -> String {
        let centroid = |s: &FieldStar| match self.brightness {
            true => vec![s.pixel[0], s.pixel[1], s.brightness],
            false => s.pixel.to_vec(),
        };
        let centroids: Vec<_> = self.stars.iter().map(centroid).collect();
        json!({ "id": self.id, "centroids": centroids }).to_string()
    }
}

/// Makes fields.
#[derive(Debug, Clone)]
pub struct FieldGenerator<'a> {
    settings: FieldSettings,
    optics: Optics,
    cone_cosine: f64,
    stars: &'a [WorldStar],
}

impl<'a> FieldGenerator<'a> {
    /// A generator over `stars`; `None` when the camera is not rectilinear.
    pub fn new(settings: FieldSettings, stars: &'a [WorldStar]) -> Option<Self> {
        let optics = Optics::new(&settings.camera)?;
        Some(Self { cone_cosine: optics.cone_cosine(1.0), optics, settings, stars })
    }

    /// Field number `index`.
    pub fn field(&self, index: u64) -> Field {
        let noise = |stream| Noise::new(self.settings.seed, index, stream);
        let quaternion = attitude::uniform(&noise(Stream::Attitude), 0);
        let mut stars = self.true_stars(quaternion, &noise(Stream::Centroid));
        self.add_false_stars(&noise(Stream::FalseStar), &mut stars);
        shuffle(&mut stars, &noise(Stream::Shuffle));
        Field { id: index, quaternion, stars, brightness: self.settings.brightness }
    }

    fn true_stars(&self, quaternion: [f64; 4], noise: &Noise) -> Vec<FieldStar> {
        let matrix = attitude::matrix(quaternion);
        let mut found = Vec::new();
        for star in self.stars.iter().filter(|s| s.v <= self.settings.limit_v) {
            if dot(matrix[2], star.direction) < self.cone_cosine {
                continue;
            }
            let truth = self.optics.project(attitude::apply(&matrix, star.direction));
            let Some([x, y]) = truth.filter(|p| self.optics.on_detector(*p)) else { continue };
            // The noise belongs to the star, not to its turn in the list: another limit leaves it as it is.
            let error = |axis| self.settings.noise_px * noise.gaussian(star.hip, axis);
            let pixel = [x + error(0), y + error(1)];
            if self.optics.on_detector(pixel) {
                found.push(FieldStar { pixel, brightness: brightness(star.v), hip: Some(star.hip) });
            }
        }
        found
    }

    fn add_false_stars(&self, noise: &Noise, stars: &mut Vec<FieldStar>) {
        for index in 0..self.settings.false_stars {
            let pixel = [
                f64::from(self.settings.camera.width_px) * noise.uniform(index, 0) - 0.5,
                f64::from(self.settings.camera.height_px) * noise.uniform(index, 1) - 0.5,
            ];
            let v = self.settings.limit_v - 4.0 * noise.uniform(index, 2);
            stars.push(FieldStar { pixel, brightness: brightness(v), hip: None });
        }
    }
}

fn brightness(v: f64) -> f64 {
    libm::pow(10.0, -0.4 * v)
}

/// Fisher and Yates; the remainder's bias is below 1e-15.
fn shuffle(stars: &mut [FieldStar], noise: &Noise) {
    for last in (1..stars.len()).rev() {
        let other = noise.bits(last as u32, 0) % (last as u64 + 1);
        stars.swap(last, other as usize);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sky() -> Vec<WorldStar> {
        let noise = Noise::new(1, 0, Stream::Attitude);
        let star = |index| WorldStar {
            hip: index + 1,
            direction: attitude::matrix(attitude::uniform(&noise, index))[2],
            v: 6.0 * noise.uniform(index, 9),
            b_v: 0.0,
        };
        (0..5000).map(star).collect()
    }

    fn settings() -> FieldSettings {
        FieldSettings {
            camera: CameraFile::from_fov(1024, 1024, 10, 15.0).unwrap(),
            limit_v: 5.0,
            noise_px: 0.3,
            false_stars: 7,
            brightness: true,
            seed: 4,
        }
    }

    #[test]
    fn the_truth_fits_the_centroids_within_the_noise() {
        let sky = sky();
        let generator = FieldGenerator::new(settings(), &sky).unwrap();
        let (mut square, mut count) = (0.0f64, 0.0f64);
        for index in 0..200 {
            let field = generator.field(index);
            assert_eq!(field.stars.iter().filter(|s| s.hip.is_none()).count(), 7);
            // Projected back onto the sky and compared there, not through the generator's own projection.
            let rows = attitude::matrix(field.quaternion);
            for star in &field.stars {
                let Some(hip) = star.hip else { continue };
                let truth = sky[hip as usize - 1];
                assert!(truth.v <= 5.0);
                let b = attitude::apply(&rows, truth.direction);
                let f = generator.settings.camera.focal_length_px;
                for axis in 0..2 {
                    let error = star.pixel[axis] - 511.5 - f * b[axis] / b[2];
                    assert!(error.abs() < 0.3 * 6.0);
                    square += error * error;
                    count += 1.0;
                }
            }
        }
        // Chi-square of all errors, 4 sigma.
        let ratio = square / count / 0.09;
        assert!(count > 5000.0 && (ratio - 1.0).abs() < 4.0 * (2.0 / count).sqrt(), "{ratio} of {count}");
    }

    #[test]
    fn a_field_depends_on_seed_and_index_only() {
        let sky = sky();
        let generator = FieldGenerator::new(settings(), &sky).unwrap();
        let ahead = generator.field(17);
        (0..17).for_each(|i| assert_ne!(generator.field(i).quaternion, ahead.quaternion));
        assert_eq!(generator.field(17), ahead);
        let other = FieldGenerator::new(FieldSettings { seed: 5, ..settings() }, &sky).unwrap();
        assert_ne!(other.field(17).quaternion, ahead.quaternion);
    }

    #[test]
    fn a_line_has_the_documented_form() {
        let sky = sky();
        let field = FieldGenerator::new(settings(), &sky).unwrap().field(3);
        let input: serde_json::Value = serde_json::from_str(&field.input_line()).unwrap();
        assert_eq!(input["id"], json!(3));
        assert_eq!(input["centroids"].as_array().unwrap().len(), field.stars.len());
        assert_eq!(input["centroids"][0].as_array().unwrap().len(), 3);
        let plain =
            FieldGenerator::new(FieldSettings { brightness: false, ..settings() }, &sky).unwrap().field(3);
        let input: serde_json::Value = serde_json::from_str(&plain.input_line()).unwrap();
        assert_eq!(input["centroids"][0].as_array().unwrap().len(), 2);
    }

    #[test]
    fn the_order_carries_no_information() {
        let sky = sky();
        let generator = FieldGenerator::new(settings(), &sky).unwrap();
        let first_is_false = (0..2000)
            .filter(|i| generator.field(*i).stars.first().is_some_and(|s| s.hip.is_none()))
            .count() as f64;
        let expected: f64 = (0..2000).map(|i| 7.0 / generator.field(i).stars.len() as f64).sum();
        // Binomial, 4 sigma.
        assert!((first_is_false - expected).abs() < 4.0 * (expected * (1.0 - expected / 2000.0)).sqrt());
    }
}
