//! The plan of a suite: which ride conceals what. Drawn before anything is simulated.

use crate::chance::Chance;
use crate::simulate::effect::{Axle, Kind};
use crate::simulate::outside::Strange;

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Class {
    Clean,
    Single,
    Two,
    Outside,
    /// A listed effect on one axle, strange physics on the other.
    Beside,
}

/// Which rides a suite holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Suite {
    Standard,
    Clean300,
    Beside,
    Quiet,
}

impl Suite {
    pub const ALL: [Suite; 4] = [
        Suite::Standard,
        Suite::Clean300,
        Suite::Beside,
        Suite::Quiet,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Suite::Standard => "standard",
            Suite::Clean300 => "clean300",
            Suite::Beside => "beside",
            Suite::Quiet => "quiet",
        }
    }

    pub fn is_clean(self) -> bool {
        matches!(self, Suite::Clean300 | Suite::Quiet)
    }

    pub fn cases(self, chance: &mut Chance) -> Vec<Case> {
        match self {
            Suite::Standard => standard(chance),
            Suite::Clean300 => clean(300, chance),
            Suite::Beside => beside(100, chance),
            Suite::Quiet => quiet(100, chance),
        }
    }
}

/// What is unusual of a clean ride that conceals nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Circumstance {
    /// 1 to 1.5 m/s.
    Walking,
    /// A log of 20 Hz.
    Slow,
    /// 300 to 800 kN/m.
    Stiff,
    /// Sensors without noise.
    Noiseless,
}

impl Circumstance {
    pub fn name(self) -> &'static str {
        match self {
            Circumstance::Walking => "walking",
            Circumstance::Slow => "slow",
            Circumstance::Stiff => "stiff",
            Circumstance::Noiseless => "noiseless",
        }
    }
}

impl Class {
    pub fn name(self) -> &'static str {
        match self {
            Class::Clean => "clean",
            Class::Single => "single",
            Class::Two => "two",
            Class::Outside => "outside",
            Class::Beside => "beside",
        }
    }
}

/// What moves the bicycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Setting {
    Road,
    /// Shaker plates move the ground under each wheel; no speed.
    Plate,
    /// Shakers push the axle masses; the ground rests.
    Shaker,
    /// Released from a deflection.
    Decay,
}

impl Setting {
    pub fn name(self) -> &'static str {
        match self {
            Setting::Road => "road",
            Setting::Plate => "plate",
            Setting::Shaker => "shaker",
            Setting::Decay => "decay",
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Noise {
    White,
    Coloured,
    Quantised,
    Road,
    Jitter,
}

impl Noise {
    pub const ALL: [Noise; 5] = [
        Noise::White,
        Noise::Coloured,
        Noise::Quantised,
        Noise::Road,
        Noise::Jitter,
    ];

    pub fn name(self) -> &'static str {
        match self {
            Noise::White => "white",
            Noise::Coloured => "coloured",
            Noise::Quantised => "quantised",
            Noise::Road => "road",
            Noise::Jitter => "jitter",
        }
    }
}

/// One planned ride.
#[derive(Clone, Debug)]
pub struct Case {
    pub class: Class,
    pub effects: Vec<(Kind, Axle)>,
    pub strange: Option<(Strange, usize)>,
    /// 0 small, 1 medium, 2 large.
    pub size: usize,
    pub setting: Setting,
    pub noise: Noise,
    pub circumstance: Option<Circumstance>,
    pub duration_s: f64,
    pub rate_hz: f64,
}

impl Case {
    fn new(class: Class, setting: Setting, noise: Noise, chance: &mut Chance) -> Self {
        let duration_s = match setting {
            Setting::Decay => 12.0,
            _ if chance.happens(0.12) => 120.0,
            _ => 60.0,
        };
        let rate_hz = if setting == Setting::Decay || chance.happens(0.12) {
            200.0
        } else {
            100.0
        };
        Self {
            class,
            effects: Vec::new(),
            strange: None,
            size: 1,
            setting,
            noise,
            circumstance: None,
            duration_s,
            rate_hz,
        }
    }

    /// The fastest that a road moves an axle (Hz): what the log carries.
    pub fn fastest_hz(&self) -> f64 {
        (0.45 * self.rate_hz).min(22.0)
    }
}

/// Rides on which one effect of the library acts on one axle, and strange physics on the other.
pub fn beside(count: usize, chance: &mut Chance) -> Vec<Case> {
    let one_axle = |kind: &Kind| kind.axles().iter().all(|axle| Axle::ONE.contains(axle));
    let kinds: Vec<Kind> = Kind::ALL.into_iter().filter(one_axle).collect();
    let strange: Vec<Strange> = (Strange::ALL.into_iter())
        .filter(|kind| *kind != Strange::LateralCoupling)
        .collect();
    (0..count)
        .map(|i| {
            let (kind, other) = (kinds[i % kinds.len()], strange[i % strange.len()]);
            let road = kind.needs_road() || other.needs_road() || chance.happens(0.8);
            let setting = if road { Setting::Road } else { Setting::Plate };
            let mut case = Case::new(Class::Beside, setting, any_noise(chance), chance);
            let axle = chance.pick(kind.axles());
            case.effects = vec![(kind, axle)];
            case.strange = Some((other, usize::from(axle == Axle::Front)));
            case.size = 1 + chance.index(2);
            case
        })
        .collect()
}

/// Clean rides at walking pace, of slow logs, on stiff axles and without noise, in turn.
pub fn quiet(count: usize, chance: &mut Chance) -> Vec<Case> {
    let circumstances = [
        Circumstance::Walking,
        Circumstance::Slow,
        Circumstance::Stiff,
        Circumstance::Noiseless,
    ];
    (0..count)
        .map(|i| {
            let noise = Noise::ALL[(i / circumstances.len()) % Noise::ALL.len()];
            let mut case = Case::new(Class::Clean, Setting::Road, noise, chance);
            case.circumstance = Some(circumstances[i % circumstances.len()]);
            if case.circumstance == Some(Circumstance::Slow) {
                case.rate_hz = 20.0;
            }
            case
        })
        .collect()
}

/// Every effect on each of its axles at three sizes, 40 clean rides, 30 pairs, 36 rides with strange physics; shuffled.
pub fn standard(chance: &mut Chance) -> Vec<Case> {
    let mut cases = clean(40, chance);
    for kind in Kind::ALL {
        for &axle in kind.axles() {
            for size in 0..3 {
                let mut case = Case::new(
                    Class::Single,
                    setting(kind.needs_road(), kind, chance),
                    any_noise(chance),
                    chance,
                );
                case.effects = vec![(kind, axle)];
                case.size = size;
                cases.push(case);
            }
        }
    }
    for _ in 0..30 {
        let pair = pair(chance);
        let road = pair.iter().any(|(kind, _)| kind.needs_road()) || chance.happens(0.8);
        let setting = if road { Setting::Road } else { Setting::Plate };
        let mut case = Case::new(Class::Two, setting, any_noise(chance), chance);
        case.effects = pair;
        case.size = 1 + chance.index(2);
        cases.push(case);
    }
    for kind in Strange::ALL {
        for turn in 0..3 {
            let road = kind.needs_road() || chance.happens(0.8);
            let setting = if road { Setting::Road } else { Setting::Plate };
            let mut case = Case::new(Class::Outside, setting, any_noise(chance), chance);
            case.strange = Some((kind, (turn + chance.index(2)) % 2));
            case.size = turn;
            cases.push(case);
        }
    }
    chance.shuffle(&mut cases);
    cases
}

/// Clean rides of all noise kinds and settings, in turn.
pub fn clean(count: usize, chance: &mut Chance) -> Vec<Case> {
    let settings = [
        Setting::Road,
        Setting::Road,
        Setting::Road,
        Setting::Plate,
        Setting::Road,
        Setting::Shaker,
        Setting::Road,
        Setting::Road,
        Setting::Decay,
        Setting::Road,
        Setting::Shaker,
    ];
    (0..count)
        .map(|i| {
            Case::new(
                Class::Clean,
                settings[i % settings.len()],
                Noise::ALL[i % 5],
                chance,
            )
        })
        .collect()
}

/// Rides of 60 s and of 300 s on a road, on which time is measured: the first of each class in a standard plan.
pub fn timing(chance: &mut Chance) -> Vec<Case> {
    let plan = standard(chance);
    let first = |class, count, duration_s| {
        let road = plan
            .iter()
            .filter(move |c| c.class == class && c.setting == Setting::Road);
        road.take(count).map(move |case| Case {
            duration_s,
            rate_hz: 100.0,
            ..case.clone()
        })
    };
    [Class::Clean, Class::Single, Class::Two, Class::Outside]
        .into_iter()
        .flat_map(|class| first(class, 20, 60.0).chain(first(class, 5, 300.0)))
        .collect()
}

fn any_noise(chance: &mut Chance) -> Noise {
    chance.pick(&[
        Noise::White,
        Noise::White,
        Noise::White,
        Noise::Coloured,
        Noise::Coloured,
        Noise::Quantised,
        Noise::Quantised,
        Noise::Road,
        Noise::Road,
        Noise::Jitter,
    ])
}

fn setting(needs_road: bool, kind: Kind, chance: &mut Chance) -> Setting {
    if needs_road {
        return Setting::Road;
    }
    // With the ground at rest these are the plain damper, plain friction, or a free rest point.
    let on_moving_ground = matches!(
        kind,
        Kind::GroundDamping | Kind::GuideFriction | Kind::SensorOffset
    );
    let draw = chance.uniform(0.0, 1.0);
    if kind == Kind::GroundDamping || kind == Kind::GuideFriction {
        return if draw < 0.5 {
            Setting::Plate
        } else {
            Setting::Road
        };
    }
    if draw < 0.76 {
        Setting::Road
    } else if draw < 0.87 || on_moving_ground {
        Setting::Plate
    } else {
        Setting::Shaker
    }
}

/// Kinds that a pair may combine, by what they touch; a pair takes two different groups.
const GROUPS: [&[Kind]; 6] = [
    &[
        Kind::CubicStiffness,
        Kind::ProgressiveStiffness,
        Kind::BumpStop,
        Kind::ViscoelasticTyre,
    ],
    &[
        Kind::QuadraticDamping,
        Kind::CoulombFriction,
        Kind::AsymmetricDamping,
    ],
    &[Kind::SprungMass, Kind::PitchCoupling, Kind::UnsprungMass],
    &[
        Kind::WheelOutOfRound,
        Kind::PedallingForce,
        Kind::LoadTransfer,
    ],
    &[
        Kind::StiffnessDrift,
        Kind::SpeedDependentStiffness,
        Kind::WheelLift,
    ],
    &[
        Kind::SensorDelay,
        Kind::SensorGain,
        Kind::SensorDrift,
        Kind::TyreEnveloping,
    ],
];

fn pair(chance: &mut Chance) -> Vec<(Kind, Axle)> {
    loop {
        let drawn = any_pair(chance);
        let has = |kind| drawn.iter().any(|(k, _)| *k == kind);
        // Dry friction on a wheel of one kilogram is stiffer than any fixed step.
        if !(has(Kind::UnsprungMass) && has(Kind::CoulombFriction)) {
            return drawn;
        }
    }
}

fn any_pair(chance: &mut Chance) -> Vec<(Kind, Axle)> {
    let first = chance.index(GROUPS.len());
    let second = (first + 1 + chance.index(GROUPS.len() - 1)) % GROUPS.len();
    [first, second]
        .map(|group| {
            let kind = chance.pick(GROUPS[group]);
            (kind, chance.pick(kind.axles()))
        })
        .to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_is_measured_on_every_class_at_both_lengths() {
        let cases = timing(&mut Chance::new(1, 0));
        for class in [Class::Clean, Class::Single, Class::Two, Class::Outside] {
            let of = |duration_s| {
                let is = |c: &&Case| c.class == class && c.duration_s == duration_s;
                cases.iter().filter(is).count()
            };
            assert_eq!((of(60.0), of(300.0)), (20, 5), "{}", class.name());
        }
    }

    #[test]
    fn the_standard_suite_holds_what_the_issue_demands() {
        let cases = standard(&mut Chance::new(1, 0));
        let count = |class| cases.iter().filter(|c| c.class == class).count();
        assert!(cases.len() >= 240);
        assert_eq!(count(Class::Clean), 40);
        assert_eq!(count(Class::Two), 30);
        assert!(count(Class::Outside) >= 30);
        for kind in Kind::ALL {
            for &axle in kind.axles() {
                let sizes = cases
                    .iter()
                    .filter(|c| c.class == Class::Single && c.effects == [(kind, axle)])
                    .count();
                assert_eq!(sizes, 3, "{}", kind.id());
            }
        }
        for noise in Noise::ALL {
            assert_eq!(
                cases
                    .iter()
                    .filter(|c| c.class == Class::Clean && c.noise == noise)
                    .count(),
                8
            );
        }
    }
}
