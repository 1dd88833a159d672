mod bicycle;
mod body;
pub mod delete;
mod facts;
pub mod file;
pub mod get;
pub mod patch;
pub mod preview;
pub mod preview_bike;
mod receive;
pub mod restore;
mod submit;
pub mod upload;
pub mod view;

pub use bicycle::looked_at;
pub use submit::Submitted;
pub use upload::{Refused, submit_upload};
