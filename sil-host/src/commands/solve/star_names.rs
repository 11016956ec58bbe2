//! Proper names of the brightest stars, by Hipparcos number (IAU catalogue of star names).

/// The name of a star, if it has one here.
pub fn name(hip: u32) -> Option<&'static str> {
    NAMES.iter().find(|(known, _)| *known == hip).map(|(_, name)| *name)
}

/// By Hipparcos number: all stars brighter than V = 1.9 that have one, and others that make figures.
const NAMES: [(u32, &str); 93] = [
    (677, "Alpheratz"),
    (746, "Caph"),
    (2081, "Ankaa"),
    (3179, "Schedar"),
    (3419, "Diphda"),
    (5447, "Mirach"),
    (7588, "Achernar"),
    (8903, "Sheratan"),
    (9640, "Almach"),
    (9884, "Hamal"),
    (11767, "Polaris"),
    (14576, "Algol"),
    (15863, "Mirfak"),
    (17702, "Alcyone"),
    (21421, "Aldebaran"),
    (24436, "Rigel"),
    (24608, "Capella"),
    (25336, "Bellatrix"),
    (25428, "Elnath"),
    (25930, "Mintaka"),
    (26311, "Alnilam"),
    (26727, "Alnitak"),
    (27366, "Saiph"),
    (27989, "Betelgeuse"),
    (28360, "Menkalinan"),
    (30324, "Mirzam"),
    (30438, "Canopus"),
    (31681, "Alhena"),
    (32349, "Sirius"),
    (33579, "Adhara"),
    (34444, "Wezen"),
    (36850, "Castor"),
    (37279, "Procyon"),
    (37826, "Pollux"),
    (39429, "Naos"),
    (41037, "Avior"),
    (42913, "Alsephina"),
    (44816, "Suhail"),
    (45238, "Miaplacidus"),
    (45556, "Aspidiske"),
    (46390, "Alphard"),
    (49669, "Regulus"),
    (50583, "Algieba"),
    (53910, "Merak"),
    (54061, "Dubhe"),
    (57632, "Denebola"),
    (58001, "Phecda"),
    (60718, "Acrux"),
    (61084, "Gacrux"),
    (61932, "Muhlifain"),
    (62434, "Mimosa"),
    (62956, "Alioth"),
    (65378, "Mizar"),
    (65474, "Spica"),
    (67301, "Alkaid"),
    (68702, "Hadar"),
    (68933, "Menkent"),
    (69673, "Arcturus"),
    (71681, "Toliman"),
    (71683, "Rigil Kentaurus"),
    (72105, "Izar"),
    (72607, "Kochab"),
    (72622, "Zubenelgenubi"),
    (74785, "Zubeneschamali"),
    (76267, "Alphecca"),
    (77070, "Unukalhai"),
    (78401, "Dschubba"),
    (80763, "Antares"),
    (82273, "Atria"),
    (85927, "Shaula"),
    (86032, "Rasalhague"),
    (86228, "Sargas"),
    (87833, "Eltanin"),
    (90185, "Kaus Australis"),
    (90496, "Kaus Borealis"),
    (91262, "Vega"),
    (92855, "Nunki"),
    (93506, "Ascella"),
    (97649, "Altair"),
    (100453, "Sadr"),
    (100751, "Peacock"),
    (102098, "Deneb"),
    (102488, "Aljanah"),
    (105199, "Alderamin"),
    (107315, "Enif"),
    (109268, "Alnair"),
    (112122, "Tiaki"),
    (113368, "Fomalhaut"),
    (113881, "Scheat"),
    (113963, "Markab"),
    (6686, "Ruchbah"),
    (89931, "Kaus Media"),
    (94141, "Albaldah"),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_those_of_bright_stars_and_no_two_alike() {
        let stars = catalog_gen::source::stars();
        for (index, (hip, name)) in NAMES.iter().enumerate() {
            let star = stars.iter().find(|star| star.hip == *hip).unwrap_or_else(|| panic!("{name}"));
            assert!(star.v < 3.0, "{name} of V = {}", star.v);
            assert!(NAMES[..index].iter().all(|(other, known)| other != hip && known != name), "{name}");
        }
        // Every star brighter than V = 1.9 has its name but gamma Velorum, which has none.
        let without: Vec<u32> = stars
            .iter()
            .filter(|star| star.v < 1.9 && name(star.hip).is_none())
            .map(|star| star.hip)
            .collect();
        assert_eq!(without, [39_953]);
    }

    #[test]
    fn stars_stand_where_their_names_say() {
        // Right ascension and declination of almanacs, rounded to degrees.
        let known = [
            ("Sirius", 101.0, -17.0),
            ("Vega", 279.0, 39.0),
            ("Polaris", 38.0, 89.0),
            ("Antares", 247.0, -26.0),
            ("Acrux", 187.0, -63.0),
            ("Fomalhaut", 344.0, -30.0),
            ("Alcyone", 57.0, 24.0),
            ("Albaldah", 287.0, -21.0),
        ];
        let stars = catalog_gen::source::stars();
        for (name, ra_deg, dec_deg) in known {
            let (hip, _) = NAMES.iter().find(|(_, known)| *known == name).unwrap();
            let star = stars.iter().find(|star| star.hip == *hip).unwrap();
            let near = |a: f64, b: f64| (a - b).abs() <= 0.6;
            assert!(near(star.ra_deg, ra_deg) && near(star.dec_deg, dec_deg), "{name}: {star:?}");
        }
    }
}
