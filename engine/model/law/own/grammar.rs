//! The grammar of a law's expressions, checked before the library that evaluates them sees them, so that every mistake has a
//! column. Sums, products, powers, functions and parentheses as everywhere; what languages read differently is refused.

use super::error::LawError;

/// Characters and nested parentheses that an expression may have.
pub const MOST_CHARACTERS: usize = 500;
const MOST_NESTED: usize = 20;

/// Functions of one value and of two.
const OF_ONE: [&str; 15] = [
    "abs", "sign", "step", "sqrt", "exp", "ln", "sin", "cos", "tan", "asin", "acos", "atan",
    "sinh", "cosh", "tanh",
];
const OF_TWO: [&str; 3] = ["min", "max", "atan2"];
/// Functions whose values have corners or jumps.
const WITH_CORNERS: [&str; 5] = ["abs", "sign", "step", "min", "max"];

#[derive(Clone, Copy, Debug, PartialEq)]
enum Token<'a> {
    Number(&'a str),
    Name(&'a str),
    Operator(char),
    Open,
    Close,
    Comma,
}

/// A parenthesis that is open.
struct Open {
    column: usize,
    /// Commas that must still come.
    commas: usize,
    /// Whether it is the exponent of a power.
    is_exponent: bool,
}

/// An expression as it is given on: with the sign of what follows written out, since the evaluating library takes -x^2 for
/// (-x)^2.
#[derive(Debug, Default, PartialEq)]
pub struct Checked {
    pub text: String,
    pub has_corners: bool,
    /// Operators and functions, which is what an evaluation costs.
    pub operations: usize,
}

/// Checks an expression of the law's `field` in which `known` names stand for values.
pub fn check(field: &str, text: &str, known: &[String]) -> Result<Checked, LawError> {
    let wrong = |column: usize, problem: String| LawError::Expression {
        field: field.to_owned(),
        column: column + 1,
        problem,
    };
    let length = text.chars().count();
    if length > MOST_CHARACTERS {
        let problem = format!("{length} characters, expected at most {MOST_CHARACTERS}");
        return Err(wrong(MOST_CHARACTERS, problem));
    }
    let tokens = tokens(text).map_err(|(column, problem)| wrong(column, problem))?;
    let mut reader = Reader::new(known);
    for (i, (column, token)) in tokens.iter().enumerate() {
        let next = tokens.get(i + 1).map(|(_, token)| *token);
        (reader.take(*column, *token, next)).map_err(|problem| wrong(*column, problem))?;
    }
    reader
        .end(length)
        .map_err(|(column, problem)| wrong(column, problem))
}

fn tokens(text: &str) -> Result<Vec<(usize, Token<'_>)>, (usize, String)> {
    let mut found = Vec::new();
    let mut rest = text;
    let mut column = 0;
    while let Some(first) = rest.chars().next() {
        let (token, length) = match first {
            ' ' | '\t' | '\n' | '\r' => (None, 1),
            '(' => (Some(Token::Open), 1),
            ')' => (Some(Token::Close), 1),
            ',' => (Some(Token::Comma), 1),
            '+' | '-' | '*' | '/' | '^' => (Some(Token::Operator(first)), 1),
            '0'..='9' | '.' => {
                let length = number_length(rest);
                let number = &rest[..length];
                let finite = fast_float2::parse::<f64, _>(number).is_ok_and(f64::is_finite);
                if !finite {
                    return Err((column, format!("'{number}' is not a number")));
                }
                (Some(Token::Number(number)), length)
            }
            'a'..='z' | 'A'..='Z' | '_' => {
                let named = |c: char| c.is_ascii_alphanumeric() || c == '_';
                let length = rest.find(|c| !named(c)).unwrap_or(rest.len());
                (Some(Token::Name(&rest[..length])), length)
            }
            other => {
                let problem = format!("unexpected '{}'", other.escape_default());
                return Err((column, problem));
            }
        };
        found.extend(token.map(|token| (column, token)));
        column += length;
        rest = &rest[length..];
    }
    Ok(found)
}

/// Length of the number at the start: digits, a point, and an exponent such as e-3.
fn number_length(text: &str) -> usize {
    let digits =
        |text: &str| text.len() - text.trim_start_matches(|c: char| c.is_ascii_digit()).len();
    let mut length = digits(text);
    if text[length..].starts_with('.') {
        length += 1 + digits(&text[length + 1..]);
    }
    let exponent = &text[length..];
    if let Some(rest) = exponent.strip_prefix(['e', 'E']) {
        let signed = rest.strip_prefix(['+', '-']).unwrap_or(rest);
        let power = digits(signed);
        if power > 0 {
            length += exponent.len() - signed.len() + power;
        }
    }
    length
}

struct Reader<'a> {
    known: &'a [String],
    out: Checked,
    open: Vec<Open>,
    /// What stood before.
    before: Option<Token<'a>>,
    /// Whether what stands there is the exponent of a power.
    is_exponent: bool,
}

impl<'a> Reader<'a> {
    fn new(known: &'a [String]) -> Self {
        Self {
            known,
            out: Checked::default(),
            open: Vec::new(),
            before: None,
            is_exponent: false,
        }
    }

    /// Whether a value must come next.
    fn wants_value(&self) -> bool {
        !matches!(
            self.before,
            Some(Token::Number(_) | Token::Name(_) | Token::Close)
        )
    }

    fn take(
        &mut self,
        column: usize,
        token: Token<'a>,
        next: Option<Token<'a>>,
    ) -> Result<(), String> {
        match (token, self.wants_value()) {
            (Token::Number(text), true) => {
                // A literal of the evaluating library has no exponent.
                let value: f64 = fast_float2::parse(text).unwrap_or(f64::NAN);
                self.out.text += &format!("{value}");
            }
            (Token::Name(name), true) => self.name(name, next)?,
            (Token::Open, true) => self.open(column, 0)?,
            (Token::Open, false) => match self.before {
                Some(Token::Name(name)) if is_function(name) => {
                    self.open(column, usize::from(OF_TWO.contains(&name)))?;
                }
                _ => return Err("an operator is missing before the parenthesis".to_owned()),
            },
            (Token::Close, false) => self.close()?,
            (Token::Comma, false) => self.comma()?,
            (Token::Operator(operator), false) => self.operator(operator)?,
            (Token::Operator(sign @ ('+' | '-')), true) => self.sign(sign)?,
            (Token::Operator(other), true) => {
                return Err(format!("a value is missing before '{other}'"));
            }
            (Token::Close, true) => return Err("a value is missing before ')'".to_owned()),
            (Token::Comma, true) => return Err("a value is missing before ','".to_owned()),
            (Token::Number(text) | Token::Name(text), false) => {
                return Err(format!("an operator is missing before '{text}'"));
            }
        }
        self.before = Some(token);
        Ok(())
    }

    fn name(&mut self, name: &'a str, next: Option<Token>) -> Result<(), String> {
        if is_function(name) {
            if next != Some(Token::Open) {
                return Err(format!("{name} is a function: {name}(..)"));
            }
            self.out.operations += 1;
            self.out.has_corners |= WITH_CORNERS.contains(&name);
        } else if name != "pi" {
            if !self.known.iter().any(|known| known == name) {
                let functions: Vec<&str> = functions().collect();
                return Err(format!(
                    "unknown name '{name}', expected one of {}, pi and the functions {}",
                    self.known.join(", "),
                    functions.join(", ")
                ));
            }
            if next == Some(Token::Open) {
                return Err(format!("{name} is a value, not a function"));
            }
        }
        self.out.text += name;
        Ok(())
    }

    fn open(&mut self, column: usize, commas: usize) -> Result<(), String> {
        if self.open.len() == MOST_NESTED {
            return Err(format!(
                "more than {MOST_NESTED} parentheses within each other"
            ));
        }
        self.open.push(Open {
            column,
            commas,
            is_exponent: std::mem::take(&mut self.is_exponent),
        });
        self.out.text.push('(');
        Ok(())
    }

    fn close(&mut self) -> Result<(), String> {
        match self.open.pop() {
            None => Err("no parenthesis is open".to_owned()),
            Some(Open { commas: 1.., .. }) => Err("a second value is missing".to_owned()),
            Some(open) => {
                self.is_exponent = open.is_exponent;
                self.out.text.push(')');
                Ok(())
            }
        }
    }

    fn comma(&mut self) -> Result<(), String> {
        match self.open.last_mut() {
            Some(open) if open.commas > 0 => {
                open.commas -= 1;
                self.is_exponent = false;
                self.out.text.push(',');
                Ok(())
            }
            _ => Err("only min, max and atan2 take two values".to_owned()),
        }
    }

    fn operator(&mut self, operator: char) -> Result<(), String> {
        if operator == '^' && self.is_exponent {
            return Err("a power of a power needs parentheses".to_owned());
        }
        self.is_exponent = operator == '^';
        self.out.operations += 1;
        self.out.text.push(operator);
        Ok(())
    }

    /// A sign where a value is wanted holds for the whole product that follows.
    fn sign(&mut self, sign: char) -> Result<(), String> {
        if matches!(self.before, Some(Token::Operator(_))) {
            return Err("a sign after an operator needs parentheses".to_owned());
        }
        if sign == '-' {
            self.out.text += "(-1)*";
        }
        Ok(())
    }

    fn end(self, length: usize) -> Result<Checked, (usize, String)> {
        if let Some(open) = self.open.last() {
            return Err((open.column, "the parenthesis is not closed".to_owned()));
        }
        if self.wants_value() {
            return Err((length, "a value is missing at the end".to_owned()));
        }
        Ok(self.out)
    }
}

fn functions() -> impl Iterator<Item = &'static str> {
    OF_ONE.into_iter().chain(OF_TWO)
}

pub fn is_function(name: &str) -> bool {
    functions().any(|known| known == name)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use proptest::prelude::*;

    use super::*;

    fn known() -> Vec<String> {
        ["d", "w", "c"].map(str::to_owned).to_vec()
    }

    #[test]
    fn a_sign_holds_for_what_follows() {
        let checked = check("force", "-c*d^2 + 1.5e-3 * exp(-(w/c)^2)", &known()).unwrap();
        assert_eq!(checked.text, "(-1)*c*d^2+0.0015*exp((-1)*(w/c)^2)");
        assert!(!checked.has_corners);
        assert!(check("force", "max(d, 0)", &known()).unwrap().has_corners);
        assert!(check("force", "(d^2)^2 * d^(w^2)", &known()).is_ok());
    }

    #[test]
    fn mistakes_have_a_column() {
        let nested = format!("{}d", "(".repeat(21));
        for (text, at, why) in [
            ("c * * d", 5, "a value is missing before '*'"),
            ("c d", 3, "an operator is missing before 'd'"),
            ("c * q", 5, "unknown name 'q', expected one of d, w, c, pi"),
            ("2 * (d + c", 5, "the parenthesis is not closed"),
            ("d)", 2, "no parenthesis is open"),
            ("d +", 4, "a value is missing at the end"),
            ("", 1, "a value is missing at the end"),
            ("sin d", 1, "sin is a function: sin(..)"),
            ("d(3)", 1, "d is a value, not a function"),
            ("max(d)", 6, "a second value is missing"),
            ("max(d, 1, 2)", 9, "only min, max and atan2 take two values"),
            ("d ^ w ^ c", 7, "a power of a power needs parentheses"),
            ("d / -c", 5, "a sign after an operator needs parentheses"),
            ("d; c", 2, "unexpected ';'"),
            ("d * 1..2", 7, "an operator is missing before '.2'"),
            ("1e999", 1, "'1e999' is not a number"),
            ("\u{b5} * d", 1, "unexpected '\\u{b5}'"),
            (
                nested.as_str(),
                21,
                "more than 20 parentheses within each other",
            ),
        ] {
            let said = check("force", text, &known()).unwrap_err().to_string();
            let expected = format!("force, column {at}: {why}");
            assert!(said.starts_with(&expected), "{text}: {said}");
        }
        let long = "d+".repeat(300);
        assert!(check("force", &long, &known()).is_err());
    }

    proptest! {
        #[test]
        fn no_text_is_too_strange(text in "[dwc0-9a-z+*/^()., \\-\u{e4}]{0,60}") {
            let _ = check("force", &text, &known());
        }
    }
}
