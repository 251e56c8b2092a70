//! Part labels as text: one integer of −1 (unknown) or more a line, line i for face i.

/// Read labels for a mesh of `faces` faces. Blank lines at the end do not count.
pub fn parse_labels(bytes: &[u8], faces: usize) -> Result<Vec<i32>, String> {
    let text = std::str::from_utf8(bytes).map_err(|_| "the labels are no text".to_owned())?;
    let text = text.strip_prefix('\u{feff}').unwrap_or(text).trim_end();
    let found = if text.is_empty() { 0 } else { text.lines().count() };
    if found != faces {
        return Err(format!(
            "there are {found} labels and the mesh has {faces} faces: give one line a face, in face \
             order"
        ));
    }
    let label = |(i, line): (usize, &str)| {
        let label = line.trim().parse::<i32>().ok().filter(|&label| label >= -1);
        label.ok_or_else(|| {
            let shown: String = line.trim().chars().take(40).collect();
            format!("line {} of the labels is {shown:?}: give an integer, -1 for unknown", i + 1)
        })
    };
    text.lines().enumerate().map(label).collect()
}

#[cfg(test)]
mod tests {
    use super::parse_labels;

    #[test]
    fn one_integer_a_line() {
        assert_eq!(parse_labels(b"3\n-1\r\n 0 \n\n", 3).unwrap(), [3, -1, 0]);
        assert_eq!(parse_labels(b"", 0).unwrap(), [0; 0]);
    }

    #[test]
    fn a_wrong_count_names_both() {
        let error = parse_labels(b"1\n2\n", 5).unwrap_err();
        assert!(error.contains("2 labels") && error.contains("5 faces"), "{error}");
    }

    #[test]
    fn a_wrong_line_is_named() {
        for text in ["1\n-2\n", "1\n\n1", "1\nx\n", "1\n1.0\n", "1\n99999999999\n"] {
            let lines = text.trim_end().lines().count();
            let error = parse_labels(text.as_bytes(), lines).unwrap_err();
            assert!(error.contains("line 2"), "{error}");
        }
        assert!(parse_labels(&[0xFF, 0xFE], 1).is_err());
    }
}
