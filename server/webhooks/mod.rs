//! A receiver is notified when a job ends or a bicycle changes, instead of having to poll: a signed POST to an address that the
//! operator allows, by the scheme of <https://www.standardwebhooks.com>.
//!
//! A program without the feature `webhooks` queues messages and does all but send them: they wait in the database for one that
//! has it.

pub mod changes;
mod event;
mod message;
#[cfg_attr(not(feature = "webhooks"), path = "not_built.rs")]
mod post;
mod send;
mod sign;
mod target;
mod turns;

pub use event::{Event, Notification};
pub use message::Message;
pub use send::{SendError, send};
pub use sign::Secret;
pub use target::Targets;
pub use turns::{CONNECTIONS, Receiver, Turns};

use crate::built::NotBuilt;

/// An error where this program cannot send messages.
pub fn built() -> Result<(), NotBuilt> {
    match cfg!(feature = "webhooks") {
        true => Ok(()),
        false => Err(NotBuilt::of("webhooks", "messages of webhooks")),
    }
}
