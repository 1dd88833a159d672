//! Where a process keeps things, and who may work there.

use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};
use std::str::FromStr;
use std::sync::Arc;

use clap::Args;
use sqlx::sqlite::SqliteConnectOptions;
use tokio::fs;
use url::Url;
use uuid::Uuid;
use veloid_engine::ride::Logger;

use super::loggers::of_folder;
use super::manifest::DATABASE;
use super::vault::{Fresh, Vault};
use super::{CliError, room};
use crate::built::NotBuilt;
use crate::files::Files;
use crate::installation::{InstallationError, adopt, pair};
use crate::store::{Db, is_postgres};

#[derive(Args, Clone)]
pub struct Storage {
    /// Folder of the raw files and the SQLite database; created if missing.
    #[arg(long, global = true, env = "VELOID_DATA", default_value = "data")]
    data: PathBuf,
    /// Location of the raw files if not in the data folder: `file:///FOLDER`, or `s3://BUCKET/PREFIX` with credentials, region
    /// and endpoint from the AWS_* variables.
    #[arg(long, env = "VELOID_FILES", value_name = "URL")]
    files: Option<Url>,
    /// Database: `postgres://...` or `sqlite:FILE`; by default `veloid.db` in the data folder.
    #[arg(long, global = true, env = "DATABASE_URL", hide_env_values = true)]
    database_url: Option<String>,
}

impl Storage {
    /// The lab's loggers, beside the database, if it has any.
    pub fn loggers(&self) -> Result<Arc<[Logger]>, CliError> {
        let folder = self.data.join("loggers");
        match folder.exists() {
            true => of_folder(&folder),
            false => Ok(Arc::default()),
        }
    }

    /// Opens the file store and the database, with its schema up to date; both are made where they are absent.
    pub async fn begin(&self) -> Result<(Db, Files), CliError> {
        let exists = self.exists().await?;
        let files = self.open_files().await?;
        // No new database beside files of one that is not there: its journal would be in the way of a copy put in its place.
        if !exists && files.has_any().await? {
            return Err(InstallationError::NoRides.into());
        }
        let paired = async |db: &Db| {
            let id = pair(db, &files).await?;
            files.belong_to(id);
            Ok(())
        };
        let db = self.connect(paired).await?;
        Ok((db, files))
    }

    /// The same of an installation that is there.
    pub async fn open(&self) -> Result<(Db, Files), CliError> {
        match self.exists().await? {
            true => self.begin().await,
            false => Err(self.absent()),
        }
    }

    /// Makes the database and the store of raw files one installation, as `installation::adopt` has it; a database where
    /// there are files of one that is lost.
    pub async fn adopt(&self, new: bool) -> Result<Uuid, CliError> {
        let exists = self.exists().await?;
        let files = self.open_files().await?;
        if !exists && !files.has_any().await? {
            return Err(self.absent());
        }
        let db = self.connect(async |_| Ok(())).await?;
        let _lock = self.lock_for_work(&db)?;
        Ok(adopt(&db, &files, new).await?)
    }

    /// The database with its schema up to date, and more work done under the same lock.
    async fn connect(
        &self,
        work: impl AsyncFnOnce(&Db) -> Result<(), InstallationError>,
    ) -> Result<Db, CliError> {
        // SQLite's migrator takes no lock of its own.
        let lock = File::create(self.data.join("migrate.lock"))?;
        lock.lock()?;
        let db = Db::connect(&self.url()?).await?;
        db.migrate().await?;
        work(&db).await?;
        lock.unlock()?;
        Ok(db)
    }

    /// Whether there is a database of ours.
    async fn exists(&self) -> Result<bool, CliError> {
        let url = self.url()?;
        Ok(match is_postgres(&url) {
            true => !Db::connect(&url).await?.is_new().await?,
            false => self.sqlite_file()?.is_file(),
        })
    }

    /// The error or, where it may come of a full disk that something is kept on, that.
    pub fn blame(&self, error: CliError) -> CliError {
        let database = self.sqlite_file().ok();
        let files = self.files.as_ref().and_then(|url| url.to_file_path().ok());
        let beside = database.as_deref().and_then(Path::parent);
        let folders = [Some(self.data.as_path()), beside, files.as_deref()];
        room::blame(error, &folders.into_iter().flatten().collect::<Vec<_>>())
    }

    fn absent(&self) -> CliError {
        self.sqlite_file()
            .map_or(CliError::NoSchema, CliError::NoDatabase)
    }

    /// Database and raw files as they lie there, without opening the database.
    pub async fn vault(&self) -> Result<Vault, CliError> {
        let database = self.sqlite_file()?;
        if !database.is_file() {
            return Err(CliError::NoDatabase(database));
        }
        let files = self.open_files().await?;
        Ok(Vault { database, files })
    }

    /// The data folder, if nothing lies there yet.
    pub async fn fresh(&self) -> Result<Fresh, CliError> {
        let database = self.sqlite_file()?;
        let fresh = Fresh::at(&self.data).await?;
        match database.exists() {
            true => Err(CliError::NotEmpty(database)),
            false => Ok(fresh),
        }
    }

    /// Where database and raw files are to be copied.
    pub async fn vault_to_fill(&self) -> Result<Vault, CliError> {
        let (database, files) = (self.sqlite_file()?, self.open_files().await?);
        Ok(Vault { database, files })
    }

    /// The data folder.
    pub fn folder(&self) -> &Path {
        &self.data
    }

    async fn open_files(&self) -> Result<Files, CliError> {
        fs::create_dir_all(&self.data).await?;
        Ok(match &self.files {
            Some(url) => Files::at(url, &self.data).await?,
            None => Files::in_folder(&self.data).await?,
        })
    }

    fn address(&self) -> String {
        let default = || format!("sqlite:{}", self.data.join(DATABASE).display());
        self.database_url.clone().unwrap_or_else(default)
    }

    /// The address of the database, which is one that this program can open.
    fn url(&self) -> Result<String, NotBuilt> {
        let url = self.address();
        match is_postgres(&url) && !cfg!(feature = "postgres") {
            true => Err(NotBuilt::of("postgres", "a PostgreSQL database")),
            false => Ok(url),
        }
    }

    fn sqlite_file(&self) -> Result<PathBuf, CliError> {
        let url = self.address();
        if is_postgres(&url) {
            return Err(CliError::OnPostgres);
        }
        let options = SqliteConnectOptions::from_str(&url)?;
        Ok(options.get_filename().to_owned())
    }

    /// Waits until nobody copies or erases what lies in the data folder; the lock lasts as long as what this
    /// returns.
    pub fn lock_for_erasure(&self) -> Result<File, CliError> {
        let lock = self.erasure_lock()?;
        lock.lock()?;
        Ok(lock)
    }

    /// The same lock, if nobody has it.
    pub fn try_lock_for_erasure(&self) -> Result<Option<File>, CliError> {
        let lock = self.erasure_lock()?;
        match lock.try_lock() {
            Ok(()) => Ok(Some(lock)),
            Err(TryLockError::WouldBlock) => Ok(None),
            Err(TryLockError::Error(error)) => Err(error.into()),
        }
    }

    fn erasure_lock(&self) -> std::io::Result<File> {
        File::create(self.data.join("erase.lock"))
    }

    /// On SQLite one process works at a time, which is how it knows at its start that what is
    /// `running` belongs to one that is gone. The lock lasts as long as what this returns.
    pub fn lock_for_work(&self, db: &Db) -> Result<Option<File>, CliError> {
        if !db.is_sqlite() {
            return Ok(None);
        }
        let path = self.data.join("work.lock");
        let lock = File::create(&path)?;
        match lock.try_lock() {
            Ok(()) => Ok(Some(lock)),
            Err(TryLockError::WouldBlock) => Err(CliError::Locked(path)),
            Err(TryLockError::Error(error)) => Err(error.into()),
        }
    }
}
