#![allow(clippy::unwrap_used)]
use super::*;
use crate::law::padded;

const STRIBECK: &str = r#"
id = "stribeck_friction"
axle = "rear"
force = "(coulomb + (breakaway - coulomb) * exp(-(w / stribeck)^2)) * tanh(w / 0.002)"
words = "friction that falls as it begins to slip"

[parameters.coulomb]
unit = "N"
start = 10.0
range = [0.0, 200.0]

[parameters.breakaway]
unit = "N"
start = [10, 40]
range = [0.0, 400.0]

[parameters.stribeck]
unit = "m/s"
start = 0.02
range = [0.001, 1.0]
"#;

#[test]
fn a_law_is_read() {
    let law = OwnLaw::read(STRIBECK).unwrap();
    assert_eq!(
        (law.id.as_str(), law.acts),
        ("stribeck_friction", Where::Rear)
    );
    let names: Vec<&str> = law.parameters.iter().map(|p| p.name.as_str()).collect();
    assert_eq!(names, ["breakaway", "coulomb", "stribeck"]);
    assert_eq!(law.starts().len(), 2);
    assert_eq!(law.starts()[1], padded([40.0, 10.0, 0.02]));
    // Neither force alone takes it all away.
    assert_eq!(law.amplitude, None);
    assert!(!law.is_on_body && !law.has_corners() && law.needs().is_empty());
}

#[test]
fn what_a_law_asks_for_is_known_from_its_expressions() {
    let law = OwnLaw::read(
        r#"id = "x"
        force = "a * sin(2*crank) * speed + a*step(t - 3) + a * q"
        parameters.a = { start = 1, range = [-5, 5] }
        states.q = "wheel - q / 0.1""#,
    )
    .unwrap();
    assert_eq!(law.amplitude, Some(0));
    assert!(law.is_on_body && law.has_corners());
    assert_eq!(law.states(), 1);
    let asked = [Need::Speed, Need::Cadence, Need::Speed, Need::WheelRadius];
    assert_eq!(law.needs(), asked);
}

#[test]
fn what_is_wrong_with_a_law_is_said() {
    let with = |from: &str, to: &str| {
        assert!(STRIBECK.contains(from), "{from}");
        OwnLaw::read(&STRIBECK.replacen(from, to, 1))
            .unwrap_err()
            .to_string()
    };
    for (from, to, said) in [
        (
            "exp(",
            "expo(",
            "force, column 36: unknown name 'expo', expected one of d, w, z, z_dot",
        ),
        ("tanh(w", "tanh(w * v", "force, column 71: unknown name 'v'"),
        ("\"rear\"", "\"left\"", "line 3, column 8: "),
        ("id =", "ident =", "line 2, column 1: unknown field `ident`"),
        (
            "range = [0.0, 200.0]",
            "",
            "line 7, column 1: missing field `range`",
        ),
        (
            "start = 10.0",
            "start = 300.0",
            "parameters.coulomb.start: 300 is outside 0 to 200",
        ),
        (
            "start = [10, 40]",
            "start = []",
            "parameters.breakaway.start: no value",
        ),
        (
            "range = [0.0, 200.0]",
            "range = [5.0, 5.0]",
            "parameters.coulomb.range: 5 to 5 is not a range",
        ),
        (
            "range = [0.0, 200.0]",
            "range = [0.0, inf]",
            "parameters.coulomb.range: 0 to inf is not a range",
        ),
        (
            "[parameters.stribeck]",
            "[parameters.d]",
            "parameters: 'd' already has another meaning",
        ),
        (
            "[parameters.stribeck]",
            "[parameters.tanh]",
            "parameters: 'tanh' already has another meaning",
        ),
        (
            "[parameters.stribeck]",
            "[parameters.\"a b\"]",
            "parameters: 'a b' is not a name",
        ),
        ("stribeck_friction", "2nd", "id: '2nd' is not a name"),
        (
            "/ stribeck",
            "",
            "parameters.stribeck: is used in no expression",
        ),
        ("start = 0.02", "start = \"x\"", "line 19, column 9: "),
    ] {
        let found = with(from, to);
        assert!(found.starts_with(said), "{to}: {found}");
    }
    let long = format!("{STRIBECK}\n#{}", "x".repeat(9000));
    assert!(matches!(OwnLaw::read(&long), Err(LawError::Long { .. })));
}

/// A law with so many parameters and states.
fn counted(parameters: usize, states: usize) -> Result<OwnLaw, String> {
    let names: Vec<String> = (0..parameters).map(|i| format!("p{i}")).collect();
    let mut text = format!("id = \"x\"\nforce = \"{} + x0\"\n", names.join("+"));
    for name in &names {
        text += &format!("parameters.{name} = {{ start = 1, range = [0, 2] }}\n");
    }
    for i in 0..states {
        text += &format!("states.x{i} = \"w - x{}\"\n", (i + 1) % states);
    }
    OwnLaw::read(&text).map_err(|error| error.to_string())
}

#[test]
fn a_law_has_so_many_parameters_and_states_at_most() {
    let law = counted(MAX_PARAMETERS, MAX_OWN_STATES).unwrap();
    assert_eq!((law.parameters.len(), law.states()), (12, 6));
    let refused = counted(13, 6).unwrap_err();
    assert_eq!(refused, "parameters: 13, expected 1 to 12");
    let refused = counted(12, 7).unwrap_err();
    assert_eq!(refused, "states: 7, expected at most 6");
}
