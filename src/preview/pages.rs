//! Several pages in one picture: ten in a row, the rows upwards, as UDIM tiles lie.

/// Pages in a row.
const ROW: u32 = 10;

/// Space between pages, page widths.
const GAP: f32 = 0.04;

/// A picture of pages.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pages {
    count: u32,
}

impl Pages {
    /// So many pages, at least one.
    pub fn new(count: u32) -> Self {
        Self { count: count.max(1) }
    }

    /// Every page's number.
    pub fn all(self) -> std::ops::Range<u32> {
        0..self.count
    }

    /// Width and height of the picture, page widths.
    pub fn size(self) -> [f32; 2] {
        let along = |pages: u32| pages as f32 + (pages - 1) as f32 * GAP;
        [along(self.count.min(ROW)), along(self.count.div_ceil(ROW))]
    }

    /// A place on a page, v up, as a place in the picture, y down; page widths.
    pub fn place(self, page: u32, [u, v]: [f32; 2]) -> [f32; 2] {
        let (column, row) = ((page % ROW) as f32, (page / ROW) as f32);
        [column * (1.0 + GAP) + u, self.size()[1] - row * (1.0 + GAP) - v]
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
}
