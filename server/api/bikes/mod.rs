pub mod course;
pub mod delete;
pub mod events;
pub mod get;
pub mod history;
pub mod list;
pub mod restore;
pub mod view;
