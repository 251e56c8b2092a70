//! A page while it is filled: one bit a cell, and the search for the lowest place where a mask fits.
//! All columns are tried at once: a row of the page, smeared over the length of a span, shows where
//! that span cannot begin.

use super::mask::Mask;

/// Cells across a page, at most.
pub(super) const CELLS: u32 = 1024;

const WORDS: usize = CELLS as usize / 64;

/// One bit a column.
type Row = [u64; WORDS];

/// Lengths 1, 2, 4 … up to the page's width.
const LEVELS: usize = CELLS.ilog2() as usize + 1;

/// Cells that are taken.
pub(super) struct Page {
    side: u32,
    /// For each row and level k the columns from which 2ᵏ cells are not all free.
    rows: Vec<[Row; LEVELS]>,
    /// Longest free run of each row.
    free: Vec<u32>,
}

impl Page {
    /// An empty square page of `side` cells, at most [`CELLS`].
    pub fn new(side: u32) -> Self {
        let side = side.min(CELLS);
        let mut row = [[0; WORDS]; LEVELS];
        fill(&mut row[0], side, CELLS);
        smear(&mut row);
        Self { side, rows: vec![row; side as usize], free: vec![side; side as usize] }
    }

    /// Bytes of a page of so many cells across.
    pub fn bytes(side: u32) -> u64 {
        u64::from(side.min(CELLS)) * (size_of::<[Row; LEVELS]>() + size_of::<u32>()) as u64
    }

    /// The lowest, then leftmost, cell on which the mask's lower left cell can be put, not below
    /// row `from` and so that the mask ends below row `end`. `work` counts the rows looked at.
    pub fn find(&self, mask: &Mask, from: u32, end: u32, work: &mut u64) -> Option<(u32, u32)> {
        if mask.width > self.side {
            return None;
        }
        let mut hint = 0;
        let mut y = from;
        while y + mask.height <= end.min(self.side) {
            *work += 1;
            let narrow = |r: &usize| self.free[y as usize + r] < mask.longest[*r];
            if narrow(&hint) {
                y += 1;
                continue;
            }
            if let Some(row) = (0..mask.height as usize).find(narrow) {
                hint = row;
                y += 1;
                continue;
            }
            let mut fits = [!0; WORDS];
            let rows = std::iter::once(hint as u32).chain(mask.order.iter().copied());
            for r in rows {
                let row = &self.rows[(y + r) as usize];
                for &[first, last] in mask.row(r) {
                    // Two spans of the next lower level cover any length.
                    *work += 2;
                    let level = (last - first).ilog2();
                    remove(&mut fits, &row[level as usize], first);
                    remove(&mut fits, &row[level as usize], last - (1 << level));
                }
                if fits == [0; WORDS] {
                    hint = r as usize;
                    break;
                }
            }
            if let Some(word) = fits.iter().position(|&f| f != 0) {
                return Some((word as u32 * 64 + fits[word].trailing_zeros(), y));
            }
            y += 1;
        }
        None
    }

    /// Take the cells of a mask whose lower left cell is at (x, y).
    pub fn insert(&mut self, mask: &Mask, x: u32, y: u32) {
        for r in 0..mask.height {
            let row = &mut self.rows[(y + r) as usize];
            for &[first, end] in mask.row(r) {
                fill(&mut row[0], x + first, x + end);
            }
            smear(row);
            self.free[(y + r) as usize] = longest_free(&row[0]);
        }
    }
}

/// Set the bits of columns `from..to`.
fn fill(row: &mut Row, from: u32, to: u32) {
    for (k, word) in row.iter_mut().enumerate() {
        let start = from.saturating_sub(64 * k as u32).min(64);
        let end = to.saturating_sub(64 * k as u32).min(64);
        let below = |n: u32| if n == 64 { !0 } else { (1u64 << n) - 1 };
        *word |= below(end) & !below(start);
    }
}

/// Take out of `fits` the columns from which the row is taken `by` columns further right; beyond the
/// page everything is taken.
fn remove(fits: &mut Row, row: &Row, by: u32) {
    let (words, bits) = ((by / 64) as usize, by % 64);
    let (seen, beyond) = fits.split_at_mut(WORDS - words);
    beyond.fill(0);
    let row = &row[words..];
    let next = row[1..].iter().chain(&[!0]);
    for ((fit, &word), &next) in seen.iter_mut().zip(row).zip(next) {
        // Two shifts, as one by 64 is none.
        *fit &= !(word >> bits | next << 1 << (63 - bits));
    }
}

/// Each level from the one before it.
fn smear(row: &mut [Row; LEVELS]) {
    for k in 1..LEVELS {
        let mut free = row[k - 1].map(|word| !word);
        remove(&mut free, &row[k - 1], 1 << (k - 1));
        row[k] = free.map(|word| !word);
    }
}

/// Length of the longest run of free columns.
fn longest_free(row: &Row) -> u32 {
    let (mut longest, mut run) = (0, 0);
    for &word in row {
        if word == 0 {
            run += 64;
            continue;
        }
        run += word.trailing_zeros();
        longest = longest.max(run);
        let mut rest = word >> word.trailing_zeros();
        let mut left = 64 - word.trailing_zeros();
        run = 0;
        while left > 0 {
            let ones = rest.trailing_ones().min(left);
            left -= ones;
            rest = rest.checked_shr(ones).unwrap_or(0);
            let zeros = if rest == 0 { left } else { rest.trailing_zeros() };
            left -= zeros;
            rest = rest.checked_shr(zeros).unwrap_or(0);
            run = zeros;
            longest = longest.max(run);
        }
    }
    longest.max(run)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::atlas::mask::Outline;
    use crate::device::Seeded;
    use crate::flatten::samples;
    use glam::DVec2;

    /// The lowest, then leftmost, free place, cell by cell.
    fn naive(taken: &[Vec<bool>], mask: &Mask) -> Option<(u32, u32)> {
        let side = taken.len() as u32;
        let free = |x: u32, y: u32| {
            (0..mask.height).all(|r| {
                let columns = mask.row(r).iter().flat_map(|s| s[0]..s[1]);
                columns.into_iter().all(|c| !taken[(y + r) as usize][(x + c) as usize])
            })
        };
        let rows = 0..=side.checked_sub(mask.height)?;
        let last = side.checked_sub(mask.width)?;
        rows.flat_map(|y| (0..=last).map(move |x| (x, y))).find(|&(x, y)| free(x, y))
    }

    #[test]
    fn the_lowest_free_place_is_found() {
        let mut random = Seeded::new(3, 0);
        for side in [64, 100, 130] {
            let mut page = Page::new(side);
            let mut taken = vec![vec![false; side as usize]; side as usize];
            for _ in 0..60 {
                let mut draw = |low: f64, high: f64| low + random.unit_f64() * (high - low);
                let (width, height) = (draw(1.0, 40.0), draw(1.0, 40.0));
                let (disk, uv) = samples::plane(1, 1, width, height);
                let turn = DVec2::from_angle(draw(0.0, 6.0));
                let mask = Mask::new(&Outline::of(&disk, &uv), turn, 1.0, 0.5, false);
                let found = page.find(&mask, 0, u32::MAX, &mut 0);
                assert_eq!(found, naive(&taken, &mask));
                if let Some((x, y)) = found {
                    let top = y + mask.height;
                    assert_eq!(page.find(&mask, y, top, &mut 0), found);
                    assert_eq!(page.find(&mask, 0, top - 1, &mut 0), None);
                    page.insert(&mask, x, y);
                    for r in 0..mask.height {
                        for c in mask.row(r).iter().flat_map(|s| s[0]..s[1]) {
                            taken[(y + r) as usize][(x + c) as usize] = true;
                        }
                    }
                }
            }
            let runs =
                |row: &Vec<bool>| row.split(|&t| t).map(<[bool]>::len).max().unwrap_or(0) as u32;
            assert_eq!(page.free, taken.iter().map(runs).collect::<Vec<_>>());
        }
    }
}
