//! Whether the sign in a column of numbers such as `1.234` is a decimal sign or that of thousands: decided on all rows.

use super::number::{Number, Signs};

/// What the cells of one column have shown.
#[derive(Clone, Debug, Default)]
pub struct Grouping {
    /// A whole number of three digits without a sign.
    few: Option<f64>,
    has_few: bool,
    has_many: bool,
    has_decimal: bool,
    has_groups: bool,
    /// Rows whose sign may be either.
    either: Vec<u32>,
}

/// What the signs of a column are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Found {
    Decimal,
    Groups,
    /// Nothing in the column says.
    Open,
    /// Cells say both.
    Both,
}

impl Grouping {
    pub fn see(&mut self, found: Number, row: usize) {
        match found.signs {
            // One value may be that of a sensor that does not measure: 0, -1, 200 or -999.
            Signs::Few if found.value.abs() >= 100.0 => {
                let first = *self.few.get_or_insert(found.value);
                self.has_few |= found.value != first;
            }
            Signs::Few => {}
            Signs::Many => self.has_many = true,
            Signs::Decimal => self.has_decimal = true,
            Signs::Groups => self.has_groups = true,
            Signs::Either => self.either.push(row as u32),
        }
    }

    /// Whether no further cell can make a group's sign of a decimal one.
    pub fn is_decided(&self) -> bool {
        self.has_decimal && !self.has_groups
    }

    /// Forgets a row that is left out.
    pub fn forget(&mut self, row: usize) {
        while self.either.last() == Some(&(row as u32)) {
            self.either.pop();
        }
    }

    /// Whether some of its signs may be either.
    pub fn is_open(&self) -> bool {
        !self.either.is_empty()
    }

    pub fn found(&self) -> Found {
        match (self.has_decimal, self.has_groups) {
            (true, true) => Found::Both,
            (true, false) => Found::Decimal,
            (false, true) => Found::Groups,
            _ if self.either.is_empty() => Found::Open,
            // Without groups a number of four digits has no sign; with three decimals each one has.
            _ if self.has_many => Found::Decimal,
            _ if self.has_few => Found::Groups,
            _ => Found::Open,
        }
    }

    /// Takes the signs for those of thousands.
    pub fn join(&self, values: &mut [f64]) {
        for row in &self.either {
            if let Some(value) = values.get_mut(*row as usize) {
                *value = (1000.0 * *value).round();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::formats::number::number;

    fn of(cells: &[&str]) -> (Found, Vec<f64>) {
        let mut grouping = Grouping::default();
        let mut values: Vec<f64> = Vec::new();
        for (row, cell) in cells.iter().enumerate() {
            let number = number(cell.as_bytes(), b'.').unwrap();
            grouping.see(number, row);
            values.push(number.value);
        }
        grouping.join(&mut values);
        (grouping.found(), values)
    }

    #[test]
    fn all_rows_say_what_a_sign_is() {
        assert_eq!(
            of(&["1.234", "812", "-2.001", "813"]),
            (Found::Groups, vec![1234.0, 812.0, -2001.0, 813.0])
        );
        assert_eq!(of(&["1.234", "0.812"]).0, Found::Decimal);
        assert_eq!(of(&["1.234", "2.5"]).0, Found::Decimal);
        assert_eq!(of(&["1.234", "1234"]).0, Found::Decimal);
        assert_eq!(of(&["1.234", "5.012"]).0, Found::Open);
        for idle in ["0", "-1", "99", "-999"] {
            assert_eq!(of(&["5.123", idle, "5.124", idle]).0, Found::Open, "{idle}");
        }
        assert_eq!(of(&["812", "1234"]).0, Found::Open);
        assert_eq!(of(&["1.234.567", "0.5"]).0, Found::Both);
    }

    #[test]
    fn rows_that_are_left_out_change_no_other() {
        let mut grouping = Grouping::default();
        let either = number(b"1.234", b'.').unwrap();
        grouping.see(either, 0);
        grouping.see(either, 1);
        grouping.forget(1);
        let mut values = [1.5, 2.5];
        grouping.join(&mut values);
        assert_eq!(values, [1500.0, 2.5]);
    }
}
