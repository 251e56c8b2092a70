//! Several pages in one picture: ten in a row, the rows upwards, as UDIM tiles lie; or the first few of them
//! larger, four in a row, the rows downwards.

/// Pages in a row, as UDIM tiles lie.
const ROW: u32 = 10;

/// Large pages in a row, and how many of them there are.
const LARGE_ROW: u32 = 4;
const MOST_LARGE: u32 = 16;

/// Space between pages, page widths.
const GAP: f32 = 0.04;

/// A picture of pages.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pages {
    count: u32,
    row: u32,
    downwards: bool,
}

impl Pages {
    /// So many pages, at least one.
    pub fn new(count: u32) -> Self {
        Self { count: count.max(1), row: ROW, downwards: false }
    }

    /// The first of so many pages, to be drawn larger. `None` where one page is all there is.
    pub fn large(count: u32) -> Option<Self> {
        let few = count.min(MOST_LARGE);
        (count > 1).then_some(Self { count: few, row: LARGE_ROW, downwards: true })
    }

    /// Whether a page is among those that are drawn.
    pub fn has(self, page: u32) -> bool {
        page < self.count
    }

    /// Every page's number.
    pub fn all(self) -> std::ops::Range<u32> {
        0..self.count
    }

    /// Width and height of the picture, page widths.
    pub fn size(self) -> [f32; 2] {
        let along = |pages: u32| pages as f32 + (pages - 1) as f32 * GAP;
        [along(self.count.min(self.row)), along(self.count.div_ceil(self.row))]
    }

    /// A place on a page, v up, as a place in the picture, y down; page widths.
    pub fn place(self, page: u32, [u, v]: [f32; 2]) -> [f32; 2] {
        let (column, row) = ((page % self.row) as f32, (page / self.row) as f32);
        let below = match self.downwards {
            true => row * (1.0 + GAP) + 1.0,
            false => self.size()[1] - row * (1.0 + GAP),
        };
        [column * (1.0 + GAP) + u, below - v]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pages_stand_side_by_side_and_then_above() {
        assert_eq!(Pages::new(1).size(), [1.0, 1.0]);
        assert_eq!(Pages::new(1).place(0, [0.25, 0.25]), [0.25, 0.75]);
        let many = Pages::new(13);
        let [width, height] = many.size();
        assert!(width > 10.0 && height > 2.0 && height < 2.1);
        // Tile 1011 is above tile 1001.
        assert!(many.place(10, [0.0, 0.0])[1] < many.place(0, [0.0, 1.0])[1]);
        let corners = many.all().flat_map(|p| [[0.0, 0.0], [1.0, 1.0]].map(|c| many.place(p, c)));
        let inside = |[x, y]: [f32; 2]| (0.0..=width).contains(&x) && (0.0..=height).contains(&y);
        assert!(corners.into_iter().all(inside));
    }

    #[test]
    fn the_first_pages_are_drawn_larger_from_the_top_down() {
        assert!(Pages::large(1).is_none());
        let large = Pages::large(30).unwrap();
        assert_eq!(large.all(), 0..16);
        assert!(large.has(15) && !large.has(16));
        assert_eq!(large.place(0, [0.0, 1.0]), [0.0, 0.0]);
        assert!(large.place(4, [0.0, 1.0])[1] > large.place(0, [0.0, 0.0])[1]);
    }
}
