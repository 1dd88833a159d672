use std::collections::BTreeMap;

pub const DAY_MS: i64 = 86_400_000;

/// For how long what is kept.
#[derive(Clone, Default)]
pub struct Policy {
    /// What is deleted can be brought back for so long (ms).
    pub grace_ms: i64,
    /// Results are deleted after so long (ms).
    pub retain_ms: Option<i64>,
    /// The same of groups that have a time of their own (ms).
    pub retain_of_ms: BTreeMap<String, i64>,
}

impl Policy {
    /// For how long the results of a group are kept, if not for ever (ms).
    pub fn retained(&self, group: &str) -> Option<i64> {
        let own = self.retain_of_ms.get(group);
        own.copied().or(self.retain_ms)
    }
}
