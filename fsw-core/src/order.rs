//! Ordered short lists without a panic path (the library's sorts and insertions have some).

/// Moves the last element of an otherwise ordered list to its place; equal elements keep their order. At most one swap an
/// element.
pub(crate) fn settle_last<T>(list: &mut [T], comes_before: impl Fn(&T, &T) -> bool) {
    for at in (1..list.len()).rev() {
        match list.get_mut(at - 1..=at) {
            Some([before, after]) if comes_before(after, before) => core::mem::swap(before, after),
            _ => return,
        }
    }
}
