use super::*;
use crate::campaign::cases;

#[test]
fn the_blocks_of_a_case_cover_its_fields_once() {
    for fields in [0, 1, FIELDS - 1, FIELDS, FIELDS + 1, 1000] {
        let keys = of_case(&cases::skies(), 1, fields);
        let mut next = 0;
        for key in &keys {
            assert_eq!(key.first, next);
            next += key.fields;
        }
        assert_eq!(next, fields);
        assert!(keys.iter().all(|key| (1..=FIELDS).contains(&key.fields)));
    }
}
