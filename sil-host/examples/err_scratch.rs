//! scratch
use sil_host::scenario::Scenario; use sil_host::run::harness; use std::collections::BTreeMap; use std::path::Path;
fn main() {
    let mut scenario = Scenario::load(Path::new("geo-eclipse")).unwrap();
    scenario.duration_s = 20000;
    let mut scene = scenario.scene().unwrap();
    let mut by: BTreeMap<u32, (f64, f64, f64, f64, f64, f64, f64, f64, f64)> = BTreeMap::new();
    harness::fly(&scenario, &mut scene, |s| {
        if s.cycle % 10 != 0 { return Ok(()) }
        let vis = s.scene.visible_stars();
        for star in &s.report.stars {
            if let Some(t) = vis.iter().find(|v| v.hip == star.hip) {
                let (dx, dy) = (f64::from(star.centre_px[0]) - t.x_px, f64::from(star.centre_px[1]) - t.y_px);
                let near = vis.iter().filter(|o| o.hip != t.hip).map(|o| ((o.x_px-t.x_px).hypot(o.y_px-t.y_px), o.v)).filter(|o| o.0 < 8.0).min_by(|a,b| a.1.total_cmp(&b.1)).unwrap_or((99.0, 99.0));
                let e = by.entry(star.hip).or_default();
                e.0 += 1.0; e.1 += dx*dx+dy*dy; e.2 += dx; e.3 += dy; e.4 = t.v; e.5 = t.b_v; e.6 = near.0; e.7 = near.1; e.8 = e.8.max(dx.hypot(dy));
            }
        }
        Ok(())
    }).unwrap();
    let mut v: Vec<_> = by.into_iter().collect(); v.sort_by(|a, b| a.1.4.total_cmp(&b.1.4));
    for (hip, e) in v { if e.0 > 20.0 { println!("{hip} n {:.0} V {:.2} B-V {:.2} rms/axis {:.4} mean {:.4} {:.4} max {:.3} near {:.1}px V {:.1}", e.0, e.4, e.5, (e.1/2.0/e.0).sqrt(), e.2/e.0, e.3/e.0, e.8, e.6, e.7); } }
}
