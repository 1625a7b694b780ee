//! Values that a host holds by handle. A handle is the address of a value on the heap. It is
//! compared, never followed, so a wrong handle is an error and not a crash.

use super::Fault;

/// Values of one type that a host holds by handle. Dropping the collection frees them.
#[derive(Debug)]
pub struct Handles<T> {
    /// Boxed, since their addresses are the handles.
    #[allow(clippy::vec_box)]
    given: Vec<Box<T>>,
}

impl<T> Default for Handles<T> {
    fn default() -> Self {
        Self { given: Vec::new() }
    }
}

#[allow(clippy::borrowed_box)] // the heap address is meant
fn address<T>(value: &Box<T>) -> usize {
    std::ptr::from_ref::<T>(value).addr()
}

impl<T> Handles<T> {
    /// Stores a value and returns its handle. If `handle` is not zero, the value overwrites the
    /// value stored under `handle`, which stays valid; no memory is allocated.
    ///
    /// # Errors
    /// [`Fault::Handle`] if the handle is neither zero nor in use.
    pub fn keep(&mut self, value: T, handle: usize) -> Result<usize, Fault> {
        if handle != 0 {
            let place = self.place(handle)?;
            *self.given[place] = value;
            return Ok(handle);
        }
        let kept = Box::new(value);
        let handle = address(&kept);
        self.given.push(kept);
        Ok(handle)
    }

    /// Like [`keep`](Self::keep), but an unknown handle counts as zero, because a host may pass an
    /// uninitialized variable for the handle to be written.
    ///
    /// # Errors
    /// None.
    pub fn keep_new(&mut self, value: T, handle: usize) -> Result<usize, Fault> {
        let known = self.place(handle).is_ok();
        self.keep(value, if known { handle } else { 0 })
    }

    /// The value of the handle.
    ///
    /// # Errors
    /// [`Fault::Handle`] if the handle is not in use.
    pub fn get(&self, handle: usize) -> Result<&T, Fault> {
        Ok(&self.given[self.place(handle)?])
    }

    /// The value of the handle, mutable.
    ///
    /// # Errors
    /// [`Fault::Handle`] if the handle is not in use.
    pub fn get_mut(&mut self, handle: usize) -> Result<&mut T, Fault> {
        let place = self.place(handle)?;
        Ok(&mut self.given[place])
    }

    /// Frees the value of the handle.
    ///
    /// # Errors
    /// [`Fault::Handle`] if the handle is not in use.
    pub fn free(&mut self, handle: usize) -> Result<(), Fault> {
        let place = self.place(handle)?;
        self.given.swap_remove(place);
        Ok(())
    }

    /// Index of a handle. The search begins at the last one, since hosts mostly restore their
    /// latest states.
    fn place(&self, handle: usize) -> Result<usize, Fault> {
        self.given.iter().rposition(|kept| address(kept) == handle).ok_or(Fault::Handle)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn handles_are_looked_up_and_never_followed() {
        let (mut handles, mut others) = (Handles::default(), Handles::default());
        let first = handles.keep(1, 0).unwrap();
        let second = handles.keep(2, 0).unwrap();
        assert_ne!(first, second);
        assert_eq!(handles.keep(3, second), Ok(second));
        assert_eq!((handles.get(first), handles.get(second)), (Ok(&1), Ok(&3)));
        assert_eq!(handles.free(first), Ok(()));
        assert_eq!(handles.free(first), Err(Fault::Handle));
        assert_eq!(handles.get(first), Err(Fault::Handle));
        assert_eq!(handles.get(12345), Err(Fault::Handle));
        assert_eq!(others.keep(4, second), Err(Fault::Handle));
        // An unknown handle, as in an uninitialized variable of a host, counts as zero.
        let new = others.keep_new(5, second).unwrap();
        assert_eq!(others.get(new), Ok(&5));
    }
}
