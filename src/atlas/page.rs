//! A page while it is filled: one bit a cell, and the search for the lowest place where a mask fits.
//! All columns are tried at once: a row of the page, smeared over the length of a span, shows where
//! that span cannot begin.

use super::mask::Mask;

/// Cells across a page, at most.
pub(super) const CELLS: u32 = 1024;

/// Words of the widest row.
const WORDS: usize = CELLS as usize / 64;

/// Cells that are taken.
pub(super) struct Page {
    side: u32,
    /// Words of a row, one bit a column.
    words: usize,
    /// Lengths 1, 2, 4 … up to the page's width.
    levels: usize,
    /// For each row and level k the columns from which 2ᵏ cells are not all free …
    rows: Vec<u64>,
    /// … up to this level; those above have yet to be made.
    made: Vec<u8>,
    /// Longest free run of each row.
    free: Vec<u32>,
    /// Rows from here on are empty.
    used: u32,
}

impl Page {
    /// An empty square page of `side` cells, at most [`CELLS`].
    pub fn new(side: u32) -> Self {
        let side = side.min(CELLS);
        let (words, levels) = shape(side);
        let rows = empty(side).repeat(side as usize);
        let made = vec![levels as u8 - 1; side as usize];
        Self { side, words, levels, rows, made, free: vec![side; side as usize], used: 0 }
    }

    /// Empty it again.
    pub fn clear(&mut self) {
        let used = self.used as usize;
        let row = empty(self.side);
        self.rows.chunks_exact_mut(row.len()).take(used).for_each(|r| r.copy_from_slice(&row));
        self.free[..used].fill(self.side);
        self.made[..used].fill(self.levels as u8 - 1);
        self.used = 0;
    }

    /// Bytes of a page of so many cells across.
    pub fn bytes(side: u32) -> u64 {
        let (words, levels) = shape(side.min(CELLS));
        u64::from(side.min(CELLS))
            * (words * levels * size_of::<u64>() + size_of::<u8>() + size_of::<u32>()) as u64
    }

    /// The lowest, then leftmost, cell on which the mask's lower left cell can be put, not below
    /// row `from` and so that the mask ends below row `end`. `work` counts the words looked at.
    pub fn find(&mut self, mask: &Mask, from: u32, end: u32, work: &mut u64) -> Option<(u32, u32)> {
        if mask.width > self.side {
            return None;
        }
        let mut hint = 0;
        let mut y = from;
        // Rows below this one are wide enough for every row of the mask.
        let mut wide = y;
        let top = end.min(self.side);
        while y + mask.height <= top {
            *work += 1;
            while wide < top.min(y + mask.height) {
                if self.free[wide as usize] < mask.least {
                    y = wide + 1;
                }
                wide += 1;
            }
            if y + mask.height > top {
                break;
            }
            if self.free[y as usize + hint] < mask.longest[hint] {
                y += 1;
                continue;
            }
            let mut fits = [!0; WORDS];
            let words = self.words;
            let fits = &mut fits[..words];
            let rows = std::iter::once(hint as u32).chain(mask.order.iter().copied());
            for r in rows {
                let spans = mask.row(r);
                let Some(highest) = spans.iter().map(|s| s[1] - s[0]).max() else { continue };
                let row = self.row(y + r, highest.ilog2() as usize);
                for &[first, last] in spans {
                    // Two spans of the next lower level cover any length.
                    *work += 2 * words as u64;
                    let level = (last - first).ilog2();
                    let row = &row[level as usize * words..][..words];
                    remove(fits, row, first);
                    remove(fits, row, last - (1 << level));
                }
                if fits.iter().all(|&word| word == 0) {
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
        let words = self.words;
        let stride = words * self.levels;
        for r in 0..mask.height {
            let at = (y + r) as usize;
            let row = &mut self.rows[at * stride..(at + 1) * stride];
            for &[first, end] in mask.row(r) {
                fill(&mut row[..words], x + first, x + end);
            }
            self.made[at] = 0;
            self.free[at] = longest_free(&row[..words]);
        }
        self.used = self.used.max(y + mask.height);
    }

    /// The levels of a row up to `level`.
    fn row(&mut self, row: u32, level: usize) -> &[u64] {
        let (row, stride) = (row as usize, self.words * self.levels);
        let made = self.made[row] as usize;
        let levels = &mut self.rows[row * stride..][..stride];
        if made < level {
            smear(&mut levels[made * self.words..(level + 1) * self.words], self.words, made);
            self.made[row] = level as u8;
        }
        levels
    }
}

/// Words and levels of a row of so many cells.
fn shape(side: u32) -> (usize, usize) {
    (side.div_ceil(64) as usize, side.ilog2() as usize + 1)
}

/// All levels of a row that is free.
fn empty(side: u32) -> Vec<u64> {
    let (words, levels) = shape(side);
    let mut row = vec![0; words * levels];
    fill(&mut row[..words], side, 64 * words as u32);
    smear(&mut row, words, 0);
    row
}

/// Set the bits of columns `from..to`.
fn fill(row: &mut [u64], from: u32, to: u32) {
    for (k, word) in row.iter_mut().enumerate() {
        let start = from.saturating_sub(64 * k as u32).min(64);
        let end = to.saturating_sub(64 * k as u32).min(64);
        let below = |n: u32| if n == 64 { !0 } else { (1u64 << n) - 1 };
        *word |= below(end) & !below(start);
    }
}

/// Take out of `fits` the columns from which the row is taken `by` columns further right; beyond the
/// page everything is taken.
fn remove(fits: &mut [u64], row: &[u64], by: u32) {
    let (words, bits) = ((by / 64) as usize, by % 64);
    let (seen, beyond) = fits.split_at_mut(row.len() - words);
    beyond.fill(0);
    let row = &row[words..];
    let next = row[1..].iter().chain(&[!0]);
    for ((fit, &word), &next) in seen.iter_mut().zip(row).zip(next) {
        // Two shifts, as one by 64 is none.
        *fit &= !(word >> bits | next << 1 << (63 - bits));
    }
}

/// Levels of so many words each, from the first one, which is level `made`.
fn smear(row: &mut [u64], words: usize, made: usize) {
    for k in 0..row.len() / words - 1 {
        let (below, level) = row[k * words..].split_at_mut(words);
        let level = &mut level[..words];
        level.iter_mut().zip(&*below).for_each(|(free, taken)| *free = !taken);
        remove(level, below, 1 << (made + k));
        level.iter_mut().for_each(|word| *word = !*word);
    }
}

/// Length of the longest run of free columns.
fn longest_free(row: &[u64]) -> u32 {
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
    fn a_page_that_was_emptied_is_as_good_as_a_new_one() {
        let (disk, uv) = samples::plane(1, 1, 30.0, 17.0);
        let outline = Outline::of(&disk, &uv);
        let mask = |angle: f64| Mask::new(&outline, DVec2::from_angle(angle), 1.0, 0.5, false);
        let fill = |page: &mut Page| -> Vec<Option<(u32, u32)>> {
            let masks = (0..40).map(|k| mask(0.4 * f64::from(k)));
            let put = |mask: Mask| {
                let found = page.find(&mask, 0, u32::MAX, &mut 0);
                found.inspect(|&(x, y)| page.insert(&mask, x, y))
            };
            masks.map(put).collect()
        };
        let mut page = Page::new(130);
        let first = fill(&mut page);
        assert!(first.contains(&None), "the page is full");
        page.clear();
        assert_eq!(fill(&mut page), first);
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
