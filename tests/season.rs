//! A season of a fleet, written straight into the server's database: its rides have neither files nor reports.
//!
//! Every bicycle rides now and then over the last 180 days. The first one's front tyre loses pressure, the second one's rear
//! tyre is changed at midsummer, the third one is much softer than the fleet. k changes by 12 % per bar and -0.03 % per
//! degree, B by -0.2 % per degree.

use std::time::{SystemTime, UNIX_EPOCH};

use rand::RngExt;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use serde_json::{Value, json};
#[cfg(feature = "postgres")]
use sqlx::PgConnection;
use sqlx::types::Json;
use sqlx::{Connection, QueryBuilder, SqliteConnection};
use uuid::Uuid;
use veloid_engine::bicycle::Bike;
use veloid_engine::ride::RideSummary;

use crate::harness::Server;

const SEASON_MS: i64 = 180 * 86_400_000;
/// Rides that are inserted together: a statement has at most 32 766 values.
const BATCH: usize = 120;
/// Axle, name, unit, typical value, and its error and scatter from ride to ride as shares of it.
const PARAMETERS: [(&str, &str, &str, f64, f64, f64); 4] = [
    ("front", "k_n_m", "N/m", 110e3, 0.002, 0.01),
    ("front", "b_n_s_m", "N s/m", 1150.0, 0.005, 0.02),
    ("rear", "k_n_m", "N/m", 120e3, 0.002, 0.01),
    ("rear", "b_n_s_m", "N s/m", 1250.0, 0.005, 0.02),
];
const METHODS: [&str; 5] = [
    "extended",
    "output_error",
    "swarm",
    "instrumental",
    "least_squares",
];
/// Shares by which k and B change with a bar and a degree, and where they are what they are (bar, degC).
const PER_BAR: [f64; 2] = [0.12, 0.0];
const PER_DEGREE: [f64; 2] = [-0.0003, -0.002];
const USUAL: [f64; 2] = [2.3, 18.0];
/// Verdicts, and up to which draw each comes.
const VERDICTS: [(&str, f64); 4] = [
    ("nothing_missing", 0.6),
    ("named", 0.9),
    ("ambiguous", 0.97),
    ("unnamed", 1.0),
];
const EFFECTS: [(&str, &str); 4] = [
    ("coulomb_friction.friction", "N"),
    ("wheel_out_of_round.amplitude", "m"),
    ("sensor_delay.delay", "s"),
    ("quadratic_damping.c2", "N s^2/m^2"),
];

/// The rows of all tables; each ride has the identifier of its job.
macro_rules! insert {
    ($tx:expr, $names:expr, $begin:expr, $simulated_rides:expr) => {{
        let mut query = QueryBuilder::new(
            "INSERT INTO bike (name, document, created_at, updated_at, group_name) ",
        );
        query.push_values(&$names, |mut row, name| {
            let document = json!({"bike": name, "mass_front_kg": 23.0, "mass_rear_kg": 63.0});
            row.push_bind(name).push_bind(Json(document));
            row.push_bind($begin).push_bind($begin).push("'default'");
        });
        query.build().execute(&mut *$tx).await.unwrap();
        let request = json!({"bike": Bike::default(), "options": {}});
        let summary = RideSummary::default();
        for part in $simulated_rides.chunks(BATCH) {
            let mut query = QueryBuilder::new(
                "INSERT INTO ride (id, sha256, name, bytes, uploaded_at, group_name, facts) ",
            );
            query.push_values(part, |mut row, simulated_ride| {
                row.push_bind(simulated_ride.id).push_bind(simulated_ride.sha256());
                row.push_bind(simulated_ride.name()).push("0").push_bind(simulated_ride.at);
                row.push("'default'").push_bind(Json(&simulated_ride.facts));
            });
            query.build().execute(&mut *$tx).await.unwrap();
            let mut query = QueryBuilder::new(
                "INSERT INTO job (id, ride_id, bike, fingerprint, request, summary, state, stage, revision, \
                 trials_total, trials_done, takeovers, verdict, created_at, finished_at, dated_at, group_name) ",
            );
            query.push_values(part, |mut row, simulated_ride| {
                row.push_bind(simulated_ride.id).push_bind(simulated_ride.id);
                row.push_bind(&simulated_ride.bike).push("''");
                row.push_bind(Json(&request)).push_bind(Json(&summary));
                row.push("'succeeded', 'diagnose', 1, 10, 10, 0");
                row.push_bind(simulated_ride.verdict).push_bind(simulated_ride.at);
                row.push_bind(simulated_ride.at).push_bind(simulated_ride.at).push("'default'");
            });
            query.build().execute(&mut *$tx).await.unwrap();
            let mut query = QueryBuilder::new(
                "INSERT INTO parameter (job_id, method, axle, name, bike, value, std_error, unit, verdict, \
                 version, identified_at, group_name) ",
            );
            let rows = part.iter().flat_map(|o| o.parameters.iter().map(move |p| (o, p)));
            query.push_values(rows, |mut row, (simulated_ride, found)| {
                let (method, axle, name, value, error, unit) = *found;
                row.push_bind(simulated_ride.id).push_bind(method).push_bind(axle).push_bind(name);
                row.push_bind(&simulated_ride.bike).push_bind(value).push_bind(error).push_bind(unit);
                row.push_bind(simulated_ride.verdict).push_bind(env!("CARGO_PKG_VERSION"));
                row.push_bind(simulated_ride.at).push("'default'");
            });
            query.build().execute(&mut *$tx).await.unwrap();
        }
    }};
}

/// Writes so many rides of so many bicycles, `season-001` and so on.
pub async fn write(server: &Server, bikes: usize, rides: usize) {
    let now = SystemTime::now().duration_since(UNIX_EPOCH).unwrap();
    let begin = i64::try_from(now.as_millis()).unwrap() - SEASON_MS;
    let simulated_rides = Season::new(bikes).simulated_rides(rides, begin);
    let names: Vec<String> = (0..bikes).map(name_of).collect();
    macro_rules! write {
        ($connection:expr) => {{
            let mut connection = $connection;
            let mut tx = connection.begin().await.unwrap();
            insert!(tx, names, begin, simulated_rides);
            tx.commit().await.unwrap();
        }};
    }
    #[cfg(feature = "postgres")]
    if let Some(url) = server.database() {
        return write!(PgConnection::connect(url).await.unwrap());
    }
    write!(SqliteConnection::connect(&server.sqlite()).await.unwrap());
}

fn name_of(bike: usize) -> String {
    format!("season-{:03}", bike + 1)
}

/// One ride before it is written.
struct SimulatedRide {
    id: Uuid,
    bike: String,
    at: i64,
    verdict: &'static str,
    facts: Value,
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

impl SimulatedRide {
    /// The ride's name, which no other one has: its identifier begins with the time.
    fn name(&self) -> String {
        format!("{} {}", self.bike, &self.id.simple().to_string()[..12])
    }

    /// As long as that of a file, and no other ride's.
    fn sha256(&self) -> String {
        self.id.simple().to_string().repeat(2)
    }
}

struct Season {
    bikes: usize,
    random: ChaCha8Rng,
}

impl Season {
    fn new(bikes: usize) -> Self {
        let random = ChaCha8Rng::seed_from_u64(1);
        Self { bikes, random }
    }

    /// Oldest first.
    fn simulated_rides(mut self, rides: usize, begin: i64) -> Vec<SimulatedRide> {
        let own: Vec<[f64; 4]> = (0..self.bikes)
            .map(|_| std::array::from_fn(|_| 1.0 + 0.04 * self.normal()))
            .collect();
        (0..rides)
            .map(|ride| {
                let passed = ride as f64 / rides as f64;
                let bike = self.random.random_range(0..self.bikes as u32) as usize;
                let at = begin + (SEASON_MS as f64 * passed) as i64;
                self.simulated_ride(bike, own[bike], at, passed)
            })
            .collect()
    }

    fn simulated_ride(
        &mut self,
        bike: usize,
        own: [f64; 4],
        at: i64,
        passed: f64,
    ) -> SimulatedRide {
        let draw: f64 = self.random.random();
        let verdict = VERDICTS.iter().find(|(_, share)| draw < *share);
        let verdict = verdict.map_or("unnamed", |(verdict, _)| verdict);
        let (facts, changed) = self.circumstances();
        let mut parameters = Vec::new();
        for (p, (axle, name, unit, typical, error, scatter)) in PARAMETERS.into_iter().enumerate() {
            let fate = match (bike, p) {
                (0, 0) => 1.0 - 0.2 * passed,
                (1, 2) if passed > 0.5 => 1.12,
                (2, _) => 0.7,
                _ => 1.0,
            };
            let truth = typical * own[p] * fate * changed[p] * (1.0 + scatter * self.normal());
            for method in METHODS {
                let value = truth * (1.0 + error * self.normal());
                // Swarms have no standard error.
                let error = (method != "swarm").then_some(error * truth);
                parameters.push((method, axle, name, value, error, unit));
                if method == "extended" {
                    parameters.push(("result", axle, name, value, error, unit));
                }
            }
        }
        if verdict == "named" || verdict == "ambiguous" {
            let (effect, unit) = EFFECTS[self.random.random_range(0..EFFECTS.len())];
            let value = 0.02 * (1.0 + 0.2 * self.normal());
            parameters.push(("extended", "front", effect, value, Some(0.002), unit));
        }
        let id = self.id_at(at);
        let bike = name_of(bike);
        SimulatedRide {
            id,
            bike,
            at,
            verdict,
            facts,
            parameters,
        }
    }

    /// What is known of a ride, and what it makes of k and B, front and rear, as factors.
    fn circumstances(&mut self) -> (Value, [f64; 4]) {
        let rounded = |x: f64| (100.0 * x).round() / 100.0;
        let [bar, degrees] = USUAL;
        let pressures: [f64; 2] = std::array::from_fn(|_| rounded(bar + 0.08 * self.normal()));
        let temperature = rounded(degrees + 6.0 * self.normal());
        let changed = |p: usize| {
            let (axle, parameter) = (p / 2, p % 2);
            1.0 + PER_BAR[parameter] * (pressures[axle] - bar)
                + PER_DEGREE[parameter] * (temperature - degrees)
        };
        let facts = json!({
            "pressure_front_bar": pressures[0],
            "pressure_rear_bar": pressures[1],
            "temperature_c": temperature,
            "rider_mass_kg": rounded(75.0 + 8.0 * self.normal()),
        });
        (facts, std::array::from_fn(changed))
    }

    /// A standard normal number, by Box and Muller.
    fn normal(&mut self) -> f64 {
        let (a, b): (f64, f64) = (self.random.random(), self.random.random());
        (-2.0 * (1.0 - a).ln()).sqrt() * (std::f64::consts::TAU * b).cos()
    }

    /// A UUIDv7 of a time.
    fn id_at(&mut self, epoch_ms: i64) -> Uuid {
        let mut bytes: [u8; 10] = self.random.random();
        bytes[0] = 0x70 | (bytes[0] & 0x0f);
        uuid::Builder::from_unix_timestamp_millis(epoch_ms.cast_unsigned(), &bytes).into_uuid()
    }
}
