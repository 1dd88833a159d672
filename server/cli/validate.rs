use std::path::{Path, PathBuf};

use clap::Args;
use serde::Serialize;
use veloid_engine::bicycle::{Axle, Bike};
use veloid_engine::document::format_number::{Quantity, fixed, significant};
use veloid_engine::report::model_on_ride::{AxleOnRide, FitOnRide};
use veloid_engine::report::{IdentifiedModel, ModelOnRide};
use veloid_engine::ride::RideFile;

use super::CliError;
use super::arguments::{name, options, read_bike, set, write};
use super::unread::explained;
use crate::options::Options;

/// Compares a model with rides that it was not identified from: how well it predicts them, and what differs.
///
/// A summary goes to stdout. Exit status: 0 every ride was compared, 2 bad input, 1 anything else.
#[derive(Args)]
pub struct Validate {
    /// Report or exported model (JSON), as `veloid identify` writes them with `--json` and `--model`.
    #[arg(value_name = "MODEL")]
    model: PathBuf,
    /// Ride files, each a separate ride.
    #[arg(required = true, value_name = "RIDE")]
    rides: Vec<PathBuf>,
    /// Bike file (JSON) of these rides; the model's when absent.
    #[arg(long)]
    bike: Option<PathBuf>,
    /// Where to write the comparisons (JSON); `-` is stdout, instead of the summary.
    #[arg(long)]
    json: Option<PathBuf>,
    /// Column of a channel in every file, by header text or number, such as `z_f=V2`; may be given more than once.
    #[arg(long, value_name = "CHANNEL=COLUMN")]
    map: Vec<String>,
    /// Sampling rate (Hz) of files without a time column, or whose times are to be replaced.
    #[arg(long, value_name = "HZ")]
    rate: Vec<String>,
    /// Data rows to use, counted from 0, the second exclusive.
    #[arg(long, value_name = "FROM:TO")]
    rows: Vec<String>,
    /// How the tables are laid out, where that is found wrong: as for `veloid identify`.
    #[arg(long, value_name = "KEY=VALUE")]
    layout: Vec<String>,
    /// Probability of calling numbers different that are not.
    #[arg(long)]
    alpha: Option<f64>,
}

/// One ride in the JSON document.
#[derive(Serialize)]
struct OnRide {
    ride: String,
    /// Null where it could not be compared.
    validation: Option<ModelOnRide>,
    /// Why not.
    problem: Option<String>,
}

impl Validate {
    pub fn run(self) -> Result<(), CliError> {
        let options = self.options()?;
        let text = std::fs::read_to_string(&self.model).map_err(CliError::of_file(&self.model))?;
        let model = veloid_engine::read_model(&text).map_err(|source| CliError::Model {
            path: self.model.clone(),
            source,
        })?;
        let bike = match &self.bike {
            Some(path) => read_bike(path)?,
            None => model.bicycle.clone(),
        };
        let compared = self.rides.iter().map(|path| {
            let validation = self.compared(path, &model, &bike, &options);
            OnRide {
                ride: name(path, &self.rides),
                problem: validation.as_ref().err().map(ToString::to_string),
                validation: validation.ok(),
            }
        });
        let compared: Vec<OnRide> = compared.collect();
        let summary: String = compared.iter().map(summary).collect();
        write(self.json.as_deref(), &compared, &summary)?;
        let failed = compared.iter().filter(|ride| ride.problem.is_some());
        match failed.count() {
            0 => Ok(()),
            count => Err(CliError::NotCompared {
                count,
                of: compared.len(),
            }),
        }
    }

    fn options(&self) -> Result<Options, CliError> {
        let mut options = options(&[
            ("map", &self.map),
            ("rate_hz", &self.rate),
            ("rows", &self.rows),
            ("layout", &self.layout),
        ])?;
        set(&mut options.settings.alpha, self.alpha);
        options.validate()?;
        Ok(options)
    }

    fn compared(
        &self,
        path: &Path,
        model: &IdentifiedModel,
        bike: &Bike,
        options: &Options,
    ) -> Result<ModelOnRide, CliError> {
        let bytes = std::fs::read(path).map_err(CliError::of_file(path))?;
        let name = path.display().to_string();
        let files = [RideFile::new(&name, &bytes)];
        let ride = veloid_engine::read(&files, bike, &options.reading)
            .map_err(|fault| explained(fault, &files, &options.reading))?;
        Ok(veloid_engine::compare(
            model,
            &ride,
            bike,
            options.settings.alpha,
        )?)
    }
}

/// One ride as lines of text.
fn summary(ride: &OnRide) -> String {
    let mut lines = vec![ride.ride.clone()];
    lines.extend(
        ride.problem
            .iter()
            .map(|problem| format!("  not compared: {problem}")),
    );
    if let Some(found) = &ride.validation {
        lines.push(format!("  {}", found.sentence));
        let more = (found.warnings.iter()).filter(|why| !found.sentence.contains(*why));
        lines.extend(more.map(|why| format!("  warning: {why}")));
        for (axle, on_axle) in found.axles.iter() {
            lines.extend(rows(axle, on_axle));
        }
        lines.extend(found.left_out.iter().map(|why| format!("  note: {why}")));
    }
    lines.join("\n") + "\n"
}

fn rows(axle: Axle, found: &AxleOnRide) -> Vec<String> {
    let unit = found.predicted.unit();
    let names = found.parameters.iter().map(|p| p.name.len());
    let wide = names.fold("without its effects".len(), usize::max);
    let row = |what: &str, fit: &FitOnRide| {
        format!(
            "  {axle:<6} {what:<wide$}  fit {:>6} %  RMS {}",
            fixed(fit.fit_percent, 2),
            Quantity::rough(fit.rms, 4, unit)
        )
    };
    let mut lines = vec![row("model", &found.model)];
    lines.extend(
        found
            .plain
            .iter()
            .map(|fit| row("without its effects", fit)),
    );
    lines.extend(
        found
            .refitted
            .iter()
            .map(|fit| row("fitted to this ride", fit)),
    );
    lines.extend(found.parameters.iter().map(|p| {
        let [model, ride] = [(p.model, p.model_std_error), (p.ride, p.ride_std_error)]
            .map(|(value, error)| Quantity::new(value, error, &p.unit).to_string());
        let apart = match (p.difference_in_errors, p.differs) {
            (Some(z), Some(true)) => format!("{} standard errors apart", significant(z.abs(), 2)),
            (Some(_), _) => "agree".to_owned(),
            (None, _) => "not compared".to_owned(),
        };
        format!(
            "  {axle:<6} {:<wide$}  model {model}, here {ride}: {apart}",
            p.name
        )
    }));
    lines
}
