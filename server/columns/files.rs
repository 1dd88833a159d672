//! The guesses for all files of a ride, none of which contradicts another.

use veloid_engine::ride::{Guess, PreviewTable, guess};

/// Each file has a time of its own.
const TIME: &str = "t";

/// Guesses for the columns without a channel. A channel that is there already, or that two columns may hold, is not guessed.
pub fn guesses(tables: &[PreviewTable]) -> Vec<Guess> {
    let all: Vec<(usize, Guess)> = (tables.iter().enumerate())
        .flat_map(|(file, table)| of_file(table).map(move |guess| (file, guess)))
        .collect();
    let same = |a: &(usize, Guess), b: &(usize, Guess)| {
        a.1.channel == b.1.channel && (a.1.channel != TIME || a.0 == b.0)
    };
    let is_alone = |guess| all.iter().filter(|other| same(guess, other)).count() == 1;
    let is_known = |(file, guess): &(usize, Guess)| {
        let mut files = tables.iter().enumerate();
        files.any(|(other, table)| {
            (guess.channel != TIME || other == *file) && has(table, guess.channel)
        })
    };
    (all.iter())
        .filter(|guess| is_alone(guess) && !is_known(guess))
        .map(|(file, guess)| Guess {
            file: (tables.len() > 1).then(|| tables[*file].name.clone()),
            ..guess.clone()
        })
        .collect()
}

fn of_file(table: &PreviewTable) -> impl Iterator<Item = Guess> {
    let free = table
        .columns
        .iter()
        .filter(|column| column.channel.is_none());
    free.filter_map(|column| guess(&column.header))
}

fn has(table: &PreviewTable, channel: &str) -> bool {
    let mut channels = table.columns.iter().map(|column| column.channel.as_deref());
    channels.any(|known| known == Some(channel))
}

#[cfg(test)]
mod tests {
    use veloid_engine::ride::PreviewColumn;

    use super::*;

    /// A file of these headers, of which those with `!` hold the channel that they name.
    fn table(name: &str, headers: &[&str]) -> PreviewTable {
        let column = |(number, header): (usize, &&str)| {
            let channel = header.strip_prefix('!');
            PreviewColumn {
                number,
                header: channel.unwrap_or(header).to_owned(),
                channel: channel.map(str::to_owned),
                ..PreviewColumn::default()
            }
        };
        PreviewTable {
            name: name.to_owned(),
            columns: (1..).zip(headers).map(column).collect(),
            ..PreviewTable::default()
        }
    }

    fn seen(tables: &[PreviewTable]) -> Vec<(Option<String>, &'static str)> {
        let guesses = guesses(tables).into_iter();
        guesses.map(|guess| (guess.file, guess.channel)).collect()
    }

    #[test]
    fn a_channel_is_guessed_once_and_only_where_it_is_not_there() {
        let one = table(
            "x",
            &[
                "Weg vorne",
                "displacement front",
                "Weg hinten",
                "speed",
                "!v",
            ],
        );
        assert_eq!(seen(&[one]), [(None, "z_r")]);
    }

    #[test]
    fn each_file_has_its_time_and_all_share_the_rest() {
        let files = [
            table("laser.csv", &["Zeit (s)", "Abstand Gabel (mm)"]),
            table("imu.csv", &["time_s", "acc_front_m_s2", "speed"]),
            table("ride.tcx", &["!t", "!v"]),
        ];
        let expected = [
            ("laser.csv", "t"),
            ("laser.csv", "d_f"),
            ("imu.csv", "t"),
            ("imu.csv", "a_f"),
        ];
        let expected = expected.map(|(file, channel)| (Some(file.to_owned()), channel));
        assert_eq!(seen(&files), expected);
        let twice = [table("a", &["Weg vorne"]), table("b", &["disp front"])];
        assert_eq!(seen(&twice), []);
    }
}
