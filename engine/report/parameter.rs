//! The report's `parameters` section.

use serde::{Deserialize, Serialize};

use super::Method;

/// A quantity of the base model as the ride determines it best; its key is `<axle>.<quantity>`, such as `front.stiffness`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "openapi", derive(utoipa::ToSchema))]
pub struct ReportedParameter {
    /// As estimated, or as the bike file gives it.
    pub value: f64,
    /// Standard error, in the same unit; null where `why` says so.
    pub std_error: Option<f64>,
    /// Lower and upper end of the 95 % interval; null with `std_error`.
    pub interval: Option<[f64; 2]>,
    /// SI, such as `N/m`.
    pub unit: String,
    /// The method that estimated it.
    pub method: Method,
    /// Why there is no standard error.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub why: Option<String>,
}
