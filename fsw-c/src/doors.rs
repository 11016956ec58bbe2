//! What can be checked of a pointer that C hands over: null, alignment, length, overlap.
//!
//! In: pointers and lengths. Out: references and slices, or the [`Status`] that says what is wrong. Whether
//! memory of that length stands behind a pointer no callee can know.

use crate::status::Status;
use core::ffi::c_void;

/// Bytes that the caller keeps where they are.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct Bytes {
    /// First byte; may be null where `length` is 0.
    pub data: *const u8,
    /// Number of bytes.
    pub length: usize,
}

impl Bytes {
    /// Of a slice that lasts.
    pub(crate) const fn of(bytes: &'static [u8]) -> Self {
        Self { data: bytes.as_ptr(), length: bytes.len() }
    }

    /// The slice; an empty one for null without a length.
    ///
    /// # Errors
    /// [`Status::Null`], [`Status::Size`].
    ///
    /// # Safety
    /// Where `data` is not null, `length` bytes stand behind it and none of them changes during `'a`.
    pub(crate) unsafe fn slice<'a>(self) -> Result<&'a [u8], Status> {
        if self.length == 0 {
            return Ok(&[]);
        }
        check(self.data)?;
        check_length(self.data.addr(), self.length)?;
        // SAFETY: not null, no longer than an object can be, and what else is needed is the caller's
        // promise.
        Ok(unsafe { core::slice::from_raw_parts(self.data, self.length) })
    }
}

/// A piece of the address space.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Extent {
    /// Address of the first byte.
    first: usize,
    /// Number of bytes.
    length: usize,
}

impl Extent {
    /// The object that a pointer points to.
    pub(crate) fn of<T>(pointer: *const T) -> Self {
        Self { first: pointer.addr(), length: size_of::<T>() }
    }

    /// A buffer of bytes.
    pub(crate) fn of_bytes(data: *const u8, length: usize) -> Self {
        Self { first: data.addr(), length }
    }

    /// Whether they have a byte in common.
    pub(crate) fn overlaps(self, other: Self) -> bool {
        let (first, second) = if self.first <= other.first { (self, other) } else { (other, self) };
        first.length > 0 && second.length > 0 && second.first.wrapping_sub(first.first) < first.length
    }

    /// [`Status::Overlap`] where they have a byte in common.
    pub(crate) fn check_apart(self, other: Self) -> Result<(), Status> {
        if self.overlaps(other) { Err(Status::Overlap) } else { Ok(()) }
    }
}

/// Refuses a null pointer and one that is not aligned for a `T`.
pub(crate) fn check<T>(pointer: *const T) -> Result<(), Status> {
    if pointer.is_null() {
        return Err(Status::Null);
    }
    if pointer.is_aligned() { Ok(()) } else { Err(Status::Alignment) }
}

/// Refuses a length that no object can have, and one beyond the end of the address space.
pub(crate) fn check_length(first: usize, length: usize) -> Result<(), Status> {
    let ends = isize::try_from(length).is_ok() && first.checked_add(length).is_some();
    if ends { Ok(()) } else { Err(Status::Size) }
}

/// Refuses memory for a `T` that is null, too short or not aligned; gives it as a place for one.
pub(crate) fn check_memory<T>(memory: *mut c_void, bytes: usize) -> Result<*mut T, Status> {
    let place = memory.cast::<T>();
    check(place)?;
    check_length(memory.addr(), bytes)?;
    if bytes < size_of::<T>() { Err(Status::Size) } else { Ok(place) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn null_misaligned_short_and_endless_memory_is_refused() {
        let mut words = [0u64; 4];
        let memory = words.as_mut_ptr().cast::<c_void>();
        assert_eq!(check_memory::<[u64; 4]>(memory, 32), Ok(memory.cast()));
        assert_eq!(check_memory::<[u64; 4]>(memory, 31), Err(Status::Size));
        assert_eq!(check_memory::<[u64; 4]>(memory.wrapping_byte_add(4), 32), Err(Status::Alignment));
        assert_eq!(check_memory::<u64>(core::ptr::null_mut(), 32), Err(Status::Null));
        assert_eq!(check_memory::<u64>(memory, usize::MAX), Err(Status::Size));
    }

    #[test]
    fn bytes_are_a_slice_or_refused() {
        let bytes = Bytes::of(b"table");
        // SAFETY: the bytes are static, and those that are not are refused before they are looked at.
        unsafe {
            assert_eq!(bytes.slice(), Ok(&b"table"[..]));
            assert_eq!(Bytes { data: core::ptr::null(), length: 0 }.slice(), Ok(&[][..]));
            assert_eq!(Bytes { data: core::ptr::null(), length: 1 }.slice(), Err(Status::Null));
            assert_eq!(Bytes { length: usize::MAX, ..bytes }.slice(), Err(Status::Size));
            assert_eq!(Bytes { length: isize::MAX as usize + 1, ..bytes }.slice(), Err(Status::Size));
        }
    }

    proptest! {
        #[test]
        fn two_extents_overlap_where_they_have_a_byte_in_common(
            (a, b) in (0usize..40, 0usize..40), (n, m) in (0usize..20, 0usize..20), high in any::<bool>(),
        ) {
            let common = (a..a + n).any(|byte| (b..b + m).contains(&byte));
            // At the end of the address space as at its beginning.
            let base = if high { usize::MAX - 60 } else { 0 };
            let (first, second) =
                (Extent { first: base + a, length: n }, Extent { first: base + b, length: m });
            prop_assert_eq!((first.overlaps(second), second.overlaps(first)), (common, common));
        }
    }
}
