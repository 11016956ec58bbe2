use super::*;
use crate::campaign::identify::cases;

#[test]
fn the_blocks_of_a_case_cover_its_fields_once() {
    for fields in [0, 1, FIELDS - 1, FIELDS, FIELDS + 1, 1000] {
        let keys: Vec<Key> = of_case(&cases::skies(), 1, 7..7 + fields).collect();
        let mut next = 7;
        for key in &keys {
            assert_eq!(key.first, next);
            next += key.fields;
        }
        assert_eq!(next, 7 + fields);
        assert!(keys.iter().all(|key| (1..=FIELDS).contains(&key.fields)));
    }
}
