//! Where pointers become slices and panics become a status: all of the unsafe code there is.
//!
//! In: what a C program passes. Out: references that live as long as the call, and writes through the caller's pointers.
//! A [`Caller`] stands for the caller's promise that pointers are what the header asks for; what can be checked, null,
//! alignment and sizes, is checked all the same and answered by a status. Rust never looks at memory that it is to fill
//! ([`Caller::room`]): a C program need not clear it.

use core::ffi::{CStr, c_char};
use core::mem::{ManuallyDrop, MaybeUninit};
use core::ptr::NonNull;
use std::panic::{AssertUnwindSafe, catch_unwind};

use crate::error::{Failure, VoxdagError, VoxdagStatus};

/// The promise of the code that called: every pointer it passed is null, or is valid for as many items as the count
/// beside it says, for reading or writing as its type says, until the call returns; what is written overlaps nothing else.
/// Only types of which any bits are valid are read: numbers, pointers, and structures of them.
pub(crate) struct Caller(());

impl Caller {
    /// # Safety
    /// The promise must hold for every pointer that is given to the methods.
    pub unsafe fn new() -> Caller {
        Caller(())
    }

    /// Runs the body of a function; an error is written to `error`, if that is not null, and a panic ends here.
    pub fn run(&self, error: *mut VoxdagError, body: impl FnOnce() -> Result<(), Failure>) -> VoxdagStatus {
        let result = catch_unwind(AssertUnwindSafe(body)).unwrap_or(Err(Failure::Panic));
        let Err(failure) = result else { return VoxdagStatus::Ok };
        if check("error", error, 1).is_ok() {
            // SAFETY: not null, aligned, and promised to be writable.
            unsafe { error.write(failure.report()) };
        }
        failure.status()
    }

    /// `count` items; a null pointer is fine if there are none.
    pub fn slice<T: 'static>(&self, name: &'static str, items: *const T, count: usize) -> Result<&[T], Failure> {
        self.kept(name, items, count)
    }

    /// `count` items that the caller promised to keep longer than this call.
    pub fn kept<T: 'static>(&self, name: &'static str, items: *const T, count: usize) -> Result<&'static [T], Failure> {
        if count == 0 {
            return Ok(&[]);
        }
        check(name, items, count)?;
        // SAFETY: not null, aligned, of a size below isize::MAX, and promised to be readable.
        Ok(unsafe { core::slice::from_raw_parts(items, count) })
    }

    /// `count` items, or none for a null pointer.
    pub fn optional<T: 'static>(
        &self,
        name: &'static str,
        items: *const T,
        count: usize,
    ) -> Result<Option<&[T]>, Failure> {
        if items.is_null() { Ok(None) } else { self.slice(name, items, count).map(Some) }
    }

    /// `3 * count` numbers as triples.
    pub fn triples<T: 'static>(
        &self,
        name: &'static str,
        numbers: *const T,
        count: usize,
    ) -> Result<&[[T; 3]], Failure> {
        // The count is checked in whole triples; a triple is aligned as its numbers are.
        self.slice(name, numbers.cast(), count)
    }

    /// One item.
    pub fn one<T: 'static>(&self, name: &'static str, item: *const T) -> Result<&T, Failure> {
        Ok(&self.slice(name, item, 1)?[0])
    }

    /// A text up to its zero byte; a null pointer is an empty one.
    pub fn text(&self, text: *const c_char) -> &CStr {
        if text.is_null() {
            return c"";
        }
        // SAFETY: promised to be readable up to a zero byte.
        unsafe { CStr::from_ptr(text) }
    }

    /// Room for `count` items; a null pointer is fine if there are none.
    // Two rooms of one pointer would break the promise that what is written overlaps nothing else.
    #[allow(clippy::mut_from_ref)]
    pub fn room<T>(&self, name: &'static str, room: *mut T, count: usize) -> Result<&mut [MaybeUninit<T>], Failure> {
        if count == 0 {
            return Ok(&mut []);
        }
        check(name, room, count)?;
        // SAFETY: as in `kept`, promised to be writable and apart from all else; `MaybeUninit` asks nothing of the bits.
        Ok(unsafe { core::slice::from_raw_parts_mut(room.cast(), count) })
    }

    /// Room for `count` items, or none for a null pointer.
    pub fn optional_room<T>(
        &self,
        name: &'static str,
        room: *mut T,
        count: usize,
    ) -> Result<Option<&mut [MaybeUninit<T>]>, Failure> {
        if room.is_null() { Ok(None) } else { self.room(name, room, count).map(Some) }
    }

    /// Room for `count` words or bytes, cleared.
    #[allow(clippy::mut_from_ref)]
    pub fn cleared<T: Copy + Default>(
        &self,
        name: &'static str,
        room: *mut T,
        count: usize,
    ) -> Result<&mut [T], Failure> {
        let room = self.room(name, room, count)?;
        room.fill(MaybeUninit::new(T::default()));
        // SAFETY: all of them are written.
        Ok(unsafe { &mut *(core::ptr::from_mut(room) as *mut [T]) })
    }

    /// Writes one item.
    pub fn put<T>(&self, name: &'static str, place: *mut T, item: T) -> Result<(), Failure> {
        self.room(name, place, 1)?[0].write(item);
        Ok(())
    }

    /// Gives the caller an object, to be handed back to [`Caller::take`].
    pub fn give<T>(&self, name: &'static str, place: *mut *mut T, object: T) -> Result<(), Failure> {
        let place = &mut self.room(name, place, 1)?[0];
        place.write(Kept::new(object)?.into_raw());
        Ok(())
    }

    /// Takes back what [`Caller::give`] gave, and drops it; a null pointer is nothing.
    pub fn take<T>(&self, object: *mut T) {
        if let Some(object) = NonNull::new(object) {
            // SAFETY: it is from `give`, and promised not to be used again.
            drop(unsafe { Kept::from_raw(object) });
        }
    }
}

/// What is kept beside what borrows it.
///
/// # Safety
/// It must be neither moved in memory nor changed nor freed while the result is in use.
pub(crate) unsafe fn forever<T: ?Sized>(item: &T) -> &'static T {
    // SAFETY: as promised; a reference is valid but for its lifetime.
    unsafe { &*core::ptr::from_ref(item) }
}

/// An object on the heap that stays where it is when its owner moves, for [`forever`]; a `Box` may not be borrowed from
/// while it moves.
pub(crate) struct Kept<T>(NonNull<T>);

// SAFETY: it owns the object, as a `Box` does.
unsafe impl<T: Send> Send for Kept<T> {}
// SAFETY: shared, it gives shared references only.
unsafe impl<T: Sync> Sync for Kept<T> {}

impl<T> Kept<T> {
    pub fn new(object: T) -> Result<Kept<T>, Failure> {
        // Unlike `Box::new` this does not abort if there is no memory.
        let mut list = Vec::new();
        list.try_reserve_exact(1).map_err(|_| Failure::Memory { needed: size_of::<T>() as u64 })?;
        list.push(object);
        let first = Box::into_raw(list.into_boxed_slice()).cast();
        // SAFETY: a pointer to an object is not null.
        Ok(Kept(unsafe { NonNull::new_unchecked(first) }))
    }

    pub fn get(&self) -> &T {
        // SAFETY: it lives until `drop`.
        unsafe { self.0.as_ref() }
    }

    /// Hands the object over, to be taken back by [`Kept::from_raw`].
    fn into_raw(self) -> *mut T {
        ManuallyDrop::new(self).0.as_ptr()
    }

    /// # Safety
    /// The pointer must be from [`Kept::into_raw`], and not be used any more.
    unsafe fn from_raw(object: NonNull<T>) -> Kept<T> {
        Kept(object)
    }
}

impl<T> Drop for Kept<T> {
    fn drop(&mut self) {
        // SAFETY: `new` made a slice of one, which is dropped once.
        drop(unsafe { Box::from_raw(core::ptr::slice_from_raw_parts_mut(self.0.as_ptr(), 1)) });
    }
}

/// What can be checked of a pointer to `count` items.
fn check<T>(name: &'static str, pointer: *const T, count: usize) -> Result<(), Failure> {
    if pointer.is_null() {
        return Err(Failure::Null { name });
    }
    if !pointer.is_aligned() {
        return Err(Failure::Misaligned { name, expected: align_of::<T>() });
    }
    let bytes = count.checked_mul(size_of::<T>()).filter(|&bytes| bytes <= isize::MAX as usize);
    match bytes.and_then(|bytes| pointer.addr().checked_add(bytes)) {
        Some(_) => Ok(()),
        None => Err(Failure::Count { name, found: count as u64 }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_ends_at_the_border() {
        // SAFETY: the only pointer is one to what lives here.
        let caller = unsafe { Caller::new() };
        let mut error = MaybeUninit::<VoxdagError>::uninit();
        let status = caller.run(error.as_mut_ptr(), || panic!("on purpose"));
        // SAFETY: written, as the status is not OK.
        let error = unsafe { error.assume_init() };
        assert_eq!((status, error.status), (VoxdagStatus::Panic, VoxdagStatus::Panic));
        assert_eq!(caller.run(core::ptr::null_mut(), || Ok(())), VoxdagStatus::Ok);
    }

    #[test]
    fn what_is_given_is_taken_back() {
        // SAFETY: the only pointers are to what lives here.
        let caller = unsafe { Caller::new() };
        let (list, mut place) = (std::sync::Arc::new(()), core::ptr::null_mut());
        caller.give("place", &mut place, list.clone()).unwrap();
        assert_eq!(std::sync::Arc::strong_count(&list), 2);
        caller.take(place);
        assert_eq!(std::sync::Arc::strong_count(&list), 1);
    }
}
