//! `sil-host defects`: a detector's bad pixels and columns' offsets, from dark pictures; and its table put
//! before other pictures.
//!
//! In: at least [`PICTURES_MIN`] pictures of darkness taken with one detector, best at the exposure and the
//! temperature of its flight. Out: the file that [`fsw_core::image::defects`] describes, and how many defects
//! of which kind ([`survey`] says how they are known). A picture that cannot be used ends the command: a
//! table from fewer pictures is not the one that was asked for.
//!
//! With the file `solve` and `earth` mend a picture as the flight code mends windows
//! ([`fsw_core::image::bad_pixels`]).

pub mod survey;

use crate::cli::DefectsArguments;
use crate::error::HostError;
use crate::formats::json;
use crate::formats::picture::{EXPOSURE_US, Picture};
use crate::words::program;
use fsw_core::checksum::crc32;
use fsw_core::image::DetectionParameters;
use fsw_core::image::bad_pixels::{BadPixelDetector, is_replaceable};
use fsw_core::image::defects::{CRC_FROM, Defects, DefectsError, HEADER_BYTES, MAGIC, VERSION};
use fsw_core::image::scan::{Detections, TILE_PIXELS, scan};
use fsw_hal::{Detector, DetectorGeometry};
use serde::Serialize;
use std::path::{Path, PathBuf};
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

/// Bytes of a table: bad pixels (column, row) sorted by row, then column, and offsets of columns from the
/// left; at most 65,535 of either.
pub fn table([width, height]: [u16; 2], bad: &[[u16; 2]], offsets: &[(u16, i16)]) -> Vec<u8> {
    let mut words = vec![width, height, offsets.len() as u16, bad.len() as u16, 0, 0];
    words.extend((0..=height).map(|row| bad.partition_point(|[_, y]| *y < row) as u16));
    words.extend(bad.iter().map(|[x, _]| *x));
    words.extend(offsets.iter().flat_map(|(x, offset)| [*x, offset.cast_unsigned()]));
    let total = CRC_FROM + 4 + 2 * words.len();
    let mut protected = (total as u32).to_le_bytes().to_vec();
    protected.extend(words.iter().flat_map(|word| word.to_le_bytes()));
    let mut bytes = MAGIC.to_vec();
    bytes.extend(VERSION.to_le_bytes());
    bytes.extend((HEADER_BYTES as u16).to_le_bytes());
    bytes.extend(crc32(&protected).to_le_bytes());
    bytes.extend(protected);
    bytes
}

/// A table that was read and checked.
pub struct DefectsFile {
    path: PathBuf,
    bytes: Vec<u8>,
}

impl DefectsFile {
    /// Reads a table.
    ///
    /// # Errors
    /// When the file cannot be read, or is no such table of this version, or is damaged.
    pub fn load(path: &Path) -> Result<Self, HostError> {
        let bytes =
            std::fs::read(path).map_err(|error| HostError::system(path, "read", &error, "check the path"))?;
        let what = match Defects::open(&bytes) {
            Ok(_) => return Ok(Self { path: path.to_path_buf(), bytes }),
            Err(DefectsError::NotDefects) => "offset 0: does not begin with SXDF".to_owned(),
            Err(DefectsError::Version(version)) => format!("offset 4: version {version} is not read"),
            Err(DefectsError::Length) => "offset 12: another length than the file's".to_owned(),
            Err(DefectsError::Checksum) => "offset 8: the checksum does not match".to_owned(),
            Err(DefectsError::Unsorted) => "its pixels or columns are out of order".to_owned(),
            Err(DefectsError::Outside) => "a pixel or column lies outside its detector".to_owned(),
            Err(DefectsError::Structure | DefectsError::OtherDetector) => {
                "its numbers contradict each other".to_owned()
            }
        };
        Err(HostError::input(path, None, what, format!("make it again with `{} defects`", program())))
    }

    /// A picture without these defects; `name` is the picture's.
    ///
    /// # Errors
    /// When the table is of a detector of another size.
    pub fn mend(&self, name: &Path, mut picture: Picture) -> Result<Picture, HostError> {
        let geometry = picture.geometry();
        let mut pixels = vec![0; geometry.whole().area()];
        let fault = |error| HostError::detector(name, error);
        // Checked when it was read.
        let table = Defects::open(&self.bytes).map_err(|_| self.other(name, geometry))?;
        let mut mended =
            BadPixelDetector::new(&mut picture, table).map_err(|_| self.other(name, geometry))?;
        mended.expose(EXPOSURE_US).and_then(|_| mended.read(geometry.whole(), &mut pixels)).map_err(fault)?;
        Ok(Picture::from_pixels(geometry, pixels).unwrap_or(picture))
    }

    fn other(&self, name: &Path, geometry: DetectorGeometry) -> HostError {
        let [w, h] = Defects::open(&self.bytes).map_or([0, 0], |table| table.size_px());
        let DetectorGeometry { width_px, height_px, .. } = geometry;
        let table = self.path.display();
        let what = format!("the picture has {width_px} x {height_px} px, the defects {table} {w} x {h}");
        HostError::input(name, None, what, "give the table of this picture's detector")
    }
}

/// Reads a picture, mended where there is a table.
///
/// # Errors
/// When it cannot be read, or has not the table's size.
pub fn picture(name: &Path, defects: Option<&DefectsFile>) -> Result<Picture, HostError> {
    let picture = Picture::load(name)?;
    match defects {
        Some(defects) => defects.mend(name, picture),
        None => Ok(picture),
    }
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
