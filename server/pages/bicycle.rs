//! The bicycle in the upload form.

use crate::api::Server;
use crate::api::access::Caller;
use crate::api::problem::{Kind, Problem};
use crate::api::rides::looked_at;
use crate::bicycle::{Fault, GROUPS, Given, Group, Way};

/// The paper's bicycle, as a placeholder.
const EXAMPLE: &str = r#"{"bike": "my-bike",
 "mass_front_kg": 23.0, "mass_rear_kg": 63.0,
 "l_front_m": 0.808, "l_rear_m": 0.293}"#;

/// The part of a form that describes the bicycle.
pub struct BicycleForm {
    /// Names of the fleet.
    pub bikes: Vec<String>,
    pub groups: &'static [Group],
    pub example: &'static str,
    way: Way,
    given: Given,
    faults: Vec<Fault>,
    /// A problem with the bicycle as a whole.
    problem: String,
}

impl BicycleForm {
    /// With this bicycle of the fleet selected, if any.
    pub fn new(bikes: Vec<String>, chosen: Option<String>) -> Self {
        let given = Given {
            fleet: chosen,
            ..Given::default()
        };
        Self::filled(bikes, given, Vec::new(), String::new())
    }

    /// As it was filled in, with its faults.
    pub async fn again(
        server: &Server,
        caller: &Caller,
        bikes: Vec<String>,
        given: Given,
        problem: &Problem,
    ) -> Self {
        let faults = match looked_at(server, caller, &given).await {
            Ok(Err(faults)) => faults,
            _ => Vec::new(),
        };
        let whole = match problem.kind {
            Kind::BadBike if faults.is_empty() => problem.detail.clone(),
            _ => String::new(),
        };
        Self::filled(bikes, given, faults, whole)
    }

    fn filled(bikes: Vec<String>, given: Given, faults: Vec<Fault>, problem: String) -> Self {
        let way = given.way.unwrap_or(match &given {
            given if given.file.is_some() => Way::File,
            given if !given.fields.is_empty() => Way::Fields,
            _ if bikes.is_empty() => Way::Fields,
            _ => Way::Fleet,
        });
        Self {
            bikes,
            groups: &GROUPS,
            example: EXAMPLE,
            way,
            given,
            faults,
            problem,
        }
    }

    pub fn is_given_by(&self, way: &str) -> bool {
        self.way.name() == way
    }

    pub fn is_chosen(&self, bike: &str) -> bool {
        self.given.fleet.as_deref() == Some(bike)
    }

    /// The bike file as it was typed.
    pub fn file(&self) -> &str {
        self.given.file.as_deref().unwrap_or_default()
    }

    /// A field as it was typed.
    pub fn value(&self, name: &str) -> &str {
        self.given.fields.get(name).map_or("", String::as_str)
    }

    /// The fault of the bike file, or of the bicycle as a whole.
    pub fn whole(&self) -> &str {
        match self.fault("bike") {
            "" => &self.problem,
            fault => fault,
        }
    }

    /// The fault of a part.
    pub fn fault(&self, part: &str) -> &str {
        let found = self.faults.iter().find(|fault| fault.part == part);
        found.map_or("", |fault| &fault.detail)
    }

    /// Whether any of the rarely used fields is filled.
    pub fn is_unusual(&self) -> bool {
        let unusual = self.groups.iter().filter(|group| !group.needed);
        let mut names = unusual.flat_map(|group| group.fields);
        names.any(|field| !self.value(field.name).is_empty())
            || !self.value("equal_axles").is_empty()
    }
}
