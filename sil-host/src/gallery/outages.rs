//! States of the sensor along six orbits (thesis figs. 8.5 to 8.10), by the flight code's prediction.

use super::{Figure, Made, Row, Told};
use crate::commands::outages::{Outlook, outlook, page, words};
use crate::error::HostError;
use crate::report::standing_alone::standing_alone;
use crate::scenario::Scenario;
use fsw_core::orbit::forces::Dynamics;
use std::path::Path;

/// States of thesis tab. 8.1.
const EARTH_PATH: u8 = 1;
const ECLIPSE: u8 = 2;
const STAR_PATH: u8 = 3;
const STAR_PATH_OVER_EARTH: u8 = 4;

/// Focal length, px, at which the side of 1280 px, along which the Sun goes, takes in the 17.7 deg that 4215
/// s and two times 13 s of the Sun's way in GEO are.
const THESIS_FOCAL_LENGTH_PX: f64 = 4106.0;

const SCAN_8_5: &str =
    "fig. 8.5; the scan has the numbers, which state they are of follows from the Earth's 17.4 deg";

/// The figures.
pub const FIGURES: &[Figure] = &[
    Figure {
        name: "fig-8.5",
        title: "outages in GEO, star path in the plane of the orbit",
        place: "\u{a7}8.2.1.1",
        thesis: &[
            Told { what: "Sun behind the Earth (2)", value: 4215.0, unit: "s", place: SCAN_8_5 },
            Told {
                what: "Sun in the star path, over the Earth (4)",
                value: 4215.0,
                unit: "s",
                place: SCAN_8_5,
            },
            Told {
                what: "Sun beside the Earth (1), each side",
                value: 13.0,
                unit: "s",
                place: "fig. 8.5: 12 to 14 s, four times",
            },
            Told {
                what: "Sun in the star path (3), each side",
                value: 13.0,
                unit: "s",
                place: "fig. 8.5: 12 to 14 s, four times",
            },
        ],
        make: geo_in_plane,
    },
    Figure {
        name: "fig-8.6",
        title: "outages in GEO, star path out of the plane",
        place: "\u{a7}8.2.1.1",
        thesis: &[],
        make: geo_out_of_plane,
    },
    Figure {
        name: "fig-8.7",
        title: "outages in a noon-midnight SSO, star path in the plane",
        place: "\u{a7}8.2.1.2",
        thesis: &[],
        make: sso_in_plane,
    },
    Figure {
        name: "fig-8.8",
        title: "outages in a noon-midnight SSO, star path out of the plane",
        place: "\u{a7}8.2.1.2",
        thesis: &[],
        make: sso_out_of_plane,
    },
    Figure {
        name: "fig-8.9",
        title: "outages in GTO, star path in the plane",
        place: "\u{a7}8.2.1.3",
        thesis: &[Told {
            what: "Sun in the star path over the Earth (4), about the perigee",
            value: 211.0,
            unit: "s",
            place: "fig. 8.9; the scan has this number alone, beside the line of state 4",
        }],
        make: gto_in_plane,
    },
    Figure {
        name: "fig-8.10",
        title: "outages in GTO, star path out of the plane",
        place: "\u{a7}8.2.1.3",
        thesis: &[],
        make: gto_out_of_plane,
    },
];

/// An orbit of `sil-host/orbits`, predicted with the reference camera, or with another focal length.
fn predicted(text: &str, focal_length_px: Option<f64>) -> Result<Outlook, HostError> {
    let mut scenario = Scenario::parse(Path::new("an orbit of the thesis"), text)?;
    if let Some(focal_length_px) = focal_length_px {
        scenario.camera.focal_length_px = focal_length_px;
    }
    outlook(&scenario, None, Dynamics::Full)
}

/// Seconds in a state.
fn seconds(outlook: &Outlook, state: u8) -> u32 {
    outlook.totals[usize::from(state)].seconds
}

/// Rows of all states for which the thesis has no number.
fn alone(outlook: &Outlook) -> Vec<Row> {
    let row = |state: u8| {
        let total = &outlook.totals[usize::from(state)];
        Row::alone(
            words(state),
            match total.count {
                0 => "never".to_owned(),
                1 => format!("{} s, once", total.seconds),
                count => format!("{} s in {count} times", total.seconds),
            },
        )
    };
    [EARTH_PATH, ECLIPSE, STAR_PATH, STAR_PATH_OVER_EARTH].map(row).to_vec()
}

fn made(title: &str, outlook: &Outlook, rows: Vec<Row>, verdict: String) -> Made {
    Made { pictures: vec![standing_alone(&page::drawing(title, outlook))], rows, verdict }
}

const NOT_IN_THE_SCAN: &str = "The scan holds no number of this figure.";

fn geo_in_plane(figure: &Figure) -> Result<Made, HostError> {
    let text = include_str!("../../orbits/geo-in-plane.toml");
    let [ours, narrow] = [predicted(text, None)?, predicted(text, Some(THESIS_FOCAL_LENGTH_PX))?];
    let each = |of: &Outlook, state| 0.5 * f64::from(seconds(of, state));
    let both = |whole: String, narrow: String| format!("{whole} ({narrow} with the narrower field)");
    let all = |state| both(format!("{} s", seconds(&ours, state)), format!("{} s", seconds(&narrow, state)));
    let halves =
        |state| both(format!("{:.0} s", each(&ours, state)), format!("{:.0} s", each(&narrow, state)));
    let rows = vec![
        figure.row(0, all(ECLIPSE)),
        figure.row(1, all(STAR_PATH_OVER_EARTH)),
        figure.row(2, halves(EARTH_PATH)),
        figure.row(3, halves(STAR_PATH)),
    ];
    let verdict = "Over the Earth ours is 40 s shorter: the thesis's Earth is 17.6 deg wide, ours 17.4 deg from 35,786 km. Eclipse ends and begins for us when some lit limb is in view, a minute a \
        side sooner. Beside the Earth the reference camera, 24 deg wide along the Sun's way, is blinded for a quarter of an hour a side. With a field of 17.7 deg, which the thesis's numbers add up to, \
        102 s are left in the star path instead of 13 s: 64 s are the Sun's radius, which ours counts and the thesis does not, 20 s a side the narrower Earth. One day at the equinox, the worst case."
        .to_owned();
    Ok(made(figure.title, &ours, rows, verdict))
}

fn geo_out_of_plane(figure: &Figure) -> Result<Made, HostError> {
    let ours = predicted(include_str!("../../orbits/geo-out-of-plane.toml"), None)?;
    let verdict = format!(
        "{NOT_IN_THE_SCAN} As it says, the Sun never comes into a star path across the plane; the way through the Earth path is as \
         long as in fig. 8.5, because our mount turns the star path and leaves the Earth path's long side along the orbit."
    );
    Ok(made(figure.title, &ours, alone(&ours), verdict))
}

fn sso_in_plane(figure: &Figure) -> Result<Made, HostError> {
    let ours = predicted(include_str!("../../orbits/sso-in-plane.toml"), None)?;
    let verdict = format!(
        "{NOT_IN_THE_SCAN} Eclipse (2) is where no lit limb is in the oblique field, about half the orbit of a noon-midnight plane; \
         the Sun stands in the Earth path once a revolution, at dawn, as the thesis has it."
    );
    Ok(made(figure.title, &ours, alone(&ours), verdict))
}

fn sso_out_of_plane(figure: &Figure) -> Result<Made, HostError> {
    let ours = predicted(include_str!("../../orbits/sso-out-of-plane.toml"), None)?;
    let verdict = format!(
        "{NOT_IN_THE_SCAN} The star path across the plane never meets the Sun, as the thesis has it."
    );
    Ok(made(figure.title, &ours, alone(&ours), verdict))
}

fn gto_in_plane(figure: &Figure) -> Result<Made, HostError> {
    let ours = predicted(include_str!("../../orbits/gto-in-plane.toml"), None)?;
    let mut rows = vec![figure.row(0, format!("{} s", seconds(&ours, STAR_PATH_OVER_EARTH)))];
    rows.extend(alone(&ours).into_iter().take(3));
    let verdict = "Near the perigee the satellite turns so fast that the Sun crosses the star path in minutes; ours sees it over the Earth \
        for 22 s less, its field and the tilt to the horizon being others. The thesis leaves its tilt and field of this figure unsaid."
        .to_owned();
    Ok(made(figure.title, &ours, rows, verdict))
}

fn gto_out_of_plane(figure: &Figure) -> Result<Made, HostError> {
    let ours = predicted(include_str!("../../orbits/gto-out-of-plane.toml"), None)?;
    let verdict = format!(
        "{NOT_IN_THE_SCAN} The star path across the plane never meets the Sun, as the thesis has it."
    );
    Ok(made(figure.title, &ours, alone(&ours), verdict))
}
