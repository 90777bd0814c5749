//! The curve of a training: the CSV file that `athlete train` keeps in its folder.

use crate::asset::read_file::read_text;
use std::path::{Path, PathBuf};

/// Largest file that is read, bytes.
const MOST_BYTES: u64 = 64 << 20;

/// A table of numbers by column; a cell without a number is NaN.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CurveTable {
    names: Vec<String>,
    columns: Vec<Vec<f64>>,
}

/// Why a curve file was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CurveError {
    /// The file could not be read.
    #[error("{}: {reason}; valid: a folder with curve.csv, or a CSV file", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// What the system said.
        reason: String,
    },
    /// There is no header.
    #[error("no header; valid: a first line of column names with `{wanted}`")]
    Header {
        /// A column that must be there.
        wanted: &'static str,
    },
    /// A line has another number of cells.
    #[error("line {line}: {found} cells; valid: {wanted}, as in the header")]
    Cells {
        /// Line, from 1.
        line: usize,
        /// Cells found.
        found: usize,
        /// Cells of the header.
        wanted: usize,
    },
    /// A cell is no number.
    #[error("line {line}, column {column}: `{found}`; valid: a number or nothing")]
    Number {
        /// Line, from 1.
        line: usize,
        /// Name of the column.
        column: String,
        /// What it holds.
        found: String,
    },
}

impl CurveTable {
    /// Reads the text of a CSV file with a column `seconds`. A last line that is still being written (no line end) is
    /// left out.
    pub fn from_csv(text: &str) -> Result<Self, CurveError> {
        let whole = text.rfind('\n').map_or("", |end| &text[..end]);
        let mut lines = whole.lines().enumerate();
        let names: Vec<String> =
            lines.next().map_or_else(Vec::new, |(_, head)| head.split(',').map(|n| n.trim().to_owned()).collect());
        if !names.iter().any(|n| n == "seconds") {
            return Err(CurveError::Header { wanted: "seconds" });
        }
        let mut columns = vec![Vec::new(); names.len()];
        for (number, line) in lines.filter(|(_, line)| !line.trim().is_empty()) {
            let cells: Vec<&str> = line.split(',').map(str::trim).collect();
            if cells.len() != names.len() {
                return Err(CurveError::Cells { line: number + 1, found: cells.len(), wanted: names.len() });
            }
            for ((cell, column), name) in cells.into_iter().zip(&mut columns).zip(&names) {
                let value = if cell.is_empty() { Ok(f64::NAN) } else { cell.parse() };
                column.push(value.map_err(|_| CurveError::Number {
                    line: number + 1,
                    column: name.clone(),
                    found: cell.chars().take(40).collect(),
                })?);
            }
        }
        Ok(Self { names, columns })
    }

    /// Reads a file, or `curve.csv` in a folder.
    pub fn load(path: &Path) -> Result<Self, CurveError> {
        let path = curve_file(path);
        let failed = |reason: String| CurveError::File { path: path.clone(), reason };
        Self::from_csv(&read_text(&path, MOST_BYTES).map_err(|e| failed(e.fault.to_string()))?)
    }

    /// Names of the columns.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// The numbers of a column.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        self.names.iter().position(|n| n == name).map(|k| self.columns[k].as_slice())
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, Vec::len)
    }

    /// The last number of a column.
    pub fn last(&self, name: &str) -> Option<f64> {
        self.column(name)?.iter().rev().copied().find(|v| v.is_finite())
    }

    /// Places (seconds, value) of a column where it has a number.
    pub fn points(&self, name: &str) -> Vec<[f64; 2]> {
        let (Some(x), Some(y)) = (self.column("seconds"), self.column(name)) else { return Vec::new() };
        x.iter().zip(y).filter(|(x, y)| x.is_finite() && y.is_finite()).map(|(x, y)| [*x, *y]).collect()
    }
}

/// The file at a path, `curve.csv` where it is a folder.
pub(super) fn curve_file(path: &Path) -> PathBuf {
    if path.is_dir() { path.join("curve.csv") } else { path.to_path_buf() }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "iteration,seconds,reward,survival\n1,0.5,0.1,\n2,1.0,0.2,0.25\n";

    #[test]
    fn columns_are_read_by_name_and_gaps_stay_gaps() {
        let table = CurveTable::from_csv(TEXT).unwrap();
        assert_eq!(table.rows(), 2);
        assert_eq!(table.points("reward"), [[0.5, 0.1], [1.0, 0.2]]);
        assert_eq!(table.points("survival"), [[1.0, 0.25]]);
        assert_eq!(table.last("survival"), Some(0.25));
        assert!(table.points("nothing").is_empty());
    }

    #[test]
    fn a_line_that_is_being_written_is_left_out() {
        let table = CurveTable::from_csv(&format!("{TEXT}3,1.5")).unwrap();
        assert_eq!(table.rows(), 2);
    }

    #[test]
    fn bad_files_are_refused_with_the_place() {
        assert!(matches!(CurveTable::from_csv(""), Err(CurveError::Header { .. })));
        assert!(matches!(CurveTable::from_csv("a,b\n1,2\n"), Err(CurveError::Header { .. })));
        let cells = CurveTable::from_csv(&format!("{TEXT}1,2\n"));
        assert_eq!(cells, Err(CurveError::Cells { line: 4, found: 2, wanted: 4 }));
        let number = CurveTable::from_csv("seconds,reward\n1,\u{1f60a}\n").unwrap_err();
        assert!(number.to_string().contains("line 2, column reward"), "{number}");
        assert!(matches!(CurveTable::load(Path::new("/nowhere/at/all")), Err(CurveError::File { .. })));
    }
}
