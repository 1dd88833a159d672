//! Who is notified when jobs end and bicycles change. For keys of the scope `admin`.

pub mod create;
pub mod delete;
pub mod list;
pub mod test;
mod view;
