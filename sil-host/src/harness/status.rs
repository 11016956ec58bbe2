//! What a second was spent on, what came of it and what did not serve, in the words of `cycles.csv`.

use fsw_core::telemetry::{
    Activity, ClockFault, DetectorFault, FixFault, ImageFault, Outcome, RateSensorFault, Report, ShutterFault,
};

/// The column `status`: a failed detector or a refused image before what came of the stars.
pub fn status_word(report: &Report) -> &'static str {
    match (report.faults.detector, report.faults.image, report.outcome) {
        (Some(_), _, _) => "detector-fault",
        (None, Some(_), _) => "image-refused",
        (None, None, None) => "waiting",
        (None, None, Some(outcome)) => outcome_word(outcome),
    }
}

fn outcome_word(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::SelfTestPassed => "self-test-passed",
        Outcome::Identified => "identified",
        Outcome::Searching => "searching",
        Outcome::NotIdentified(_) => "not-identified",
        Outcome::TooFast => "too-fast",
        Outcome::Tracked => "tracked",
        Outcome::Lost => "lost",
        Outcome::Blinded => "blinded",
        Outcome::StarPathShut => "star-path-shut",
    }
}

/// The column `path_shut`: the path that was to be shut; empty where both were open.
pub fn shut_word(report: &Report) -> &'static str {
    match (report.star_path_shut, report.earth_path_shut) {
        (true, _) => "star",
        (_, true) => "earth",
        _ => "",
    }
}

/// The column `activity`.
pub fn activity_word(activity: Activity) -> &'static str {
    match activity {
        Activity::Waiting => "waiting",
        Activity::SelfTest => "self-test",
        Activity::StarSearch => "star-search",
        Activity::StreakSearch => "streak-search",
        Activity::StarTracking => "star-tracking",
        Activity::Propagation => "propagation",
    }
}

/// The column `reported_faults`: every fault of the second, without comma; empty where there is none.
pub fn fault_words(report: &Report) -> String {
    let faults = &report.faults;
    let mut words = Vec::new();
    words.extend(faults.detector.map(|fault| match fault {
        DetectorFault::Request => "detector refused a request",
        DetectorFault::Geometry => "detector of another size",
        DetectorFault::Hardware => "detector hardware",
    }));
    words.extend(faults.image.map(|fault| match fault {
        ImageFault::Repeated => "image repeated",
        ImageFault::OutOfOrder => "image out of order",
        ImageFault::Implausible => "image of an implausible instant",
    }));
    words.extend(faults.clock.map(|fault| match fault {
        ClockFault::NotSynchronised => "clock not synchronised",
        ClockFault::Implausible => "clock implausible",
        ClockFault::Hardware => "clock hardware",
        ClockFault::CounterReset => "counter reset",
    }));
    words.extend(faults.rate_sensor.map(|fault| match fault {
        RateSensorFault::Silent => "rate sensor silent",
        RateSensorFault::Stale => "rate sensor stale",
        RateSensorFault::NotFinite => "rate sensor not finite",
        RateSensorFault::Saturated => "rate sensor saturated",
        RateSensorFault::ShutOut => "rate sensor shut out",
        RateSensorFault::Hardware => "rate sensor hardware",
    }));
    words.extend(faults.shutter.map(|fault| match fault {
        ShutterFault::Stuck => "shutter stuck",
        ShutterFault::Hardware => "shutter hardware",
    }));
    words.extend(faults.fix.map(|fault| match fault {
        FixFault::Impossible => "fix impossible",
        FixFault::Covariance => "fix covariance",
    }));
    let crowded = (faults.crowded > 0).then(|| format!("crowded tiles {}", faults.crowded));
    words.into_iter().map(str::to_owned).chain(crowded).collect::<Vec<_>>().join("; ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use fsw_core::telemetry::Faults;

    #[test]
    fn a_fault_of_detector_or_image_comes_before_what_came_of_the_stars() {
        let mut report = Report { outcome: Some(Outcome::Tracked), ..Report::default() };
        assert_eq!(status_word(&report), "tracked");
        report.faults.image = Some(ImageFault::Repeated);
        assert_eq!(status_word(&report), "image-refused");
        report.faults.detector = Some(DetectorFault::Hardware);
        assert_eq!(status_word(&report), "detector-fault");
        assert_eq!(status_word(&Report::default()), "waiting");
    }

    #[test]
    fn every_fault_of_a_second_is_named() {
        assert_eq!(fault_words(&Report::default()), "");
        let faults = Faults {
            clock: Some(ClockFault::CounterReset),
            rate_sensor: Some(RateSensorFault::Stale),
            crowded: 3,
            ..Faults::default()
        };
        let words = fault_words(&Report { faults, ..Report::default() });
        assert_eq!(words, "counter reset; rate sensor stale; crowded tiles 3");
    }
}
