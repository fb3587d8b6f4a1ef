//! Keeps the faults of file decoders inside the file that caused them.

use crate::{Error, Result};
use std::cell::Cell;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

thread_local! {
    /// Whether this thread runs a decoder whose panic becomes an error.
    static CONTAINS: Cell<bool> = const { Cell::new(false) };
}

/// From now on nothing is printed of panics that become errors: the error says it.
pub(crate) fn silence() {
    let hook = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        if !CONTAINS.get() {
            hook(panic);
        }
    }));
}

/// Pictures wider or higher than this are refused.
pub(crate) const MAX_SIDE: u64 = 1 << 16;

/// Runs a decoder written by others: should it panic on a damaged file, that is an error about `path`.
pub(crate) fn contain<T>(path: &Path, decode: impl FnOnce() -> Result<T>) -> Result<T> {
    let outer = CONTAINS.replace(true);
    // What `decode` borrows is not looked at again after a panic, so no broken state is seen.
    let result = catch_unwind(AssertUnwindSafe(decode));
    CONTAINS.set(outer);
    result.unwrap_or_else(|_| Err(Error::file(path, "damaged: the decoder gave up")))
}

/// Refuses pictures that no renderer needs, before memory is taken for them.
/// `bytes` is what the decoded picture takes, `max_bytes` what it may take.
pub(crate) fn check_size(path: &Path, (width, height): (u64, u64), bytes: u64, max_bytes: u64) -> Result<()> {
    if width == 0 || height == 0 {
        return Err(Error::file(path, "the picture is empty"));
    }
    if width > MAX_SIDE || height > MAX_SIDE {
        let message = format!("{width} × {height} pixels; no side may exceed {MAX_SIDE}");
        return Err(Error::file(path, message));
    }
    if bytes > max_bytes {
        let (has, may) = (bytes >> 20, max_bytes >> 20);
        let message = format!("takes {has} MiB when decoded; at most {may} MiB are allowed");
        return Err(Error::file(path, message));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_becomes_an_error_that_names_the_file() {
        let error = contain::<()>(Path::new("bad.exr"), || panic!("expected by a test"));
        assert!(error.unwrap_err().to_string().starts_with("bad.exr: damaged"));
        assert_eq!(contain(Path::new("good.exr"), || Ok(3)).unwrap(), 3);
    }

    #[test]
    fn sizes_are_checked_at_their_limits() {
        let check = |size, bytes| check_size(Path::new("p.png"), size, bytes, 1000);
        assert!(check((MAX_SIDE, 1), 1000).is_ok());
        assert!(check((MAX_SIDE + 1, 1), 1000).is_err());
        assert!(check((1, MAX_SIDE + 1), 1000).is_err());
        assert!(check((1, 1), 1001).is_err());
        assert!(check((0, 1), 0).is_err());
    }
}
