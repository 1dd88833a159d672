//! What is said of the clocks of a ride's sensors and files.

use crate::RideSummary;
use crate::channels::channel::Channel;
use crate::clocks::sensor_clock::SensorClock;
use crate::file::FileSummary;
use crate::recording::Recording;

/// What clocks of files are compared by.
const ONLY: &str = "only a laser and an accelerometer on the same axle determine it; time stamps and the offset option do not";

/// One clock for each that goes on its own: sensors of one file share its clock.
pub fn apart(clocks: &[SensorClock]) -> impl Iterator<Item = &SensorClock> {
    let mut files: Vec<&String> = Vec::new();
    clocks.iter().filter(move |clock| {
        let Some(file) = &clock.file else { return true };
        let is_new = !files.contains(&file);
        files.push(file);
        is_new
    })
}

/// Says how the clocks were found to go, and of each file whose clock was not compared why it stands as it does.
pub fn note(recording: &mut Recording, clocks: &[SensorClock]) {
    for clock in apart(clocks) {
        if clock.applied || clock.found.is_none() || clock.file.is_some() {
            recording.warnings.push(clock.summary());
        }
        if clock.is_weak()
            && let Some(file) = &clock.file
        {
            recording.warnings.push(format!(
                "the clock of {file} is known less accurately than to 1 ms and 5 ppm: the road is smooth, the ride short or slow, \
                 or the sensors noisy"
            ));
        }
    }
    let beside = |name: &str| {
        clocks
            .iter()
            .any(|c| c.beside_file.as_deref() == Some(name))
    };
    let compared =
        |name: &str| beside(name) || clocks.iter().any(|c| c.file.as_deref() == Some(name));
    let files = || recording.files.iter();
    let reference = (files().find(|f| beside(&f.name)))
        .or(files().find(|f| f.dated))
        .or(files().next());
    let Some(reference) = reference.map(|f| f.name.clone()) else {
        return;
    };
    for file in &mut recording.files {
        if file.name != reference && !compared(&file.name) {
            let why = kept(file, &reference);
            recording.warnings.push(format!("{}: {why}", file.name));
            file.kept = Some(why);
        }
    }
}

/// Clocks that k and B rest on and that nobody knows: those of files that hold a channel of an axle, that neither stamps nor the
/// user place, and that were not compared with another file.
pub fn unknown(summary: &RideSummary, compared: &[SensorClock]) -> Vec<SensorClock> {
    let axle_channel = |file: &FileSummary| {
        let own = (summary.columns.iter()).filter(|c| c.file.as_deref() == Some(&file.name));
        let mut own = own.filter(|c| Channel::named(&c.channel).is_some_and(Channel::is_essential));
        own.next().map(|c| c.channel.clone())
    };
    let is_compared = |file: &FileSummary| {
        let mut files = compared.iter().flat_map(|c| [&c.file, &c.beside_file]);
        files.any(|other| other.as_ref() == Some(&file.name))
    };
    let mut known = (summary.files.iter()).filter_map(|f| Some((f, axle_channel(f)?)));
    let beside = (known.clone()).find(|(f, _)| is_compared(f) || f.dated);
    let Some((reference, beside)) = beside.or(known.next()) else {
        return Vec::new();
    };
    let files = summary
        .files
        .iter()
        .filter(|f| f.name != reference.name && !f.is_placed() && !is_compared(f));
    let unknown = files.filter_map(|file| {
        Some(SensorClock {
            channel: axle_channel(file)?,
            beside: beside.clone(),
            file: Some(file.name.clone()),
            beside_file: Some(reference.name.clone()),
            reason: Some(ONLY.to_owned()),
            ..SensorClock::default()
        })
    });
    unknown.collect()
}

fn kept(file: &FileSummary, reference: &str) -> String {
    let nothing =
        "it records no motion that another file also records, so its clock could not be compared";
    match file.dated {
        true => {
            format!("{nothing}: its dated time stamps are used as they are")
        }
        false => format!(
            "{nothing}: its time stamps have no date, so it was placed at {:.3} s, aligned with {reference}",
            file.from_s
        ),
    }
}
