//! Names as people read them.

use veloid_engine::report::Method;

/// `nothing_missing` as "nothing missing".
pub fn plain(name: &str) -> String {
    name.replace('_', " ")
}

/// With a capital.
pub fn title(name: &str) -> String {
    let plain = plain(name);
    let mut letters = plain.chars();
    match letters.next() {
        Some(first) => first.to_uppercase().chain(letters).collect(),
        None => plain,
    }
}

/// The page of a bike of this name.
pub fn bike_page(name: &str) -> String {
    let name: String = form_urlencoded::byte_serialize(name.as_bytes()).collect();
    format!("/bikes/{}", name.replace('+', "%20"))
}

/// A text as it stands in a query.
pub fn query(text: &str) -> String {
    form_urlencoded::byte_serialize(text.as_bytes()).collect()
}

/// A method of the report or the fleet.
pub fn method(name: &str) -> String {
    Method::by_name(name).map_or_else(|| plain(name), |method| method.title().to_owned())
}

/// A parameter of the fleet: `k_n_m`, `b_n_s_m`, `mass_kg` or `effect.parameter`.
pub fn parameter(name: &str) -> String {
    match name {
        "k_n_m" => "stiffness k".to_owned(),
        "b_n_s_m" => "damping B".to_owned(),
        "mass_kg" => "mass m".to_owned(),
        name => plain(&name.replace('.', ": ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_become_words_and_addresses() {
        assert_eq!(title("coulomb_friction"), "Coulomb friction");
        assert_eq!(bike_page("a b/ü?"), "/bikes/a%20b%2F%C3%BC%3F");
    }
}
