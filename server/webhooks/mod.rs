//! A receiver is notified when a job ends or a bicycle changes, instead of having to poll: a signed POST to an address that the
//! operator allows, by the scheme of <https://www.standardwebhooks.com>.

pub mod changes;
mod event;
mod send;
mod sign;
mod target;
mod turns;

pub use event::{Event, Notification};
pub use send::{Message, SendError, send};
pub use sign::Secret;
pub use target::Targets;
pub use turns::{CONNECTIONS, Receiver, Turns};
