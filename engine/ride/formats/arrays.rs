//! Arrays in memory as a table.

use crate::channels::glimpse::Glimpse;
use crate::channels::table::{Table, measured};
use crate::error::{Problem, ReadError};
use crate::file::Arrays;
use crate::formats::header::Offered;
use crate::options::ReadOptions;

/// Recognises columns by their names and takes the rows that are asked for.
pub fn read(arrays: &Arrays<'_>, options: &ReadOptions) -> Result<Table, ReadError> {
    let too_many = |what, limit| Err(Problem::TooMany { what, limit }.into());
    let limits = &options.limits;
    if arrays.columns.len() > limits.columns {
        return too_many("columns", limits.columns);
    }
    let names: Vec<String> = arrays
        .columns
        .iter()
        .map(|(n, _)| (*n).to_owned())
        .collect();
    let recognised = Offered {
        names: &names,
        units: &[],
        are_times: &[],
        paces: &[],
        line: None,
    }
    .recognise(options)?;
    let of = |number: usize| arrays.columns[number - 1].1;
    let rows = recognised.specs.first().map_or(0, |s| of(s.number).len());
    for spec in &recognised.specs {
        let found = of(spec.number).len();
        if found != rows {
            let expected = rows;
            return Err(spec.blame(Problem::RaggedRow { found, expected }));
        }
    }
    if rows > limits.rows {
        return too_many("rows", limits.rows);
    }
    let (from, to) = options.rows.unwrap_or((0, rows));
    if from >= rows && rows > 0 {
        return Err(Problem::BadRows { from, to, rows }.into());
    }
    let mut warnings = recognised.warnings;
    if to > rows {
        warnings.push(format!(
            "rows {from}:{to} were requested, but the file ends after {rows}"
        ));
    }
    let range = from.min(rows)..to.min(rows);
    let glimpse = |(name, values): &(&str, &[f64])| {
        Glimpse::of_numbers(name, values.iter().skip(from).copied())
    };
    let glimpses = arrays.columns.iter().map(glimpse).collect();
    let columns = recognised.specs.into_iter().map(|spec| {
        let values = of(spec.number)[range.clone()].to_vec();
        match measured(&values, true) {
            Ok(()) => Ok((spec, values)),
            Err((at, problem)) => Err(spec.blame(problem).at_sample(from + at + 1)),
        }
    });
    Ok(Table {
        columns: columns.collect::<Result<Vec<_>, ReadError>>()?,
        rows: range.len(),
        glimpses,
        epoch_s: arrays.epoch_s,
        unfound: recognised.unfound,
        ignored: recognised.ignored,
        warnings,
        format: "arrays".to_owned(),
        ..Table::default()
    })
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::{Content, Ride, RideFile, read, read_on_clocks};
    use veloid_core::bicycle::Bike;

    /// A wave on a road at 100 Hz: t, u_f, z_f.
    fn waves() -> [Vec<f64>; 3] {
        let t: Vec<f64> = (0..400).map(|i| f64::from(i) / 100.0).collect();
        let wave = |late: f64| {
            t.iter()
                .map(move |t| 1e-3 * ((9.0 * t - late).sin() + (31.0 * t).cos()))
        };
        let (u, z) = (wave(0.0).collect(), wave(0.1).collect());
        [t, u, z]
    }

    fn given(columns: &[(&str, &[f64])], options: &ReadOptions) -> Result<Ride, ReadError> {
        let arrays = Arrays {
            columns,
            epoch_s: None,
        };
        let content = Content::Arrays(arrays);
        read_on_clocks(
            &[RideFile { name: "x", content }],
            &Bike::default(),
            options,
            &[],
        )
    }

    #[test]
    fn arrays_are_the_ride_of_a_file_with_the_same_numbers() {
        let [t, u, mut z] = waves();
        z[100] = f64::NAN;
        let notes = [0.0; 7];
        let columns = [
            ("note", &notes[..]),
            ("t", &t),
            ("u_f", &u),
            ("z_f [mm]", &z),
        ];
        let mut text = "note,t,u_f,z_f [mm]\n".to_owned();
        for ((t, u), z) in t.iter().zip(&u).zip(&z) {
            let z = if z.is_nan() {
                String::new()
            } else {
                format!("{z:?}")
            };
            text += &format!("x,{t:?},{u:?},{z}\n");
        }
        for rows in [None, Some((50, 250)), Some((300, 900))] {
            let options = ReadOptions {
                rows,
                ..ReadOptions::default()
            };
            let mut own = given(&columns, &options).unwrap();
            let file = read(text.as_bytes(), "x", &Bike::default(), &options).unwrap();
            assert_ne!(own.summary.sha256, file.summary.sha256);
            own.summary.sha256.clone_from(&file.summary.sha256);
            assert_eq!(own, file);
        }
    }

    #[test]
    fn faults_name_column_and_sample() {
        let [t, u, mut z] = waves();
        z[31] = f64::INFINITY;
        let fault = |columns: &[(&str, &[f64])], rows| {
            let options = ReadOptions {
                rows,
                ..ReadOptions::default()
            };
            let e = given(columns, &options).unwrap_err();
            (e.kind(), e.column().map(|(n, _)| n), e.sample())
        };
        let columns = [("t", &t[..]), ("u_f", &u), ("z_f", &z)];
        assert_eq!(fault(&columns, None), ("not-finite", Some(3), Some(32)));
        assert_eq!(
            fault(&columns, Some((31, 200))),
            ("not-finite", Some(3), Some(32))
        );
        assert_eq!(fault(&columns, Some((400, 500))), ("bad-rows", None, None));
        let uneven = [("t", &t[..]), ("u_f", &u[1..])];
        assert_eq!(fault(&uneven, None), ("ragged-row", Some(2), None));
        assert_eq!(fault(&columns[1..2], None), ("time-missing", None, None));
        assert_eq!(fault(&[], None), ("time-missing", None, None));
        let wide = vec![("x", &t[..0]); 600];
        assert_eq!(fault(&wide, None), ("too-many", None, None));
    }
}
