//! The two axles, and what there is one of for each.

use std::fmt;

use serde::{Deserialize, Serialize};

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[serde(rename_all = "snake_case")]
#[allow(missing_docs, reason = "its schema stands wherever it is used")]
pub enum Axle {
    Front,
    Rear,
}

impl Axle {
    /// Front first.
    pub const BOTH: [Axle; 2] = [Axle::Front, Axle::Rear];

    /// The name at the beginning of a sentence.
    pub fn title(self) -> &'static str {
        match self {
            Axle::Front => "Front",
            Axle::Rear => "Rear",
        }
    }

    /// `front` or `rear`.
    pub fn name(self) -> &'static str {
        match self {
            Axle::Front => "front",
            Axle::Rear => "rear",
        }
    }
}

impl fmt::Display for Axle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// One value for each axle that the ride recorded.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[allow(missing_docs, reason = "its schema stands wherever it is used")]
pub struct PerAxle<T> {
    #[cfg_attr(feature = "openapi", schema(schema_with = nullable::<T>))]
    pub front: Option<T>,
    #[cfg_attr(feature = "openapi", schema(schema_with = nullable::<T>))]
    pub rear: Option<T>,
}

/// The derived schema of a generic `Option` forgets that it may be null.
#[cfg(feature = "openapi")]
fn nullable<T: utoipa::ToSchema>() -> utoipa::openapi::Schema {
    use utoipa::openapi::schema::{ObjectBuilder, OneOfBuilder, Type};
    let null = ObjectBuilder::new().schema_type(Type::Null);
    OneOfBuilder::new().item(T::schema()).item(null).into()
}

impl<T> Default for PerAxle<T> {
    fn default() -> Self {
        Self {
            front: None,
            rear: None,
        }
    }
}

impl<T> PerAxle<T> {
    /// Of one axle, where it is there.
    pub fn get(&self, axle: Axle) -> Option<&T> {
        match axle {
            Axle::Front => self.front.as_ref(),
            Axle::Rear => self.rear.as_ref(),
        }
    }

    /// Of one axle, to be changed.
    pub fn get_mut(&mut self, axle: Axle) -> Option<&mut T> {
        match axle {
            Axle::Front => self.front.as_mut(),
            Axle::Rear => self.rear.as_mut(),
        }
    }

    /// Puts a value in.
    pub fn set(&mut self, axle: Axle, value: T) {
        match axle {
            Axle::Front => self.front = Some(value),
            Axle::Rear => self.rear = Some(value),
        }
    }

    /// Whether neither is there.
    pub fn is_empty(&self) -> bool {
        self.front.is_none() && self.rear.is_none()
    }

    /// The axles present, front first.
    pub fn iter(&self) -> impl Iterator<Item = (Axle, &T)> {
        Axle::BOTH
            .into_iter()
            .filter_map(|a| self.get(a).map(|v| (a, v)))
    }

    /// Of each axle that is there.
    pub fn map<'a, U>(&'a self, mut f: impl FnMut(Axle, &'a T) -> U) -> PerAxle<U> {
        PerAxle {
            front: self.front.as_ref().map(|v| f(Axle::Front, v)),
            rear: self.rear.as_ref().map(|v| f(Axle::Rear, v)),
        }
    }

    /// Of each axle that is there, where there is something.
    pub fn filter_map<'a, U>(&'a self, mut f: impl FnMut(Axle, &'a T) -> Option<U>) -> PerAxle<U> {
        PerAxle {
            front: self.front.as_ref().and_then(|v| f(Axle::Front, v)),
            rear: self.rear.as_ref().and_then(|v| f(Axle::Rear, v)),
        }
    }

    /// Of each axle that is there.
    ///
    /// # Errors
    /// The first one that `f` gives.
    pub fn try_map<'a, U, E>(
        &'a self,
        mut f: impl FnMut(Axle, &'a T) -> Result<U, E>,
    ) -> Result<PerAxle<U>, E> {
        Ok(PerAxle {
            front: self.front.as_ref().map(|v| f(Axle::Front, v)).transpose()?,
            rear: self.rear.as_ref().map(|v| f(Axle::Rear, v)).transpose()?,
        })
    }
}
