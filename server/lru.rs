//! The last few values of something costly, each made once however many ask at the same time.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use tokio::sync::OnceCell;

type Slot<V> = Arc<OnceCell<Arc<V>>>;

pub struct Lru<V> {
    capacity: usize,
    slots: Mutex<VecDeque<(String, Slot<V>)>>,
}

impl<V> Lru<V> {
    pub fn new(capacity: usize) -> Self {
        Self {
            capacity,
            slots: Mutex::default(),
        }
    }

    /// The value of the key; made by `make` where it is not there. A failure is not kept.
    pub async fn get<E>(
        &self,
        key: String,
        make: impl AsyncFnOnce() -> Result<V, E>,
    ) -> Result<Arc<V>, E> {
        let slot = self.slot(key);
        let value = slot.get_or_try_init(async || make().await.map(Arc::new));
        value.await.cloned()
    }

    /// Keeps a value that was made elsewhere.
    pub fn put(&self, key: String, value: Arc<V>) {
        // Someone else may have made it meanwhile; one of the two stays.
        let _ = self.slot(key).set(value);
    }

    fn slot(&self, key: String) -> Slot<V> {
        let mut slots = self.slots.lock().unwrap_or_else(PoisonError::into_inner);
        let found = slots.iter().position(|(k, _)| *k == key);
        let slot = found
            .and_then(|index| slots.remove(index))
            .map_or_else(Slot::default, |(_, slot)| slot);
        slots.push_front((key, Arc::clone(&slot)));
        slots.truncate(self.capacity);
        slot
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn a_value_is_made_once_until_it_is_pushed_out() {
        let lru = Lru::new(2);
        let mut made = Vec::new();
        for key in ["a", "b", "a", "c", "a", "b"] {
            let value = lru
                .get(key.to_owned(), async || {
                    made.push(key);
                    Ok::<_, ()>(key)
                })
                .await;
            assert_eq!(value.as_deref(), Ok(&key));
        }
        assert_eq!(made, ["a", "b", "c", "b"]);
    }

    #[tokio::test]
    async fn a_failure_is_tried_again() {
        let lru = Lru::<u8>::new(2);
        assert_eq!(lru.get("a".to_owned(), async || Err(7)).await, Err(7));
        assert_eq!(
            lru.get("a".to_owned(), async || Ok::<_, u8>(1))
                .await
                .as_deref(),
            Ok(&1)
        );
    }
}
