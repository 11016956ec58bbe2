use super::*;
use crate::attitude::VectorPair;
use crate::frames::Direction;
use crate::oracle::Generator;
use std::vec::Vec;

const ARCSEC: f32 = 1.0 / 206_264.8;
const DEG: f32 = 3600.0 * ARCSEC;
const SIGMA: [f32; 3] = [1.0 * ARCSEC, 1.0 * ARCSEC, 6.0 * ARCSEC];
/// Time over which the errors of a star on its pixels forget each other, s.
const COLOUR_S: f32 = 20.0;
/// Way over which they do, px.
const COLOUR_PX: f32 = 30.0;

fn vector(generator: &mut Generator) -> Vector3<f32> {
    generator.gaussian_vector().map(|component| component as f32)
}

/// A sensor that turns, and what its images say: errors of [`SIGMA`], of which [`CORRELATED_SHARE`] lasts.
struct Turning {
    attitude: nalgebra::Rotation3<f64>,
    cycle: u32,
    lasting: Vector3<f32>,
    generator: Generator,
}

impl Turning {
    fn new(seed: u64) -> Self {
        let mut generator = Generator::new(seed);
        let attitude = nalgebra::Rotation3::new(generator.unit() * generator.between(0.0, 3.0));
        let lasting = vector(&mut generator);
        Self { attitude, cycle: 0, lasting, generator }
    }

    /// A second at `rate`, rad/s.
    fn turn(&mut self, rate: &Vector3<f32>) {
        self.attitude = nalgebra::Rotation3::new(-rate.map(f64::from)) * self.attitude;
        self.cycle += 1;
        // At a degree a second a star crosses 68 pixels in one.
        let crossed_px = rate.norm() / DEG * 68.0;
        let kept = (-1.0 / COLOUR_S - crossed_px / COLOUR_PX).exp();
        self.lasting = self.lasting * kept + vector(&mut self.generator) * (1.0 - kept * kept).sqrt();
    }

    fn now(&self) -> LocalTime {
        LocalTime::from_us(i64::from(self.cycle) * 1_000_000)
    }

    fn truth(&self) -> Rotation<Icrs, StarPath> {
        Rotation::from_orthogonal(self.attitude.matrix().map(|element| element as f32))
    }

    fn image(&mut self) -> Rotation<Icrs, StarPath> {
        let error = self.lasting * CORRELATED_SHARE.sqrt()
            + vector(&mut self.generator) * (1.0 - CORRELATED_SHARE).sqrt();
        self.truth().turned(&error.component_mul(&Vector3::from(SIGMA)))
    }

    fn begin(&mut self) -> Filter {
        Filter::new(self.image(), SIGMA, self.now())
    }

    fn update_by_image(&mut self, filter: &mut Filter) {
        filter.measurement_update(self.image(), SIGMA, self.now());
    }

    /// Error of a filter's attitude now over its sigma, and over that of an image.
    fn errors(&self, filter: &Filter) -> (Vector3<f32>, Vector3<f32>) {
        let (attitude, sigma) = filter.at(self.now()).unwrap();
        let error = attitude.angle_from(&self.truth());
        (error.component_div(&Vector3::from(sigma)), error.component_div(&Vector3::from(SIGMA)))
    }
}

fn mean_square(of: &[Vector3<f32>]) -> f32 {
    of.iter().map(Vector3::norm_squared).sum::<f32>() / (3 * of.len()) as f32
}

#[test]
fn one_attitude_gives_no_rate_and_no_prediction() {
    let filter = Turning::new(1).begin();
    assert!(
        filter.rate().is_none()
            && [0, 1].iter().all(|us| filter.at(LocalTime::from_us(us * 1_000_000)).is_none())
    );
}

#[test]
fn a_rate_that_is_known_from_elsewhere_predicts_the_second_attitude() {
    const RATE_SIGMA: f32 = 0.02 * DEG;
    let (mut offs, mut expected) = (Vec::new(), 0);
    for seed in 1..=200 {
        let mut turning = Turning::new(seed);
        let rate = vector(&mut turning.generator) * DEG;
        let error = vector(&mut turning.generator) * RATE_SIGMA;
        let told = Rate { rad_s: rate + error, sigma_rad_s: Vector3::repeat(RATE_SIGMA) };
        let mut filter = turning.begin().with_rate(&told);
        turning.turn(&rate);
        offs.push(turning.errors(&filter).0);
        let image = turning.image();
        expected += usize::from(filter.expects(&image, &SIGMA, turning.now()));
        let wrong = image.turned(&Vector3::new(0.0, 0.0, 12.0 * RATE_SIGMA));
        assert!(!filter.expects(&wrong, &SIGMA, turning.now()), "seed {seed}");
        filter.measurement_update(image, SIGMA, turning.now());
        assert!(turning.errors(&filter).0.amax() < 5.0, "seed {seed}");
    }
    // Below 1: the rate of a body that turns freely would change. 600 squares of standard deviation 1.4.
    let mean = mean_square(&offs);
    std::println!("squares of the error over its sigma {mean:.2}, {expected} of 200 within 3 sigma");
    assert!((0.5..1.2).contains(&mean) && expected >= 196);
    let alone = Turning::new(1).begin();
    assert!(!alone.expects(&Turning::new(1).image(), &SIGMA, alone.instant));
}

#[test]
fn rates_without_attitudes_hold_the_prediction_of_a_turn_that_changes() {
    const RATE_SIGMA: f32 = 0.01 * DEG;
    let (mut with, mut without, mut sigmas) = (Vec::new(), Vec::new(), Vec::new());
    for seed in 1..=100 {
        let mut turning = Turning::new(seed);
        let mut rate = vector(&mut turning.generator) * (2.0 * DEG);
        let measured = |turning: &mut Turning, rate: &Vector3<f32>| {
            let error = vector(&mut turning.generator) * RATE_SIGMA;
            Rate { rad_s: rate + error, sigma_rad_s: Vector3::repeat(RATE_SIGMA) }
        };
        let told = measured(&mut turning, &rate);
        let mut filter = turning.begin().with_rate(&told);
        let mut alone = filter;
        for _ in 0..5 {
            let change = vector(&mut turning.generator) * free_body_change(&rate);
            // The sensor turns by the mean of the rates before and after.
            turning.turn(&(rate + change * 0.5));
            rate += change;
            let told = measured(&mut turning, &rate);
            filter.measurement_update_rate(&told, turning.now());
        }
        let off = |filter: &Filter| filter.at(turning.now()).unwrap().0.angle_from(&turning.truth());
        with.push(off(&filter));
        without.push(off(&alone));
        sigmas.push(turning.errors(&filter).0);
        // A rate from nowhere changes nothing.
        let wrong = Rate { rad_s: rate.map(|axis| axis + 0.1), sigma_rad_s: Vector3::repeat(1e-5) };
        assert!(!filter.measurement_update_rate(&wrong, turning.now()));
        alone = alone.with_rate_sensor(RateSensorNoise::default());
        assert!(!alone.measurement_update_rate(&told, turning.now()));
    }
    let (ratio, square) = (mean_square(&with) / mean_square(&without), mean_square(&sigmas));
    std::println!("variance with rates over that without {ratio:.3}, squares over sigma {square:.2}");
    assert!(ratio < 0.3 && (0.4..2.0).contains(&square));
}

#[test]
fn of_a_body_that_tumbles_the_sigma_grows_as_its_rate_may_change() {
    let error_and_sigma = |rate_deg_s: f32| {
        let mut turning = Turning::new(7);
        let mut rate = Vector3::new(0.0, rate_deg_s, 0.0) * DEG;
        let mut filter = turning.begin();
        for second in 0..30 {
            // Its axis goes round in it.
            rate += Vector3::new(rate.y, -rate.x, 0.0) * (free_body_change(&rate) / rate.norm());
            turning.turn(&rate);
            if second < 15 {
                turning.update_by_image(&mut filter);
            }
        }
        let (attitude, sigma) = filter.at(turning.now()).unwrap();
        (attitude.angle_from(&turning.truth()).amax(), Vector3::from(sigma).amax())
    };
    for rate_deg_s in [0.6, 1.0, 1.5, 2.0] {
        let (error, sigma) = error_and_sigma(rate_deg_s);
        assert!(error < 3.0 * sigma && error > 0.2 * sigma, "{rate_deg_s} deg/s: {error}, {sigma}");
    }
    // At rest seconds do not count.
    assert!(error_and_sigma(0.01).1 < 100.0 * ARCSEC);
}

#[test]
fn at_any_rate_up_to_ten_degrees_a_second_the_filter_is_honest_and_better_than_its_images() {
    // 100 flights of 300 s. The coloured share is all that should be left: 0.35 of the variance; less than
    // 0.55 is asked.
    for rate_deg_s in [0.0, 0.004, 0.06, 1.0, 10.0] {
        let (mut normalised, mut relative, mut rates) = (Vec::new(), Vec::new(), Vec::new());
        for seed in 0..100 {
            let mut truth = Turning::new(1000 + seed);
            let rate = vector(&mut truth.generator).normalize() * (rate_deg_s * DEG);
            let mut filter = truth.begin();
            for _ in 0..300 {
                truth.turn(&rate);
                truth.update_by_image(&mut filter);
            }
            let (over_sigma, over_image) = truth.errors(&filter);
            normalised.push(over_sigma);
            relative.push(over_image);
            let told = filter.rate().unwrap();
            rates.push((told.rad_s - rate).component_div(&told.sigma_rad_s));
        }
        let [nees, share, rate_nees] = [&normalised, &relative, &rates].map(|of| mean_square(of));
        std::println!(
            "{rate_deg_s} deg/s: (error / sigma)² {nees:.2}, of an image's variance {share:.2}, rate {rate_nees:.2}"
        );
        // 300 degrees of freedom: 99.9 % within 0.75 to 1.29 for an exact sigma; this one errs to the safe
        // side.
        assert!((0.5..1.29).contains(&nees), "{nees}");
        assert!((0.3..1.29).contains(&rate_nees), "{rate_nees}");
        assert!(share < 0.55, "{share}");
    }
}

#[test]
fn the_attitude_is_carried_for_twenty_minutes_within_its_sigma() {
    let mut errors = Vec::new();
    for seed in 0..100 {
        let mut truth = Turning::new(31 + seed);
        let rate = Vector3::new(0.0, 1.1e-3, 2e-4);
        let mut filter = truth.begin();
        for _ in 0..200 {
            truth.turn(&rate);
            truth.update_by_image(&mut filter);
        }
        for _ in 0..1200 {
            truth.turn(&rate);
            filter.propagate(truth.now(), None);
        }
        errors.push(truth.errors(&filter).0);
    }
    let nees = mean_square(&errors);
    std::println!("mean normalised square error after 1200 s blind: {nees:.3}");
    // The sigma expects a rate that changes, so it may be far too large here, but never too small.
    assert!((0.005..1.29).contains(&nees), "{nees}");
}

#[test]
fn a_slew_is_followed_without_an_error_beyond_an_images() {
    // From rest to 0.5 deg/s in 20 s and back again.
    let (mut normalised, mut relative) = (Vec::new(), Vec::new());
    for seed in 0..50 {
        let mut truth = Turning::new(500 + seed);
        let axis = vector(&mut truth.generator).normalize();
        let mut filter = truth.begin();
        for second in 0..200 {
            let rate_deg_s = match second {
                100..120 => 0.025 * (second - 99) as f32,
                120..140 => 0.5 - 0.025 * (second - 119) as f32,
                _ => 0.0,
            };
            truth.turn(&(axis * (rate_deg_s * DEG)));
            truth.update_by_image(&mut filter);
            if second > 90 {
                let (over_sigma, over_image) = truth.errors(&filter);
                normalised.push(over_sigma);
                relative.push(over_image);
            }
        }
    }
    let (nees, share) = (mean_square(&normalised), mean_square(&relative));
    let beyond = normalised.iter().flatten().filter(|error| error.abs() > 3.0).count();
    let beyond = beyond as f32 / (3 * normalised.len()) as f32;
    std::println!(
        "slew: (error / sigma)² {nees:.2}, of an image's variance {share:.2}, beyond 3 sigma {beyond:.4}"
    );
    assert!(nees < 1.3 && share < 1.0 && beyond < 0.005);
}

#[test]
fn of_a_turn_that_an_image_says_to_change_the_prediction_is_not_believed() {
    // Two minutes at rest; then it begins to turn by 2 arcsec a second in a blurred image, known to 25.
    let blurred = SIGMA.map(|sigma| sigma + 25.0 * ARCSEC);
    let errors = [false, true].map(|told| {
        let mut errors = Vec::new();
        for seed in 0..40 {
            let mut turning = Turning::new(seed);
            let mut filter = turning.begin();
            for _ in 0..120 {
                turning.turn(&Vector3::zeros());
                filter.measurement_update(turning.image(), SIGMA, turning.now());
            }
            let rate = turning.generator.unit().map(|axis| axis as f32) * (2.0 * ARCSEC);
            if told {
                filter.expect_change();
            }
            for sigma in [blurred, SIGMA] {
                turning.turn(&rate);
                filter.measurement_update(turning.image(), sigma, turning.now());
            }
            errors.push(turning.errors(&filter).0);
        }
        mean_square(&errors)
    });
    std::println!("mean square of error over sigma {:.1}, told {:.1}", errors[0], errors[1]);
    assert!(errors[0] > 2.0 * errors[1] && errors[1] < 2.0);
}

#[test]
fn what_turns_otherwise_than_predicted_is_not_steady_until_ten_seconds_agree() {
    let mut truth = Turning::new(7);
    let mut filter = truth.begin();
    let (rest, turn) = (Vector3::zeros(), Vector3::new(0.0, 0.1 * DEG, 0.0));
    // A turn by 0.1 deg in the 40th second; an image without stars in the 80th.
    for second in 0..100 {
        truth.turn(if second == 40 { &turn } else { &rest });
        if second == 80 {
            filter.contradict(truth.now());
        } else {
            truth.update_by_image(&mut filter);
        }
        // The image after the turn contradicts the rate that the turn left.
        let unsteady = (40..51).contains(&second) || (80..90).contains(&second);
        assert_eq!(filter.is_steady(), !unsteady, "{second}");
    }
    // A rate sensor tells of any turn.
    filter.contradict(truth.now());
    let noise = RateSensorNoise { white_rad: ARCSEC, walk_rad_s: 0.001 * ARCSEC, bias_rad_s: 20.0 * ARCSEC };
    assert!(!filter.is_steady() && filter.with_rate_sensor(noise).is_steady());
}

#[test]
fn a_rate_sensor_bears_a_slew_in_the_dark_and_its_bias_is_found() {
    // A fibre-optic gyro: 1 arcsec in a second, bias 20 deg/h.
    let noise = RateSensorNoise { white_rad: ARCSEC, walk_rad_s: 0.001 * ARCSEC, bias_rad_s: 20.0 * ARCSEC };
    let (mut biases, mut dark, mut without) = (Vec::new(), Vec::new(), 0);
    for seed in 0..100 {
        let mut truth = Turning::new(900 + seed);
        let bias = vector(&mut truth.generator) * noise.bias_rad_s;
        let axis = vector(&mut truth.generator).normalize();
        let mut alone = truth.begin();
        let mut filter = alone.with_rate_sensor(noise);
        for second in 0..260 {
            let rate = if second < 200 { Vector3::zeros() } else { axis * (0.5 * DEG) };
            truth.turn(&rate);
            let white = vector(&mut truth.generator) * noise.white_rad;
            filter.propagate(truth.now(), Some(rate + bias + white));
            if second < 200 {
                let image = truth.image();
                filter.measurement_update(image, SIGMA, truth.now());
                alone.measurement_update(image, SIGMA, truth.now());
            } else {
                alone.propagate(truth.now(), None);
            }
            if second == 199 {
                let error = filter.driven + bias;
                let variance = filter.covariance.at(RATE, RATE).diagonal();
                biases.push(error.component_div(&filter.sigma(&variance)));
            }
        }
        dark.push(truth.errors(&filter).0);
        without += usize::from(truth.errors(&alone).0.norm() > 10.0);
    }
    let (bias, dark) = (mean_square(&biases), mean_square(&dark));
    std::println!(
        "bias (error / sigma)² {bias:.2}; after a slew of 60 s in the dark {dark:.2}, {without} of 100 lost without"
    );
    assert!((0.5..1.29).contains(&bias) && (0.5..1.29).contains(&dark) && without == 100);
}

#[test]
fn a_gap_does_not_spoil_the_rate() {
    let rate = Vector3::new(1e-4, -5e-4, 3e-4);
    let mut truth = Turning::new(5);
    let mut filter = truth.begin();
    for _ in 0..60 {
        truth.turn(&rate);
        truth.update_by_image(&mut filter);
    }
    for _ in 0..5000 {
        truth.turn(&rate);
    }
    truth.update_by_image(&mut filter);
    assert_eq!(filter.age_us(truth.now()), 0);
    assert!((filter.rate().unwrap().rad_s - rate).norm() < 3.0 * ARCSEC);
    let (over_sigma, _) = truth.errors(&filter);
    assert!(over_sigma.amax() < 4.0, "{over_sigma}");
}

#[test]
fn a_turn_too_far_is_not_predicted() {
    let mut truth = Turning::new(9);
    let mut filter = truth.begin();
    for _ in 0..5 {
        truth.turn(&Vector3::new(0.0, 0.01, 0.0));
        truth.update_by_image(&mut filter);
    }
    let after = |second: i64| filter.at(LocalTime::from_us(second * 1_000_000));
    assert!(after(100).is_some() && after(5 + 200).is_none() && after(4).is_none());
}

#[test]
fn the_mean_turn_is_the_integral_of_turns() {
    for angle in
        [Vector3::new(1e-4, -2e-4, 5e-5), Vector3::new(0.3, 0.1, -0.2), Vector3::new(-0.8, 0.9, 0.85)]
    {
        // Midpoints of 2000 steps, in f64.
        let step = |k: usize| {
            let part = angle.map(f64::from) * ((k as f64 + 0.5) / 2000.0);
            nalgebra::Rotation3::new(-part).into_inner()
        };
        let mean = (0..2000).map(step).sum::<Matrix3<f64>>() / 2000.0;
        let turn = RotationStep::by(angle);
        let whole = nalgebra::Rotation3::new(-angle.map(f64::from)).into_inner();
        assert!((turn.mean.map(f64::from) - mean).amax() < 3e-6, "{}", turn.mean.map(f64::from) - mean);
        assert!((turn.whole.map(f64::from) - whole).amax() < 3e-6);
    }
}

/// What a star in this direction of the star path says, with its error.
fn star(turning: &mut Turning, direction: Vector3<f32>, sigma_rad: f32) -> VectorPair {
    let truth = turning.truth();
    let seen = Direction::<StarPath>::new(direction).unwrap();
    let error = vector(&mut turning.generator) * sigma_rad;
    let measured = Direction::new(seen.vector() + error - seen.vector() * seen.vector().dot(&error)).unwrap();
    VectorPair { measured, reference: truth.inverse().apply(&seen), sigma_rad }
}

#[test]
fn one_star_holds_its_direction_and_a_second_the_roll() {
    // 100 flights: a minute of whole attitudes, then five of one or two stars 10 degrees apart, at 0.06
    // deg/s.
    const STAR_SIGMA: f32 = 3.0 * ARCSEC;
    let places = [Vector3::new(0.05, 0.08, 1.0), Vector3::new(-0.1, -0.03, 1.0)];
    for (count, roll_arcsec) in [(1, 600.0), (2, 30.0)] {
        let (mut errors, mut rolls, mut across) = (Vec::new(), Vec::new(), Vec::new());
        for seed in 0..100 {
            let mut turning = Turning::new(3000 + seed);
            let rate = vector(&mut turning.generator).normalize() * (0.06 * DEG);
            let mut filter = turning.begin();
            for _ in 0..60 {
                turning.turn(&rate);
                turning.update_by_image(&mut filter);
            }
            for _ in 0..300 {
                turning.turn(&rate);
                for place in places.iter().take(count) {
                    let seen = star(&mut turning, *place, STAR_SIGMA);
                    assert!(filter.measurement_update_star(&seen, turning.now()));
                }
            }
            errors.push(turning.errors(&filter).0);
            let error = filter.at(turning.now()).unwrap().0.angle_from(&turning.truth()) / ARCSEC;
            rolls.push(error.z.abs());
            across.push(error.cross(&places[0].normalize()).norm());
        }
        let largest = |of: &[f32]| of.iter().copied().fold(0.0, f32::max);
        std::println!(
            "{count} stars: the first off by {:.2}, roll by {:.1} arcsec at most, normalised square {:.2}",
            largest(&across),
            largest(&rolls),
            mean_square(&errors)
        );
        assert!(largest(&across) < 6.0 && largest(&rolls) < roll_arcsec && mean_square(&errors) < 1.3);
    }
}

#[test]
fn a_star_where_none_is_expected_changes_nothing() {
    let mut turning = Turning::new(7);
    let rate = Vector3::new(0.0, 0.06 * DEG, 0.0);
    let mut filter = turning.begin();
    for _ in 0..20 {
        turning.turn(&rate);
        turning.update_by_image(&mut filter);
    }
    turning.turn(&rate);
    let mut seen = star(&mut turning, Vector3::new(0.0, 0.1, 1.0), 1.0 * ARCSEC);
    let before = filter.at(turning.now()).unwrap();
    seen.measured = Direction::new(seen.measured.vector() + Vector3::new(60.0 * ARCSEC, 0.0, 0.0)).unwrap();
    assert!(!filter.measurement_update_star(&seen, turning.now()));
    assert_eq!(filter.at(turning.now()).unwrap().1, before.1);
    assert_eq!(filter.age_us(turning.now()), 1_000_000);
}

#[test]
fn images_late_early_and_out_of_order_are_taken_for_what_their_instants_say() {
    // 0.5 deg/s; images 0.2 to 6 s apart, then one of an instant long ago.
    let rate = Vector3::new(3.0e-3, -6.0e-3, 5.0e-3);
    let mut truth = Turning::new(12);
    let mut filter = truth.begin();
    let start = truth.attitude;
    let mut now_us = 0;
    for (index, step_us) in
        [1_000_000, 200_000, 6_000_000, 1_000_000, 350_000, 1_800_000].iter().cycle().take(60).enumerate()
    {
        now_us += step_us;
        let now = LocalTime::from_us(now_us);
        truth.attitude = nalgebra::Rotation3::new(-rate.map(f64::from) * (now_us as f64 * 1e-6)) * start;
        filter.measurement_update(truth.image(), SIGMA, now);
        if index > 3 {
            let (attitude, sigma) = filter.at(now).unwrap();
            let error = attitude.angle_from(&truth.truth()).component_div(&Vector3::from(sigma));
            assert!(error.amax() < 5.0, "image {index}: {error}");
            assert!((filter.rate().unwrap().rad_s - rate).norm() < 10.0 * ARCSEC);
        }
    }
    assert!(filter.at(LocalTime::from_us(now_us - 1)).is_none());
    assert!(
        filter.at(LocalTime::from_us(i64::MAX)).is_none()
            && filter.at(LocalTime::from_us(i64::MIN)).is_none()
    );
}
