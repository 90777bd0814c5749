//! Matrices cut into strips of 32 columns: the layout in which every product runs over contiguous, aligned memory.

/// Columns of a strip: two vectors of AVX-512, four of AVX2, eight of SSE, NEON or WASM.
pub(super) const WIDTH: usize = 32;

/// Rows are allocated in multiples of this, so that a product has no row tile that is cut off.
pub(super) const ROW_TILE: usize = 8;

/// 32 neighbouring values of one row. Its alignment keeps a vector within one cache line.
#[derive(Clone, Copy)]
#[repr(C, align(128))]
pub(super) struct Strip(pub [f32; WIDTH]);

impl Strip {
    pub const ZERO: Strip = Strip([0.0; WIDTH]);
}

/// A matrix stored panel by panel: panel p holds columns 32 p to 32 p + 31 of every row, one strip a row.
///
/// Columns beyond the last are zero in every row below `rows`; rows between `rows` and the end of their tile hold anything.
#[derive(Clone, Default)]
pub(super) struct Strips {
    rows: usize,
    columns: usize,
    strips: Vec<Strip>,
}

impl Strips {
    /// Gives the matrix a shape; its content is then undefined. Allocates only when it has never been this large.
    pub fn reshape(&mut self, rows: usize, columns: usize) {
        (self.rows, self.columns) = (rows, columns);
        let needed = self.panel_rows() * self.panels();
        if self.strips.len() < needed {
            self.strips.resize(needed, Strip::ZERO);
        }
    }

    pub fn rows(&self) -> usize {
        self.rows
    }

    pub fn columns(&self) -> usize {
        self.columns
    }

    pub fn panels(&self) -> usize {
        self.columns.div_ceil(WIDTH)
    }

    /// Rows of a panel: those of the matrix, up to a full tile.
    fn panel_rows(&self) -> usize {
        self.rows.next_multiple_of(ROW_TILE)
    }

    /// The strips of a panel, one a row, with those that fill the last tile.
    #[inline(always)]
    pub fn panel_tiles(&self, panel: usize) -> &[Strip] {
        let rows = self.panel_rows();
        &self.strips[panel * rows..(panel + 1) * rows]
    }

    /// The strips of a panel, one a row.
    #[inline(always)]
    pub fn panel(&self, panel: usize) -> &[Strip] {
        &self.panel_tiles(panel)[..self.rows]
    }

    /// As `panel_tiles`, to be written.
    #[inline(always)]
    pub fn panel_tiles_mut(&mut self, panel: usize) -> &mut [Strip] {
        let rows = self.panel_rows();
        &mut self.strips[panel * rows..(panel + 1) * rows]
    }

    /// Copies a row-major matrix of `columns` columns.
    pub fn pack(&mut self, source: &[f32], columns: usize) {
        self.reshape(source.len() / columns, columns);
        let rows = self.rows;
        for panel in 0..self.panels() {
            let first = panel * WIDTH;
            let used = WIDTH.min(columns - first);
            for (strip, row) in self.panel_tiles_mut(panel)[..rows].iter_mut().zip(source.chunks_exact(columns)) {
                let values = &row[first..first + used];
                match <&[f32; WIDTH]>::try_from(values) {
                    Ok(whole) => strip.0 = *whole,
                    Err(_) => {
                        strip.0 = [0.0; WIDTH];
                        strip.0[..used].copy_from_slice(values);
                    }
                }
            }
        }
    }

    /// Copies rows from anywhere, each of `columns` values.
    pub fn gather<'a>(&mut self, rows: impl ExactSizeIterator<Item = &'a [f32]>, columns: usize) {
        self.reshape(rows.len(), columns);
        let (panel_rows, panels) = (self.panel_rows(), self.panels());
        for (row, values) in rows.enumerate() {
            let (whole, rest) = values[..columns].as_chunks::<WIDTH>();
            for (panel, whole) in whole.iter().enumerate() {
                self.strips[panel * panel_rows + row].0 = *whole;
            }
            if !rest.is_empty() {
                let last = &mut self.strips[(panels - 1) * panel_rows + row].0;
                *last = [0.0; WIDTH];
                last[..rest.len()].copy_from_slice(rest);
            }
        }
    }

    /// Copies the transpose of a row-major matrix of `depth` columns: its rows become columns here.
    pub fn pack_transposed(&mut self, source: &[f32], depth: usize) {
        self.reshape(depth, source.len() / depth);
        for (panel, rows) in source.chunks(WIDTH * depth).enumerate() {
            let strips = &mut self.panel_tiles_mut(panel)[..depth];
            if rows.len() < WIDTH * depth {
                strips.fill(Strip::ZERO);
            }
            // Eight source rows at a time: as many streams as the processor's prefetcher follows.
            for (group, eight) in rows.chunks(8 * depth).enumerate() {
                for (column, row) in eight.chunks_exact(depth).enumerate() {
                    let lane = group * 8 + column;
                    for (strip, value) in strips.iter_mut().zip(row) {
                        strip.0[lane % WIDTH] = *value;
                    }
                }
            }
        }
    }

    /// Copies the matrix into `target`, row-major.
    pub fn unpack(&self, target: &mut [f32]) {
        for panel in 0..self.panels() {
            let first = panel * WIDTH;
            let used = WIDTH.min(self.columns - first);
            for (row, strip) in target.chunks_exact_mut(self.columns).zip(self.panel(panel)) {
                row[first..first + used].copy_from_slice(&strip.0[..used]);
            }
        }
    }
}
