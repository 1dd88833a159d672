//! The allocator, and how long it keeps what was freed.

use std::ffi::{c_int, c_long};

use libmimalloc_sys::mi_option_set_default;

/// glibc's keeps what many threads have freed: three quarters of an hour of rides took a server from 183 to 260 MB, of which
/// trimming gave 106 back.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// The place of `mi_option_purge_delay` in mimalloc.h, which its crate does not name.
const PURGE_DELAY: c_int = 15;
/// Time (ms) after which freed memory is given back. By default it is a second, which is longer than a diagnosis takes
/// (`docs/performance.md`, Memory).
const SOON: c_long = 10;

/// Has freed memory given back soon, unless MIMALLOC_PURGE_DELAY says otherwise.
pub fn give_back_soon() {
    // SAFETY: the function writes one number of a table of options, and no other thread runs yet that could read it.
    unsafe { mi_option_set_default(PURGE_DELAY, SOON) };
}

#[cfg(test)]
mod tests {
    use libmimalloc_sys::mi_option_get;

    use super::*;

    #[test]
    fn freed_memory_is_given_back_soon() {
        // SAFETY: reads one number, which at most `give_back_soon` writes.
        let delay = || unsafe { mi_option_get(PURGE_DELAY) };
        if std::env::var_os("MIMALLOC_PURGE_DELAY").is_none() {
            // Else the option is another one, or its default has changed.
            assert_eq!(delay(), 1000);
            give_back_soon();
            assert_eq!(delay(), SOON);
        }
    }
}
