//! What is known of a ride besides its file. Whoever changes it has locked the ride's jobs (`deletion::lock`).

use sqlx::QueryBuilder;
use sqlx::types::Json;
use uuid::Uuid;

use super::Tx;
use crate::facts::Facts;

/// The group's ride of this file and name.
pub async fn ride_of_file(
    tx: &mut Tx,
    group: &str,
    sha256: &str,
    name: &str,
) -> sqlx::Result<Option<Uuid>> {
    const SQL: &str = "SELECT id FROM ride WHERE group_name = $1 AND sha256 = $2 AND name = $3";
    on!(tx, t => sqlx::query_scalar(SQL)
        .bind(group)
        .bind(sha256)
        .bind(name)
        .fetch_optional(&mut **t)
        .await)
}

/// What is known of a ride.
pub async fn of_ride(tx: &mut Tx, ride: Uuid) -> sqlx::Result<Facts> {
    const SQL: &str = "SELECT facts FROM ride WHERE id = $1";
    let facts: Option<Option<Json<Facts>>> =
        on!(tx, t => sqlx::query_scalar(SQL).bind(ride).fetch_optional(&mut **t).await)?;
    Ok(facts.flatten().map(|json| json.0).unwrap_or_default())
}

/// Keeps the facts of a ride in place of earlier ones, and gives its jobs their date.
pub async fn put(tx: &mut Tx, ride: Uuid, facts: &Facts) -> sqlx::Result<()> {
    const FACTS: &str = "UPDATE ride SET facts = $2 WHERE id = $1";
    const UNTAG: &str = "DELETE FROM ride_tag WHERE ride_id = $1";
    const DATE: &str = "\
        UPDATE job SET dated_at = COALESCE($2, created_at), revision = revision + 1 WHERE ride_id = $1";
    on!(tx, t => {
        let document = sqlx::query(FACTS).bind(ride).bind(Json(facts.document()));
        document.execute(&mut **t).await?;
        sqlx::query(UNTAG).bind(ride).execute(&mut **t).await?;
        if !facts.tags.is_empty() {
            QueryBuilder::new("INSERT INTO ride_tag (ride_id, tag) ")
                .push_values(&facts.tags, |mut row, tag| {
                    row.push_bind(ride).push_bind(tag);
                })
                .build()
                .execute(&mut **t)
                .await?;
        }
        let date = sqlx::query(DATE).bind(ride).bind(facts.ridden_ms());
        date.execute(&mut **t).await.map(drop)
    })
}
