//! Tests of the camera files: the embedded ones, and the place and words of every kind of fault.

use super::*;

const GOOD: &str = "[detector]\nwidth_px = 640\nheight_px = 480\nbits = 12\n\n[optics]\nfocal_length_px = 1000\n\
                    optical_centre_px = [319.5, 239.5]\n";

fn fault(text: &str) -> String {
    CameraFile::parse(Path::new("c.toml"), text).expect_err("must be refused").to_string()
}

#[test]
fn the_embedded_cameras_are_those_of_the_record() {
    let reference = CameraFile::reference();
    assert_eq!((reference.width_px, reference.height_px, reference.bits), (1280, 1024, 10));
    assert_eq!((reference.focal_length_px, reference.optical_centre_px), (3000.0, [639.5, 511.5]));
    let mita = CameraFile::embedded("mita", MITA);
    let fov = |side: f64, f: f64| 2.0 * (side / 2.0 / f).atan().to_degrees();
    assert!((fov(386.0, mita.focal_length_px) - 17.2).abs() < 0.2);
    assert!((fov(290.0, mita.focal_length_px) - 12.7).abs() < 0.2);
    assert_eq!(CameraFile::embedded("pcs", PCS2112).focal_length_px, 3432.0);
}

#[test]
fn everything_but_the_first_five_keys_has_a_default() {
    let camera = CameraFile::parse(Path::new("c.toml"), GOOD).unwrap();
    assert_eq!(camera.projection, Projection::Rectilinear);
    assert_eq!(camera.distortion, Distortion::default());
    assert_eq!(camera.corner_loss, CORNER_LOSS);
    assert_eq!(camera.correction_table, None);
    let lines: Vec<&str> = GOOD.lines().collect();
    for key in ["width_px", "height_px", "bits", "focal_length_px", "optical_centre_px"] {
        let without: Vec<&str> = lines.iter().copied().filter(|line| !line.starts_with(key)).collect();
        let message = fault(&without.join("\n"));
        assert!(
            message.starts_with("sil-host: c.toml:") && message.contains(&format!("`{key}`")),
            "{message}"
        );
    }
}

#[test]
fn optional_keys_are_read() {
    let text = format!(
        "{GOOD}projection = \"equiangular\"\ndistortion = {{ k1 = -0.1, p2 = 1e-3 }}\ncorrection_table = \"a.corr\"\n"
    );
    let camera = CameraFile::parse(Path::new("folder/c.toml"), &text).unwrap();
    assert_eq!(camera.projection, Projection::Equiangular);
    assert_eq!(camera.distortion, Distortion { k1: -0.1, p2: 1e-3, ..Distortion::default() });
    assert_eq!(camera.correction_table, Some(PathBuf::from("folder/a.corr")));
}

#[test]
fn a_fault_names_file_line_and_key() {
    let cases = [
        ("width_px = 640", "width_px = 8", "sil-host: c.toml:2: detector.width_px: 8 px is out of range"),
        (
            "height_px = 480",
            "height_px = 99999999999",
            "sil-host: c.toml:3: detector.height_px: 99999999999 px",
        ),
        ("bits = 12", "bits = 17", "sil-host: c.toml:4: detector.bits: 17 bits"),
        ("bits = 12", "bits = \"ten\"", "sil-host: c.toml:4: bits: invalid type"),
        ("bits = 12", "bits = 12\ngain = 3", "sil-host: c.toml:5: unknown field `gain`"),
        (
            "focal_length_px = 1000",
            "focal_length_px = nan",
            "sil-host: c.toml:7: optics.focal_length_px: NaN",
        ),
        ("[319.5, 239.5]", "[319.5]", "sil-host: c.toml:8: optical_centre_px: invalid length"),
        (
            "[319.5, 239.5]",
            "[\n  319.5,\n  9e9,\n]",
            "sil-host: c.toml:8: optics.optical_centre_px: 9000000000",
        ),
        (
            "focal_length_px = 1000",
            "corner_loss = 1.0\nfocal_length_px = 1000",
            "sil-host: c.toml:7: optics.corner_loss: 1 is out of range",
        ),
        ("bits = 12", "bits = = 12", "sil-host: c.toml:4:"),
    ];
    for (from, to, expected) in cases {
        let message = fault(&GOOD.replace(from, to));
        assert!(message.starts_with(expected), "{message}\nshould begin {expected}");
        assert!(message.contains("; ") && !message.contains('\n'), "{message}");
    }
    let message = fault(&format!("{GOOD}distortion = {{ k1 = 1, k9 = 2 }}\n"));
    assert!(message.starts_with("sil-host: c.toml:9: unknown field `k9`"), "{message}");
    let message = fault(&format!("{GOOD}projection = \"round\"\n"));
    assert!(message.starts_with("sil-host: c.toml:9: projection: unknown variant"), "{message}");
}

#[test]
fn a_missing_or_empty_file_is_said_plainly() {
    let message = CameraFile::load(Path::new("no/such.toml")).unwrap_err().to_string();
    assert!(message.starts_with("sil-host: no/such.toml: cannot be read: no such file"), "{message}");
    assert!(fault("").starts_with("sil-host: c.toml:1: missing field `detector`"), "{}", fault(""));
}

#[test]
fn a_field_of_view_gives_the_focal_length() {
    let camera = CameraFile::from_fov(1280, 1024, 10, 24.08515).unwrap();
    assert!((camera.focal_length_px - 3000.0).abs() < 0.002, "{}", camera.focal_length_px);
    assert_eq!(camera.optical_centre_px, [639.5, 511.5]);
    for bad in [0.0, -3.0, 180.0, f64::NAN] {
        assert!(CameraFile::from_fov(1280, 1024, 10, bad).is_err());
    }
}

#[test]
fn what_is_written_is_read_again() {
    for text in [REFERENCE, MITA, PCS2112] {
        let mut camera = CameraFile::parse(Path::new("a/camera.toml"), text).unwrap();
        camera.distortion = Distortion { k1: -0.123_456_789_012_3, k2: 1e-7, k3: 0.0, p1: -2.5e-4, p2: 3.0 };
        camera.focal_length_px += 1.0 / 3.0;
        camera.corner_loss = 0.3;
        camera.correction_table = Some(PathBuf::from("b/a \"table\".corr"));
        assert_eq!(CameraFile::parse(Path::new("camera.toml"), &camera.to_toml()).unwrap(), camera);
    }
}

#[test]
fn a_camera_read_in_blocks_sees_the_same_directions() {
    let whole = CameraFile::reference();
    let binned = whole.binned(4);
    assert_eq!((binned.width_px, binned.height_px), (320, 256));
    // The middle of block 10 is pixel 41.5.
    let slope = |camera: &CameraFile, x: f64| (x - camera.optical_centre_px[0]) / camera.focal_length_px;
    assert!((slope(&binned, 10.0) - slope(&whole, 41.5)).abs() < 1e-12);
}

#[test]
fn the_camera_file_that_the_help_shows_is_one_and_shows_the_defaults() {
    let (_, text) = HELP.split_once("\n\n").unwrap();
    let shown = CameraFile::parse(Path::new("help.toml"), text).unwrap();
    assert_eq!(shown, CameraFile::reference());
    assert_eq!(shown, CameraFile::parse(Path::new("help.toml"), &first_five(text)).unwrap());
}

/// A camera file without the keys that have defaults.
fn first_five(text: &str) -> String {
    let has_default = |line: &&str| {
        ["projection", "distortion", "corner_loss", "mirrored"].iter().any(|key| line.starts_with(key))
    };
    text.lines().filter(|line| !has_default(line)).collect::<Vec<_>>().join("\n")
}
