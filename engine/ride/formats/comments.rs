//! What a text file says in comments above its header.

use crate::formats::head::{decode, is_comment};
use crate::formats::source::Source;
use crate::options::Limits;

/// Lines that are looked at, and the longest that is read (bytes).
const LINES: usize = 100;
const LONGEST: usize = 8 << 10;

/// Number and text of the comments before the first line that is none, without their marks. A file that is no text has none.
pub fn comments(bytes: &[u8]) -> Vec<(usize, String)> {
    let Ok(mut source) = Source::open(bytes, &Limits::default()) else {
        return Vec::new();
    };
    let Ok(Some(block)) = source.next_block() else {
        return Vec::new();
    };
    let above = (1..)
        .zip(block.split(|byte| *byte == b'\n'))
        .take(LINES)
        .take_while(|(_, line)| is_comment(line) || line.trim_ascii().is_empty());
    above
        .filter(|(_, line)| is_comment(line) && line.len() <= LONGEST)
        .map(|(number, line)| {
            let text = decode(line.trim_ascii());
            let text = text.trim_start_matches(['#', '%', ' ', '\t']);
            (number, text.to_owned())
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_above_the_header_are_read_packed_or_not() {
        let text =
            b"# pressure_front_bar: 2.2\n\n%% road: caf\xe9\r\nt,z_f\n# rider: nobody\n0,1\n";
        let found = [
            (1, "pressure_front_bar: 2.2".to_owned()),
            (3, "road: caf\u{e9}".to_owned()),
        ];
        assert_eq!(comments(text), found);
        let packed = crate::formats::zstd::tests::packed(text);
        assert_eq!(comments(&packed), found);
        for nothing in [&b""[..], b"t,z_f\n0,1\n", b"\x1f\x8b", b"MATLAB 5.0\0\x01"] {
            assert!(comments(nothing).is_empty());
        }
        assert!(comments(&b"#".repeat(1 << 20)).is_empty());
    }
}
