//! The report's `result` section.

use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

use super::{Estimate, Method};
use veloid_core::document::format_number::Quantity;

/// The one answer of an axle: what its base model names (`k`, `B`, `mass`, `natural_frequency`, `damping_ratio`), in that
/// order.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
#[serde(transparent)]
#[cfg_attr(feature = "openapi", schema(value_type = std::collections::BTreeMap<String, ResultQuantity>))]
pub struct AxleResult(IndexMap<String, ResultQuantity>);

/// A quantity of the base model, by the method that determines it best on this ride.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct ResultQuantity {
    /// As estimated, or as the bike file gives it; null where it is withheld.
    pub value: Option<f64>,
    /// Standard error, in the same unit; null for the reason in `why`.
    pub std_error: Option<f64>,
    /// Lower and upper end of the 95 % interval; null with `std_error`.
    pub interval: Option<[f64; 2]>,
    /// SI unit, such as `N/m`.
    pub unit: String,
    /// The method that estimated it.
    pub method: Method,
    /// Why the value or its standard error is null.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub why: Option<String>,
}

impl ResultQuantity {
    /// The value with its 95 % interval.
    pub fn quantity(&self) -> Option<Quantity> {
        let value = self.value?;
        Some(Quantity::new(value, self.std_error, &self.unit))
    }
}

impl AxleResult {
    /// The quantity of this name.
    pub fn get(&self, name: &str) -> Option<&ResultQuantity> {
        self.0.get(name)
    }

    /// Why a quantity has no value; then no place shows what any method estimates of it.
    pub fn withheld(&self, name: &str) -> Option<&str> {
        let quantity = self.get(name).filter(|quantity| quantity.value.is_none())?;
        quantity.why.as_deref()
    }

    /// A method's estimate, without an interval of what the result withholds.
    pub fn bound(&self, estimate: Estimate) -> Estimate {
        let (k, b) = (self.withheld("k"), self.withheld("B"));
        let because = |own: Option<String>, why: Option<&str>| own.or(why.map(str::to_owned));
        Estimate {
            k_std_n_m: estimate.k_std_n_m.filter(|_| k.is_none()),
            b_std_n_s_m: estimate.b_std_n_s_m.filter(|_| b.is_none()),
            k_not_identifiable: because(estimate.k_not_identifiable, k),
            b_not_identifiable: because(estimate.b_not_identifiable, b),
            covariance: estimate.covariance.filter(|_| k.is_none() && b.is_none()),
            ..estimate
        }
    }

    /// Every quantity with its name.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &ResultQuantity)> {
        self.0
            .iter()
            .map(|(name, quantity)| (name.as_str(), quantity))
    }
}

impl FromIterator<(String, ResultQuantity)> for AxleResult {
    fn from_iter<I: IntoIterator<Item = (String, ResultQuantity)>>(quantities: I) -> Self {
        Self(quantities.into_iter().collect())
    }
}
