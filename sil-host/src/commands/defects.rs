//! `sil-host defects`: a detector's bad pixels and columns' offsets, from dark pictures.
//!
//! In: at least [`PICTURES_MIN`] pictures of darkness taken with one detector, best at the exposure and the
//! temperature of its flight. Out: the file that [`fsw_core::image::defects`] describes, and how many defects
//! of which kind ([`survey`] says how they are known). A picture that cannot be used ends the command: a
//! table from fewer pictures is not the one that was asked for.
//!
//! With the file `solve` and `earth` mend a picture ([`crate::formats::defects_file`]).

pub mod survey;

use crate::cli::DefectsArguments;
use crate::error::HostError;
use crate::formats::defects_file::table;
use crate::formats::json;
use crate::formats::picture::{EXPOSURE_US, Picture};
use fsw_core::image::DetectionParameters;
use fsw_core::image::bad_pixels::is_replaceable;
use fsw_core::image::defects::Defects;
use fsw_core::image::scan::{Detections, TILE_PIXELS, scan};
use fsw_hal::{Detector, DetectorGeometry};
use serde::Serialize;
use std::path::PathBuf;
use std::process::ExitCode;
use survey::{Kind, Survey};

/// A flickering pixel and a hit are distinguished by what is left when one picture is not looked at. Of three
/// pictures that leaves two, whose difference says too little: 20 false pixels in a million.
pub const PICTURES_MIN: usize = 5;
/// More star-like spots than this, median of the pictures, are stars: a detector with 2,000 hot pixels and 20
/// hits has none, a real dark with amplifier glow and banding 6, a sky of 10 deg 80 and more.
pub const SPOTS_MAX: u32 = 20;

/// The answer.
#[derive(Clone, Debug, Serialize)]
pub struct DefectsAnswer {
    /// The table.
    pub file: String,
    /// Its length.
    pub bytes: usize,
    /// Pictures it was made from.
    pub pictures: usize,
    /// Noise of a pixel in one picture, digital numbers.
    pub noise_dn: f64,
    /// Star-like spots in a picture, median of the pictures.
    pub star_like_spots: u32,
    /// Bad pixels that are too bright.
    pub hot: usize,
    /// Bad pixels that are too dark.
    pub dead: usize,
    /// Bad pixels that change too much.
    pub flickering: usize,
    /// Bad pixels that have no good one near enough to take their place.
    pub beyond_mending: usize,
    /// Columns with an offset.
    pub columns: usize,
}

/// Pictures of one size and resolution.
fn darks(names: &[PathBuf]) -> Result<Vec<Picture>, HostError> {
    let mut pictures: Vec<Picture> = Vec::with_capacity(names.len());
    for name in names {
        let picture = Picture::load(name)?;
        let (geometry, first) = (picture.geometry(), pictures.first().unwrap_or(&picture).geometry());
        if geometry != first {
            let of = |g: DetectorGeometry| format!("{} x {} px of {} bits", g.width_px, g.height_px, g.bits);
            let what = format!("the picture has {}, the first {}", of(geometry), of(first));
            return Err(HostError::input(name, None, what, "give pictures of one detector"));
        }
        pictures.push(picture);
    }
    if pictures.len() < PICTURES_MIN {
        let what = format!("{} dark pictures do not tell a defect from a hit", pictures.len());
        return Err(HostError::usage(what, format!("give {PICTURES_MIN} or more, best 8 or more")));
    }
    Ok(pictures)
}

/// Refuses pictures of which one is another's copy: even of darkness two exposures differ by noise.
fn check_copies(names: &[PathBuf], pictures: &[Picture]) -> Result<(), HostError> {
    for (index, picture) in pictures.iter().enumerate() {
        let copy = pictures[..index].iter().position(|before| before.pixels() == picture.pixels());
        if let Some(first) = copy {
            let what = format!("equal to {}, pixel by pixel", names[first].display());
            let to_do = "give pictures exposed one by one, their black level above 0";
            return Err(HostError::input(&names[index], None, what, to_do));
        }
    }
    Ok(())
}

/// Star-like spots that the flight code finds in a picture, median of the pictures.
fn star_like_spots(names: &[PathBuf], pictures: &mut [Picture]) -> Result<u32, HostError> {
    let (mut buffer, mut detections) = (Box::new([0; TILE_PIXELS]), Detections::new());
    let mut counts = Vec::with_capacity(pictures.len());
    for (name, picture) in names.iter().zip(pictures) {
        let fault = |error| HostError::detector(name, error);
        picture.expose(EXPOSURE_US).map_err(fault)?;
        scan(picture, &mut buffer, &DetectionParameters::default(), &mut detections).map_err(fault)?;
        counts.push(detections.found());
    }
    counts.sort_unstable();
    Ok(counts.get(counts.len() / 2).copied().unwrap_or(0))
}

/// Bytes of the table for what was found, and how many of its pixels are beyond mending.
fn file(geometry: DetectorGeometry, survey: &Survey) -> Option<(Vec<u8>, usize)> {
    let bad: Vec<_> = survey.bad.iter().map(|(at, _)| *at).collect();
    let bytes = table([geometry.width_px, geometry.height_px], &bad, &survey.offsets);
    let opened = Defects::open(&bytes).ok()?;
    let left = bad.iter().filter(|[x, y]| !is_replaceable(&opened, *x, *y)).count();
    Some((bytes, left))
}

/// Prints the answer for people.
fn print_text(answer: &DefectsAnswer) {
    let DefectsAnswer { hot, dead, flickering, beyond_mending, columns, .. } = answer;
    print_line!(
        "{}: {} bytes from {} pictures, noise {:.2} DN, {} star-like spots in each",
        answer.file,
        answer.bytes,
        answer.pictures,
        answer.noise_dn,
        answer.star_like_spots
    );
    print_line!(
        "{} bad pixels: {hot} hot, {dead} dead, {flickering} flickering ({beyond_mending} beyond mending); \
         {columns} columns with an offset",
        hot + dead + flickering
    );
}

/// Runs the command.
///
/// # Errors
/// When a picture cannot be used, so much is out of line that it is no dark, or the file cannot be written.
pub fn run(arguments: &DefectsArguments) -> Result<ExitCode, HostError> {
    let mut pictures = darks(&arguments.images)?;
    check_copies(&arguments.images, &pictures)?;
    let star_like_spots = star_like_spots(&arguments.images, &mut pictures)?;
    if star_like_spots > SPOTS_MAX {
        let what = format!("the pictures show stars: {star_like_spots} star-like spots in each");
        return Err(HostError::usage(what, "give pictures with the lens closed"));
    }
    let geometry = pictures[0].geometry();
    let frames: Vec<_> = pictures.iter().map(Picture::pixels).collect();
    let no_dark = || {
        let what = "the pictures show more than darkness and some defects";
        HostError::usage(what, "give dark pictures of one detector, all of one exposure")
    };
    let survey = survey::survey(&frames, geometry).ok_or_else(no_dark)?;
    let (bytes, beyond_mending) = file(geometry, &survey).ok_or_else(no_dark)?;
    crate::output::write_whole(&arguments.out, &bytes)?;
    let count = |kind| survey.bad.iter().filter(|(_, is)| *is == kind).count();
    let answer = DefectsAnswer {
        file: arguments.out.display().to_string(),
        bytes: bytes.len(),
        pictures: pictures.len(),
        noise_dn: survey.noise_dn,
        star_like_spots,
        hot: count(Kind::Hot),
        dead: count(Kind::Dead),
        flickering: count(Kind::Flickering),
        beyond_mending,
        columns: survey.offsets.len(),
    };
    if arguments.json {
        json::print_line(&answer);
    } else {
        print_text(&answer);
    }
    Ok(ExitCode::SUCCESS)
}

#[cfg(test)]
mod tests;
