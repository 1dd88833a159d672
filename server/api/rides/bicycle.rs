//! The bicycle of an upload.

use veloid_engine::bicycle::Bike;

use crate::api::Server;
use crate::api::access::Caller;
use crate::api::problem::{Kind, Problem};
use crate::bicycle::{Chosen, Fault, Given, of_fields};
use crate::store::bike;

/// The bicycle that is given, or what is wrong with the parts that describe it.
pub async fn looked_at(
    server: &Server,
    caller: &Caller,
    given: &Given,
) -> Result<Result<Bike, Vec<Fault>>, Problem> {
    let refused = |detail: String| Problem::new(Kind::BadBike, detail);
    let chosen = given.chosen().map_err(|two| refused(two.to_string()))?;
    let (part, text) = match chosen {
        Chosen::Fields(fields) => return Ok(of_fields(fields)),
        Chosen::Text(part, text) => (part, text),
        Chosen::Nothing => {
            let expected = "no bike, expected a bike file or the name of a bike of the fleet as `bike`, or the keys of a bike \
                            file as separate parts";
            return Err(refused(expected.to_owned()));
        }
    };
    let fault = |detail| Err(vec![Fault { part, detail }]);
    if text.starts_with('{') {
        return Ok(Bike::from_json(text).or_else(|error| fault(error.to_string())));
    }
    let known = bike::find(&server.db, &caller.group, text).await?;
    Ok(match known {
        Some(row) => Ok(row.document.0),
        None => fault(format!(
            "'{text}' is not a bike of the fleet, expected one or a bike file as JSON"
        )),
    })
}

/// The bicycle that is given.
pub async fn the_bike(server: &Server, caller: &Caller, given: &Given) -> Result<Bike, Problem> {
    looked_at(server, caller, given).await?.map_err(|faults| {
        let details: Vec<String> = faults.into_iter().map(|fault| fault.detail).collect();
        Problem::new(Kind::BadBike, details.join("; "))
    })
}
