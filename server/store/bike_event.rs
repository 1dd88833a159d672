//! What was done to bicycles: a service, a new tyre.

use sqlx::FromRow;
use uuid::Uuid;

use super::{Db, Tx, now_ms};

#[derive(Clone, Debug, FromRow)]
pub struct EventRow {
    pub id: Uuid,
    pub bike: String,
    /// Beginning of the day (epoch ms, UTC).
    pub day: i64,
    pub text: String,
}

/// Those of a bicycle, oldest first.
pub async fn of_bike(db: &Db, group: &str, bike: &str) -> sqlx::Result<Vec<EventRow>> {
    const SQL: &str = "\
        SELECT id, bike, day, text FROM bike_event \
        WHERE group_name = $1 AND bike = $2 AND deleted_at IS NULL ORDER BY day, id";
    on!(read db, p => sqlx::query_as(SQL).bind(group).bind(bike).fetch_all(p).await)
}

/// Those of all bicycles of a group, oldest first.
pub async fn of_group(db: &Db, group: &str) -> sqlx::Result<Vec<EventRow>> {
    const SQL: &str = "\
        SELECT id, bike, day, text FROM bike_event \
        WHERE group_name = $1 AND deleted_at IS NULL ORDER BY day, id";
    on!(read db, p => sqlx::query_as(SQL).bind(group).fetch_all(p).await)
}

pub async fn count(tx: &mut Tx, group: &str, bike: &str) -> sqlx::Result<i64> {
    const SQL: &str = "\
        SELECT COUNT(*) FROM bike_event WHERE group_name = $1 AND bike = $2 AND deleted_at IS NULL";
    on!(tx, t => sqlx::query_scalar(SQL).bind(group).bind(bike).fetch_one(&mut **t).await)
}

/// Adds one to a bicycle that is not deleted; false where there is none.
pub async fn insert(tx: &mut Tx, group: &str, row: &EventRow) -> sqlx::Result<bool> {
    const SQL: &str = "\
        INSERT INTO bike_event (id, group_name, bike, day, text, created_at) \
        SELECT $1, group_name, name, $4, $5, $6 FROM bike \
        WHERE group_name = $2 AND name = $3 AND deleted_at IS NULL";
    let added = on!(tx, t => sqlx::query(SQL)
        .bind(row.id)
        .bind(group)
        .bind(&row.bike)
        .bind(row.day)
        .bind(&row.text)
        .bind(now_ms())
        .execute(&mut **t)
        .await?
        .rows_affected());
    Ok(added == 1)
}

/// Takes one away for good; false where the bicycle has none of this id.
pub async fn delete(tx: &mut Tx, group: &str, bike: &str, id: Uuid) -> sqlx::Result<bool> {
    const SQL: &str = "\
        DELETE FROM bike_event WHERE group_name = $1 AND bike = $2 AND id = $3 AND deleted_at IS NULL";
    let gone = on!(tx, t => sqlx::query(SQL)
        .bind(group)
        .bind(bike)
        .bind(id)
        .execute(&mut **t)
        .await?
        .rows_affected());
    Ok(gone == 1)
}

/// Erases those that were deleted at a time or before with their bicycle, which may be there again; its group and name, once for each.
pub async fn erase(tx: &mut Tx, until: i64) -> sqlx::Result<Vec<(String, String)>> {
    const SQL: &str = "DELETE FROM bike_event WHERE deleted_at <= $1 RETURNING group_name, bike";
    on!(tx, t => sqlx::query_as(SQL).bind(until).fetch_all(&mut **t).await)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use veloid_engine::bicycle::Bike;

    use super::*;
    use crate::conformance::on_each;
    use crate::store::deletion::{self, Of};
    use crate::store::key::HOME;
    use crate::store::{Db, bike};

    async fn texts(db: &Db) -> Vec<String> {
        let rows = of_bike(db, HOME, "lab-7").await.unwrap();
        rows.into_iter().map(|row| row.text).collect()
    }

    #[tokio::test]
    async fn events_go_and_come_with_their_bike_and_a_new_bike_has_none_of_the_old_ones() {
        on_each(async |db| {
            let event = |day, text: &str| EventRow {
                id: Uuid::now_v7(),
                bike: "lab-7".to_owned(),
                day,
                text: text.to_owned(),
            };
            let mut tx = db.begin().await.unwrap();
            assert!(!insert(&mut tx, HOME, &event(7, "lost")).await.unwrap());
            bike::upsert(&mut tx, HOME, "lab-7", &Bike::default())
                .await
                .unwrap();
            for event in [event(9, "tyre"), event(8, "service")] {
                assert!(insert(&mut tx, HOME, &event).await.unwrap());
            }
            tx.commit().await.unwrap();
            assert_eq!(texts(&db).await, ["service", "tyre"]);
            assert_eq!(of_group(&db, "others").await.unwrap().len(), 0);

            let mut tx = db.begin().await.unwrap();
            assert!(
                deletion::mark_bike(&mut tx, HOME, "lab-7", 1000)
                    .await
                    .unwrap()
            );
            tx.commit().await.unwrap();
            assert!(texts(&db).await.is_empty());
            let mut tx = db.begin().await.unwrap();
            let of = Of::Bike("lab-7");
            deletion::unmark(&mut tx, HOME, of, Some(1000))
                .await
                .unwrap();
            tx.commit().await.unwrap();
            assert_eq!(texts(&db).await, ["service", "tyre"]);

            // Uploaded again before the deleted one is erased, the bike begins without its events.
            let mut tx = db.begin().await.unwrap();
            deletion::mark_bike(&mut tx, HOME, "lab-7", 2000)
                .await
                .unwrap();
            bike::upsert(&mut tx, HOME, "lab-7", &Bike::default())
                .await
                .unwrap();
            deletion::unmark(&mut tx, HOME, of, None).await.unwrap();
            assert!(insert(&mut tx, HOME, &event(10, "new")).await.unwrap());
            assert!(erase(&mut tx, 1999).await.unwrap().is_empty());
            assert_eq!(erase(&mut tx, 2000).await.unwrap().len(), 2);
            tx.commit().await.unwrap();
            assert_eq!(texts(&db).await, ["new"]);
        })
        .await;
    }
}
