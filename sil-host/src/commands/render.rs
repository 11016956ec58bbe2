//! `sil-host render`: the frame the detector would show in a second of a scenario.
//!
//! In: a scenario and a second. Out: raw digital numbers, not scaled, as grey of 16 bits: a PNG, or a FITS
//! file of one plane (`BITPIX = 16` with `BZERO = 32768`, the usual way to hold unsigned numbers; first row
//! first, said by `ROWORDER`). A frame is a pure function of scenario, seed and second: no second before it
//! is flown.

use crate::cli::RenderArguments;
use crate::error::HostError;
use crate::scenario::Scenario;
use fsw_hal::{Detector, DetectorGeometry};
use image::{ExtendedColorType, ImageEncoder};
use std::path::Path;
use std::process::ExitCode;

/// Length of a FITS block, and of a card in its header, bytes.
const FITS_BLOCK: usize = 2880;
const FITS_CARD: usize = 80;

/// Kinds of file that can be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Png,
    Fits,
}

impl Kind {
    fn of(path: &Path) -> Result<Self, HostError> {
        match path.extension().and_then(|extension| extension.to_str()).map(str::to_lowercase).as_deref() {
            Some("png") => Ok(Self::Png),
            Some("fits" | "fit") => Ok(Self::Fits),
            _ => Err(HostError::usage(
                format!("--out: {} is neither .png nor .fits", path.display()),
                "name a file that ends in one of them",
            )),
        }
    }
}

fn png(pixels: &[u16], geometry: DetectorGeometry) -> Result<Vec<u8>, image::ImageError> {
    // The encoder takes the machine's byte order and writes the format's.
    let bytes: Vec<u8> = pixels.iter().flat_map(|value| value.to_ne_bytes()).collect();
    let (width, height) = (geometry.width_px.into(), geometry.height_px.into());
    let mut file = Vec::new();
    image::codecs::png::PngEncoder::new(&mut file).write_image(
        &bytes,
        width,
        height,
        ExtendedColorType::L16,
    )?;
    Ok(file)
}

/// One header and one plane, both padded to whole blocks (FITS 4.0, sections 3.1 and 4.4.1).
fn fits(pixels: &[u16], geometry: DetectorGeometry) -> Vec<u8> {
    let cards = [
        ("SIMPLE", "T".to_owned()),
        ("BITPIX", "16".to_owned()),
        ("NAXIS", "2".to_owned()),
        ("NAXIS1", geometry.width_px.to_string()),
        ("NAXIS2", geometry.height_px.to_string()),
        ("BZERO", "32768".to_owned()),
        ("BSCALE", "1".to_owned()),
    ];
    let mut file = Vec::new();
    for (key, value) in cards {
        file.extend_from_slice(format!("{key:<8}= {value:>20}{:50}", "").as_bytes());
    }
    for card in ["ROWORDER= 'TOP-DOWN'", "END"] {
        file.extend_from_slice(format!("{card:FITS_CARD$}").as_bytes());
    }
    file.resize(file.len().next_multiple_of(FITS_BLOCK), b' ');
    for value in pixels {
        // Stored as value - 32768, which is the value with its highest bit turned over.
        file.extend_from_slice(&(value ^ 0x8000).to_be_bytes());
    }
    file.resize(file.len().next_multiple_of(FITS_BLOCK), 0);
    file
}

/// Runs the command.
///
/// # Errors
/// When the scenario cannot be read, the second lies beyond its end, or the file cannot be written.
pub fn run(arguments: &RenderArguments) -> Result<ExitCode, HostError> {
    let kind = Kind::of(&arguments.out)?;
    let scenario = Scenario::load(&arguments.scenario)?.with_seed(arguments.seed);
    if arguments.cycle >= scenario.duration_s {
        return Err(HostError::usage(
            format!("--cycle: {} lies beyond the end of the scenario", arguments.cycle),
            format!("use 0 to {}", scenario.duration_s - 1),
        ));
    }
    let mut scene = scenario.scene()?;
    let geometry = scene.geometry();
    let mut pixels = vec![0; geometry.whole().area()];
    let file = scene
        .expose_cycle(arguments.cycle.into(), scenario.exposure_us)
        .and_then(|()| scene.read(geometry.whole(), &mut pixels))
        .map_err(|error| format!("{error:?}"))
        .and_then(|()| match kind {
            Kind::Png => png(&pixels, geometry).map_err(|error| error.to_string()),
            Kind::Fits => Ok(fits(&pixels, geometry)),
        })
        .map_err(|error| HostError::usage(format!("the frame cannot be made: {error}"), "report this"))?;
    crate::output::write_whole(&arguments.out, &file)?;
    print_line!(
        "{}: second {} of {}, {} x {} px, raw values up to {}",
        arguments.out.display(),
        arguments.cycle,
        scenario.name,
        geometry.width_px,
        geometry.height_px,
        geometry.full_scale()
    );
    Ok(ExitCode::SUCCESS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::picture::Picture;

    #[test]
    fn both_kinds_of_file_hold_the_raw_values() {
        let geometry = DetectorGeometry { width_px: 40, height_px: 33, bits: 16 };
        let pixels: Vec<u16> = (0..40 * 33).map(|n| (n * 49) as u16).collect();
        for file in [png(&pixels, geometry).unwrap(), fits(&pixels, geometry)] {
            let picture = Picture::decode(&file).unwrap();
            assert_eq!(picture.pixels(), pixels);
            assert_eq!(picture.geometry(), geometry);
        }
        assert_eq!(fits(&pixels, geometry).len() % FITS_BLOCK, 0);
    }

    #[test]
    fn only_files_of_these_kinds_are_written() {
        assert_eq!(Kind::of(Path::new("a.PNG")).ok(), Some(Kind::Png));
        assert_eq!(Kind::of(Path::new("b.fits")).ok(), Some(Kind::Fits));
        assert!(Kind::of(Path::new("c.jpg")).is_err() && Kind::of(Path::new("d")).is_err());
    }
}
