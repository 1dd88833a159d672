//! Answers of costly functions by what these were asked: pages that are polled ask the same again and again.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use sha2::{Digest, Sha256};

type Key = [u8; 32];

/// The answers to at most so many questions.
pub struct Memo<V> {
    most: usize,
    known: Mutex<BTreeMap<Key, V>>,
}

impl<V: Clone> Memo<V> {
    pub const fn new(most: usize) -> Self {
        Self {
            most,
            known: Mutex::new(BTreeMap::new()),
        }
    }

    /// The answer to a question that these bytes hold whole; nobody waits for another's. All are forgotten once there are too many.
    pub fn get(&self, asked: &[u8], answer: impl FnOnce() -> V) -> V {
        let key: Key = Sha256::digest(asked).into();
        let known = || self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(value) = known().get(&key) {
            return value.clone();
        }
        let value = answer();
        let mut known = known();
        if known.len() >= self.most {
            known.clear();
        }
        known.insert(key, value.clone());
        value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_question_is_answered_once_and_few_are_kept() {
        let (memo, answered) = (Memo::new(2), std::cell::Cell::new(0));
        let ask = |asked: &str| {
            memo.get(asked.as_bytes(), || {
                answered.set(answered.get() + 1);
                asked.len()
            })
        };
        assert_eq!([ask("a"), ask("bc"), ask("a"), ask("bc")], [1, 2, 1, 2]);
        assert_eq!(answered.get(), 2);
        assert_eq!(ask("def"), 3);
        assert_eq!([ask("a"), answered.get()], [1, 4]);
    }
}
