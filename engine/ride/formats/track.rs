//! Tracks of head units in XML as the text of a table: speed and cadence of each point by its time of day. Formats: GPX 1.0 and 1.1
//! (Topografix) with Garmin's TrackPointExtension, TCX (Garmin's TrainingCenterDatabase v2).

use memchr::memmem;
use quick_xml::events::Event;
use quick_xml::{Reader, errors::Error};

use crate::error::Problem;

/// What such a file is called.
pub const FORMAT: &str = "GPX or TCX";
/// Bytes in which the root element begins, whatever stands above it.
const HEAD: usize = 4096;
/// Longest value that is looked at (letters).
const LONGEST: usize = 64;
/// Columns: a point's time, speed (m/s) and cadence, by the local names of their elements.
const HEADER: &str = "t,v,cadence\n";
const WITHOUT_SPEED: &str = "t,cadence\n";
const FIELDS: [[&str; 2]; 3] = [["time", "Time"], ["speed", "Speed"], ["cad", "Cadence"]];
const POINTS: [&str; 2] = ["trkpt", "Trackpoint"];

pub fn is_track(bytes: &[u8]) -> bool {
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    let head = &text[..text.len().min(HEAD)];
    let begins = |root: &[u8]| memmem::find(head, root).is_some();
    head.trim_ascii_start().starts_with(b"<")
        && (begins(b"<gpx") || begins(b"<TrainingCenterDatabase"))
}

/// A row for each point that has a time. Entities are not expanded: no number has any.
pub fn text(bytes: &[u8]) -> Result<String, Problem> {
    let mut reader = Reader::from_reader(bytes);
    let mut text = HEADER.to_owned();
    let mut point: Option<[String; FIELDS.len()]> = None;
    let mut field = None;
    let (mut points, mut speeds, mut cadences) = (0, 0, 0);
    loop {
        match reader.read_event().map_err(|e| corrupt(&e))? {
            Event::Start(element) => {
                let name = element.local_name();
                if POINTS.contains(&name.as_ref()) {
                    point = Some(Default::default());
                }
                field = FIELDS
                    .iter()
                    .position(|names| names.contains(&name.as_ref()));
            }
            Event::Text(value) => {
                if let (Some(point), Some(field)) = (&mut point, field) {
                    point[field] = cell(&value);
                }
            }
            Event::End(element) => {
                field = None;
                if POINTS.contains(&element.local_name().as_ref())
                    && let Some(point) = point.take()
                    && !point[0].is_empty()
                {
                    points += 1;
                    speeds += usize::from(!point[1].is_empty());
                    cadences += usize::from(!point[2].is_empty());
                    text += &(point.join(",") + "\n");
                }
            }
            Event::Eof => break,
            _ => {}
        }
    }
    match (speeds, cadences) {
        (0, 0) if points > 0 => Err(Problem::NoSpeed { points }),
        (0, 1..) => Ok(without_speed(&text)),
        _ => Ok(text),
    }
}

/// The rows without the column of speeds, in which there is none.
fn without_speed(text: &str) -> String {
    let rows = text
        .lines()
        .skip(1)
        .map(|row| row.replace(",,", ",") + "\n");
    WITHOUT_SPEED.to_owned() + &rows.collect::<String>()
}

/// A value without what would end its cell. Some programs write the decimal sign of their language.
fn cell(value: &str) -> String {
    let digits = |part: &str| !part.is_empty() && part.bytes().all(|b| b.is_ascii_digit());
    if let Some((whole, fraction)) = value.trim().split_once(',')
        && value.len() <= LONGEST
        && digits(whole.strip_prefix('-').unwrap_or(whole))
        && digits(fraction)
    {
        return format!("{whole}.{fraction}");
    }
    let plain = |c: char| match c.is_whitespace() || matches!(c, ',' | '"') {
        true => '_',
        false => c,
    };
    value.trim().chars().take(LONGEST).map(plain).collect()
}

fn corrupt(cause: &Error) -> Problem {
    Problem::Corrupt {
        format: FORMAT,
        cause: cause.to_string(),
    }
}

#[cfg(test)]
pub mod tests {
    #![allow(clippy::unwrap_used)]
    use proptest::prelude::*;

    use super::*;

    /// A track of seconds from `at` (a beginning of a minute, without seconds and zone), each with a speed (m/s).
    pub fn gpx(at: &str, speeds: &[f64]) -> String {
        let points = speeds.iter().enumerate().map(|(second, speed)| {
            format!(
                "<trkpt lat=\"49.0\" lon=\"8.4\"><ele>115.2</ele><time>{at}:{second:02}Z</time><extensions><x:TrackPointExtension>\
                 <x:cad>80</x:cad><x:speed>{speed}</x:speed></x:TrackPointExtension></extensions></trkpt>\n"
            )
        });
        let points: String = points.collect();
        format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<gpx version=\"1.1\" xmlns:x=\"http://www.garmin.com/xmlschemas/TrackPointExtension/v2\">\n\
             <metadata><time>2001-01-01T00:00:00Z</time></metadata><trk><trkseg>\n{points}</trkseg></trk></gpx>\n"
        )
    }

    #[test]
    fn points_become_rows() {
        let track = gpx("2026-05-01T10:00", &[5.0, 5.25]);
        assert!(is_track(track.as_bytes()));
        let expected = "t,v,cadence\n2026-05-01T10:00:00Z,5,80\n2026-05-01T10:00:01Z,5.25,80\n";
        assert_eq!(text(track.as_bytes()).unwrap(), expected);
        let lap = "\u{feff}<?xml version=\"1.0\"?><TrainingCenterDatabase><Lap><Cadence>1</Cadence><Track>\
             <Trackpoint><Time> 2026-05-01T10:00:00.500Z\n</Time><HeartRateBpm><Value>120</Value></HeartRateBpm><Cadence>81</Cadence>\
             <Extensions><ns3:TPX><ns3:Speed>4.5</ns3:Speed></ns3:TPX></Extensions></Trackpoint>\
             <Trackpoint><DistanceMeters>9</DistanceMeters></Trackpoint></Track></Lap></TrainingCenterDatabase>";
        assert!(is_track(lap.as_bytes()));
        let expected = "t,v,cadence\n2026-05-01T10:00:00.500Z,4.5,81\n";
        assert_eq!(text(lap.as_bytes()).unwrap(), expected);
        assert!(!is_track(b"<html>gpx</html>") && !is_track(b"t,z_f\n0,1\n"));
    }

    #[test]
    fn decimal_commas_are_read() {
        let track = gpx("2026-05-01T10:00", &[5.25]).replace("5.25", "5,25");
        assert!(text(track.as_bytes()).unwrap().ends_with("Z,5.25,80\n"));
    }

    #[test]
    fn a_track_without_speeds_offers_none() {
        let track = gpx("2026-05-01T10:00", &[5.0]);
        let slow = track.replace("<x:speed>5</x:speed>", "");
        let expected = "t,cadence\n2026-05-01T10:00:00Z,80\n";
        assert_eq!(text(slow.as_bytes()).unwrap(), expected);
        let positions = slow.replace("<x:cad>80</x:cad>", "");
        let error = text(positions.as_bytes()).unwrap_err();
        assert_eq!(error.kind(), "no-speed");
        assert!(
            error.to_string().starts_with("no point has a speed"),
            "{error}"
        );
    }

    #[test]
    fn damage_is_refused_and_values_stay_in_their_cells() {
        let track = gpx("2026-05-01T10:00", &[5.0]);
        let cut = &track[..track.find("<x:cad>").unwrap() + 3];
        let broken = track.replace("</x:speed>", "</x:sped>");
        assert_eq!(text(broken.as_bytes()).unwrap_err().kind(), "corrupt-file");
        assert_eq!(text(cut.as_bytes()).unwrap_err().kind(), "corrupt-file");
        let odd = track.replace(">5<", ">5,\n7<");
        assert!(text(odd.as_bytes()).unwrap().ends_with("Z,5__7,80\n"));
    }

    proptest! {
        #[test]
        fn no_track_does_harm(
            pieces in prop::collection::vec(prop::sample::select(vec![
                "<gpx>", "</gpx>", "<trkpt>", "</trkpt>", "<time>", "</time>", "2026-05-01T10:00:00Z", "<speed>", "1e999", "</speed>", "<a b=\"", "<!--",
                "<![CDATA[", "]]>", "&#0;", "&lol;", "<!DOCTYPE x [<!ENTITY lol \"lol\">]>", "<?", "\u{feff}", "<cad/>", "<x:speed>", "</x:speed>",
            ]), 0..30),
        ) {
            let track = format!("<gpx>{}", pieces.concat());
            prop_assert!(is_track(track.as_bytes()));
            if let Ok(text) = text(track.as_bytes()) {
                prop_assert!(text.lines().all(|row| [2, 3].contains(&row.split(',').count())));
            }
        }
    }
}
