//! Tests of the pictures: real ones, made ones of every kind, damaged ones, and the manners of the detector.

use super::*;
use image::{GrayAlphaImage, GrayImage, ImageBuffer, Luma, RgbImage, RgbaImage};

fn encoded(image: impl Into<DynamicImage>, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    image.into().write_to(&mut bytes, format).unwrap();
    bytes.into_inner()
}

fn fits_file(cards: &[(&str, &str)], data: &[u8]) -> Vec<u8> {
    let mut header: String =
        cards.iter().map(|(k, v)| format!("{:<80}", format!("{k:<8}= {v:>20}"))).collect();
    header += &format!("{:<80}", "END");
    let mut bytes = header.into_bytes();
    bytes.resize(bytes.len().div_ceil(2880) * 2880, b' ');
    bytes.extend_from_slice(data);
    bytes.resize(bytes.len().div_ceil(2880) * 2880, 0);
    bytes
}

fn fits_16(extra: &[(&str, &str)], values: impl Iterator<Item = i16>) -> Vec<u8> {
    let mut cards =
        vec![("SIMPLE", "T"), ("BITPIX", "16"), ("NAXIS", "2"), ("NAXIS1", "40"), ("NAXIS2", "32")];
    cards.extend_from_slice(extra);
    fits_file(&cards, &values.flat_map(i16::to_be_bytes).collect::<Vec<u8>>())
}

/// The folder of real pictures; relative paths count from the workspace.
fn data() -> PathBuf {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    root.join(std::env::var("SEXTANT_DATA").unwrap_or_else(|_| "../shared/data".into()))
}

/// All pictures below `folder`.
fn pictures_below(folder: &Path) -> Vec<PathBuf> {
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let is_picture = |p: &Path| p.extension().is_some_and(|e| ["png", "jpg", "tiff"].iter().any(|k| e == *k));
    let entries = entries.map(|entry| entry.unwrap().path());
    entries
        .flat_map(|p| if p.is_dir() { pictures_below(&p) } else { vec![p] })
        .filter(|p| is_picture(p))
        .collect()
}

#[test]
fn every_real_picture_loads_and_none_loads_cut_in_half() {
    let pictures = pictures_below(&data());
    if pictures.is_empty() {
        println!("skipped: no data");
    }
    for file in pictures {
        let bytes = std::fs::read(&file).unwrap();
        Picture::decode(&bytes).unwrap_or_else(|fault| panic!("{}: {fault}", file.display()));
        let half = Picture::decode(&bytes[..bytes.len() / 2]);
        assert!(matches!(half, Err(PictureFault::Damaged(_))), "{}: {half:?}", file.display());
    }
}

#[test]
fn real_pictures_load_with_the_sizes_on_record() {
    let sky = data().join("sky");
    let Ok(text) = std::fs::read_to_string(sky.join("truth.json")) else {
        println!("skipped: no data");
        return;
    };
    let records: Vec<serde_json::Value> = serde_json::from_str(&text).unwrap();
    assert!(!records.is_empty());
    for record in records {
        let name = record["image"].as_str().unwrap();
        let mut picture = Picture::load(&sky.join(name)).unwrap();
        let geometry = picture.geometry();
        let size = (record["size"][0].as_u64().unwrap(), record["size"][1].as_u64().unwrap());
        assert_eq!((u64::from(geometry.width_px), u64::from(geometry.height_px)), size, "{name}");
        assert!(matches!(geometry.bits, 8 | 16), "{name}");
        let most = *picture.pixels().iter().max().unwrap();
        assert!(most > geometry.full_scale() / 8 && most <= geometry.full_scale(), "{name}: {most}");
        picture.expose(1).unwrap();
        let mut whole = vec![0; geometry.whole().area()];
        picture.read(geometry.whole(), &mut whole).unwrap();
        assert_eq!(whole, picture.pixels(), "{name}");
    }
}

#[test]
fn grey_values_are_kept_as_they_are() {
    let image = GrayImage::from_fn(40, 32, |x, y| Luma([(x + 5 * y) as u8]));
    for format in [ImageFormat::Png, ImageFormat::Tiff, ImageFormat::Pnm] {
        let picture = Picture::decode(&encoded(image.clone(), format)).unwrap();
        assert_eq!(picture.geometry().bits, 8);
        assert_eq!(picture.pixels()[41], 6);
    }
    let image = ImageBuffer::<Luma<u16>, _>::from_fn(40, 32, |x, y| Luma([(1000 * x + y) as u16]));
    for format in [ImageFormat::Png, ImageFormat::Tiff] {
        let picture = Picture::decode(&encoded(image.clone(), format)).unwrap();
        assert_eq!(picture.geometry().bits, 16);
        assert_eq!(picture.pixels()[41], 1001);
    }
    let image = GrayAlphaImage::from_fn(40, 32, |x, _| image::LumaA([x as u8, 0]));
    assert_eq!(Picture::decode(&encoded(image, ImageFormat::Png)).unwrap().pixels()[7], 7);
}

#[test]
fn netpbm_and_bmp_files_of_others_are_read() {
    // As cameras write them: 10 bits in two bytes, the greater first; a comment; letters instead of bytes.
    let values: Vec<u8> = (0..1280u16).flat_map(|value| (value % 1024).to_be_bytes()).collect();
    let deep = [&b"P5\n# a camera\n40 32\n65535\n"[..], &values].concat();
    let picture = Picture::decode(&deep).unwrap();
    assert_eq!((picture.geometry().bits, picture.pixels()[1279]), (16, 255));
    let letters: String = (0..1280).map(|value| format!("{} ", value % 256)).collect();
    let plain = Picture::decode(format!("P2 40 32 255\n{letters}").as_bytes()).unwrap();
    assert_eq!((plain.geometry().bits, plain.pixels()[300]), (8, 44));
    // A grey palette of 8 bits becomes colours that are equal, rows are stored from the lowest up.
    let image = GrayImage::from_fn(40, 32, |x, y| Luma([(x + 5 * y) as u8]));
    let picture = Picture::decode(&encoded(image, ImageFormat::Bmp)).unwrap();
    let scale = if picture.geometry().bits == 8 { 1 } else { 257 };
    assert_eq!((picture.pixels()[41], picture.pixels()[1279]), (6 * scale, 194 * scale));
}

#[test]
fn a_picture_without_content_says_why() {
    let grey = |value: u8, odd: usize| {
        let pixels = (0..1024).map(|k| if k < odd { 7 } else { value.into() }).collect();
        Picture::from_pixels(DetectorGeometry { width_px: 32, height_px: 32, bits: 8 }, pixels).unwrap()
    };
    assert!(grey(255, 0).without_content().unwrap().contains("overexposed"));
    assert!(grey(255, 500).without_content().unwrap().contains("overexposed"));
    assert!(grey(0, 0).without_content().unwrap().contains("same value"));
    assert_eq!((grey(255, 512).without_content(), grey(0, 1).without_content()), (None, None));
}

#[test]
fn colour_becomes_luminance_of_16_bits_and_alpha_is_ignored() {
    let image =
        RgbImage::from_fn(40, 32, |x, _| image::Rgb([[255, 0, 0], [0, 255, 0], [9, 9, 9]][x as usize % 3]));
    let picture = Picture::decode(&encoded(image, ImageFormat::Png)).unwrap();
    assert_eq!(picture.geometry().bits, 16);
    assert_eq!(&picture.pixels()[..3], &[13_933, 46_871, 9 * 257]);
    let image = RgbaImage::from_fn(40, 32, |_, y| image::Rgba([8, 8, 8, y as u8]));
    let picture = Picture::decode(&encoded(image, ImageFormat::Png)).unwrap();
    assert!(picture.pixels().iter().all(|v| *v == 8 * 257));
    assert_eq!(luminance_16(65_535, 65_535, 65_535), 65_535);
}

#[test]
fn fits_values_follow_the_table() {
    let unsigned =
        fits_16(&[("BZERO", "32768.0"), ("BSCALE", "1.0D0")], (0..1280).map(|i| i16::MIN + i + 200));
    let picture = Picture::decode(&unsigned).unwrap();
    assert_eq!((picture.geometry().width_px, picture.geometry().bits), (40, 16));
    assert_eq!(&picture.pixels()[..2], &[200, 201]);
    let signed = Picture::decode(&fits_16(&[], (0..1280).map(|i| i - 640))).unwrap();
    assert_eq!((signed.pixels()[0], signed.pixels()[1279]), (0, 65_535));
    let flipped = fits_16(&[("ROWORDER", "'BOTTOM-UP'")], 0..1280);
    assert_eq!(Picture::decode(&flipped).unwrap().pixels()[0], 1240);
    let blank = fits_16(&[("BLANK", "5")], 0..1280);
    assert_eq!(Picture::decode(&blank).unwrap().pixels()[5], 0);

    let cards = |bitpix, axes| {
        [
            ("SIMPLE", "T"),
            ("BITPIX", bitpix),
            ("NAXIS", axes),
            ("NAXIS1", "40"),
            ("NAXIS2", "32"),
            ("NAXIS3", "3"),
        ]
    };
    let bytes: Vec<u8> = (0..1280).map(|i| (i % 256) as u8).collect();
    let picture = Picture::decode(&fits_file(&cards("8", "2")[..5], &bytes)).unwrap();
    assert_eq!((picture.geometry().bits, picture.pixels()[255]), (8, 255));
    let colour = Picture::decode(&fits_file(&cards("8", "3"), &bytes.repeat(3))).unwrap();
    assert_eq!((colour.geometry().bits, colour.pixels()[255]), (16, 65_535));
    let reals: Vec<u8> = (0..1280).flat_map(|i| (i as f32 / 1279.0).to_be_bytes()).collect();
    let picture = Picture::decode(&fits_file(&cards("-32", "2")[..5], &reals)).unwrap();
    assert_eq!((picture.pixels()[0], picture.pixels()[1279]), (0, 65_535));
    let longs: Vec<u8> = (0..1280i32).flat_map(|i| (i * 3).to_be_bytes()).collect();
    assert_eq!(Picture::decode(&fits_file(&cards("32", "2")[..5], &longs)).unwrap().pixels()[2], 6);
}

#[test]
fn damaged_files_are_refused_in_one_line() {
    let grey = GrayImage::from_fn(64, 64, |x, y| Luma([((x * 7) ^ (y * 13)) as u8]));
    let mut files = vec![("fits", fits_16(&[], 0..1280))];
    for format in FORMATS {
        files.push((format.extensions_str()[0], encoded(grey.clone(), format)));
    }
    for (name, bytes) in files {
        assert!(Picture::decode(&bytes).is_ok(), "{name}");
        for keep in [1, 2, 3] {
            let fault = Picture::decode(&bytes[..bytes.len() * keep / 4]).unwrap_err();
            assert!(matches!(fault, PictureFault::Damaged(_)), "{name} {keep}/4: {fault}");
        }
    }
    assert_eq!(Picture::decode(b"").unwrap_err(), PictureFault::Empty);
    assert_eq!(Picture::decode(b"not a picture").unwrap_err(), PictureFault::UnknownFormat);
    let message = Picture::load(Path::new("no/such.png")).unwrap_err().to_string();
    assert_eq!(
        message,
        "no/such.png: cannot be read: no such file or directory; check the path and its permissions"
    );
}

#[test]
fn absurd_sizes_are_refused_before_memory_is_asked_for() {
    let small = encoded(GrayImage::new(31, 64), ImageFormat::Png);
    assert_eq!(Picture::decode(&small).unwrap_err(), PictureFault::Size(31, 64));
    let wide = encoded(GrayImage::new(70_000, 32), ImageFormat::Png);
    assert_eq!(Picture::decode(&wide).unwrap_err(), PictureFault::Size(70_000, 32));
    let cards = [
        ("SIMPLE", "T"),
        ("BITPIX", "16"),
        ("NAXIS", "2"),
        ("NAXIS1", "9999999999"),
        ("NAXIS2", "9999999999"),
    ];
    assert!(matches!(Picture::decode(&fits_file(&cards, b"")), Err(PictureFault::Size(..))));
    let cards = [("SIMPLE", "T"), ("BITPIX", "16"), ("NAXIS", "2"), ("NAXIS1", "-5"), ("NAXIS2", "9")];
    assert!(matches!(Picture::decode(&fits_file(&cards, b"")), Err(PictureFault::Damaged(_))));
    let cards = [("SIMPLE", "T"), ("BITPIX", "8"), ("NAXIS", "0")];
    assert!(matches!(Picture::decode(&fits_file(&cards, b"")), Err(PictureFault::Unsupported(_))));
}

#[test]
fn the_detector_refuses_wrong_requests_and_leaves_the_buffer_alone() {
    let geometry = DetectorGeometry { width_px: 40, height_px: 32, bits: 16 };
    let mut picture = Picture::from_pixels(geometry, (0..1280).collect()).unwrap();
    let window = Window { x: 38, y: 30, width: 2, height: 2 };
    let mut buffer = [7; 4];
    assert_eq!(picture.read(window, &mut buffer), Err(DetectorError::NotExposed));
    picture.expose(100).unwrap();
    let outside = Window { x: 39, ..window };
    assert_eq!(picture.read(outside, &mut buffer), Err(DetectorError::OutsideDetector));
    assert_eq!(picture.read(window, &mut buffer[..3]), Err(DetectorError::BufferLength));
    assert_eq!(buffer, [7; 4]);
    picture.read(window, &mut buffer).unwrap();
    assert_eq!(buffer, [1238, 1239, 1278, 1279]);
    picture.read(Window::default(), &mut []).unwrap();
    assert!(Picture::from_pixels(geometry, vec![0; 3]).is_none());
}

#[test]
fn a_picture_in_blocks_holds_their_means_and_drops_what_is_left_over() {
    let geometry = DetectorGeometry { width_px: 131, height_px: 66, bits: 8 };
    let pixels: Vec<u16> = (0..131 * 66).map(|n| ((n * 7) % 256) as u16).collect();
    let picture = Picture::from_pixels(geometry, pixels.clone()).unwrap();
    let binned = picture.binned(2).unwrap();
    assert_eq!(binned.geometry(), DetectorGeometry { width_px: 65, height_px: 33, bits: 16 });
    for (x, y) in [(0, 0), (64, 32), (17, 5)] {
        let sum: u16 = [0, 1, 131, 132].map(|next| pixels[2 * y * 131 + 2 * x + next]).iter().sum();
        let mean = f64::from(sum) / 4.0 * 257.0;
        assert!((f64::from(binned.pixels()[y * 65 + x]) - mean).abs() <= 0.5);
    }
    assert!(picture.binned(4).is_none(), "too small is left");
    assert!(picture.binned(0).is_none());
}

#[test]
fn renewed_noise_changes_the_lowest_bit_of_half_of_the_pixels_and_is_another_each_time() {
    let geometry = DetectorGeometry { width_px: 96, height_px: 64, bits: 10 };
    let mut picture = Picture::from_pixels(geometry, vec![100; geometry.whole().area()]).unwrap();
    for seed in 0..20 {
        let before = picture.clone();
        picture.renew_noise(seed);
        let changed = |group: (&[u16], &[u16])| group.0.iter().zip(group.1).filter(|(a, b)| a != b).count();
        let groups = || picture.pixels().chunks(64).zip(before.pixels().chunks(64));
        assert!(groups().all(|group| changed(group) > 8), "{seed}");
        let share = groups().map(changed).sum::<usize>() as f64 / picture.pixels().len() as f64;
        assert!((0.45..0.55).contains(&share), "{seed}: {share}");
        assert!(picture.pixels().iter().all(|pixel| pixel | 1 == 101));
    }
}
