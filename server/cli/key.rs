//! `veloid key`: who may enter.

use std::io::Write;

use clap::{Args, Subcommand};
use uuid::Uuid;
use veloid_engine::unseen;

use super::CliError;
use super::storage::Storage;
use crate::api::access::Token;
use crate::store::key::{self, HOME, KeyRow, Scope, Scopes};
use crate::store::now_ms;
use crate::store::session::{self, SessionRow};
use crate::time;

const DAY_MS: i64 = 86_400_000;

/// Creates, lists and revokes API keys.
#[derive(Args)]
pub struct Key {
    #[command(flatten)]
    storage: Storage,
    #[command(subcommand)]
    action: Action,
}

#[derive(Subcommand)]
enum Action {
    Create(Create),
    /// Lists all keys without their secrets, oldest first.
    List,
    /// Lists the browsers that are signed in, oldest first.
    Sessions,
    /// Signs a browser out.
    End {
        /// The session's id, as shown by `sessions`.
        id: Uuid,
    },
    /// Revokes a key and signs out the browsers that use it, immediately and permanently.
    Revoke {
        /// The key's id, as shown by `list`.
        id: Uuid,
    },
}

/// Creates a key and prints it once.
#[derive(Args)]
struct Create {
    /// User or purpose of the key.
    #[arg(long, default_value = "", value_parser = plain)]
    name: String,
    /// Group whose rides, jobs and bikes the key gives access to; it cannot see other groups.
    #[arg(long, default_value = HOME, value_parser = group)]
    group: String,
    /// Scope of the key; may be given several times.
    #[arg(long = "scope", value_enum, default_values = ["read", "upload"])]
    scopes: Vec<Scope>,
    /// Days until the key expires; by default never.
    #[arg(long, value_parser = clap::value_parser!(i64).range(1..=36_500))]
    days: Option<i64>,
    /// Largest upload (bytes); by default the server's limit.
    #[arg(long, value_parser = clap::value_parser!(i64).range(1..))]
    max_upload: Option<i64>,
    /// Requests per minute; by default the server's limit.
    #[arg(long, value_parser = clap::value_parser!(i64).range(1..=1_000_000))]
    requests_per_minute: Option<i64>,
    /// Jobs that may be queued or running; by default the server's limit.
    #[arg(long, value_parser = clap::value_parser!(i64).range(0..))]
    unfinished_jobs: Option<i64>,
}

/// A group that can be distinguished from others when it is read.
fn group(text: &str) -> Result<String, String> {
    match text.trim() {
        "" => Err("expected a name".to_owned()),
        name => plain(name),
    }
}

/// A text of one line that looks like what it is.
fn plain(text: &str) -> Result<String, String> {
    match unseen(text).next() {
        Some(found) => Err(format!(
            "U+{:04X} in it, expected visible characters",
            u32::from(found)
        )),
        None => Ok(text.to_owned()),
    }
}

impl Key {
    pub async fn run(self) -> Result<(), CliError> {
        let (db, _files) = match self.action {
            Action::Create(_) => self.storage.begin().await?,
            _ => self.storage.open().await?,
        };
        match self.action {
            Action::Create(create) => {
                let token = Token::draw().map_err(std::io::Error::from)?;
                let row = create.row();
                let mut tx = db.begin().await?;
                key::insert(&mut tx, &token.sha256(), &row).await?;
                tx.commit().await?;
                eprintln!(
                    "key {} of group {} may {}; it is not shown again:",
                    row.id, row.group_name, row.scopes
                );
                writeln!(std::io::stdout(), "{}", token.0)?;
            }
            Action::List => list(&key::list(&db).await?)?,
            Action::Sessions => sessions(&session::list(&db).await?)?,
            Action::End { id } => {
                let mut tx = db.begin().await?;
                let ended = session::revoke(&mut tx, id).await?;
                tx.commit().await?;
                if !ended {
                    return Err(CliError::NoSuchSession(id));
                }
                eprintln!("session {id} has ended");
            }
            Action::Revoke { id } => {
                let mut tx = db.begin().await?;
                let revoked = key::revoke(&mut tx, id).await?;
                tx.commit().await?;
                if !revoked {
                    return Err(CliError::NoSuchKey(id));
                }
                eprintln!("key {id} is revoked");
            }
        }
        Ok(())
    }
}

impl Create {
    fn row(self) -> KeyRow {
        let now = now_ms();
        KeyRow {
            id: Uuid::now_v7(),
            name: self.name,
            group_name: self.group,
            scopes: Scopes(self.scopes),
            max_upload_bytes: self.max_upload,
            requests_per_minute: self.requests_per_minute,
            unfinished_jobs: self.unfinished_jobs,
            created_at: now,
            expires_at: self.days.map(|days| now + days * DAY_MS),
            last_used_at: None,
            revoked_at: None,
        }
    }
}

fn sessions(sessions: &[SessionRow]) -> std::io::Result<()> {
    let mut out = std::io::stdout().lock();
    writeln!(
        out,
        "{:36}  {:36}  {:20}  {:24}  {:24}",
        "id", "key", "name", "since", "until"
    )?;
    for session in sessions {
        let [since, until] = [session.created_at, session.expires_at].map(time::text);
        let (id, key, name) = (session.id, session.key_id, &session.key_name);
        writeln!(out, "{id}  {key}  {name:20}  {since:24}  {until:24}")?;
    }
    Ok(())
}

fn list(keys: &[KeyRow]) -> std::io::Result<()> {
    let mut out = std::io::stdout().lock();
    writeln!(
        out,
        "{:36}  {:7}  {:16}  {:12}  {:20}  {:24}  {:24}",
        "id", "valid", "scopes", "group", "name", "last used", "expires"
    )?;
    let at = |ms: Option<i64>| ms.map_or_else(|| "never".to_owned(), time::text);
    for key in keys {
        let valid = match (key.revoked_at, key.is_valid()) {
            (Some(_), _) => "revoked",
            (None, true) => "yes",
            (None, false) => "expired",
        };
        writeln!(
            out,
            "{}  {valid:7}  {:16}  {:12}  {:20}  {:24}  {:24}",
            key.id,
            key.scopes.to_string(),
            key.group_name,
            key.name,
            at(key.last_used_at),
            at(key.expires_at),
        )?;
    }
    Ok(())
}
