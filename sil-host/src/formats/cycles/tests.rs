use super::*;
use columns::{COLUMNS, Cell, VERSION};

/// The columns of version 1, which scripts rely on.
const FIRST: &str = "cycle,t_s,mode,expected_mode,sensor_state,lit_limb_deg,status,earth_status,\
stars,detections,limb_points,\
true_qx,true_qy,true_qz,true_qw,qx,qy,qz,qw,\
attitude_error_x_arcsec,attitude_error_y_arcsec,attitude_error_z_arcsec,\
attitude_sigma_x_arcsec,attitude_sigma_y_arcsec,attitude_sigma_z_arcsec,\
true_x_km,true_y_km,true_z_km,true_vx_km_s,true_vy_km_s,true_vz_km_s,\
x_km,y_km,z_km,vx_km_s,vy_km_s,vz_km_s,\
sigma_x_km,sigma_y_km,sigma_z_km,sigma_vx_km_s,sigma_vy_km_s,sigma_vz_km_s,\
position_error_radial_km,position_error_along_km,position_error_cross_km,\
velocity_error_radial_m_s,velocity_error_along_m_s,velocity_error_cross_m_s,\
earth_error_x_deg,earth_error_y_deg,earth_sigma_deg,distance_error_km,distance_sigma_km,\
limb_inliers,limb_arc_deg,limb_rms_px,\
limb_height_km,limb_height_sigma_km,nis,since_fix_s,settled,events,faults,\
rate_error_x_arcsec_s,rate_error_y_arcsec_s,rate_error_z_arcsec_s,\
gyro_x_deg_s,gyro_y_deg_s,gyro_z_deg_s,magnetometer_x_ut,magnetometer_y_ut,magnetometer_z_ut,\
true_rate_x_deg_s,true_rate_y_deg_s,true_rate_z_deg_s,rate_x_deg_s,rate_y_deg_s,rate_z_deg_s,\
rate_sigma_x_deg_s,rate_sigma_y_deg_s,rate_sigma_z_deg_s,rate_source,rate_either_sense,\
rate_error_percent,rate_axis_error_deg,\
filtered_error_x_arcsec,filtered_error_y_arcsec,filtered_error_z_arcsec,\
filtered_sigma_x_arcsec,filtered_sigma_y_arcsec,filtered_sigma_z_arcsec,activity,reported_faults";

#[test]
fn the_columns_of_version_1_stand_first_in_their_order_and_no_name_stands_twice() {
    let names: Vec<&str> = names().collect();
    let first: Vec<&str> = FIRST.split(',').collect();
    assert_eq!(names[..first.len()], first);
    assert!(VERSION > 1 && names.len() > first.len());
    assert_eq!(names.iter().collect::<std::collections::BTreeSet<_>>().len(), names.len());
}

#[test]
fn a_unit_in_a_name_is_the_one_that_is_declared() {
    let suffixes = [
        ("_arcsec_s", "arcsec/s"),
        ("_arcsec", "arcsec"),
        ("_deg_s", "deg/s"),
        ("_deg", "deg"),
        ("_km_s", "km/s"),
        ("_m_s", "m/s"),
        ("_km", "km"),
        ("_px", "px"),
        ("_ut", "uT"),
        ("_percent", "%"),
        ("_s", "s"),
    ];
    for of in COLUMNS {
        for name in of.names {
            let unit =
                suffixes.iter().find(|(suffix, _)| name.ends_with(suffix)).map_or("", |(_, unit)| unit);
            assert_eq!(of.unit, unit, "{name}");
        }
    }
}

#[test]
fn a_line_read_again_has_the_cells_it_was_made_of() {
    let mut writer = csv::WriterBuilder::new().has_headers(false).from_writer(Vec::new());
    let cells = [Cell::Number(-0.125, 2), Cell::Empty, Cell::Words("a, \"b\"".into()), Cell::Number(7.0, 0)];
    writer.serialize(cells).unwrap();
    let bytes = writer.into_inner().unwrap();
    let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(&bytes[..]);
    let read: (f64, Option<f64>, String, u32) = reader.deserialize().next().unwrap().unwrap();
    assert_eq!(read, (-0.12, None, "a, \"b\"".to_owned(), 7));
}
