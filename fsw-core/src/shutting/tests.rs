use super::*;
use OpenPaths::{Both, BothClear, Earth, Star};
use std::vec::Vec;

fn second(s: i64) -> LocalTime {
    LocalTime::from_us(s * 1_000_000)
}

fn measured(free: OpenPaths) -> Option<SunPlace> {
    Some(SunPlace { free, measured: true })
}

fn carried(free: OpenPaths) -> Option<SunPlace> {
    Some(SunPlace { free, measured: false })
}

/// A world with the Sun in one path (`free`: what it leaves free) or in none from second to second, where the
/// Earth blinds without its filter unless it is dark (both clear): what the shutters are in each, and how
/// many seconds are blinded.
fn fly(
    parameters: &ShutterParameters,
    free: impl Fn(i64) -> OpenPaths,
    told: impl Fn(i64, OpenPaths) -> Option<SunPlace>,
    seconds: i64,
) -> (Vec<OpenPaths>, usize) {
    let mut shutting = Shutting::default();
    let (mut flown, mut blinded_s) = (Vec::new(), 0);
    for s in 0..seconds {
        let open = shutting.open();
        flown.push(open);
        let blinded = match free(s) {
            Both => open.clear(),
            BothClear => false,
            Star => open != Star,
            Earth => open.star(),
        };
        blinded_s += usize::from(blinded);
        shutting.next(second(s), blinded, told(s, open), parameters);
    }
    (flown, blinded_s)
}

#[test]
fn a_path_is_shut_before_the_sun_comes_and_opened_when_it_has_gone() {
    for in_path in [Star, Earth] {
        let free = |s: i64| if (100..200).contains(&s) { in_path } else { Both };
        // The prediction is of the next second; without stars the attitude is carried on.
        let told = |s: i64, open: OpenPaths| Some(SunPlace { free: free(s + 1), measured: open.star() });
        let (flown, blinded) = fly(&ShutterParameters::default(), free, told, 300);
        let looks = flown[100..200].iter().filter(|open| **open == Both).count();
        assert_eq!(flown.iter().filter(|open| **open == in_path).count(), 100 - looks);
        assert_eq!((flown[99], flown[100], flown[201]), (Both, in_path, Both), "{in_path:?}");
        // Without an attitude of its own a shut star path is looked through now and then.
        assert_eq!(blinded, looks);
        assert_eq!(looks, if in_path == Star { 0 } else { 3 });
    }
}

#[test]
fn without_an_attitude_the_path_is_found_by_trying() {
    for (in_path, trials) in [(Star, 1), (Earth, 2)] {
        let (flown, blinded) = fly(&ShutterParameters::default(), |_| in_path, |_, _| None, 1000);
        assert_eq!(flown[trials], in_path);
        // A look every 30 s, and the way back from it.
        assert!(blinded <= trials + 1000 * trials / 30 + 1, "{in_path:?}: {blinded}");
        assert!(blinded >= 1000 / 32);
    }
}

#[test]
fn a_sun_in_both_paths_or_a_light_that_no_shutter_stops_leaves_them_open() {
    let mut shutting = Shutting::default();
    let mut open = [0; 4];
    for s in 0..600 {
        shutting.next(second(s), true, None, &ShutterParameters::default());
        open[shutting.open() as usize] += 1;
    }
    assert!(open[Both as usize] > 550, "{open:?}");
    let mut shutting = Shutting::default();
    shutting.next(second(0), false, measured(Both), &ShutterParameters::default());
    assert_eq!(shutting.open(), Both);
}

#[test]
fn a_prediction_that_the_image_contradicts_is_not_believed_until_a_look() {
    // The clock is wrong: the attitude says that the Sun is in neither path, and it is in the Earth path.
    let told = |_: i64, open: OpenPaths| if open.earth() { carried(Both) } else { measured(Both) };
    let (flown, blinded) = fly(&ShutterParameters::default(), |_| Star, told, 3000);
    assert_eq!(flown[1], Star);
    assert!(blinded <= 1 + 3000 / 31, "{blinded}");
    // And one that says that it is in the other path, which is clear.
    let (_, blinded) = fly(&ShutterParameters::default(), |_| Star, |_, _| carried(Earth), 3000);
    assert!(blinded <= 2 + 2 * 3000 / 31, "{blinded}");
}

#[test]
fn a_path_without_a_shutter_stays_open() {
    let only = |paths| ShutterParameters { paths, ..ShutterParameters::default() };
    for (paths, in_path) in [(Shutters::Star, Star), (Shutters::Earth, Earth)] {
        let (flown, blinded) = fly(&only(paths), |_| in_path, |_, _| measured(in_path), 100);
        // Trying the other one, which has a shutter, does not help.
        assert!(flown.iter().all(|open| *open != in_path), "{in_path:?}");
        assert_eq!(blinded, 100);
    }
    assert!(only(Shutters::Star).paths.allow(Earth) && !only(Shutters::Star).paths.allow(Star));
}

#[test]
fn the_filter_is_out_while_the_earth_is_dark_and_no_longer() {
    let adaptive = |paths| ShutterParameters { paths, filter: EarthFilter::Adaptive, ..Default::default() };
    let free = |s: i64| match s {
        100..200 => BothClear,
        300..400 => Star,
        _ => Both,
    };
    for paths in [Shutters::Neither, Shutters::Both] {
        let told = |s: i64, open: OpenPaths| Some(SunPlace { free: free(s + 1), measured: open.star() });
        let (flown, blinded) = fly(&adaptive(paths), free, told, 500);
        let clear: Vec<_> = (0..500).filter(|s| flown[*s as usize] == BothClear).collect();
        assert_eq!(clear, (100..200).collect::<Vec<_>>());
        // The Sun in the Earth path is an outage where that has no shutter.
        assert_eq!(blinded, if paths == Shutters::Neither { 100 } else { 0 });
    }
    // No parameter says that it moves.
    let told = |_: i64, _: OpenPaths| measured(BothClear);
    let (flown, _) = fly(&ShutterParameters::default(), |_| BothClear, told, 100);
    assert!(flown.iter().all(|open| *open == Both));
}

#[test]
fn an_image_that_is_blinded_or_gives_no_attitude_puts_the_filter_back() {
    let parameters = ShutterParameters { filter: EarthFilter::Adaptive, ..Default::default() };
    // A wrong orbit says that the Earth is dark, and it is lit: one blinded second, and none again as long as
    // the prediction is contradicted.
    let (flown, blinded) = fly(&parameters, |_| Both, |_, _| measured(BothClear), 25);
    assert_eq!((flown[1], flown[2], blinded), (BothClear, Both, 1));
    let mut shutting = Shutting::default();
    for (told, open) in
        [(measured(BothClear), BothClear), (carried(Both), Both), (measured(BothClear), BothClear)]
    {
        shutting.next(second(0), false, told, &parameters);
        assert_eq!(shutting.open(), open);
    }
    shutting.next(second(1), false, None, &parameters);
    assert_eq!(shutting.open(), Both);
}

#[test]
fn a_command_holds_them_until_another_one() {
    let mut shutting = Shutting::default();
    shutting.command(Some(Star));
    for s in 0..200 {
        shutting.next(second(s), s % 2 == 0, measured(Earth), &ShutterParameters::default());
        assert_eq!(shutting.open(), Star);
    }
    shutting.command(None);
    assert_eq!(shutting.open(), Both);
    shutting.next(second(200), false, measured(Earth), &ShutterParameters::default());
    assert_eq!(shutting.open(), Earth);
}
