//! The matrices of MATLAB level 4 files (saved with -v4), one after the other and never packed. Format: "MAT-File Format",
//! MathWorks, 2022, chapter 1.

use crate::error::ReadError;
use crate::formats::matrix::{Numbers, Offer, Visit, corrupt, text, visit_columns};

const HEADER: usize = 20;
/// Longest name with the zero at its end (bytes); MATLAB's have 64.
const NAME: usize = 256;
/// Largest matrix that MATLAB writes so (bytes).
const MATRIX: u64 = 1 << 31;
/// Numbers by their digit in the header (double, single, int32, int16, uint16, uint8): type in level 5, and bytes.
const TYPES: [(u32, u64); 6] = [(9, 8), (7, 4), (5, 4), (3, 2), (4, 2), (2, 1)];
/// Contents of a matrix; between them is text.
const NUMBERS: u32 = 0;
const SPARSE: u32 = 2;

/// Whether these bytes begin as such a file does: it has no other mark than a sound header of its first matrix.
pub fn begins(bytes: &[u8]) -> bool {
    Header::of(bytes).is_some()
}

/// Visits every column in the order of the file. Texts and sparse matrices are only named.
pub fn columns(bytes: &[u8], visit: &mut Visit<'_>) -> Result<(), ReadError> {
    let mut rest = bytes;
    while !rest.is_empty() {
        let at = bytes.len() - rest.len();
        let header =
            Header::of(rest).ok_or_else(|| corrupt(&format!("no variable begins at byte {at}")))?;
        let name = text(header.name);
        let data = &rest[HEADER + header.name.len()..];
        let parts = if header.complex { 2 } else { 1 };
        let Some(all) = data.get(..parts * header.size) else {
            return Err(corrupt(&format!("it ends within {name}")).into());
        };
        rest = &data[all.len()..];
        if header.contents != NUMBERS {
            visit(&Offer::other(name), &Numbers::none())?;
            continue;
        }
        let numbers = Numbers::new(header.kind, &all[..header.size], header.big_endian);
        visit_columns(&name, header.shape, header.complex, &numbers, visit)?;
    }
    Ok(())
}

/// What stands before the numbers of a matrix.
struct Header<'a> {
    big_endian: bool,
    contents: u32,
    /// Type of the numbers in level 5.
    kind: u32,
    /// Rows and columns.
    shape: (usize, usize),
    complex: bool,
    /// With the zero at its end.
    name: &'a [u8],
    /// Bytes of the real part, and of the imaginary one if there is one.
    size: usize,
}

impl<'a> Header<'a> {
    fn of(bytes: &'a [u8]) -> Option<Self> {
        let (words, rest) = bytes.split_first_chunk::<HEADER>()?;
        // The first word is below 5000, which it is in the right order of bytes only.
        let big_endian = words[2..4] != [0, 0];
        let word = |at: usize| {
            let word = [words[at], words[at + 1], words[at + 2], words[at + 3]];
            match big_endian {
                true => u32::from_be_bytes(word),
                false => u32::from_le_bytes(word),
            }
        };
        let [what, rows, columns, imaginary, name] = [0, 4, 8, 12, 16].map(word);
        let (machine, order, contents) = (what / 1000, what / 100 % 10, what % 10);
        let (kind, width) = *TYPES.get(what as usize / 10 % 10)?;
        let size = (u64::from(rows) * u64::from(columns)).checked_mul(width)?;
        let name = rest.get(..name as usize).filter(|n| n.len() <= NAME)?;
        let is_name = match name {
            [letters @ .., 0] => !letters.is_empty() && letters.iter().all(u8::is_ascii_graphic),
            _ => false,
        };
        let is_sound = machine == u32::from(big_endian)
            && order == 0
            && contents <= SPARSE
            && imaginary <= 1
            && size <= MATRIX
            && is_name;
        is_sound.then_some(Self {
            big_endian,
            contents,
            kind,
            shape: (rows as usize, columns as usize),
            complex: imaginary == 1,
            name,
            size: size as usize,
        })
    }
}

#[cfg(test)]
pub mod tests {
    #![allow(clippy::unwrap_used)]
    use proptest::prelude::*;

    use super::*;

    /// A matrix under a header of these words, the last of which is the length of its name.
    pub fn matrix(words: [u32; 4], big_endian: bool, name: &str, data: &[u8]) -> Vec<u8> {
        let bytes = |word: u32| match big_endian {
            true => word.to_be_bytes(),
            false => word.to_le_bytes(),
        };
        let [what, rows, columns, imaginary] = words;
        let words = [what, rows, columns, imaginary, name.len() as u32 + 1];
        [&words.map(bytes).concat(), name.as_bytes(), &[0], data].concat()
    }

    /// A column of doubles.
    pub fn doubles(name: &str, values: &[f64]) -> Vec<u8> {
        let data: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        matrix([0, values.len() as u32, 1, 0], false, name, &data)
    }

    fn all(bytes: &[u8]) -> Vec<(String, Vec<f64>)> {
        let mut all = Vec::new();
        columns(bytes, &mut |offer, numbers| {
            all.push((offer.name.clone(), numbers.iter().collect()));
            Ok(())
        })
        .unwrap();
        all
    }

    #[test]
    fn numbers_of_every_type_and_order_are_read() {
        for (digit, little) in [
            (0, (-2.5f64).to_le_bytes().to_vec()),
            (1, (-2.5f32).to_le_bytes().to_vec()),
            (2, (-70_000i32).to_le_bytes().to_vec()),
            (3, (-300i16).to_le_bytes().to_vec()),
            (4, 65_000u16.to_le_bytes().to_vec()),
            (5, vec![200]),
        ] {
            let expected = [-2.5, -2.5, -70_000.0, -300.0, 65_000.0, 200.0][digit as usize];
            let big: Vec<u8> = little.iter().rev().copied().collect();
            for (what, data, is_big) in [(0, little, false), (1000, big, true)] {
                let words = [what + 10 * digit, 2, 1, 0];
                let file = matrix(words, is_big, "z_f", &data.repeat(2));
                assert!(begins(&file));
                assert_eq!(all(&file), [("z_f".to_owned(), vec![expected; 2])]);
            }
        }
    }

    #[test]
    fn texts_and_sparse_matrices_are_only_named() {
        let file = [
            matrix([51, 1, 2, 0], false, "note", b"hi"),
            matrix([1, 1, 2, 0], false, "old", &[0; 16]),
            matrix([2, 3, 3, 0], false, "sparse", &[0; 72]),
            matrix([20, 2, 3, 0], false, "m", &[1; 24]),
        ];
        let names: Vec<(String, usize)> = (all(&file.concat()).into_iter())
            .map(|(name, values)| (name, values.len()))
            .collect();
        let names: Vec<(&str, usize)> = names.iter().map(|(n, v)| (n.as_str(), *v)).collect();
        let expected = [
            ("note", 0),
            ("old", 0),
            ("sparse", 0),
            ("m#1", 3),
            ("m#2", 3),
        ];
        assert_eq!(names, expected);
    }

    #[test]
    fn no_other_file_begins_so() {
        let sound = matrix([0, 1, 1, 0], false, "z_f", &[0; 8]);
        assert!(begins(&sound) && begins(&sound[..24]) && !begins(&sound[..23]));
        for words in [
            [100, 1, 1, 0],           // by rows
            [60, 1, 1, 0],            // no type
            [3, 1, 1, 0],             // no contents
            [1000, 1, 1, 0],          // of the other order
            [2000, 1, 1, 0],          // of a VAX
            [0, 1, 1, 2],             // neither real nor complex
            [0, 1 << 16, 1 << 13, 0], // 4 GiB
            [0, u32::MAX, u32::MAX, 0],
        ] {
            assert!(!begins(&matrix(words, false, "z_f", &[0; 8])), "{words:?}");
        }
        for name in ["", "z f", "z\0f", "\u{b5}", &"x".repeat(NAME)] {
            assert!(
                !begins(&matrix([0, 1, 1, 0], false, name, &[0; 8])),
                "{name}"
            );
        }
        let endless = [&sound[..23], b"_f"].concat();
        assert!(!begins(&endless) && !begins(&[0; 64]) && !begins(b""));
        assert!(!begins(b"t,u_f,z_f\n0.00,0.13,0.02\n0.01,0.21,0.05\n"));
    }

    proptest! {
        #[test]
        fn no_bytes_do_harm(
            words in [0u32..1060, 0u32..5, 0u32..5, 0u32..2],
            bytes in prop::collection::vec(any::<u8>(), 0..300),
            second in any::<bool>(),
        ) {
            let big_endian = words[0] >= 1000;
            let rest = match second {
                true => matrix(words, big_endian, "u_f", &bytes),
                false => bytes.clone(),
            };
            let file = [matrix(words, big_endian, "z_f", &bytes), rest].concat();
            let _ = columns(&file, &mut |_, numbers| {
                let _ = numbers.iter().count();
                Ok(())
            });
        }
    }
}
