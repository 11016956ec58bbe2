//! Short lists filled, sorted and asked for what most of them agree on, without a panic path (the library's
//! `extend`, sorts and insertions have some).

use heapless::Vec;

/// Adds values to a list as long as there is room.
pub(crate) fn fill<T, const N: usize>(list: &mut Vec<T, N>, values: impl IntoIterator<Item = T>) {
    for value in values {
        if list.push(value).is_err() {
            break;
        }
    }
}

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

/// The element to which most of the list are alike, itself among them, and how many; the first of equals.
pub(crate) fn most_alike<T: Copy>(list: &[T], are_alike: impl Fn(T, T) -> bool) -> Option<(T, usize)> {
    list.iter().fold(None, |best: Option<(T, usize)>, one| {
        let count = list.iter().filter(|other| are_alike(*one, **other)).count();
        match best {
            Some((_, most)) if most >= count => best,
            _ => Some((*one, count)),
        }
    })
}

/// The two least of two in order and another value, in order.
pub(crate) fn two_least<T: PartialOrd>([first, second]: [T; 2], value: T) -> [T; 2] {
    if value < first {
        [value, first]
    } else if value < second {
        [first, value]
    } else {
        [first, second]
    }
}

/// Distances of the elements that [`sort_unstable`] compares, from pass to pass (Ciura 2001).
const GAPS: [usize; 5] = [57, 23, 10, 4, 1];

/// Orders a list (Shell 1959), equal elements in any order: of 64 elements a third of the comparisons of
/// [`sort`].
#[inline]
pub(crate) fn sort_unstable<T>(list: &mut [T], comes_before: impl Fn(&T, &T) -> bool) {
    for gap in GAPS {
        for last in gap..list.len() {
            let mut at = last;
            while let Some([before, .., after]) = list.get_mut(at.wrapping_sub(gap)..=at)
                && comes_before(after, before)
            {
                core::mem::swap(before, after);
                at -= gap;
            }
        }
    }
}

/// Orders numbers, least first.
#[inline]
pub(crate) fn sort_numbers<T: PartialOrd>(numbers: &mut [T]) {
    sort_unstable(numbers, |one, other| one < other);
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    #[test]
    fn a_list_is_filled_to_its_end_and_no_further() {
        let mut list = heapless::Vec::<_, 4>::new();
        fill(&mut list, [1, 2]);
        assert_eq!(list, [1, 2]);
        fill(&mut list, 3..);
        assert_eq!(list, [1, 2, 3, 4]);
    }

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
        fn numbers_are_in_order(mut numbers in prop::collection::vec(-20i32..20, 0..150)) {
            let mut sorted = numbers.clone();
            sorted.sort_unstable();
            sort_numbers(&mut numbers);
            prop_assert_eq!(numbers, sorted);
        }

        #[test]
        fn most_are_alike_to_the_first_of_those_with_the_most(
            list in prop::collection::vec(0i32..30, 0..60),
            reach in 0i32..5,
        ) {
            let alike = |one: i32, other: i32| (one - other).abs() <= reach;
            let counts: Vec<usize> =
                list.iter().map(|one| list.iter().filter(|other| alike(*one, **other)).count()).collect();
            let first = counts.iter().position(|count| Some(count) == counts.iter().max());
            prop_assert_eq!(most_alike(&list, alike), first.map(|at| (list[at], counts[at])));
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
