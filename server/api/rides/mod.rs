mod body;
pub mod file;
pub mod get;
pub mod preview;
mod receive;
mod submit;
pub mod upload;

pub use submit::Submitted;
pub use upload::submit_upload;
