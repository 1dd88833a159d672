use std::time::Duration;

/// Longest wait for an answer.
pub const PATIENCE: Duration = Duration::from_secs(10);

/// What is sent; the same identifier at each attempt, so that a receiver knows what it has.
pub struct Message<'a> {
    pub id: &'a str,
    pub body: &'a str,
    /// Of this attempt (s since 1970).
    pub timestamp: i64,
}
