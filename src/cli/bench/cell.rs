//! A figure in a table.

/// With so many places; a dash where there is none.
pub fn number(x: Option<f64>, places: usize) -> String {
    x.map_or_else(|| "–".to_owned(), |x| format!("{x:.places$}"))
}
