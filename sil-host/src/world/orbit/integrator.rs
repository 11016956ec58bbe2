//! Steps along the equation of motion.
//!
//! In: acceleration as a function of time, position and velocity; a start. Out: [`Node`]s at the steps taken.
//! Method: Dormand and Prince of order 8 with error estimates of orders 5 and 3 (Hairer, Norsett and Wanner,
//! Solving Ordinary Differential Equations I, 2nd ed., DOP853). A step is taken when the estimate is below
//! the tolerance in position (km), and in velocity below that times the angular rate; it never exceeds
//! [`LONGEST_STEP`] of a radian, so that the curve between nodes keeps the accuracy of the nodes. The steps
//! do not depend on how long the run is.

use crate::world::attitude::Vector;
use crate::world::vector::{length, plus};

/// Longest step in radians of a circular orbit through the place.
const LONGEST_STEP: f64 = 0.1;
/// Shortest step, s: taken whatever the estimate says.
const SHORTEST_STEP_S: f64 = 0.05;
/// Greatest change of the step, down and up.
const CHANGE: (f64, f64) = (0.3, 3.0);

/// A place on the way, with all that the curve to the next needs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Node {
    pub(super) t_s: f64,
    pub(super) position: Vector,
    pub(super) velocity: Vector,
    pub(super) acceleration: Vector,
}

/// Times of the stages, in steps.
const TIMES: [f64; 12] = [
    0.0,
    0.052_600_151_958_767_73,
    0.078_900_227_938_151_6,
    0.118_350_341_907_227_4,
    0.281_649_658_092_772_6,
    0.333_333_333_333_333_3,
    0.25,
    0.307_692_307_692_307_7,
    0.651_282_051_282_051_3,
    0.6,
    0.857_142_857_142_857_1,
    1.0,
];
/// Weights of the earlier stages in each stage from the second on.
const STAGES: [&[f64]; 11] = [
    &[0.05260015195876773],
    &[0.0197250569845379, 0.0591751709536137],
    &[0.02958758547680685, 0.0, 0.08876275643042054],
    &[0.2413651341592667, 0.0, -0.8845494793282861, 0.924834003261792],
    &[0.037037037037037035, 0.0, 0.0, 0.17082860872947386, 0.12546768756682242],
    &[0.037109375, 0.0, 0.0, 0.17025221101954405, 0.06021653898045596, -0.017578125],
    &[
        0.03709200011850479,
        0.0,
        0.0,
        0.17038392571223998,
        0.10726203044637328,
        -0.015319437748624402,
        0.008273789163814023,
    ],
    &[
        0.6241109587160757,
        0.0,
        0.0,
        -3.3608926294469414,
        -0.868219346841726,
        27.59209969944671,
        20.154067550477894,
        -43.48988418106996,
    ],
    &[
        0.47766253643826434,
        0.0,
        0.0,
        -2.4881146199716677,
        -0.590290826836843,
        21.230051448181193,
        15.279233632882423,
        -33.28821096898486,
        -0.020331201708508627,
    ],
    &[
        -0.9371424300859873,
        0.0,
        0.0,
        5.186372428844064,
        1.0914373489967295,
        -8.149787010746927,
        -18.52006565999696,
        22.739487099350505,
        2.4936055526796523,
        -3.0467644718982196,
    ],
    &[
        2.273310147516538,
        0.0,
        0.0,
        -10.53449546673725,
        -2.0008720582248625,
        -17.9589318631188,
        27.94888452941996,
        -2.8589982771350235,
        -8.87285693353063,
        12.360567175794303,
        0.6433927460157636,
    ],
];
/// Weights of the stages in the step.
const WEIGHTS: [f64; 12] = [
    0.054293734116568765,
    0.0,
    0.0,
    0.0,
    0.0,
    4.450312892752409,
    1.8915178993145003,
    -5.801203960010585,
    0.3111643669578199,
    -0.1521609496625161,
    0.20136540080403034,
    0.04471061572777259,
];
/// In the estimates of order 3 and 5.
const ESTIMATE_3: [f64; 12] = [
    -0.18980075407240762,
    0.0,
    0.0,
    0.0,
    0.0,
    4.450312892752409,
    1.8915178993145003,
    -5.801203960010585,
    -0.4226823213237919,
    -0.1521609496625161,
    0.20136540080403034,
    0.02265179219836082,
];
const ESTIMATE_5: [f64; 12] = [
    0.01312004499419488,
    0.0,
    0.0,
    0.0,
    0.0,
    -1.2251564463762044,
    -0.4957589496572502,
    1.6643771824549864,
    -0.35032884874997366,
    0.3341791187130175,
    0.08192320648511571,
    -0.022355307863886294,
];

/// Weighted sum of the stages, position and velocity.
fn sum(weights: &[f64], stages: &[(Vector, Vector)]) -> (Vector, Vector) {
    let pairs = weights.iter().zip(stages).filter(|(weight, _)| **weight != 0.0);
    pairs.fold(([0.0; 3], [0.0; 3]), |(r, v), (weight, stage)| {
        (plus(r, *weight, stage.0), plus(v, *weight, stage.1))
    })
}

/// One step of `h` seconds, and its error in tolerances.
pub(super) fn step(
    acceleration: &mut impl FnMut(f64, Vector, Vector) -> Vector,
    from: &Node,
    h: f64,
    tolerance_km: f64,
) -> (Node, f64) {
    let mut slopes = [([0.0; 3], [0.0; 3]); 12];
    slopes[0] = (from.velocity, from.acceleration);
    for (index, weights) in STAGES.iter().enumerate() {
        let (along, faster) = sum(weights, &slopes[..=index]);
        let (r, v) = (plus(from.position, h, along), plus(from.velocity, h, faster));
        slopes[index + 1] = (v, acceleration(from.t_s + TIMES[index + 1] * h, r, v));
    }
    let (along, faster) = sum(&WEIGHTS, &slopes);
    let (position, velocity) = (plus(from.position, h, along), plus(from.velocity, h, faster));
    let t_s = from.t_s + h;
    let end = Node { t_s, position, velocity, acceleration: acceleration(t_s, position, velocity) };
    let rate = length(from.velocity) / length(from.position);
    let square = |weights: &[f64]| {
        let (r, v) = sum(weights, &slopes);
        let in_tolerances = [length(r) / tolerance_km, length(v) / (tolerance_km * rate)];
        in_tolerances.iter().map(|part| part * part).sum::<f64>()
    };
    let (five, three) = (square(&ESTIMATE_5), square(&ESTIMATE_3));
    let scale = ((five + 0.01 * three) * 6.0).sqrt();
    let error = if scale > 0.0 { h.abs() * five / scale } else { 0.0 };
    (end, if error.is_finite() { error } else { f64::MAX })
}

/// Nodes from `start` until one lies at `until_s` or beyond, or one no longer `flies`.
pub(super) fn integrate(
    acceleration: &mut impl FnMut(f64, Vector, Vector) -> Vector,
    mu_km3_s2: f64,
    start: Node,
    until_s: f64,
    tolerance_km: f64,
    mut flies: impl FnMut(&Node) -> bool,
) -> Vec<Node> {
    let longest = |node: &Node| {
        let radius = length(node.position);
        LONGEST_STEP * radius * (radius / mu_km3_s2).sqrt()
    };
    let mut nodes = vec![start];
    let mut node = start;
    let mut h = 0.3 * longest(&start);
    while node.t_s < until_s {
        h = h.min(longest(&node));
        let (next, error) = step(acceleration, &node, h, tolerance_km);
        let change = 0.9 * libm::pow(error.max(1e-12), -0.125);
        if error <= 1.0 || h <= SHORTEST_STEP_S {
            nodes.push(next);
            node = next;
            if !flies(&node) {
                break;
            }
        }
        h = (h * change.clamp(CHANGE.0, CHANGE.1)).max(SHORTEST_STEP_S);
    }
    nodes
}
