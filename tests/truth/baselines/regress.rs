//! Differentiate the recording, regress the acceleration on library terms, forward, as many as cross-validation bears.

use super::cross::{Validated, validated};
use super::design::Design;

pub fn choose(design: &Design) -> Option<Validated> {
    validated(design, |gram| design.forward(gram))
}
