//! The work: one River kind per stage of an identification. A stage computes in a child process or on threads of its own, then
//! stores its result, completes its River row and queues what comes next in one transaction.

mod anew;
mod announce;
mod at_hand;
mod budget;
mod cache;
mod compute;
mod conclude;
mod control;
mod deliver;
mod diagnose;
mod drawing;
mod errand;
mod fault;
mod finish;
mod gate;
mod hub;
mod isolate;
mod observe;
mod panics;
mod permits;
mod queue;
mod readers;
mod refit;
mod repair;
mod run;
mod seats;
mod stage;
mod study;
mod takeover;
mod task;
mod threads;
mod together;
mod trial;
mod unread;
mod work;

pub use anew::{begin_anew, queue_first};
pub use budget::{Budget, OverBudget};
pub use cache::RideCache;
pub use compute::Compute;
pub use drawing::Drawing;
pub use errand::Source;
pub use fault::Fault;
pub use finish::{parameters, verdict_name};
pub use gate::Gate;
pub use hub::{Hub, HubEvent, Searched};
pub use isolate::{Child, ChildError};
pub use queue::{LONG, QUICK, Queue};
pub use readers::{Patience, Readers};
#[cfg(test)]
pub use repair::repair;
pub use run::start;
pub use seats::Purpose;
pub use stage::give_up;
pub use study::{known_study, named as named_rides, queue_study};
#[cfg(test)]
pub use takeover::sweep;
pub use together::USUAL;
pub use unread::Unreadable;
pub use work::Work;
