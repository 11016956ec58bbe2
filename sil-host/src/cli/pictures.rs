//! Arguments of the commands that take pictures or lists of what was measured in them.

use clap::Args;
use fsw_core::attitude::comparison::WahbaMethod;
use std::path::PathBuf;

/// What is known of the optics of pictures: one of the two.
#[derive(Debug, Args)]
#[group(multiple = false)]
pub struct OpticsArguments {
    /// Camera file
    #[arg(long, value_name = "CAM.toml")]
    pub camera: Option<PathBuf>,
    /// Horizontal field of view of an undistorted camera, degrees; solve and calibrate need it right to 2 %
    #[arg(long, value_name = "F")]
    pub fov_deg: Option<f64>,
}

/// Arguments of `solve`.
#[derive(Debug, Args)]
pub struct SolveArguments {
    /// Pictures: PNG, TIFF, JPEG, BMP, PGM or FITS
    #[arg(required = true, value_name = "IMAGE")]
    pub images: Vec<PathBuf>,
    /// Optics
    #[command(flatten)]
    pub optics: OpticsArguments,
    /// Catalogue made by catalog-gen, instead of the embedded one
    #[arg(long, value_name = "FILE", requires = "OpticsArguments")]
    pub catalog: Option<PathBuf>,
    /// Defects of the detector, made by `defects`
    #[arg(long, value_name = "FILE.defects")]
    pub defects: Option<PathBuf>,
    /// Folder for drawings: each picture with its stars (named: green, others: red), residuals twenty times
    /// as long (yellow) and lines of right ascension and declination; NAME-sky.png, of pictures with one
    /// name the second is NAME-2-sky.png
    #[arg(long, value_name = "DIR")]
    pub overlay: Option<PathBuf>,
    /// Table of all answers, a row a picture
    #[arg(long, value_name = "FILE.csv")]
    pub csv: Option<PathBuf>,
    /// Folder for FITS headers with the world coordinates of each identified picture; NAME.wcs
    #[arg(long, value_name = "DIR")]
    pub wcs: Option<PathBuf>,
    /// One JSON object a picture on stdout, and nothing else
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `earth`.
#[derive(Debug, Args)]
pub struct EarthArguments {
    /// Pictures: PNG, TIFF, JPEG, BMP, PGM or FITS
    #[arg(required = true, value_name = "IMAGE")]
    pub images: Vec<PathBuf>,
    /// Optics
    #[command(flatten)]
    pub optics: OpticsArguments,
    /// The Earth's pole in the sensor frame; without it a mean sphere
    #[arg(long, value_name = "x,y,z", allow_hyphen_values = true, value_parser = vector)]
    pub pole: Option<[f32; 3]>,
    /// The Sun's direction in the sensor frame
    #[arg(long, value_name = "x,y,z", allow_hyphen_values = true, value_parser = vector)]
    pub sun: Option<[f32; 3]>,
    /// Defects of the detector, made by `defects`
    #[arg(long, value_name = "FILE.defects")]
    pub defects: Option<PathBuf>,
    /// Folder for drawings: each picture with its limb points (green, left out: red), the limb and the
    /// centre; NAME-earth.png, of pictures with one name the second is NAME-2-earth.png
    #[arg(long, value_name = "DIR")]
    pub overlay: Option<PathBuf>,
    /// One JSON object a picture on stdout, and nothing else
    #[arg(long)]
    pub json: bool,
}

/// Three numbers that make a direction.
fn vector(text: &str) -> Result<[f32; 3], String> {
    let numbers: Option<Vec<f32>> = text.split(',').map(|number| number.trim().parse().ok()).collect();
    let vector = numbers.and_then(|numbers| <[f32; 3]>::try_from(numbers).ok());
    let length = |[x, y, z]: [f32; 3]| x.hypot(y).hypot(z);
    // Also refuses what is no number.
    vector.filter(|vector| (1e-3..1e6).contains(&length(*vector))).ok_or_else(|| {
        "no direction: give x,y,z along the columns, the rows and the line of sight, not all zero".into()
    })
}

/// Arguments of `identify`.
#[derive(Debug, Args)]
pub struct IdentifyArguments {
    /// Fields of centroids, one JSON object a line
    #[arg(value_name = "FIELDS.jsonl")]
    pub fields: PathBuf,
    /// Camera file
    #[arg(long, value_name = "CAM.toml")]
    pub camera: PathBuf,
    /// Catalogue made by catalog-gen, instead of the embedded one
    #[arg(long, value_name = "FILE")]
    pub catalog: Option<PathBuf>,
    /// One JSON object a field on stdout, and nothing else
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `attitude`.
#[derive(Debug, Args)]
pub struct AttitudeArguments {
    /// Sets of vector pairs, one JSON object a line
    #[arg(value_name = "SETS.jsonl", required_unless_present = "table")]
    pub sets: Option<PathBuf>,
    /// Methods, separated by commas: svd, q, quest, foam, esoq, esoq2, lsq, anisotropic
    #[arg(long, value_name = "METHOD,...", value_delimiter = ',', default_value = "svd", value_parser = crate::commands::attitude::methods::method)]
    pub method: Vec<WahbaMethod>,
    /// All methods on the stars of the sky, beside the thesis's table 3.9 and the Cramer-Rao bound
    #[arg(long, conflicts_with_all = ["sets", "method"])]
    pub table: bool,
    /// One JSON object an answer (or a row) on stdout, and nothing else
    #[arg(long)]
    pub json: bool,
}

/// Most electrons that a pixel holds.
const FULL_WELL_MAX_E: f64 = 1e7;

/// The charge of a full pixel.
fn electrons(text: &str) -> Result<f64, String> {
    let charge = text.parse().ok().filter(|charge| (1.0..=FULL_WELL_MAX_E).contains(charge));
    charge.ok_or_else(|| format!("give 1 to {FULL_WELL_MAX_E} electrons"))
}

/// Arguments of `calibrate`.
#[derive(Debug, Args)]
pub struct CalibrateArguments {
    /// Pictures of one lens: PNG, TIFF, JPEG, BMP, PGM or FITS
    #[arg(required_unless_present = "rendered", value_name = "IMAGE")]
    pub images: Vec<PathBuf>,
    /// So many pictures of the rendered sky instead, through the camera of --camera in a laboratory that is
    /// cooler than the flight
    #[arg(long, value_name = "N", conflicts_with_all = ["images", "fov_deg"], value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub rendered: Option<u32>,
    /// Optics to start from, the focal length right to 2 %
    #[command(flatten)]
    pub optics: OpticsArguments,
    /// Camera file to write; a drawing of the residuals (.svg) comes beside it, and the star profiles and
    /// corrections (.corr) where the pictures show enough stars
    #[arg(long, value_name = "CAM.toml")]
    pub out: PathBuf,
    /// Charge of a full pixel by the detector's data sheet, electrons; of a rendered one the laboratory's
    #[arg(long, value_name = "E", default_value_t = 40_000.0, conflicts_with = "rendered", value_parser = electrons)]
    pub full_well_e: f64,
}

/// Arguments of `defects`.
#[derive(Debug, Args)]
pub struct DefectsArguments {
    /// Five or more dark pictures of one detector: PNG, TIFF, JPEG, BMP, PGM or FITS
    #[arg(required = true, value_name = "DARK")]
    pub images: Vec<PathBuf>,
    /// The file to write
    #[arg(long, value_name = "FILE.defects")]
    pub out: PathBuf,
    /// One JSON object on stdout, and nothing else
    #[arg(long)]
    pub json: bool,
}
