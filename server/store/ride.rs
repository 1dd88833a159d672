use sqlx::types::Json;
use sqlx::{FromRow, QueryBuilder};
use uuid::Uuid;

use super::{Db, Tx, now_ms};
use crate::facts::Facts;

/// An uploaded ride.
#[derive(FromRow)]
pub struct RideRow {
    /// Of its file; of several files what stands for all of theirs.
    pub sha256: String,
    pub name: String,
    pub bytes: i64,
    pub uploaded_at: i64,
    /// Since when all of its jobs are deleted.
    pub deleted_at: Option<i64>,
    pub facts: Option<Json<Facts>>,
}

/// One of a ride's files.
#[derive(FromRow)]
pub struct FileRow {
    pub sha256: String,
    pub name: String,
    pub bytes: i64,
}

const UPSERT: &str = "\
    INSERT INTO ride (id, group_name, sha256, name, bytes, uploaded_at) VALUES ($1, $2, $3, $4, $5, $6) \
    ON CONFLICT (group_name, sha256, name) DO UPDATE SET bytes = excluded.bytes RETURNING id";

/// Records a ride whose files lie in the store; the same bytes under the same name stay one ride.
pub async fn upsert(
    tx: &mut Tx,
    group: &str,
    sha256: &str,
    name: &str,
    bytes: i64,
) -> sqlx::Result<Uuid> {
    on!(tx, t => sqlx::query_scalar(UPSERT)
        .bind(Uuid::now_v7())
        .bind(group)
        .bind(sha256)
        .bind(name)
        .bind(bytes)
        .bind(now_ms())
        .fetch_one(&mut **t)
        .await)
}

/// Records the files of a ride that has several.
pub async fn add_files(tx: &mut Tx, ride: Uuid, files: &[FileRow]) -> sqlx::Result<()> {
    const SQL: &str = "\
        INSERT INTO ride_file (ride_id, number, sha256, name, bytes) VALUES ($1, $2, $3, $4, $5) \
        ON CONFLICT (ride_id, number) DO NOTHING";
    for (number, file) in files.iter().enumerate() {
        on!(tx, t => sqlx::query(SQL)
            .bind(ride)
            .bind(number as i64)
            .bind(&file.sha256)
            .bind(&file.name)
            .bind(file.bytes)
            .execute(&mut **t)
            .await
            .map(drop))?;
    }
    Ok(())
}

/// A ride's files, in the order in which they came.
pub async fn files(db: &Db, ride: Uuid) -> sqlx::Result<Vec<FileRow>> {
    const SQL: &str = "\
        SELECT sha256, name, bytes FROM (\
            SELECT number, sha256, name, bytes FROM ride_file WHERE ride_id = $1 \
            UNION ALL \
            SELECT 0, sha256, name, bytes FROM ride \
            WHERE id = $1 AND NOT EXISTS (SELECT 1 FROM ride_file WHERE ride_id = $1)\
        ) AS file ORDER BY number";
    on!(read db, p => sqlx::query_as(SQL).bind(ride).fetch_all(p).await)
}

/// Number of rides, of all groups.
pub async fn count(db: &Db) -> sqlx::Result<i64> {
    const SQL: &str = "SELECT COUNT(*) FROM ride";
    on!(read db, p => sqlx::query_scalar(SQL).fetch_one(p).await)
}

pub async fn find(db: &Db, group: &str, id: Uuid) -> sqlx::Result<Option<RideRow>> {
    const SQL: &str = "\
        SELECT sha256, name, bytes, uploaded_at, facts, \
               (SELECT CASE WHEN COUNT(*) = COUNT(deleted_at) THEN MAX(deleted_at) END \
                FROM job WHERE job.ride_id = ride.id) AS deleted_at \
        FROM ride WHERE id = $1 AND group_name = $2";
    on!(read db, p => sqlx::query_as(SQL).bind(id).bind(group).fetch_optional(p).await)
}

/// Keeps others from recording or removing a file until the transaction ends.
pub async fn lock_file(tx: &mut Tx, sha256: &str) -> sqlx::Result<()> {
    // SQLite has one writer at a time; PostgreSQL many, so it takes a lock.
    const LOCK: &str = "SELECT pg_advisory_xact_lock(hashtextextended($1, 0))";
    if let Some(t) = tx.postgres() {
        sqlx::query(LOCK).bind(sha256).execute(&mut **t).await?;
    }
    Ok(())
}

/// Whether a ride of any group has this file.
pub async fn is_held(tx: &mut Tx, sha256: &str) -> sqlx::Result<bool> {
    const SQL: &str = "\
        SELECT (SELECT COUNT(*) FROM ride WHERE sha256 = $1) + (SELECT COUNT(*) FROM ride_file WHERE sha256 = $1)";
    let rides: i64 = on!(tx, t => sqlx::query_scalar(SQL).bind(sha256).fetch_one(&mut **t).await)?;
    Ok(rides > 0)
}

/// Those of these files that the database knows: a ride of any group has them, or had them until it was erased.
pub async fn known(db: &Db, files: &[String]) -> sqlx::Result<Vec<String>> {
    on!(read db, p => {
        let mut query = QueryBuilder::new("");
        for part in [
            "SELECT sha256 FROM ride WHERE sha256 IN (",
            " UNION SELECT sha256 FROM ride_file WHERE sha256 IN (",
            " UNION SELECT sha256 FROM erased_file WHERE sha256 IN (",
        ] {
            let mut list = query.push(part).separated(", ");
            for sha256 in files {
                list.push_bind(sha256);
            }
            query.push(")");
        }
        query.build_query_scalar().fetch_all(p).await
    })
}

/// Erases a ride unless it has a job left; the files that it had.
pub async fn erase_if_done(tx: &mut Tx, id: Uuid) -> sqlx::Result<Option<Vec<String>>> {
    // A statement of PostgreSQL sees what was there when it began: an upload that holds the ride may add a
    // job before this one has it.
    const LOCK: &str = "SELECT id FROM ride WHERE id = $1 FOR UPDATE";
    const SQL: &str = "\
        DELETE FROM ride WHERE id = $1 AND NOT EXISTS (SELECT 1 FROM job WHERE ride_id = $1) \
        RETURNING sha256";
    // Of several files; the ride's own name stands for all of them.
    const SEVERAL: &str = "SELECT sha256 FROM ride_file WHERE ride_id = $1";
    if let Some(t) = tx.postgres() {
        sqlx::query(LOCK).bind(id).execute(&mut **t).await?;
    }
    let several: Vec<String> =
        on!(tx, t => sqlx::query_scalar(SEVERAL).bind(id).fetch_all(&mut **t).await)?;
    let file: Option<String> =
        on!(tx, t => sqlx::query_scalar(SQL).bind(id).fetch_optional(&mut **t).await)?;
    Ok(file.map(|sha256| match several.is_empty() {
        true => vec![sha256],
        false => several,
    }))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::conformance::on_each;
    use crate::store::key::HOME;

    #[tokio::test]
    async fn a_ride_has_one_file_or_several_in_their_order() {
        on_each(async |db| {
            let file = |name: &str| FileRow {
                sha256: format!("{name}-sum"),
                name: name.to_owned(),
                bytes: 3,
            };
            let mut tx = db.begin().await.unwrap();
            let one = upsert(&mut tx, HOME, "aa", "z.csv", 5).await.unwrap();
            let several = upsert(&mut tx, HOME, "bb", "b, a", 6).await.unwrap();
            for _ in 0..2 {
                let files = [file("b"), file("a")];
                add_files(&mut tx, several, &files).await.unwrap();
            }
            tx.commit().await.unwrap();
            let reported = async |ride| -> Vec<(String, String, i64)> {
                let files = files(&db, ride).await.unwrap().into_iter();
                files.map(|f| (f.name, f.sha256, f.bytes)).collect()
            };
            let row = |name: &str, sum: &str, bytes| (name.to_owned(), sum.to_owned(), bytes);
            assert_eq!(reported(one).await, [row("z.csv", "aa", 5)]);
            let expected = [row("b", "b-sum", 3), row("a", "a-sum", 3)];
            assert_eq!(reported(several).await, expected);
            assert!(reported(Uuid::now_v7()).await.is_empty());
        })
        .await;
    }
}
