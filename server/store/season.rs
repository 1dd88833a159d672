//! A made-up season of a fleet, written in bulk.

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use sqlx::QueryBuilder;
use sqlx::types::Json;
use uuid::Uuid;
use veloid_engine::bicycle::Bike;
use veloid_engine::ride::RideSummary;

use super::job::Request;
use super::key::HOME;
use super::parameter::METHODS;
use super::ride::TOLD;
use super::{Db, bike, now_ms};
use crate::facts::Facts;
use crate::options::Options;

const SEASON_MS: i64 = 180 * 86_400_000;
/// Rides in one transaction.
const BATCH: usize = 500;
/// Axle, name, unit, typical value, and its error and scatter from ride to ride as shares of it.
const PARAMETERS: [(&str, &str, &str, f64, f64, f64); 4] = [
    ("front", "k_n_m", "N/m", 110e3, 0.002, 0.01),
    ("front", "b_n_s_m", "N s/m", 1150.0, 0.005, 0.02),
    ("rear", "k_n_m", "N/m", 120e3, 0.002, 0.01),
    ("rear", "b_n_s_m", "N s/m", 1250.0, 0.005, 0.02),
];
/// Shares by which k and B change with a bar and a degree, and where they are what they are (bar, degC).
const PER_BAR: [f64; 2] = [0.12, 0.0];
const PER_DEGREE: [f64; 2] = [-0.0003, -0.002];
const USUAL: [f64; 2] = [2.3, 18.0];
/// Verdicts in the share in which they come, and the effect that is named.
const VERDICTS: [(&str, f64); 4] = [
    ("nothing_missing", 0.6),
    ("named", 0.9),
    ("ambiguous", 0.97),
    ("unnamed", 1.0),
];
pub const EFFECTS: [(&str, &str); 4] = [
    ("coulomb_friction.friction", "N"),
    ("wheel_out_of_round.amplitude", "m"),
    ("sensor_delay.delay", "s"),
    ("quadratic_damping.c2", "N s^2/m^2"),
];

pub struct Season {
    bikes: u32,
    rides: u32,
    random: ChaCha8Rng,
}

/// How much was written.
pub struct Told {
    pub rides: usize,
    pub parameters: usize,
}

/// One ride before it is written.
struct Outing {
    id: Uuid,
    bike: String,
    at: i64,
    verdict: &'static str,
    facts: Facts,
    parameters: Vec<Found>,
}

/// Method, axle, name, value, standard error, unit.
type Found = (
    &'static str,
    &'static str,
    &'static str,
    f64,
    Option<f64>,
    &'static str,
);

impl Season {
    pub fn new(bikes: u32, rides: u32, seed: u64) -> Self {
        Self {
            bikes,
            rides,
            random: ChaCha8Rng::seed_from_u64(seed),
        }
    }

    /// Writes everything, oldest first.
    pub async fn tell(mut self, db: &Db) -> sqlx::Result<Told> {
        let begin = now_ms() - SEASON_MS;
        let mut tx = db.begin().await?;
        let of_bike = (0..self.bikes)
            .map(|i| format!("season-{:03}", i + 1))
            .collect::<Vec<_>>();
        for name in &of_bike {
            let file = Bike {
                bike: name.clone(),
                mass_front_kg: Some(23.0),
                mass_rear_kg: Some(63.0),
                ..Bike::default()
            };
            bike::upsert(&mut tx, HOME, name, &file).await?;
        }
        tx.commit().await?;
        let own: Vec<[f64; 4]> = (0..self.bikes)
            .map(|_| std::array::from_fn(|_| 1.0 + 0.04 * self.normal()))
            .collect();
        let mut told = Told {
            rides: 0,
            parameters: 0,
        };
        let mut batch = Vec::with_capacity(BATCH);
        for ride in 0..self.rides {
            let at = begin + SEASON_MS * i64::from(ride) / i64::from(self.rides);
            let bike = self.random.random_range(0..self.bikes) as usize;
            batch.push(self.outing(of_bike[bike].clone(), bike, own[bike], at, begin));
            if batch.len() == BATCH || ride + 1 == self.rides {
                told.rides += batch.len();
                told.parameters += batch
                    .iter()
                    .map(|outing| outing.parameters.len())
                    .sum::<usize>();
                write(db, &batch).await?;
                batch.clear();
            }
        }
        Ok(told)
    }

    fn outing(&mut self, name: String, bike: usize, own: [f64; 4], at: i64, begin: i64) -> Outing {
        let draw: f64 = self.random.random();
        let verdict = VERDICTS
            .iter()
            .find(|(_, share)| draw < *share)
            .map_or("unnamed", |(v, _)| v);
        let passed = (at - begin) as f64 / SEASON_MS as f64;
        let (facts, changed) = self.circumstances();
        let mut parameters = Vec::new();
        for (p, (axle, parameter, unit, typical, error, scatter)) in
            PARAMETERS.into_iter().enumerate()
        {
            let fate = match (bike, p) {
                (0, 0) => 1.0 - 0.2 * passed,
                (1, 2) if passed > 0.5 => 1.12,
                (2, _) => 0.7,
                _ => 1.0,
            };
            let truth = typical * own[p] * fate * changed[p] * (1.0 + scatter * self.normal());
            // The rides that are made up have a road.
            for method in METHODS.into_iter().filter(|m| *m != "latent_road") {
                let value = truth * (1.0 + error * self.normal());
                // Swarms have no standard error.
                let error = (method != "swarm").then_some(error * truth);
                parameters.push((method, axle, parameter, value, error, unit));
            }
        }
        if verdict == "named" || verdict == "ambiguous" {
            let (effect, unit) = EFFECTS[self.random.random_range(0..EFFECTS.len())];
            let value = 0.02 * (1.0 + 0.2 * self.normal());
            parameters.push(("extended", "front", effect, value, Some(0.002), unit));
        }
        Outing {
            id: id_at(at, &mut self.random),
            bike: name,
            at,
            verdict,
            facts,
            parameters,
        }
    }

    /// What is known of a ride, and what it makes of k and B, front and rear, as factors.
    fn circumstances(&mut self) -> (Facts, [f64; 4]) {
        let rounded = |x: f64| (100.0 * x).round() / 100.0;
        let [bar, degrees] = USUAL;
        let pressures: [f64; 2] = std::array::from_fn(|_| rounded(bar + 0.08 * self.normal()));
        let temperature = rounded(degrees + 6.0 * self.normal());
        let changed = |p: usize| {
            let (axle, parameter) = (p / 2, p % 2);
            1.0 + PER_BAR[parameter] * (pressures[axle] - bar)
                + PER_DEGREE[parameter] * (temperature - degrees)
        };
        let facts = Facts {
            pressure_front_bar: Some(pressures[0]),
            pressure_rear_bar: Some(pressures[1]),
            temperature_c: Some(temperature),
            rider_mass_kg: Some(rounded(75.0 + 8.0 * self.normal())),
            ..Facts::default()
        };
        (facts, std::array::from_fn(changed))
    }

    /// A standard normal number, by Box and Muller.
    fn normal(&mut self) -> f64 {
        let (a, b): (f64, f64) = (self.random.random(), self.random.random());
        (-2.0 * (1.0 - a).ln()).sqrt() * (std::f64::consts::TAU * b).cos()
    }
}

/// A UUIDv7 of a time.
fn id_at(epoch_ms: i64, random: &mut ChaCha8Rng) -> Uuid {
    let mut bytes: [u8; 10] = random.random();
    bytes[0] = 0x70 | (bytes[0] & 0x0f);
    uuid::Builder::from_unix_timestamp_millis(epoch_ms.cast_unsigned(), &bytes).into_uuid()
}

impl Outing {
    /// The ride's name, which no other one has: its identifier begins with the time.
    fn name(&self) -> String {
        let id = self.id.simple().to_string();
        format!("{} {}", self.bike, &id[..12])
    }
}

/// Each ride has the identifier of its job.
async fn write(db: &Db, outings: &[Outing]) -> sqlx::Result<()> {
    let request = Request {
        bike: Bike::default(),
        options: Options::default(),
    };
    let summary = RideSummary::default();
    // A statement has at most 32 766 values.
    macro_rules! insert {
        ($tx:expr) => {{
            for part in outings.chunks(1000) {
                let mut query = QueryBuilder::new("INSERT INTO ride (id, sha256, name, bytes, uploaded_at, group_name, facts) ");
                query.push_values(part, |mut row, outing| {
                    row.push_bind(outing.id).push_bind(TOLD).push_bind(outing.name()).push("0").push_bind(outing.at);
                    row.push_bind(HOME).push_bind(Json(outing.facts.document()));
                });
                query.build().execute(&mut **$tx).await?;
                let mut query = QueryBuilder::new(
                    "INSERT INTO job (id, ride_id, bike, fingerprint, request, summary, state, stage, revision, \
                     trials_total, trials_done, takeovers, verdict, created_at, finished_at, dated_at, group_name) ",
                );
                query.push_values(part, |mut row, outing| {
                    row.push_bind(outing.id).push_bind(outing.id).push_bind(&outing.bike).push_bind("");
                    row.push_bind(Json(&request)).push_bind(Json(&summary));
                    row.push("'succeeded', 'diagnose', 1, 10, 10, 0");
                    row.push_bind(outing.verdict).push_bind(outing.at).push_bind(outing.at).push_bind(outing.at).push_bind(HOME);
                });
                query.build().execute(&mut **$tx).await?;
            }
            let rows: Vec<_> = outings.iter().flat_map(|o| o.parameters.iter().map(move |p| (o, p))).collect();
            for part in rows.chunks(2500) {
                let mut query = QueryBuilder::new(
                    "INSERT INTO parameter (job_id, method, axle, name, bike, value, std_error, unit, verdict, \
                     version, identified_at, group_name) ",
                );
                query.push_values(part, |mut row, (outing, (method, axle, name, value, error, unit))| {
                    row.push_bind(outing.id).push_bind(*method).push_bind(*axle).push_bind(*name);
                    row.push_bind(&outing.bike).push_bind(*value).push_bind(*error).push_bind(*unit);
                    row.push_bind(outing.verdict).push_bind(env!("CARGO_PKG_VERSION")).push_bind(outing.at).push_bind(HOME);
                });
                query.build().execute(&mut **$tx).await?;
            }
        }};
    }
    let mut tx = db.begin().await?;
    match &mut tx {
        super::Tx::Sqlite(t) => insert!(t),
        super::Tx::Postgres(t) => insert!(t),
    }
    tx.commit().await
}
