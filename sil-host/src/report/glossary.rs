//! The terms of the page, explained.

/// A term and what it means here.
pub const TERMS: [(&str, &str); 19] = [
    (
        "Error",
        "estimate less truth. The truth is the simulated world's, which the flight software never sees.",
    ),
    (
        "Sigma (\u{3c3})",
        "the standard deviation that the flight software itself reports for an estimate: its own word on how \
         far to trust it. Right sigmas hold 68 % of the errors within 1\u{3c3}, 99.7 % within 3\u{3c3}.",
    ),
    ("rms, 95 %", "root mean square of the errors; the size below which 95 % of them lie."),
    (
        "Bias, noise",
        "the mean error over the run, axis by axis, and the root mean square of what is about it (ECSS-E-ST-60-20C): \
         rms\u{b2} = bias\u{b2} + noise\u{b2}.",
    ),
    (
        "NEES, (e/\u{3c3})\u{b2}",
        "normalised estimation error squared, here over its degrees of freedom: the mean of (error / sigma)\
         \u{b2}. 1 where the sigmas are right, less where they are too large, more where they are too small.",
    ),
    (
        "NIS",
        "normalised innovation squared: how far a measured position lies from the predicted one, over the \
         sigmas of both. With three axes its mean is 3 where filter and measurement noise agree.",
    ),
    ("Cram\u{e9}r-Rao bound", "what no unbiased estimate from the same stars and photons can go below."),
    (
        "Bound of the horizon",
        "the least sigma of the position that any filter can have by the limb seen until then, over an Earth whose limb \
         stands as unevenly as this world's; an rms over worlds, in one of them an error may be smaller.",
    ),
    (
        "Radial, along, cross",
        "up from the Earth's centre; in the orbit plane along flight; along the orbit's normal.",
    ),
    (
        "Star path, Earth path",
        "the two views on one detector: a mirror shows stars, a grey filter dims the Earth.",
    ),
    (
        "Limb, lit limb",
        "the Earth's edge; the part of it that the Sun lights and the detector sees, in degrees of azimuth.",
    ),
    ("Settled", "the orbit filter says that its position sigma fell below its goal."),
    ("Self-test", "mode: windows are read twice and compared before anything is claimed."),
    ("Acquisition", "mode: stars are identified, or the rate is found, without prior knowledge."),
    ("Tracking", "mode: predicted stars are followed; the Earth's limb gives its direction and distance."),
    ("Eclipse", "mode: no lit limb is in the field; stars give the attitude, the orbit is predicted."),
    ("Sun outage", "mode: the Sun blinds the detector; attitude and orbit are predicted."),
    ("Safe", "mode: faults in a row or a search without end; the sensor tests itself until it passes."),
    ("Fault", "something that the scenario breaks on purpose: detector, image or clock."),
];
