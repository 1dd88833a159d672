//! Times in unusual writing: rewritten in a usual one, or read as durations.

use super::moment::{DAY_S, Moment, time_of_day};

/// Beginnings of the names of months in English, German, French, Spanish, Italian and Dutch.
const MONTHS: [&[&str]; 12] = [
    &["jan", "jän", "ene", "gen"],
    &["feb", "fév", "fev"],
    &["mar", "mär", "mrz", "mrt", "maart"],
    &["apr", "avr", "abr"],
    &["may", "mai", "mei", "mag"],
    &["jun", "juin", "giu"],
    &["jul", "juil", "lug"],
    &["aug", "aoû", "aou", "ago"],
    &["sep", "set"],
    &["oct", "okt", "ott"],
    &["nov"],
    &["dec", "déc", "dez", "dic"],
];
/// Ends of times before and after noon, as they are written in small letters.
const HALVES: [(&str, &str); 6] = [
    ("a.m.", "AM"),
    ("p.m.", "PM"),
    ("a. m.", "AM"),
    ("p. m.", "PM"),
    ("am", "AM"),
    ("pm", "PM"),
];

/// A time of a calendar in a usual writing; none where there is nothing to rewrite.
pub fn usual(text: &str) -> Option<String> {
    let mut plain = String::new();
    for letter in text.chars() {
        match letter {
            '年' | '月' => plain.push('-'),
            '日' | '\u{a0}' | '\u{202f}' => plain.push(' '),
            '時' | '分' => plain.push(':'),
            '秒' => {}
            other => plain.push(other),
        }
    }
    let plain = without_name_of_zone(plain);
    let plain = with_half_of_day(plain);
    let plain = with_colons(plain);
    let plain = with_number_of_month(&plain).unwrap_or(plain);
    (plain != text).then_some(plain)
}

/// `GMT+0200 (CEST)` is `+0200`.
fn without_name_of_zone(text: String) -> String {
    let Some(at) = text.find("GMT").or_else(|| text.find("UTC")) else {
        return text;
    };
    let (time, zone) = text.split_at(at);
    let offset = zone[3..].split('(').next().unwrap_or_default().trim();
    match offset.starts_with(['+', '-']) {
        true => format!("{time}{offset}"),
        false => text,
    }
}

fn with_half_of_day(text: String) -> String {
    for (end, half) in HALVES {
        let time = text.len().checked_sub(end.len()).and_then(|at| {
            let (time, found) = (text.get(..at)?, text.get(at..)?);
            (found.eq_ignore_ascii_case(end)).then_some(time.trim_end())
        });
        if let Some(time) = time.filter(|time| time.ends_with(|c: char| c.is_ascii_digit())) {
            return format!("{time} {half}");
        }
    }
    text
}

/// `2026-05-21_10-00-00.005` and `2026-05-21T10.00.00.005`.
fn with_colons(text: String) -> String {
    let is = |at: usize, marks: &[u8]| text.as_bytes().get(at).is_some_and(|b| marks.contains(b));
    let is_apart = is(4, b"-") && is(7, b"-") && is(10, b"_T ") && text.is_ascii();
    if !is_apart || !(is(13, b"-._") && is(16, b"-._") || is(10, b"_") && is(13, b":")) {
        return text;
    }
    let (hour, minute, second) = (&text[11..13], text.get(14..16), text.get(17..));
    match (minute, second) {
        (Some(minute), Some(second)) => format!("{} {hour}:{minute}:{second}", &text[..10]),
        _ => text,
    }
}

/// `Thu May 21 10:00:00 2026` or `21-Mai-2026 10:00:00` with the date in numbers.
fn with_number_of_month(text: &str) -> Option<String> {
    let mut words: Vec<&str> = text.split_ascii_whitespace().collect();
    let time = words.iter().position(|word| word.contains(':'))?;
    let is_year = |word: &str| word.len() == 4 && word.bytes().all(|b| b.is_ascii_digit());
    let mut date = words[..time].join(" ");
    if let Some(year) = words[time + 1..].last().filter(|word| is_year(word)) {
        date = format!("{date} {year}");
        words.pop();
    }
    let parts = date
        .split(|c: char| !c.is_alphanumeric())
        .filter(|part| !part.is_empty() && !part.eq_ignore_ascii_case("de"));
    let (numbers, names): (Vec<&str>, Vec<&str>) =
        parts.partition(|part| part.bytes().all(|b| b.is_ascii_digit()));
    // A day of the week may stand in front.
    let month = match *names {
        [month] => month,
        [day, month] if date.starts_with(day) => month,
        _ => return None,
    };
    let month = month.to_lowercase();
    let begins = |names: &[&str]| names.iter().any(|name| month.starts_with(name));
    let month = 1 + MONTHS.iter().position(|names| begins(names))?;
    let (year, day) = match *numbers {
        [year, day] | [day, year] if is_year(year) && day.len() <= 2 => (year, day),
        _ => return None,
    };
    Some(format!(
        "{year}-{month:02}-{day:0>2} {}",
        words[time..].join(" ")
    ))
}

/// A duration: `0 days 00:00:00.005` or `1 day, 0:00:00.5` as Python writes it, `25:00:00.5`, or minutes in `00:50.005`.
pub fn duration(text: &str) -> Option<Moment> {
    if let Some((days, rest)) = text.split_once(" day") {
        let days: u32 = days.parse().ok()?;
        let rest = rest.strip_prefix('s').unwrap_or(rest);
        let time = time_of_day(rest.trim_start_matches([',', ' ', '+']))?;
        let mut moment = Moment::of_day(time);
        moment.second += i64::from(days) * DAY_S;
        return Some(moment);
    }
    let parts: Vec<&str> = text.split(':').collect();
    let (hours, minutes, seconds) = match *parts {
        // Without a fraction of a second it may be hours and minutes.
        [minutes, seconds] if seconds.contains(['.', ',']) => ("0", minutes, seconds),
        [hours, minutes, seconds] if minutes.len() == 2 => (hours, minutes, seconds),
        _ => return None,
    };
    let (whole, part) = seconds.split_once(['.', ',']).unwrap_or((seconds, "0"));
    let is_digits = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    if whole.len() != 2
        || ![hours, minutes, whole, part].into_iter().all(is_digits)
        || hours.len() + minutes.len() > 6
    {
        return None;
    }
    let whole: i64 = whole.parse().ok()?;
    let minutes: i64 = minutes.parse().ok()?;
    if whole >= 60 || parts.len() == 3 && minutes >= 60 {
        return None;
    }
    let hours: i64 = hours.parse().ok()?;
    Some(Moment {
        second: 3600 * hours + 60 * minutes + whole,
        part: format!("0.{part}").parse().ok()?,
        is_dated: false,
    })
}

#[cfg(test)]
mod tests {
    use super::super::times::Times;

    fn epoch(text: &str) -> Option<f64> {
        Times::default().read(text.as_bytes()).map(|m| m.epoch_s())
    }

    #[test]
    fn calendars_of_many_programs_are_read() {
        for text in [
            "21-Mai-2026 10:00:00.5",
            "21. Mai 2026 10:00:00,5",
            "21 mai 2026 10:00:00.5",
            "21 de mayo de 2026 10:00:00.5",
            "jeu. 21 mai 2026 10:00:00.5",
            "Thu May 21 10:00:00.5 2026",
            "Thu May 21 2026 12:00:00.5 GMT+0200 (Central European Summer Time)",
            "Thu, 21 May 2026 10:00:00.5 GMT",
            "2026-05-21_10-00-00.5",
            "2026-05-21_10:00:00.5",
            "2026-05-21T10.00.00.5",
            "2026年05月21日 10:00:00.5",
            "2026年5月21日10時00分00.5秒",
            "2026-141T10:00:00.5",
            "05/21/2026 10:00:00.5 a.m.",
            "21.05.2026 10:00:00.5 am",
            "05/21/2026 10:00:00.5\u{202f}AM",
        ] {
            assert_eq!(epoch(text), Some(1_779_357_600.5), "{text}");
        }
        assert_eq!(
            epoch("mar. 24 mars 2026 10:00:00"),
            epoch("2026-03-24 10:00:00")
        );
        assert_eq!(
            epoch("05/21/2026 03:00:00 p. m."),
            epoch("2026-05-21 15:00:00")
        );
    }

    #[test]
    fn durations_are_read() {
        for (text, seconds) in [
            ("0 days 00:00:00.005000", 0.005),
            ("0 days 00:00:32", 32.0),
            ("1 day, 0:00:01.5", 86_401.5),
            ("00:50.005", 50.005),
            ("75:00.5", 4500.5),
            ("25:00:00.5", 90_000.5),
        ] {
            assert_eq!(epoch(text), Some(seconds), "{text}");
        }
    }

    #[test]
    fn other_text_is_no_time() {
        for text in [
            "21-Foo-2026 10:00:00",
            "May 10:00:00",
            "Laps: 10:00",
            "-1 days +23:59:59",
            "10:60.5",
            "10:61:00.5",
            "1:2.5",
            "2026-05-21_10",
            "a:b.c",
        ] {
            assert_eq!(epoch(text), None, "{text}");
        }
    }
}
