use super::*;

/// A file of this test in the system's folder for such.
fn scratch(name: &str, bytes: &[u8]) -> PathBuf {
    let path = std::env::temp_dir().join(format!("sextant-defects-file-{}-{name}", std::process::id()));
    std::fs::write(&path, bytes).unwrap();
    path
}

#[test]
fn what_the_host_writes_the_flight_code_reads() {
    let bad = [[7, 0], [2, 4], [19, 4], [3, 9]];
    let bytes = table([20, 10], &bad, &[(0, -5), (11, 300)]);
    let defects = Defects::open(&bytes).unwrap();
    let read: Vec<_> = (0..10).flat_map(|y| defects.row(y).map(move |x| [x, y])).collect();
    assert_eq!(read, bad);
    assert_eq!(defects.offsets().collect::<Vec<_>>(), [(0, -5), (11, 300)]);
}

#[test]
fn a_picture_is_mended_and_one_of_another_size_refused() {
    let file = DefectsFile { path: "a.defects".into(), bytes: table([64, 64], &[[5, 6]], &[(9, 2)]) };
    let geometry = |width_px| DetectorGeometry { width_px, height_px: 64, bits: 8 };
    let mut pixels = vec![50; 64 * 64];
    pixels[6 * 64 + 5] = 255;
    let picture = Picture::from_pixels(geometry(64), pixels).unwrap();
    let mended = file.mend(Path::new("a.png"), picture).unwrap();
    let other = |(place, value): (usize, &u16)| *value != if place % 64 == 9 { 48 } else { 50 };
    assert!(!mended.pixels().iter().enumerate().any(other));
    let picture = Picture::from_pixels(geometry(65), vec![0; 64 * 65]).unwrap();
    let message = file.mend(Path::new("b.png"), picture).unwrap_err().to_string();
    assert!(message.starts_with("sil-host: b.png: ") && message.contains("65 x 64"), "{message}");
    assert!(message.contains("a.defects 64 x 64") && !message.contains('\n'), "{message}");
}

#[test]
fn damaged_tables_cost_a_line_that_says_where() {
    let sound = table([64, 64], &[[5, 6]], &[]);
    let changed = |at: usize| {
        let mut bytes = sound.clone();
        bytes[at] ^= 8;
        bytes
    };
    let cases = [
        (b"no table".to_vec(), "SXDF"),
        (changed(4), "version 9"),
        (sound[..40].to_vec(), "length"),
        (changed(40), "checksum"),
    ];
    for (bytes, word) in cases {
        let path = scratch("damaged", &bytes);
        let message = DefectsFile::load(&path).map(|_| ()).unwrap_err().to_string();
        assert!(
            message.contains(word) && message.contains("damaged: ") && !message.contains('\n'),
            "{message}"
        );
    }
    let _ = std::fs::remove_file(scratch("damaged", b""));
    let message = DefectsFile::load(Path::new("no/such.defects")).map(|_| ()).unwrap_err().to_string();
    assert!(message.contains("no/such.defects: cannot be read"), "{message}");
}
