//! Why a ride file was turned down.

use std::fmt;

use crate::clocks::rates::RATES;

/// A rejected ride file: where the fault lies and what was expected instead.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadError {
    pub(super) file: String,
    pub(super) line: Option<usize>,
    pub(super) sample: Option<usize>,
    pub(super) column: Option<(usize, String)>,
    /// What is wrong.
    pub problem: Box<Problem>,
}

impl ReadError {
    /// Name of the file, as given to [`super::read`].
    pub fn file(&self) -> &str {
        &self.file
    }

    /// Line of the fault, counted from 1 as an editor does.
    pub fn line(&self) -> Option<usize> {
        self.line
    }

    /// Sample of the fault in a file without lines (.mat), counted from 1.
    pub fn sample(&self) -> Option<usize> {
        self.sample
    }

    /// Column of the fault, counted from 1, and its header text (empty without a header).
    pub fn column(&self) -> Option<(usize, &str)> {
        self.column.as_ref().map(|(n, name)| (*n, name.as_str()))
    }

    /// Stable slug of the kind of fault, for problem types.
    pub fn kind(&self) -> &'static str {
        self.problem.kind()
    }

    /// Names the file, where it is not named yet.
    pub(super) fn in_file(mut self, file: &str) -> Self {
        if self.file.is_empty() {
            self.file = file.to_owned();
        }
        self
    }

    pub(super) fn at_line(mut self, line: usize) -> Self {
        self.line = Some(line);
        self
    }

    /// In a file without lines.
    pub(super) fn at_sample(mut self, sample: usize) -> Self {
        self.sample = Some(sample);
        self
    }

    pub(super) fn in_column(mut self, number: usize, header: &str) -> Self {
        self.column = Some((number, header.to_owned()));
        self
    }
}

impl From<Problem> for ReadError {
    fn from(problem: Problem) -> Self {
        Self {
            file: String::new(),
            line: None,
            sample: None,
            column: None,
            problem: Box::new(problem),
        }
    }
}

impl std::error::Error for ReadError {}

impl fmt::Display for ReadError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.file)?;
        if let Some(line) = self.line {
            write!(f, ", line {line}")?;
        }
        if let Some(sample) = self.sample {
            write!(f, ", sample {sample}")?;
        }
        match &self.column {
            Some((number, name)) if name.is_empty() => write!(f, ", column {number}")?,
            Some((number, name)) => write!(f, ", column {number} ({name})")?,
            None => {}
        }
        write!(f, ": {}", self.problem)
    }
}

/// What is wrong, with the numbers, and what was expected.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs, reason = "the messages say what each is")]
pub enum Problem {
    #[error("the file is empty, expected a header line and rows of numbers")]
    EmptyFile,
    #[error(
        "this is {what}, expected text (CSV), gzip, zstd, a MATLAB v4/v5/v7 .mat file, .fit, .gpx, .tcx or .xlsx"
    )]
    BinaryFile { what: String },
    #[error("this is {what}, which this build cannot read: it lacks the feature `{feature}`")]
    NotBuilt {
        what: &'static str,
        feature: &'static str,
    },
    #[error("there is a header, but no row of numbers below it")]
    HeaderOnly,
    #[error(
        "this is not a table of numbers: no cell in the {rows} line(s) below \"{first}\" is a number"
    )]
    NoTable { first: String, rows: usize },
    #[error(
        "there is no header, expected channel names ({known}) or a mapping by number such as z_f=2"
    )]
    NoHeader { known: String },
    #[error(
        "this is JSON, which is not read: export the ride as CSV, with a line of column names and a line of numbers for each sample"
    )]
    Json,
    #[error("{bytes} bytes, expected at most {limit}")]
    TooLarge { bytes: u64, limit: u64 },
    #[error("more than {limit} {what}")]
    TooMany { what: &'static str, limit: usize },
    #[error("the line is longer than {limit} bytes")]
    LineTooLong { limit: usize },
    #[error("the cell is {bytes} bytes long, expected a number of at most {limit}")]
    CellTooLong { bytes: usize, limit: usize },
    #[error("a {what} in the workbook is longer than {limit} {unit}")]
    PartTooLong {
        what: &'static str,
        limit: usize,
        unit: &'static str,
    },
    #[error(
        "{packed} compressed bytes expand to more than {limit} {what}: rejected as a compression bomb"
    )]
    GzipBomb {
        packed: usize,
        what: &'static str,
        limit: u64,
    },
    #[error("the {format} data is damaged: {cause}")]
    Corrupt { format: &'static str, cause: String },
    #[error(
        "complex numbers, expected real ones: save real({variable}) or imag({variable}), or abs({variable}) \
         if it is an amplitude"
    )]
    ComplexNumbers { variable: String },
    #[error(
        "{objects}: a table or object, which only MATLAB can read: save table2struct(T, 'ToScalar', true) of the table T"
    )]
    MatObjects { objects: String },
    #[error("MATLAB v7.3 (HDF5), expected v5 or v7: save it with the flag -v7")]
    MatV73,
    #[error("{}, expected {expected}", cells(*found))]
    RaggedRow { found: usize, expected: usize },
    #[error("the file ends within the line, expected a complete line")]
    CutShort,
    #[error(
        "{first}; {damaged} of {lines} lines are damaged, expected at most 1 %: the rows before the first can be read alone with rows 0:{rows} \
         (--rows 0:{rows})"
    )]
    Damaged {
        /// What is wrong with the first.
        first: Box<Problem>,
        damaged: usize,
        lines: usize,
        /// Rows before it.
        rows: usize,
    },
    #[error(
        "the sign in its numbers is that of thousands in some cells and a decimal sign in others, expected one of the two"
    )]
    MixedSigns,
    #[error("'{cell}' is not a number, expected one with a decimal {decimal}, or a blank cell")]
    NotANumber { cell: String, decimal: &'static str },
    #[error("'{cell}' is not finite, expected a number or a blank cell")]
    NotFinite { cell: String },
    #[error("{value:?} is beyond {limit:e}, expected a measured value")]
    OutOfRange { value: f64, limit: f64 },
    #[error("unknown unit '{unit}' for {channel}, expected {expected}")]
    UnknownUnit {
        unit: String,
        channel: &'static str,
        expected: String,
    },
    #[error("'{cell}' has no unit or another one, expected {unit} as in the cells before")]
    OtherUnit { cell: String, unit: String },
    #[error("the unit is {header}, but {cells} in the cells, expected one unit")]
    UnitsDiffer { header: String, cells: String },
    #[error("{channel} is already in column {first}, expected it once")]
    DuplicateColumn { channel: String, first: usize },
    #[error("the mapping names the channel '{channel}', expected one of {known}")]
    UnknownChannel { channel: String, known: String },
    #[error("the mapping {channel}={column} names no column of the file, expected one of {found}")]
    MissingColumn {
        channel: String,
        column: String,
        found: String,
    },
    #[error(
        "the mapping {channel}={column} may be one of several columns, expected one of {found}, with its unit"
    )]
    AmbiguousColumn {
        channel: String,
        column: String,
        found: String,
    },
    #[error("option {name}: {value}, expected {expected}")]
    BadOption {
        name: &'static str,
        value: String,
        expected: &'static str,
    },
    #[error(
        "the stamps take {stamped_s:.3} s, the rows at {rate_hz} Hz {rows_s:.3} s: rows are missing or repeated, or the rate is another; \
         read a part without a gap with --rows FROM:TO (rows), or leave the rate out"
    )]
    RowsMissing {
        stamped_s: f64,
        rows_s: f64,
        rate_hz: f64,
    },
    #[error("rows {from}:{to} of {rows}, expected FROM before TO and both within the file")]
    BadRows { from: usize, to: usize, rows: usize },
    #[error(
        "there is no time: expected a column t, a mapping such as t=..., or a rate in Hz (found {found})"
    )]
    TimeMissing { found: String },
    #[error(
        "'{cell}' is not in the form of the times before it, expected all numbers or all dates with times of day"
    )]
    OtherTime { cell: String },
    #[error("{channel} is already in {first}, expected it in one file")]
    ChannelTwice {
        channel: &'static str,
        first: String,
    },
    #[error("options are given for the file '{file}', expected one of {known}")]
    UnknownFile { file: String, known: String },
    #[error("two of the files have this name, expected different names")]
    SameName,
    #[error("{files} files, expected one to {limit}")]
    FileCount { files: usize, limit: usize },
    #[error(
        "no channel is recognised, expected at least one or a mapping such as {example}=... (found {found})"
    )]
    NoChannel { example: String, found: String },
    #[error(
        "the files do not overlap in time: {spans}; give an offset for a file whose time stamps start at an arbitrary time"
    )]
    FilesApart { spans: String },
    #[error("the time is blank in a row with values, expected a time stamp")]
    TimeBlank,
    #[error(
        "one sample every {:e} s, expected a rate of {RATES}: is the unit of the time right?",
        six_digits(*step_s)
    )]
    RateOutOfRange { step_s: f64 },
    #[error(
        "{repeated} of {stamps} time stamps repeat the previous one or come within a third of a step of it, \
         expected even stamps, or jitter of at most half a step: if the samples are evenly spaced, give their rate with rate_hz (--rate HZ)"
    )]
    TimeRepeats { repeated: usize, stamps: usize },
    #[error(
        "{missing_s:.1} s of {total_s:.1} s are missing, expected gaps of at most a quarter; \
         select a stretch without gaps with rows FROM:TO"
    )]
    GapTooLong { missing_s: f64, total_s: f64 },
    #[error(
        "no axle has a displacement: expected z_f or z_r, or d and a to compute it from, or a_f, a_r and v, \
         which need no road (found {found})"
    )]
    AxleMissing { found: String },
    #[error(
        "u_r is missing, and deriving it from u_f requires {missing}; expected that or a column u_r"
    )]
    RearRoadMissing { missing: &'static str },
    #[error(
        "{implausible} of {samples} samples of {channel} are far outside the range of all others, the first at {value}; \
         expected at most one in a hundred"
    )]
    Implausible {
        channel: &'static str,
        implausible: usize,
        samples: usize,
        value: String,
    },
    #[error("{samples} samples, expected at least {least}")]
    TooShort { samples: usize, least: usize },
    #[error(
        "{samples} samples of {channel} can be trusted (the rest is clipped, missing or outside \
         what the sensors reach), expected at least {least}{doubt}"
    )]
    Untrusted {
        channel: &'static str,
        samples: usize,
        least: usize,
        /// What may be wrong instead, if the rate is unusual.
        doubt: String,
    },
    #[error("{channel} is constant at {value:?}, expected it to vary")]
    Constant { channel: &'static str, value: f64 },
    #[error(
        "{channel} moves, but no excitation is recorded (no road, no force), and it neither decays nor oscillates at a steady \
         frequency as a free decay would: record the road, the force, or the axle's acceleration as well"
    )]
    NotExcited { channel: &'static str },
    #[error(
        "no point has a speed: the {points} points of the track have positions and times only, expected a speed in each; \
         export the ride with speeds, as FIT or TCX for example"
    )]
    NoSpeed { points: usize },
    #[error(
        "{field}: an array of structures, whose vectors are named {vectors} here; map them to channels, with a time or a rate, \
         or save each as a vector of its own"
    )]
    MatStructures { field: String, vectors: String },
    #[error(
        "the {formulas} formulas of sheet \"{sheet}\" have no stored values, expected numbers: open the workbook in a spreadsheet \
         program and save it, or save the sheet as CSV"
    )]
    NoFormulaValues { sheet: String, formulas: usize },
}

fn cells(found: usize) -> String {
    match found {
        1 => "1 cell".to_owned(),
        n => format!("{n} cells"),
    }
}

fn six_digits(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

impl Problem {
    /// Stable slug of the kind.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::EmptyFile => "empty-file",
            Self::BinaryFile { .. } => "binary-file",
            Self::NotBuilt { .. } => "not-built",
            Self::HeaderOnly => "header-only",
            Self::NoTable { .. } => "no-table",
            Self::NoHeader { .. } => "no-header",
            Self::Json => "json",
            Self::TooLarge { .. } => "too-large",
            Self::TooMany { .. } => "too-many",
            Self::LineTooLong { .. } => "line-too-long",
            Self::CellTooLong { .. } => "cell-too-long",
            Self::PartTooLong { .. } => "part-too-long",
            Self::GzipBomb { .. } => "gzip-bomb",
            Self::Corrupt { .. } => "corrupt-file",
            Self::ComplexNumbers { .. } => "complex-numbers",
            Self::MatObjects { .. } => "mat-objects",
            Self::MatV73 => "mat-v73",
            Self::RaggedRow { .. } => "ragged-row",
            Self::CutShort => "cut-short",
            Self::Damaged { first, .. } => first.kind(),
            Self::MixedSigns => "mixed-signs",
            Self::NotANumber { .. } => "not-a-number",
            Self::NotFinite { .. } => "not-finite",
            Self::OutOfRange { .. } => "out-of-range",
            Self::UnknownUnit { .. } => "unknown-unit",
            Self::OtherUnit { .. } => "other-unit",
            Self::UnitsDiffer { .. } => "units-differ",
            Self::DuplicateColumn { .. } => "duplicate-column",
            Self::UnknownChannel { .. } => "unknown-channel",
            Self::MissingColumn { .. } => "missing-column",
            Self::AmbiguousColumn { .. } => "ambiguous-column",
            Self::BadOption { .. } => "bad-option",
            Self::RowsMissing { .. } => "rows-missing",
            Self::BadRows { .. } => "bad-rows",
            Self::TimeMissing { .. } => "time-missing",
            Self::TimeBlank => "time-blank",
            Self::OtherTime { .. } => "other-time",
            Self::ChannelTwice { .. } => "channel-twice",
            Self::UnknownFile { .. } => "unknown-file",
            Self::SameName => "same-name",
            Self::FileCount { .. } => "file-count",
            Self::NoChannel { .. } => "no-channel",
            Self::FilesApart { .. } => "files-apart",
            Self::TimeRepeats { .. } => "time-not-increasing",
            Self::RateOutOfRange { .. } => "rate-out-of-range",
            Self::GapTooLong { .. } => "gap-too-long",
            Self::AxleMissing { .. } => "axle-missing",
            Self::RearRoadMissing { .. } => "rear-road-missing",
            Self::Implausible { .. } => "wild-samples",
            Self::TooShort { .. } => "too-short",
            Self::Untrusted { .. } => "untrusted",
            Self::Constant { .. } => "constant",
            Self::NotExcited { .. } => "not-excited",
            Self::NoSpeed { .. } => "no-speed",
            Self::MatStructures { .. } => "mat-structures",
            Self::NoFormulaValues { .. } => "no-formula-values",
        }
    }
}
