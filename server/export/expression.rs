//! Expressions of laws in the languages of scripts.

/// How a language writes what differs.
pub struct Dialect {
    pub power: &'static str,
    pub comment: &'static str,
    /// What stands behind an assignment.
    pub end: &'static str,
    /// Names of functions that it calls otherwise.
    pub functions: &'static [(&'static str, &'static str)],
}

pub const PYTHON: Dialect = Dialect {
    power: "**",
    comment: "#",
    end: "",
    functions: &[("ln", "log"), ("step", "above_zero")],
};

/// MATLAB's and Octave's.
pub const MATLAB: Dialect = Dialect {
    power: "^",
    comment: "%",
    end: ";",
    functions: &[("ln", "log"), ("step", "above_zero")],
};

/// The expression in another language, with its names as `named` has them.
pub fn translated(text: &str, dialect: &Dialect, named: &dyn Fn(&str) -> String) -> String {
    let mut out = String::new();
    let mut rest = text;
    while let Some(first) = rest.chars().next() {
        let length = match first {
            '0'..='9' | '.' => number_length(rest),
            'a'..='z' | 'A'..='Z' | '_' => {
                let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
                rest.find(|c| !is_word(c)).unwrap_or(rest.len())
            }
            other => other.len_utf8(),
        };
        let (token, behind) = rest.split_at(length);
        match first {
            '^' => out.push_str(dialect.power),
            'a'..='z' | 'A'..='Z' | '_' if behind.trim_start().starts_with('(') => {
                let other = dialect.functions.iter().find(|(own, _)| *own == token);
                out.push_str(other.map_or(token, |(_, name)| name));
            }
            'a'..='z' | 'A'..='Z' | '_' => out.push_str(&named(token)),
            _ => out.push_str(token),
        }
        rest = behind;
    }
    out
}

/// Length of the number at the start, its exponent included.
fn number_length(text: &str) -> usize {
    let is_part = |c: char| c.is_ascii_digit() || c == '.';
    let length = text.find(|c| !is_part(c)).unwrap_or(text.len());
    let Some(exponent) = text[length..].strip_prefix(['e', 'E']) else {
        return length;
    };
    let unsigned = exponent.strip_prefix(['+', '-']).unwrap_or(exponent);
    let is_digit = |c: char| c.is_ascii_digit();
    let digits = unsigned.find(|c| !is_digit(c)).unwrap_or(unsigned.len());
    match digits {
        0 => length,
        _ => text.len() - unsigned.len() + digits,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_functions_and_powers_are_those_of_the_language() {
        let named = |name: &str| match name {
            "d" | "pi" => name.to_owned(),
            other => format!("{other}_1"),
        };
        let text = "lambda * ln (d^2 + 1.5e-3) - step(d) * e * pi";
        assert_eq!(
            translated(text, &PYTHON, &named),
            "lambda_1 * log (d**2 + 1.5e-3) - above_zero(d) * e_1 * pi"
        );
        assert_eq!(translated("2E5*d^x", &MATLAB, &named), "2E5*d^x_1");
    }
}
