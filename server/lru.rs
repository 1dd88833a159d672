//! The last few values of something costly, each made once however many ask at the same time.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

use tokio::sync::OnceCell;

type Slot<V> = Arc<OnceCell<Arc<V>>>;

pub struct Lru<V> {
    capacity: usize,
    /// What they may weigh together, and what each does.
    most: usize,
    weigh: fn(&V) -> usize,
    slots: Mutex<VecDeque<(String, Slot<V>)>>,
}

impl<V> Lru<V> {
    pub fn new(capacity: usize) -> Self {
        Self {
            capacity,
            most: 0,
            weigh: |_| 0,
            slots: Mutex::default(),
        }
    }

    /// Keeps no more than weigh so much together, the last one excepted.
    pub fn of_at_most(self, most: usize, weigh: fn(&V) -> usize) -> Self {
        Self {
            most,
            weigh,
            ..self
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
        let value = value.await.cloned();
        self.shed();
        value
    }

    /// Keeps a value that was made elsewhere.
    pub fn put(&self, key: String, value: Arc<V>) {
        // Someone else may have made it meanwhile; one of the two stays.
        let _ = self.slot(key).set(value);
        self.shed();
    }

    /// Lets those go that were used longest ago, as long as all weigh too much.
    fn shed(&self) {
        let mut slots = self.slots.lock().unwrap_or_else(PoisonError::into_inner);
        let weigh = |(_, slot): &(String, Slot<V>)| slot.get().map_or(0, |v| (self.weigh)(v));
        while slots.len() > 1 && slots.iter().map(weigh).sum::<usize>() > self.most {
            slots.pop_back();
        }
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
    #![allow(clippy::unwrap_used)]
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
    async fn what_weighs_too_much_together_goes() {
        let lru = Lru::new(9).of_at_most(5, |value: &usize| *value);
        for (key, value) in [("a", 2), ("b", 3), ("c", 1), ("d", 9), ("e", 1)] {
            lru.put(key.to_owned(), Arc::new(value));
        }
        let kept: Vec<String> = lru
            .slots
            .lock()
            .unwrap()
            .iter()
            .map(|(k, _)| k.clone())
            .collect();
        assert_eq!(kept, ["e"]);
        lru.put("f".to_owned(), Arc::new(4));
        assert_eq!(lru.slots.lock().unwrap().len(), 2);
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
