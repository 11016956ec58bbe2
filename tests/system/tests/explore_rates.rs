//! Exploration.
use fsw_core::attitude::rate::{Arc, solve};
use fsw_core::camera::Camera;
use fsw_core::image::streaks::{follow, search};
use sil_host::camera_file::CameraFile;
use sil_host::world::attitude::{apply, matrix, normalised};
use sil_host::world::disturbances::Disturbances;
use sil_host::world::imaging::ImagingModel;
use sil_host::world::motion::Motion;
use sil_host::world::protons::Protons;
use sil_host::world::scene::{Scene, SceneSettings};
use sil_host::world::stars::DetectorModel;
use sil_host::{flight, star_scene};

fn settings(q: [f64; 4], rate: [f64; 3], seed: u64) -> SceneSettings {
    let mut s =
        SceneSettings::new(CameraFile::reference(), Motion::turning(normalised(q).unwrap(), rate), seed);
    s.imaging = ImagingModel::REFERENCE;
    s.detector = DetectorModel::reference();
    s.disturbances = Disturbances { hot_pixels: 200, protons: Protons::Fixed(20), ..Disturbances::default() };
    s
}

#[test]
fn explore() {
    let rates: Vec<f64> =
        std::env::var("RATES").unwrap_or("4".into()).split(',').map(|r| r.parse().unwrap()).collect();
    let verbose = std::env::var("VERBOSE").is_ok();
    let camera = Camera::new(flight::camera_parameters(&CameraFile::reference())).unwrap();
    for rate in rates {
        let mut z2 = vec![];
        let mut zc2 = vec![];
        let mut fits = vec![];
        let mut axes = vec![];
        let mut none = 0;
        let mut sig = vec![];
        for case in 0..8u64 {
            let r = |k: u64| {
                let x = (case * 7 + k * 13 + 5) as f64 * 0.754877666;
                (x - x.floor()) * 2.0 - 1.0
            };
            let q = [r(1), r(2), r(3), r(4)];
            let axis = {
                let v = [r(5), r(6), r(7)];
                let n = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2] as f64).sqrt();
                v.map(|c| c / n)
            };
            let w = axis.map(|c| c * rate.to_radians());
            let mut scene = Scene::new(settings(q, w, 1 + case), &star_scene::sky()).unwrap();
            scene.expose_cycle(3, 400_000).unwrap();
            let mut buffer = [0u16; 8192];
            let mut pieces = search::Pieces::new();
            search::search(&mut scene, &mut buffer, &mut pieces).unwrap();
            let mut streaks: Vec<fsw_core::image::streaks::Streak> = vec![];
            let (mut tried, mut failed) = (0, 0);
            for piece in &pieces {
                if streaks.iter().any(|s| s.holds(piece.at_px, 6.0)) {
                    continue;
                }
                tried += 1;
                match follow::follow(&mut scene, &mut buffer, piece, &mut 9000000).unwrap() {
                    Some(s) => {
                        if !streaks.iter().any(|o| o.holds(s.middle_px(), 4.0)) {
                            streaks.push(s)
                        }
                    }
                    None => failed += 1,
                }
            }
            let optics = scene.optics().clone();
            if verbose {
                for piece in &pieces {
                    let b = camera.direction(piece.at_px).unwrap();
                    let t = [piece.at_px[0] + 8.0 * piece.along[0], piece.at_px[1] + 8.0 * piece.along[1]];
                    let c = *camera.direction(t).unwrap().vector() - *b.vector();
                    let wv = [w[0] as f32, w[1] as f32, w[2] as f32];
                    let v = b.vector();
                    let m = [
                        -(wv[1] * v.z - wv[2] * v.y),
                        -(wv[2] * v.x - wv[0] * v.z),
                        -(wv[0] * v.y - wv[1] * v.x),
                    ];
                    let dot = (c.x * m[0] + c.y * m[1] + c.z * m[2])
                        / c.norm()
                        / (m[0] * m[0] + m[1] * m[1] + m[2] * m[2]).sqrt();
                    print!(
                        " {:.0},{:.0}:{:.1}/{:.0}",
                        piece.at_px[0],
                        piece.at_px[1],
                        piece.strength as f32 / 16.0,
                        dot.abs().min(1.0).acos().to_degrees()
                    );
                }
                println!();
            }
            if let Ok(only) = std::env::var("CASE")
                && only != case.to_string()
            {
                continue;
            }
            let Motion::Turning(turning) = scene.settings().motion.clone() else { panic!() };
            let sky = star_scene::sky();
            let ends = |star: &sil_host::world::scene::WorldStar| {
                let e = [-0.2, 0.2]
                    .map(|dt| optics.project(apply(&matrix(turning.at(3.0 + dt)), star.direction)));
                Some([e[0]?, e[1]?])
            };
            let d = |a: [f32; 2], b: [f64; 2]| {
                ((a[0] as f64 - b[0]).powi(2) + (a[1] as f64 - b[1]).powi(2)).sqrt()
            };
            println!(
                "rate {rate} case {case}: {} pieces, {tried} tried, {failed} failed, {} streaks",
                pieces.len(),
                streaks.len()
            );
            for s in &streaks {
                let best = sky
                    .iter()
                    .filter(|x| x.v < 7.0)
                    .filter_map(|x| {
                        let e = ends(x)?;
                        let one = [d(s.ends_px[0], e[0]), d(s.ends_px[1], e[1])];
                        let two = [d(s.ends_px[0], e[1]), d(s.ends_px[1], e[0])];
                        let (m, o) = if one[0] + one[1] < two[0] + two[1] {
                            (one, e_(e, false))
                        } else {
                            (two, e_(e, true))
                        };
                        Some((m[0] + m[1], x.v, o))
                    })
                    .min_by(|a, b| a.0.total_cmp(&b.0))
                    .unwrap();
                let len = s.length_px() as f64;
                let u = [
                    (s.ends_px[1][0] - s.ends_px[0][0]) as f64 / len,
                    (s.ends_px[1][1] - s.ends_px[0][1]) as f64 / len,
                ];
                let o = best.2;
                let off: Vec<[f64; 2]> = (0..2)
                    .map(|k| {
                        let dx = s.ends_px[k][0] as f64 - o[2 * k];
                        let dy = s.ends_px[k][1] as f64 - o[2 * k + 1];
                        [dx * u[0] + dy * u[1], dy * u[0] - dx * u[1]]
                    })
                    .collect();
                if verbose {
                    println!(
                        "  V {:.1} len {:.1} cut {} sig {:.2} {:.2} along {:.2} {:.2} across {:.2} {:.2}",
                        best.1,
                        len,
                        s.cut,
                        s.sigma_along_px,
                        s.sigma_across_px,
                        off[0][0],
                        off[1][0],
                        off[0][1],
                        off[1][1]
                    );
                }
                if best.0 < 60.0 && !s.cut {
                    for o in &off {
                        z2.push((o[0] / s.sigma_along_px as f64).powi(2));
                        zc2.push((o[1] / s.sigma_across_px as f64).powi(2));
                    }
                }
            }
            let longest = streaks.iter().map(|s| s.length_px()).fold(0.0, f32::max);
            let arcs: Vec<Arc> = streaks
                .iter()
                .take(24)
                .filter_map(|s| {
                    let ends = [camera.direction(s.ends_px[0])?, camera.direction(s.ends_px[1])?]
                        .map(|d| *d.vector());
                    let per = camera.rad_per_px() * 1.414;
                    let stretch = if s.cut { longest / s.length_px().max(1.0) } else { 1.0 };
                    Some(Arc {
                        ends,
                        sigma_rad: [s.sigma_along_px * per, s.sigma_across_px * per * stretch],
                        duration_s: 0.4,
                        directed: false,
                        whole: !s.cut,
                    })
                })
                .collect();
            match solve(&arcs) {
                None => {
                    none += 1;
                    println!("  no rate");
                }
                Some(rate_found) => {
                    let f = rate_found.rad_s.map(f64::from);
                    let n = f.norm();
                    let t = nalgebra_like(w);
                    let cos = (f.x * t[0] + f.y * t[1] + f.z * t[2]) / n / rate.to_radians();
                    let sign = cos.signum();
                    let e = [f.x - sign * w[0], f.y - sign * w[1], f.z - sign * w[2]];
                    let s = rate_found.sigma_rad_s();
                    println!(
                        "  rate {:.4} deg/s ({:+.2} %), axis off {:.3} deg, {} of {} arcs, z {:.1} {:.1} {:.1}",
                        n.to_degrees(),
                        100.0 * (n / rate.to_radians() - 1.0),
                        cos.abs().min(1.0).acos().to_degrees(),
                        rate_found.count(),
                        arcs.len(),
                        e[0] / s.x as f64,
                        e[1] / s.y as f64,
                        e[2] / s.z as f64
                    );
                    fits.push((100.0 * (n / rate.to_radians() - 1.0)).abs());
                    axes.push(cos.abs().min(1.0).acos().to_degrees());
                    for k in 0..3 {
                        sig.push((e[k] / s[k] as f64).powi(2));
                    }
                }
            }
        }
        let med = |v: &mut Vec<f64>| {
            v.sort_by(f64::total_cmp);
            v.get(v.len() / 2).copied().unwrap_or(f64::NAN)
        };
        println!(
            "== {rate}: none {none}, rate {:.2} %, axis {:.3} deg, rms z rate {:.2} med z2 along {:.2} across {:.2} ({} ends)",
            med(&mut fits),
            med(&mut axes),
            (sig.iter().sum::<f64>() / sig.len() as f64).sqrt(),
            med(&mut z2) / 0.455,
            med(&mut zc2) / 0.455,
            z2.len()
        );
    }
}
fn nalgebra_like(w: [f64; 3]) -> [f64; 3] {
    w
}
fn e_(e: [[f64; 2]; 2], r: bool) -> [f64; 4] {
    if r { [e[1][0], e[1][1], e[0][0], e[0][1]] } else { [e[0][0], e[0][1], e[1][0], e[1][1]] }
}
