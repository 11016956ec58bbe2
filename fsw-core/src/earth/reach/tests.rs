use super::*;
use proptest::prelude::*;

#[test]
fn a_strip_reaches_over_the_glow_and_three_sigmas_of_the_limbs_height() {
    let mut parameters = EarthParameters::default();
    parameters.limb.scale_height_km = 8.0;
    let reach = |outward_px, inward_px| Some(Reach { outward_px, inward_px });
    // From the geostationary orbit 12 km a pixel: 36 km of glow are 3 px, 12 km of the bright side one,
    // beside the margin of 9.
    assert_eq!(limb_reach(12.0, 0.0, 0.0, &parameters), reach(12, 10));
    assert_eq!(limb_reach(12.0, 40.0, 0.0, &parameters), reach(22, 20));
    // Half of what the exposure draws out lies on either side.
    assert_eq!(limb_reach(12.0, 0.0, 8.0, &parameters), reach(16, 14));
    // From a low one 0.8 km a pixel: 45 px of glow, 15 px of the bright side.
    assert_eq!(limb_reach(0.8, 0.0, 0.0, &parameters), reach(54, 24));
    assert_eq!(limb_reach(0.8, 2.0, 0.0, &parameters), reach(62, 32));
}

#[test]
fn a_limb_of_which_too_little_is_known_has_no_strip() {
    let parameters = EarthParameters::default();
    assert_eq!(limb_reach(0.8, 50.0, 0.0, &parameters), None);
    for (km_per_px, sigma_km) in
        [(f32::NAN, 1.0), (1.0, f32::NAN), (0.0, 1.0), (1.0, f32::INFINITY), (f32::MIN_POSITIVE, 0.0)]
    {
        assert_eq!(limb_reach(km_per_px, sigma_km, 0.0, &parameters), None, "{km_per_px} {sigma_km}");
    }
}

proptest! {
    #[test]
    fn a_strip_holds_what_it_must_and_is_no_longer_than_a_strip_can_be(
        km_per_px in 0.1f32..50.0, sigma_km in 0f32..200.0, further_km in 0f32..50.0
    ) {
        let parameters = EarthParameters::default();
        let Some(reach) = limb_reach(km_per_px, sigma_km, 0.0, &parameters) else {
            let both = 2.0 * STRIP_MARGIN_PX + (glow_km(&parameters) + BRIGHT_SCALES * 8.0 + 6.0 * sigma_km) / km_per_px;
            prop_assert!(both > MAX_LENGTH as f32 - 3.0);
            return Ok(());
        };
        let (outward, inward) = (f32::from(reach.outward_px), f32::from(reach.inward_px));
        prop_assert!(outward + inward < MAX_LENGTH as f32);
        let needed_px = |km: f32| STRIP_MARGIN_PX + (km + 3.0 * sigma_km) / km_per_px;
        prop_assert!((-1e-3..1.001).contains(&(outward - needed_px(glow_km(&parameters)))));
        prop_assert!((-1e-3..1.001).contains(&(inward - needed_px(BRIGHT_SCALES * parameters.limb.scale_height_km))));
        // The less is known, the farther it reaches.
        if let Some(farther) = limb_reach(km_per_px, sigma_km + further_km, 0.0, &parameters) {
            prop_assert!(reach.outward_px <= farther.outward_px && reach.inward_px <= farther.inward_px);
        }
    }
}
