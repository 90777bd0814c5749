//! Tables of people, and how far an athlete is from them.

use super::curves::{Curve, GaitReport, POINTS};
use crate::asset::read_file::read_text;
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Largest table that is read, bytes.
const MAX_BYTES: u64 = 1 << 20;

/// Why a table cannot be used.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PeopleError {
    /// It cannot be read.
    #[error("{}: {message}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        message: String,
    },
    /// A line is not what it should be.
    #[error("{}, line {line}: {found}; valid: {valid}", path.display())]
    Line {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What is there.
        found: String,
        /// What would be valid.
        valid: String,
    },
    /// A column is missing.
    #[error("{}: no column {column}; valid: one of {known}", path.display())]
    Column {
        /// The file.
        path: PathBuf,
        /// What the name has to contain.
        column: &'static str,
        /// The columns that there are.
        known: String,
    },
}

/// Curves of people, as a laboratory publishes them. What a file does not have is `None`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct People {
    /// Moment of the ankle over the cycle, N m/kg.
    pub ankle_moment: Option<Curve>,
    /// Vertical force over the cycle, body weights.
    pub vertical_force: Option<Curve>,
    /// Where the force acts over the stance, 0 to 1 from heel to toe.
    pub pressure_path: Option<Curve>,
}

/// Straight lines through points (x in percent), at [`POINTS`] places from 0 to 100 %; zero outside.
fn at_points(points: &[(f64, f64)], hold: bool) -> Vec<f64> {
    let value = |x: f64| {
        let next = points.iter().position(|p| p.0 >= x);
        match next {
            Some(0) => {
                if hold || points[0].0 == x {
                    points[0].1
                } else {
                    0.0
                }
            }
            Some(k) => {
                let ((x0, y0), (x1, y1)) = (points[k - 1], points[k]);
                y0 + (y1 - y0) * (x - x0) / (x1 - x0).max(1e-9)
            }
            None => {
                if hold {
                    points.last().map_or(0.0, |p| p.1)
                } else {
                    0.0
                }
            }
        }
    };
    (0..POINTS).map(|k| value(100.0 * k as f64 / (POINTS - 1) as f64)).collect()
}

/// A table of numbers under names.
struct Table {
    names: Vec<String>,
    rows: Vec<Vec<f64>>,
}

/// The tables of a file: each begins with a line of names, with or without `#`; other lines that begin with `#` are remarks.
fn tables(path: &Path) -> Result<Vec<Table>, PeopleError> {
    let text = read_text(path, MAX_BYTES)
        .map_err(|error| PeopleError::Read { path: path.to_path_buf(), message: error.fault.to_string() })?;
    let mut tables: Vec<Table> = Vec::new();
    for (k, line) in text.lines().enumerate() {
        let plain = line.trim().trim_start_matches('#').trim();
        let cells: Vec<&str> = plain.split(',').map(str::trim).collect();
        if plain.is_empty() || (line.starts_with('#') && !cells[0].ends_with("_pct")) {
            continue;
        }
        if cells[0].ends_with("_pct") {
            tables.push(Table { names: cells.into_iter().map(String::from).collect(), rows: Vec::new() });
            continue;
        }
        let fault =
            |found: String, valid: String| PeopleError::Line { path: path.to_path_buf(), line: k + 1, found, valid };
        let numbers: Option<Vec<f64>> = cells.iter().map(|c| c.parse().ok().filter(|x: &f64| x.is_finite())).collect();
        let numbers = numbers.ok_or_else(|| fault(format!("`{plain}`"), "numbers with commas between them".into()))?;
        let Some(table) = tables.last_mut() else {
            return Err(fault("numbers without names".into(), "names first, the first of them in _pct".into()));
        };
        if numbers.len() != table.names.len() {
            return Err(fault(
                format!("{} numbers", numbers.len()),
                format!("{}, one for each name", table.names.len()),
            ));
        }
        if table.rows.last().is_some_and(|before| before[0] >= numbers[0]) {
            return Err(fault(format!("{} %", numbers[0]), "more than in the line before".into()));
        }
        table.rows.push(numbers);
    }
    Ok(tables)
}

impl People {
    /// Reads tables from files, comma separated, each under a line of names of which the first ends in `_pct`: percent of the gait cycle, or of the stance.
    /// Columns are known by their names: `ankle_moment` (N m/kg; the column after it, `sd`, is its deviation), `vertical_grf` (body weights),
    /// `cop_pct` (percent of the foot's length).
    pub fn read(files: &[PathBuf]) -> Result<Self, PeopleError> {
        let mut people = Self::default();
        for path in files {
            let mut known = Vec::new();
            let mut any = false;
            for table in tables(path)? {
                let column = |name: &str| table.names.iter().position(|n| n.contains(name));
                let curve = |k: usize, scale: f64, hold: bool| {
                    let points: Vec<(f64, f64)> = table.rows.iter().map(|r| (r[0], r[k] * scale)).collect();
                    at_points(&points, hold)
                };
                let of = |k: usize, scale: f64, hold: bool| {
                    let sd =
                        table.names.get(k + 1).filter(|n| *n == "sd").map_or(Vec::new(), |_| curve(k + 1, scale, hold));
                    Some(Curve { mean: curve(k, scale, hold), sd })
                };
                if let Some(k) = column("ankle_moment") {
                    (people.ankle_moment, any) = (of(k, 1.0, true), true);
                }
                if let Some(k) = column("vertical_grf") {
                    (people.vertical_force, any) = (of(k, 1.0, false), true);
                }
                if let Some(k) = column("cop_pct") {
                    (people.pressure_path, any) = (of(k, 0.01, true), true);
                }
                known.extend(table.names);
            }
            if !any {
                let column = "ankle_moment, vertical_grf or cop_pct";
                return Err(PeopleError::Column { path: path.clone(), column, known: known.join(", ") });
            }
        }
        Ok(people)
    }
}

/// How near an athlete is to people; `None` where nothing is known of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Agreement {
    /// Correlation of the ankle's moment over the cycle.
    pub ankle_moment_correlation: Option<f64>,
    /// Part of the stance in which it is within one standard deviation.
    pub ankle_moment_within_sd: Option<f64>,
    /// Correlation of the vertical force over the cycle.
    pub vertical_force_correlation: Option<f64>,
    /// Mean distance of the places at which the force acts, as a part of the foot's length.
    pub pressure_path_error: Option<f64>,
}

/// Pearson's correlation.
fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len().min(b.len()).max(1) as f64;
    let (ma, mb) = (a.iter().sum::<f64>() / n, b.iter().sum::<f64>() / n);
    let sum = |f: &dyn Fn(f64, f64) -> f64| a.iter().zip(b).map(|(x, y)| f(x - ma, y - mb)).sum::<f64>();
    sum(&|x, y| x * y) / (sum(&|x, _| x * x) * sum(&|_, y| y * y)).sqrt().max(1e-12)
}

/// Compares a walk with people.
pub fn agreement(report: &GaitReport, people: &People) -> Agreement {
    let stance = (report.stance * (POINTS - 1) as f64).round() as usize + 1;
    let within = |curve: &Curve| {
        let all = report.ankle_moment.mean.iter().zip(&curve.mean).zip(&curve.sd).take(stance);
        let inside = all.clone().filter(|((a, b), sd)| (*a - *b).abs() <= **sd).count();
        (!curve.sd.is_empty()).then(|| inside as f64 / all.count().max(1) as f64)
    };
    let apart = |curve: &Curve| {
        let sum: f64 = report.pressure_path.mean.iter().zip(&curve.mean).map(|(a, b)| (a - b).abs()).sum();
        sum / curve.mean.len().max(1) as f64
    };
    Agreement {
        ankle_moment_correlation: people.ankle_moment.as_ref().map(|c| correlation(&report.ankle_moment.mean, &c.mean)),
        ankle_moment_within_sd: people.ankle_moment.as_ref().and_then(within),
        vertical_force_correlation: people
            .vertical_force
            .as_ref()
            .map(|c| correlation(&report.vertical_force.mean, &c.mean)),
        pressure_path_error: people.pressure_path.as_ref().map(apart),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_are_read_by_name_and_compared() {
        let file = std::env::temp_dir().join(format!("people_{}.csv", std::process::id()));
        let text = "# a remark, of somebody\ngait_pct,ankle_moment_Nm_per_kg,sd\n0,0,0.1\n50,1.5,0.3\n100,0,0.1\n\
                    # stance_pct,cop_pct_of_length\n0,0\n100,100\n";
        std::fs::write(&file, text).unwrap();
        let people = People::read(std::slice::from_ref(&file)).unwrap();
        let moment = people.ankle_moment.clone().unwrap();
        let at = [moment.mean[25], moment.sd[25], moment.mean[50]];
        assert!(at.iter().zip([1.5, 0.3, 0.0]).all(|(a, b)| (a - b).abs() < 1e-12), "{at:?}");
        assert!(people.vertical_force.is_none());
        let mut report = GaitReport { stance: 0.6, ankle_moment: moment.clone(), ..GaitReport::default() };
        report.pressure_path.mean = (0..POINTS).map(|k| k as f64 / 50.0 + 0.05).collect();
        let same = agreement(&report, &people);
        assert!((same.ankle_moment_correlation.unwrap() - 1.0).abs() < 1e-12);
        assert_eq!((same.ankle_moment_within_sd, same.vertical_force_correlation), (Some(1.0), None));
        assert!((same.pressure_path_error.unwrap() - 0.05).abs() < 1e-9);
        report.ankle_moment.mean.iter_mut().for_each(|m| *m = -*m);
        assert!((agreement(&report, &people).ankle_moment_correlation.unwrap() + 1.0).abs() < 1e-12);

        std::fs::write(&file, "gait_pct,ankle_moment,sd\n0,0,0.1\n50,x,0.3\n").unwrap();
        let error = People::read(std::slice::from_ref(&file)).unwrap_err().to_string();
        assert!(error.contains("line 3: `50,x,0.3`; valid: numbers"), "{error}");
        std::fs::write(&file, "gait_pct,knee\n0,0\n").unwrap();
        let error = People::read(std::slice::from_ref(&file)).unwrap_err().to_string();
        assert!(error.contains("no column ankle_moment, vertical_grf or cop_pct"), "{error}");
        std::fs::remove_file(&file).unwrap();
    }
}
