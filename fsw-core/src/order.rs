//! Sorting of short lists without a panic path (the library's sorts and insertions have some).

/// Moves the last element of an otherwise ordered list to its place; equal elements keep their order. At most
/// one swap an element.
pub(crate) fn insert_last<T>(list: &mut [T], comes_before: impl Fn(&T, &T) -> bool) {
    for at in (1..list.len()).rev() {
        match list.get_mut(at - 1..=at) {
            Some([before, after]) if comes_before(after, before) => core::mem::swap(before, after),
            _ => return,
        }
    }
}

/// Orders a list by [`insert_last`] of ever longer pieces; equal elements keep their order.
pub(crate) fn sort<T>(list: &mut [T], comes_before: impl Fn(&T, &T) -> bool) {
    for end in 1..=list.len() {
        if let Some(piece) = list.get_mut(..end) {
            insert_last(piece, &comes_before);
        }
    }
}

/// Orders numbers, least first.
#[inline(never)]
pub(crate) fn sort_numbers(numbers: &mut [f32]) {
    sort(numbers, |one, other| one < other);
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    proptest! {
        #[test]
        fn a_list_filled_element_by_element_is_sorted_stably(keys in prop::collection::vec(0u8..12, 0..80)) {
            let arrivals: Vec<(u8, usize)> = keys.into_iter().zip(0..).collect();
            let mut list = Vec::new();
            for arrival in &arrivals {
                list.push(*arrival);
                insert_last(&mut list, |one, other| one.0 < other.0);
            }
            let mut sorted = arrivals;
            sorted.sort_by_key(|arrival| arrival.0);
            prop_assert_eq!(list, sorted);
        }

        #[test]
        fn only_the_last_element_moves(
            mut list in prop::collection::vec(any::<i16>(), 0..40),
            last in any::<i16>(),
        ) {
            list.sort_unstable_by(|one, other| other.cmp(one));
            let others = list.clone();
            list.push(last);
            insert_last(&mut list, |one, other| one > other);
            let place = list.iter().rposition(|value| *value == last).unwrap();
            list.remove(place);
            prop_assert_eq!(list, others);
        }
    }

    #[test]
    fn a_nan_stays_where_it_is() {
        let mut list = [1.0, 2.0, f32::NAN];
        insert_last(&mut list, |one, other| one < other);
        assert!(list[0] == 1.0 && list[1] == 2.0 && list[2].is_nan());
        insert_last::<f32>(&mut [], |_, _| true);
    }
}
