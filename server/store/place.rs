//! The files of a SQLite database that this process has open, by device and inode. A file that was renamed over one of them,
//! or the place where one was removed, has nothing of what is written to the open one.

use std::io;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use crate::exchanged::Exchanged;

/// Device and inode.
type Inode = (u64, u64);

pub struct Place {
    database: Noted,
    /// The log and its index.
    beside: [Noted; 2],
}

type Noted = (PathBuf, Inode);

impl Place {
    /// Notes the files of an open database.
    pub fn of(database: &Path) -> io::Result<Self> {
        // They lie beside the file that a link leads to.
        let file = database.canonicalize()?;
        let beside = |suffix| {
            let mut path = file.clone().into_os_string();
            path.push(suffix);
            noted(path.into())
        };
        Ok(Self {
            database: noted(database.to_owned())?,
            beside: [beside("-wal")?, beside("-shm")?],
        })
    }

    /// Whether these files still have their names.
    pub fn holds(&self) -> Result<(), Exchanged> {
        same(&self.database).map_err(Exchanged::File)?;
        self.beside
            .iter()
            .try_for_each(same)
            .map_err(Exchanged::Log)
    }
}

fn noted(path: PathBuf) -> io::Result<Noted> {
    let inode = inode(&path)?;
    Ok((path, inode))
}

fn inode(path: &Path) -> io::Result<Inode> {
    let metadata = path.metadata()?;
    Ok((metadata.dev(), metadata.ino()))
}

fn same((path, noted): &Noted) -> Result<(), String> {
    let name = path.display();
    match inode(path) {
        Ok(found) if found == *noted => Ok(()),
        Ok(_) => Err(format!("{name} is another file")),
        Err(error) if error.kind() == io::ErrorKind::NotFound => Err(format!("{name} is missing")),
        Err(error) => Err(format!("{name}: {error}")),
    }
}
