//! The first picture of a FITS file.
//!
//! In: the bytes of a file that begins with a primary header (FITS 4.0, sections 3.3 and 4). Out:
//! [`FitsPlanes`], the physical values `BZERO + BSCALE * stored` of one plane (grey) or three (red, green,
//! blue), in the order of the file, unless `ROWORDER = 'BOTTOM-UP'` says that the last row is the upper one.
//! `BITPIX` may be 8, 16, 32, -32 or -64; a value equal to `BLANK` and anything that is not a number reads as
//! the smallest value of its plane. A file without any number is refused.
//!
//! Why not a library: the pure-Rust readers tried return fewer pixels for a truncated file without a word, or
//! stop the program on an absurd `NAXISn`. Extensions, tables and compressed tiles are not read.

/// Length of a FITS block, bytes.
const BLOCK: usize = 2880;
/// Length of a header card, bytes.
const CARD: usize = 80;
/// Most header blocks looked at: 36 cards each, far beyond any picture's header.
const HEADER_BLOCKS_MAX: usize = 1000;

/// The values of a picture, plane after plane.
#[derive(Debug, Clone, PartialEq)]
pub struct FitsPlanes {
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// One plane (grey) or three (red, green, blue), each `width * height` long, first row first.
    pub planes: Vec<Vec<f64>>,
    /// Whether the values were stored in 8 bits and are used as stored.
    pub eight_bit: bool,
    /// Whether the values were stored as whole numbers.
    pub whole: bool,
}

/// What is wrong with a FITS file.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum FitsError {
    /// The file ends before the header or the picture does.
    #[error("truncated FITS file")]
    Truncated,
    /// A mandatory keyword is not there or cannot be understood.
    #[error("FITS keyword {0} is missing or wrong")]
    Keyword(String),
    /// The primary header describes something else than a grey or three-plane picture.
    #[error("first FITS unit is no picture of one or three planes")]
    NoPicture,
    /// Every value is NaN, infinite or `BLANK`.
    #[error("no pixel of the FITS picture holds a number")]
    NoNumber,
    /// A side is outside what the caller allows.
    #[error("{0} x {1} px")]
    Size(u64, u64),
}

/// The keywords that matter here.
struct Header {
    bitpix: i64,
    axes: Vec<u64>,
    zero: f64,
    scale: f64,
    blank: Option<i64>,
    bottom_up: bool,
    length: usize,
}

/// Whether `bytes` begin like a FITS file.
pub fn is_fits(bytes: &[u8]) -> bool {
    bytes.starts_with(b"SIMPLE  =")
}

/// Reads the picture of the first unit; `side_ok` judges a side before any memory is asked for.
///
/// # Errors
/// See [`FitsError`].
pub fn read(bytes: &[u8], side_ok: impl Fn(u64) -> bool) -> Result<FitsPlanes, FitsError> {
    let header = Header::read(bytes)?;
    let (width, height, planes) = match header.axes[..] {
        [w, h] | [w, h, 1] => (w, h, 1),
        [w, h, 3] => (w, h, 3),
        _ => return Err(FitsError::NoPicture),
    };
    if !side_ok(width) || !side_ok(height) {
        return Err(FitsError::Size(width, height));
    }
    let (width, height) = (width as usize, height as usize);
    let size = match header.bitpix {
        8 => 1,
        16 => 2,
        32 | -32 => 4,
        -64 => 8,
        _ => return Err(FitsError::Keyword("BITPIX".into())),
    };
    let plane_bytes = width * height * size;
    let data = bytes.get(header.length..).ok_or(FitsError::Truncated)?;
    let data = data.get(..plane_bytes * planes).ok_or(FitsError::Truncated)?;
    let mut planes: Vec<Vec<f64>> =
        data.chunks_exact(plane_bytes).map(|plane| header.plane(plane, size, width)).collect();
    if !planes.iter().flatten().any(|value| value.is_finite()) {
        return Err(FitsError::NoNumber);
    }
    planes.iter_mut().for_each(|plane| fill(plane));
    Ok(FitsPlanes {
        width,
        height,
        planes,
        eight_bit: header.bitpix == 8 && header.zero == 0.0 && header.scale == 1.0,
        whole: header.bitpix > 0 && header.zero.fract() == 0.0 && header.scale.fract() == 0.0,
    })
}

impl Header {
    fn read(bytes: &[u8]) -> Result<Self, FitsError> {
        let mut header = Self {
            bitpix: 0,
            axes: Vec::new(),
            zero: 0.0,
            scale: 1.0,
            blank: None,
            bottom_up: false,
            length: 0,
        };
        let mut axis_count = None;
        let mut sides = [None; 3];
        let cards = bytes.chunks_exact(CARD).take(HEADER_BLOCKS_MAX * BLOCK / CARD);
        let mut end = None;
        for (index, card) in cards.enumerate() {
            let name = String::from_utf8_lossy(&card[..8]).trim_end().to_string();
            if name == "END" {
                end = Some(index + 1);
                break;
            }
            if card.get(8..10) != Some(b"= ") {
                continue;
            }
            let value = value_of(&card[10..]);
            let wrong = || FitsError::Keyword(name.clone());
            match name.as_str() {
                "BITPIX" => header.bitpix = value.parse().map_err(|_| wrong())?,
                "NAXIS" => axis_count = Some(value.parse::<usize>().map_err(|_| wrong())?),
                "NAXIS1" => sides[0] = Some(value.parse().map_err(|_| wrong())?),
                "NAXIS2" => sides[1] = Some(value.parse().map_err(|_| wrong())?),
                "NAXIS3" => sides[2] = Some(value.parse().map_err(|_| wrong())?),
                "BZERO" => header.zero = real(&value).ok_or_else(wrong)?,
                "BSCALE" => header.scale = real(&value).ok_or_else(wrong)?,
                "BLANK" => header.blank = value.parse().ok(),
                "ROWORDER" => {
                    header.bottom_up = value.trim_matches('\'').trim().eq_ignore_ascii_case("BOTTOM-UP")
                }
                _ => {}
            }
        }
        header.length = (end.ok_or(FitsError::Truncated)? * CARD).div_ceil(BLOCK) * BLOCK;
        let count = axis_count.ok_or_else(|| FitsError::Keyword("NAXIS".into()))?;
        if !(2..=3).contains(&count) {
            return Err(FitsError::NoPicture);
        }
        for (number, side) in sides.iter().take(count).enumerate() {
            header.axes.push(side.ok_or_else(|| FitsError::Keyword(format!("NAXIS{}", number + 1)))?);
        }
        Ok(header)
    }

    /// The physical values of one plane of `size`-byte numbers, upper row first; NaN where there is none.
    fn plane(&self, bytes: &[u8], size: usize, width: usize) -> Vec<f64> {
        let value = |stored: &[u8]| self.physical(stored);
        let rows = bytes.chunks_exact(size * width);
        let mut values = Vec::with_capacity(bytes.len() / size);
        if self.bottom_up {
            rows.rev().for_each(|row| values.extend(row.chunks_exact(size).map(value)));
        } else {
            rows.for_each(|row| values.extend(row.chunks_exact(size).map(value)));
        }
        values
    }

    /// `BZERO + BSCALE * stored`; NaN where the file says that there is no value.
    fn physical(&self, stored: &[u8]) -> f64 {
        let whole = match *stored {
            [a] => i64::from(a),
            [a, b] => i64::from(i16::from_be_bytes([a, b])),
            [a, b, c, d] if self.bitpix > 0 => i64::from(i32::from_be_bytes([a, b, c, d])),
            [a, b, c, d] => return self.zero + self.scale * f64::from(f32::from_be_bytes([a, b, c, d])),
            [a, b, c, d, e, f, g, h] => {
                return self.zero + self.scale * f64::from_be_bytes([a, b, c, d, e, f, g, h]);
            }
            _ => return f64::NAN,
        };
        if self.blank == Some(whole) { f64::NAN } else { self.zero + self.scale * whole as f64 }
    }
}

/// Gives what is no number the smallest value of the plane; 0 where there is none.
fn fill(plane: &mut [f64]) {
    let least = plane.iter().copied().filter(|v| v.is_finite()).fold(f64::INFINITY, f64::min);
    let least = if least.is_finite() { least } else { 0.0 };
    plane.iter_mut().filter(|v| !v.is_finite()).for_each(|v| *v = least);
}

/// The value field of a card: up to the comment's slash, which inside quotes is no comment.
fn value_of(field: &[u8]) -> String {
    let text = String::from_utf8_lossy(field);
    let mut quoted = false;
    let end = text.find(|c: char| {
        quoted ^= c == '\'';
        c == '/' && !quoted
    });
    text[..end.unwrap_or(text.len())].trim().to_string()
}

/// A real number as FITS writes it; Fortran's exponent letter D is allowed.
fn real(text: &str) -> Option<f64> {
    text.replace(['D', 'd'], "E").parse().ok().filter(|value: &f64| value.is_finite())
}
