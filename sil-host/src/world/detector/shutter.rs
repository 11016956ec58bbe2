//! The shutter: when a row collects light, and where a star is then.
//!
//! Global: all rows integrate about the same instant. Rolling: row `y` integrates for as long, about `t +
//! (y - middle) row_time`; a star is then seen where it is at the time of its own row, `y = y(t + (y -
//! middle) row_time)`, which is found by iteration: a round makes the error smaller by the rows a star
//! crosses in a row's time. Attitudes in between come from matrices at even steps, interpolated line by line;
//! their rows keep their length to `TURN_RAD`² / 8 = 3e-8, and the direction is put right by the projection.

use crate::world::attitude::{Vector, apply, matrix};
use crate::world::lens::optics::Optics;

/// Largest turn between two matrices, rad: the place is right to 1e-4 px at f = 3000 px.
const TURN_RAD: f64 = 5e-4;
/// Fewest and most matrices over a rolling exposure.
const NODES: (f64, f64) = (9.0, 8192.0);
/// Agreement at which the row's time is found, px.
const AGREEMENT_PX: f64 = 1e-7;
/// Most rounds.
const ROUNDS_MAX: u32 = 20;

/// When rows collect light.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shutter {
    /// All at once.
    Global,
    /// One after the other.
    Rolling {
        /// From a row to the next, s.
        row_time_s: f64,
    },
}

impl Shutter {
    /// From a row to the next, s.
    pub fn row_time_s(self) -> f64 {
        match self {
            Self::Global => 0.0,
            Self::Rolling { row_time_s } => row_time_s,
        }
    }
}

/// The attitudes of an exposure, step by step through the time that a pixel collects light.
#[derive(Debug, Clone)]
pub struct Way {
    nodes: Vec<[Vector; 3]>,
    start_s: f64,
    nodes_per_s: f64,
    /// Middle of each step, s.
    steps_s: Vec<f64>,
    row_time_s: f64,
    rows: f64,
}

impl Way {
    /// Of an exposure of `time_s` about `middle_s`, in `steps` equal parts, of a detector with `rows` rows
    /// that turns with `rate_rad_s`; `attitude` gives the quaternion of an instant.
    pub fn new(
        shutter: Shutter,
        attitude: impl Fn(f64) -> [f64; 4],
        (middle_s, time_s): (f64, f64),
        steps: u32,
        rows: u16,
        rate_rad_s: f64,
    ) -> Self {
        let step_s = |step: u32| middle_s + time_s * ((f64::from(step) + 0.5) / f64::from(steps) - 0.5);
        let steps_s: Vec<f64> = (0..steps).map(step_s).collect();
        let rows = f64::from(rows);
        match shutter {
            Shutter::Global => Self {
                nodes: steps_s.iter().map(|t| matrix(attitude(*t))).collect(),
                start_s: 0.0,
                nodes_per_s: 0.0,
                steps_s,
                row_time_s: 0.0,
                rows,
            },
            Shutter::Rolling { row_time_s } => {
                let span_s = time_s + rows * row_time_s;
                let parts = (rate_rad_s * span_s / TURN_RAD).ceil().clamp(NODES.0 - 1.0, NODES.1);
                let start_s = middle_s - 0.5 * span_s;
                let node = |k: u32| matrix(attitude(start_s + span_s * f64::from(k) / parts));
                Self {
                    nodes: (0..=parts as u32).map(node).collect(),
                    start_s,
                    nodes_per_s: parts / span_s,
                    steps_s,
                    row_time_s,
                    rows,
                }
            }
        }
    }

    /// Number of steps.
    pub fn steps(&self) -> usize {
        self.steps_s.len()
    }

    /// Middle of a step in the middle row, s.
    pub fn step_s(&self, step: usize) -> f64 {
        self.steps_s[step]
    }

    /// Where `direction` is imaged in `step`, px; `None` where the camera does not see it.
    pub fn place(&self, step: usize, direction: Vector, optics: &Optics) -> Option<[f64; 2]> {
        if self.row_time_s == 0.0 && self.nodes_per_s == 0.0 {
            return optics.project(apply(&self.nodes[step], direction));
        }
        let middle = 0.5 * (self.rows - 1.0);
        let mut row = middle;
        for _ in 0..ROUNDS_MAX {
            let time_s = self.steps_s[step] + (row - middle) * self.row_time_s;
            let pixel = optics.project(self.seen(time_s, direction))?;
            // Rows off the detector collect nothing: their time is that of the nearest.
            let next = pixel[1].clamp(-0.5, self.rows - 0.5);
            if (next - row).abs() < AGREEMENT_PX {
                return Some(pixel);
            }
            row = next;
        }
        None
    }

    /// `direction` in the sensor frame at an instant, any length.
    fn seen(&self, time_s: f64, direction: Vector) -> Vector {
        let place = ((time_s - self.start_s) * self.nodes_per_s).max(0.0);
        let index = (place as usize).min(self.nodes.len() - 2);
        let part = place - index as f64;
        let (a, b) = (apply(&self.nodes[index], direction), apply(&self.nodes[index + 1], direction));
        [0, 1, 2].map(|k| a[k] + part * (b[k] - a[k]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::camera_file::CameraFile;
    use crate::world::attitude::Turning;

    #[test]
    fn a_star_is_seen_where_it_is_at_the_time_of_its_row() {
        let optics = Optics::new(&CameraFile::reference()).unwrap();
        let turning = Turning { quaternion: [0.0, 0.0, 0.0, 1.0], rate_rad_s: [0.02, -0.03, 0.05] };
        let row_time_s = 4e-4;
        let way = |shutter| Way::new(shutter, |t| turning.at(t), (2.0, 0.3), 1, 1024, 0.07);
        let (rolling, global) = (way(Shutter::Rolling { row_time_s }), way(Shutter::Global));
        for pixel in [[100.0, 40.0], [900.0, 1000.0], [640.0, 511.5]] {
            // A star that is there at the middle of the exposure.
            let frame = matrix(turning.at(2.0));
            let d = optics.unproject(pixel).unwrap();
            let star = [0, 1, 2].map(|k| (0..3).map(|j| frame[j][k] * d[j]).sum::<f64>());
            let at_once = global.place(0, star, &optics).unwrap();
            assert!((at_once[0] - pixel[0]).abs() < 1e-6 && (at_once[1] - pixel[1]).abs() < 1e-6);
            let seen = rolling.place(0, star, &optics).unwrap();
            let time_s = 2.0 + (seen[1] - 511.5) * row_time_s;
            let then = optics.project(apply(&matrix(turning.at(time_s)), star)).unwrap();
            assert!(
                (seen[0] - then[0]).abs() < 1e-4 && (seen[1] - then[1]).abs() < 1e-4,
                "{seen:?} {then:?}"
            );
            assert!(pixel[1] == 511.5 || (seen[0] - pixel[0]).abs() > 5.0);
        }
    }

    #[test]
    fn a_rolling_shutter_without_row_time_or_motion_changes_nothing() {
        let optics = Optics::new(&CameraFile::reference()).unwrap();
        let still = |_| [0.1, -0.2, 0.3, 0.927_361_849_549_570_4];
        let star = matrix(still(0.0))[2];
        let place =
            |shutter| Way::new(shutter, still, (0.0, 0.4), 1, 1024, 0.0).place(0, star, &optics).unwrap();
        let (global, rolling) = (place(Shutter::Global), place(Shutter::Rolling { row_time_s: 5e-5 }));
        assert!((global[0] - rolling[0]).abs() < 1e-9 && (global[1] - rolling[1]).abs() < 1e-9);
    }
}
