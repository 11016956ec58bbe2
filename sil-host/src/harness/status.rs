//! What a second was spent on, what came of it and what did not serve, in the words of `cycles.csv`.

use fsw_core::telemetry::{
    Activity, ClockFault, DetectorFault, FixFault, ImageFault, Outcome, ReadingFault, Report, ShutterFault,
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

/// Why an instrument beside the camera gave no reading.
fn reading_word(fault: ReadingFault) -> &'static str {
    match fault {
        ReadingFault::Silent => "silent",
        ReadingFault::Stale => "stale",
        ReadingFault::NotFinite => "not finite",
        ReadingFault::Saturated => "saturated",
        ReadingFault::ShutOut => "shut out",
        ReadingFault::Hardware => "hardware",
    }
}

/// The column `reported_faults`: every fault of the second, without comma; empty where there is none.
pub fn fault_words(report: &Report) -> String {
    let faults = &report.faults;
    let detector = faults.detector.map(|fault| match fault {
        DetectorFault::Request => "detector refused a request",
        DetectorFault::Geometry => "detector of another size",
        DetectorFault::Hardware => "detector hardware",
    });
    let image = faults.image.map(|fault| match fault {
        ImageFault::Repeated => "image repeated",
        ImageFault::OutOfOrder => "image out of order",
        ImageFault::Unexpected => "image unexpected",
        ImageFault::Implausible => "image of an implausible instant",
    });
    let clock = faults.clock.map(|fault| match fault {
        ClockFault::NotSynchronised => "clock not synchronised",
        ClockFault::Implausible => "clock implausible",
        ClockFault::Hardware => "clock hardware",
        ClockFault::CounterReset => "counter reset",
    });
    let shutter = faults.shutter.map(|fault| match fault {
        ShutterFault::Stuck => "shutter stuck",
        ShutterFault::Hardware => "shutter hardware",
    });
    let fix = faults.fix.map(|fault| match fault {
        FixFault::Impossible => "fix impossible",
        FixFault::Covariance => "fix covariance",
    });
    let reading = |name: &str, fault: Option<ReadingFault>| {
        fault.map(|fault| format!("{name} {}", reading_word(fault)))
    };
    let whole = |word: Option<&str>| word.map(str::to_owned);
    let words = [
        whole(detector),
        whole(image),
        whole(clock),
        reading("rate sensor", faults.rate_sensor),
        reading("magnetometer", faults.magnetometer),
        whole(shutter),
        whole(fix),
        (faults.crowded > 0).then(|| format!("crowded tiles {}", faults.crowded)),
    ];
    words.into_iter().flatten().collect::<Vec<_>>().join("; ")
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
            rate_sensor: Some(ReadingFault::Stale),
            crowded: 3,
            ..Faults::default()
        };
        let words = fault_words(&Report { faults, ..Report::default() });
        assert_eq!(words, "counter reset; rate sensor stale; crowded tiles 3");
    }
}
