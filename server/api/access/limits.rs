//! What keys may do, unless they say otherwise.

/// Limits of whatever has none of its own.
#[derive(Clone, Copy)]
pub struct Limits {
    pub requests_per_minute: u32,
    /// Jobs of one key that are not at their end.
    pub unfinished_jobs: i64,
    /// Jobs of all together that are not at their end.
    pub queue: i64,
}
