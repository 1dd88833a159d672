mod body;
pub mod delete;
mod facts;
pub mod file;
pub mod get;
pub mod patch;
pub mod preview;
mod receive;
pub mod restore;
mod submit;
pub mod upload;
mod view;

pub use submit::Submitted;
pub use upload::submit_upload;
