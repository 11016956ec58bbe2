#![allow(missing_docs, unused, clippy::all)]
use fsw_core::earth::heights::PredictedLimb;
use fsw_core::earth::{Body, EarthFix, LimbPoint};
use fsw_core::frames::{Direction, Icrs, Rotation, StarPath};
use fsw_core::matrix::{symmetric_product, transposed_product};
use fsw_core::orbit::ephemeris;
use fsw_core::orbit::filter::{OrbitFilter, Update};
use fsw_core::orbit::look::LimbHeight;
use fsw_core::orbit::point::{PositionFix, earth_to_icrs};
use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};
use sil_host::flight;
use sil_host::harness;
use sil_host::scenario::Scenario;
use std::io::{Read, Write};
use std::path::Path;

fn main() {
    let a: Vec<String> = std::env::args().collect();
    match a[1].as_str() {
        "record" => record(&a[2], a[3].parse().unwrap(), &a[4]),
        _ => {
            use rayon::prelude::*;
            let jobs: usize = std::env::var("JOBS").ok().and_then(|j| j.parse().ok()).unwrap_or(1);
            rayon::ThreadPoolBuilder::new().num_threads(jobs).build_global().unwrap();
            let lines: Vec<String> = a[2..].par_iter().map(|f| replay(f)).collect();
            for l in lines { println!("{l}"); }
        }
    }
}
fn put(o: &mut Vec<u8>, x: &[f64]) { for v in x { o.extend(v.to_le_bytes()); } }

fn record(name: &str, seed: u64, out: &str) {
    let s = Scenario::named(Some(Path::new(name))).unwrap().with_seed(Some(seed));
    let mut scene = s.scene().unwrap();
    let mut o = Vec::new();
    harness::fly(&s, &mut scene, |sec| {
        let t = sec.truth;
        put(&mut o, &[t.instant_us as f64, t.position_km[0], t.position_km[1], t.position_km[2], t.velocity_km_s[0], t.velocity_km_s[1], t.velocity_km_s[2]]);
        match (sec.debug, &sec.report.attitude) {
            (Some((fix, us, points)), Some(att)) => {
                put(&mut o, &[points.len() as f64, *us as f64]);
                put(&mut o, &att.quaternion.map(f64::from));
                put(&mut o, &att.sigma_rad.map(f64::from));
                for v in [fix.centre_km, fix.linearisation_km] { put(&mut o, &[v.x.into(), v.y.into(), v.z.into()]); }
                for m in [fix.covariance_km2, fix.noise_km2] { for e in m.iter() { put(&mut o, &[f64::from(*e)]); } }
                put(&mut o, &[fix.arc_rad.into(), fix.rms_px.into(), (fix.inliers as u64) as f64]);
                o.extend(((fix.inliers >> 64) as u64).to_le_bytes());
                o.extend((fix.inliers as u64).to_le_bytes());
                for p in points { put(&mut o, &[p.centre_px[0].into(), p.centre_px[1].into(), p.sigma_px.into(), p.outward_px[0].into(), p.outward_px[1].into()]); }
            }
            _ => put(&mut o, &[-1.0]),
        }
        Ok(())
    }).unwrap();
    let mut f = std::fs::File::create(out).unwrap();
    let head = format!("{name} {seed}\n");
    f.write_all(head.as_bytes()).unwrap();
    f.write_all(&o).unwrap();
}

struct R<'a>(&'a [u8]);
impl R<'_> {
    fn f(&mut self) -> f64 { let (h, t) = self.0.split_at(8); self.0 = t; f64::from_le_bytes(h.try_into().unwrap()) }
    fn u(&mut self) -> u64 { let (h, t) = self.0.split_at(8); self.0 = t; u64::from_le_bytes(h.try_into().unwrap()) }
    fn v(&mut self) -> Vector3<f64> { Vector3::new(self.f(), self.f(), self.f()) }
    fn m(&mut self) -> Matrix3<f32> { let mut m = Matrix3::zeros(); for e in m.iter_mut() { *e = self.f() as f32; } m }
}

fn replay(file: &str) -> String {
    let mut bytes = Vec::new();
    std::fs::File::open(file).unwrap().read_to_end(&mut bytes).unwrap();
    let end = bytes.iter().position(|b| *b == b'\n').unwrap();
    let head = String::from_utf8(bytes[..end].to_vec()).unwrap();
    let (name, seed) = head.split_once(' ').unwrap();
    let s = Scenario::named(Some(Path::new(name))).unwrap().with_seed(Some(seed.parse().unwrap()));
    let camera = flight::camera(&s.believed_camera(), &s.file).unwrap();
    let calibration = s.calibration().unwrap();
    let calibration = calibration.as_ref().and_then(|c| c.open());
    let parameters = s.flight_parameters(calibration.as_ref());
    let (_, star_to_earth) = parameters.check().unwrap();
    let mut op = parameters.orbit;
    for kv in std::env::var("P").unwrap_or_default().split(',').filter(|k| !k.is_empty()) {
        let (k, v) = kv.split_once('=').unwrap();
        let v: f32 = v.parse().unwrap();
        match k {
            "h" => op.height_sigma_km = v, "ha" => op.height_sigma_rad = v, "su" => op.summer_sigma_km = v,
            "tr" => op.tropics_km = v, "trs" => op.tropics_sigma_km = v, "f" => op.field_sigma_km = v,
            "fl" => op.field_length_km = v, "e" => op.edge_sigma_km = v, "ep" => op.edge_patch_km = v,
            "look" => op.look_s = v, "mis" => op.misalignment_sigma_rad = v, "g" => op.gravity_noise_km_s15 = v,
            "gate" => op.gate_sigma = v,
            _ => panic!(),
        }
    }
    let verbose = std::env::var("V").is_ok();
    let mut r = R(&bytes[end + 1..]);
    let mut filter = OrbitFilter::new();
    let period = s.period_s();
    let total = s.duration_s as usize;
    let mounting = star_to_earth.inverse();
    let (mut i, mut started, mut told, mut within, mut restarts, mut rejected) = (0usize, None, 0u32, 0u32, 0, 0);
    let (mut nees_sum, mut nees_n) = (0.0, 0u32);
    let (mut nis, mut nisf) = (0.0f64, 0.0f64);
    let mut rac2 = Vector3::zeros(); let mut rac_n = 0.0; let mut sig2 = Vector3::zeros();
    let mut last = (0.0, 0.0, 0.0); let mut worst = 0.0f64; let mut worst_nees: f64 = 0.0;
    while !r.0.is_empty() {
        let _t_us = r.f() as i64;
        let (tp, tv) = (r.v(), r.v());
        let n = r.f();
        let mut update = Update::Gathered;
        if n >= 0.0 {
            let us = r.f() as i64;
            let q = [r.f() as f32, r.f() as f32, r.f() as f32, r.f() as f32];
            let sig = [r.f() as f32, r.f() as f32, r.f() as f32];
            let centre = r.v().map(|x| x as f32); let lin = r.v().map(|x| x as f32);
            let (cov, noise) = (r.m(), r.m());
            let (arc, rms, _) = (r.f() as f32, r.f() as f32, r.f());
            let (hi, lo) = (r.u(), r.u());
            let fix = EarthFix { centre_km: centre, linearisation_km: lin, covariance_km2: cov, noise_km2: noise, arc_rad: arc, rms_px: rms, inliers: (u128::from(hi) << 64) | u128::from(lo) };
            let points: Vec<LimbPoint> = (0..n as usize).map(|_| LimbPoint { centre_px: [r.f() as f32, r.f() as f32], sigma_px: r.f() as f32, outward_px: [r.f() as f32, r.f() as f32] }).collect();
            // the second
            if filter.advance(us, &op).is_err() { restarts += 1; }
            update = filter.finish_look(&op);
            count(&update, &mut nis, &mut nisf, &mut rejected, &mut restarts);
            let rotation = Rotation::<Icrs, StarPath>::from_quaternion(q).unwrap();
            let path = rotation.then(&star_to_earth);
            let pole: Direction<Icrs> = ephemeris::pole(us);
            let body = Body::new(&path.apply(&pole), None, &parameters.earth);
            let to_icrs = earth_to_icrs(&rotation, &mounting);
            let att = Matrix3::from_diagonal(&Vector3::from(sig.map(|x| x * x)));
            if let Some(state) = filter.state() {
                let c = transposed_product(&to_icrs, &state.position_km).map(|a| -a as f32);
                let in_path = symmetric_product(star_to_earth.matrix(), &att);
                if let Some(limb) = PredictedLimb::new(&c, &camera, &body) {
                    let hs = points.iter().enumerate().filter(|(k, _)| fix.is_inlier(*k)).filter_map(|(_, p)| {
                        let h = limb.height(p)?;
                        Some(LimbHeight { radial: h.radial, height_km: h.height_km, sigma_km: h.sigma_km })
                    });
                    filter.observe_limb(hs, &to_icrs, &in_path, &op);
                }
            } else {
                let shared = cov - noise;
                if let Some(p) = PositionFix::new(&centre, [&noise, &shared], &lin, &to_icrs, &att, &mounting) {
                    let u = filter.update(us, &p, &to_icrs, &op);
                    if u == Update::Started { if verbose { eprintln!("{i} started"); } started.get_or_insert(i); }
                    count(&u, &mut nis, &mut nisf, &mut rejected, &mut restarts);
                }
            }
        } else {
            let us = _t_us;
            if filter.advance(us, &op).is_err() { restarts += 1; }
            update = filter.finish_look(&op);
            count(&update, &mut nis, &mut nisf, &mut rejected, &mut restarts);
        }
        if let Some(st) = filter.state() {
            let up = tp.normalize(); let cr = tp.cross(&tv).normalize(); let al = cr.cross(&up);
            let axes = Matrix3::from_rows(&[up.transpose(), al.transpose(), cr.transpose()]);
            let e = axes * (st.position_km - tp);
            let p = axes * filter.position_covariance_km2().unwrap() * axes.transpose();
            let sg = p.diagonal().map(f64::sqrt);
            told += 1;
            let ok = (0..3).all(|k| e[k].abs() <= 3.0 * sg[k]);
            within += u32::from(ok);
            let ne = e.dot(&(p.try_inverse().unwrap() * e)) / 3.0;
            worst_nees = worst_nees.max(ne);
            if i as f64 >= total as f64 - period { nees_sum += ne; nees_n += 1; rac2 += e.component_mul(&e); sig2 += p.diagonal(); rac_n += 1.0; worst = worst.max(e.norm()); }
            last = (e.norm(), sg.norm(), ne);
            let nisok = matches!(update, Update::Accepted(_) | Update::Rejected(_) | Update::Diverged(_));
            if verbose && (nisok || i % 300 == 0) {
                eprintln!("{i} err {:.2} {:.2} {:.2} sig {:.2} {:.2} {:.2} nees/3 {:.2} h {:?} up {:?}", e.x, e.y, e.z, sg.x, sg.y, sg.z, ne, filter.limb_height_km().unwrap(), if nisok { Some(update) } else { None });
            }
        }
        i += 1;
    }
    let rac = (rac2 / rac_n).map(f64::sqrt);
    let sg = (sig2 / rac_n).map(f64::sqrt);
    let _ = (Matrix6::<f64>::zeros(), Vector6::<f64>::zeros());
    format!("{name:13} {seed:>4} start {:>5} end {:6.2} (sig {:5.2} nees/3 {:5.2}) last orbit R/A/C {:5.2} {:5.2} {:5.2} 3D {:5.2} sig {:5.2} {:5.2} {:5.2} nees/3 {:6.2} worst {:5.1} in3 {:6.2}% worstnees {:6.1} NIS/n {:.2} rej {} re {}", started.map_or(-1, |x| x as i64), last.0, last.1, last.2, rac.x, rac.y, rac.z, rac.norm(), sg.x, sg.y, sg.z, nees_sum / f64::from(nees_n), worst, 100.0 * f64::from(within) / f64::from(told), worst_nees, nis / nisf, rejected, restarts)
}
fn count(u: &Update, nis: &mut f64, f: &mut f64, rej: &mut u32, re: &mut u32) {
    match u {
        Update::Accepted(n) => { *nis += f64::from(n.square); *f += f64::from(n.freedom); }
        Update::Rejected(n) => { *rej += 1; *nis += f64::from(n.square); *f += f64::from(n.freedom); }
        Update::Diverged(_) => *re += 1,
        _ => {}
    }
}
