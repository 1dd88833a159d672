//! The words of headers: English, German, French, Spanish, Italian and Dutch. Long ones also count within a compound
//! (`Vorderradbeschleunigung`).

/// Letters from which on a word is looked for within others.
const LONG: usize = 5;
/// Long ones that other words hold by chance: `orange`, `temporal`.
const WHOLE: &[&str] = &["range", "tempo"];

pub const FRONT: &[&str] = &[
    "front",
    "vorne",
    "vorn",
    "vorder",
    "f",
    "fw",
    "fork",
    "gabel",
    "avant",
    "fourche",
    "delante",
    "delantera",
    "delantero",
    "horquilla",
    "anteriore",
    "forcella",
    "voor",
    "voorvork",
];
pub const REAR: &[&str] = &[
    "rear",
    "hinten",
    "hinter",
    "back",
    "r",
    "rw",
    "saddle",
    "seat",
    "sattel",
    "arrière",
    "arriere",
    "selle",
    "trasera",
    "trasero",
    "sillín",
    "sillin",
    "posteriore",
    "sella",
    "achter",
    "zadel",
];

pub const TIME: &[&str] = &[
    "time",
    "timestamp",
    "zeit",
    "zeitstempel",
    "messzeit",
    "uhrzeit",
    "t",
    "temps",
    "tiempo",
    "tempo",
    "tijd",
    "elapsed",
    "epoch",
    "epoc",
];
/// Parts of a second as words of a name.
pub const PARTS: &[&str] = &[
    "ms",
    "us",
    "ns",
    "millis",
    "micros",
    "nanos",
    "milliseconds",
    "microseconds",
    "nanoseconds",
];
pub const ROAD: &[&str] = &["road", "fahrbahn", "strasse", "straße", "untergrund"];
pub const ACCELERATION: &[&str] = &[
    "acc",
    "accel",
    "acceleration",
    "beschl",
    "beschleunigung",
    "az",
    "accélération",
    "aceleración",
    "aceleracion",
    "accelerazione",
    "versnelling",
];
pub const DISPLACEMENT: &[&str] = &["displacement", "disp", "weg", "auslenkung"];
/// What a laser measures: the way from sensor to road, which grows where the deflection u - z shrinks.
pub const DISTANCE: &[&str] = &[
    "laser",
    "lidar",
    "distance",
    "range",
    "abstand",
    "distanz",
    "entfernung",
    "distancia",
    "distanza",
    "afstand",
];
pub const DEFLECTION: &[&str] = &["deflection", "einfederung"];
pub const FORCE: &[&str] = &["force", "kraft"];
pub const SPEED: &[&str] = &[
    "speed",
    "velocity",
    "geschwindigkeit",
    "geschw",
    "vitesse",
    "velocidad",
    "velocità",
    "velocita",
    "snelheid",
];
pub const LATERAL: &[&str] = &["lateral", "quer"];
pub const CADENCE: &[&str] = &["cadence", "trittfrequenz", "kadenz"];
pub const YAW: &[&str] = &["yaw", "gier"];
pub const RATE: &[&str] = &["rate", "geschwindigkeit"];
pub const ROLL: &[&str] = &["roll", "rollwinkel"];
pub const STEER: &[&str] = &["steer", "steering", "lenkwinkel"];
/// What makes another quantity of it.
pub const OTHER: &[&str] = &[
    "x",
    "y",
    "torque",
    "moment",
    "drehmoment",
    "winkelbeschleunigung",
    "temp",
    "temperature",
    "temperatur",
    "température",
    "pressure",
    "druck",
    "pression",
    "presión",
    "pressione",
    "power",
    "leistung",
    "max",
    "min",
    "mean",
    "std",
    "count",
    "error",
    "fehler",
    "status",
];

/// The words of a header, small: apart at what is no letter and where a capital follows a small letter.
pub fn of(header: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut before = ' ';
    for letter in header.chars() {
        if !letter.is_alphabetic() || letter.is_uppercase() && before.is_lowercase() {
            words.push(String::new());
        }
        if letter.is_alphabetic()
            && let Some(word) = words.last_mut()
        {
            word.extend(letter.to_lowercase());
        }
        before = letter;
    }
    words.retain(|word| !word.is_empty());
    words
}

/// Whether one of the words is among those that are known.
pub fn holds(words: &[String], known: &[&str]) -> bool {
    words.iter().any(|word| {
        known.iter().any(|known| {
            word == known
                || known.chars().count() >= LONG && !WHOLE.contains(known) && word.contains(known)
                || *known == "gier" && word.starts_with(known)
                || *known == "quer" && word.starts_with(known)
        })
    })
}
