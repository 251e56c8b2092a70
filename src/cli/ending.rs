//! The ending of a file that is to be written says what will stand in it: one that cannot be written is
//! refused before the work, and so is a place that does not exist.

use std::path::{Path, PathBuf};

use clap::builder::{PathBufValueParser, TypedValueParser};

use crate::contract::ArtifactKind;

/// A parser of paths that end as one of these kinds does, or have no ending.
pub fn of(kinds: Vec<ArtifactKind>) -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(move |path| checked(path, &kinds))
}

/// Which of these kinds a path means by its ending; without one, none.
pub fn kind(path: &Path, kinds: &[ArtifactKind]) -> Option<ArtifactKind> {
    let ending = path.extension()?.to_str()?;
    kinds.iter().copied().find(|kind| ending.eq_ignore_ascii_case(kind.ending()))
}

/// The path, if it ends as one of these kinds does, or not at all, and its folder is there.
pub fn checked(path: PathBuf, kinds: &[ArtifactKind]) -> Result<PathBuf, String> {
    if let Some(ending) = path.extension()
        && kind(&path, kinds).is_none()
    {
        let can: Vec<String> = kinds.iter().map(|kind| format!(".{}", kind.ending())).collect();
        return Err(format!(
            ".{} cannot be written here; what can: {}",
            ending.to_string_lossy(),
            can.join(", ")
        ));
    }
    if path.is_dir() {
        return Err("it is a folder: name a file in it".into());
    }
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() && !folder.is_dir() => {
            Err(format!("there is no folder {}: make it first", folder.display()))
        }
        _ => Ok(path),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_ending_says_what_is_written_and_another_is_refused() {
        let both = [ArtifactKind::Model, ArtifactKind::Metrics];
        let check = |path: &str| checked(path.into(), &both);
        assert_eq!(check("x.glb"), Ok("x.glb".into()));
        assert_eq!(check("X.GLB"), Ok("X.GLB".into()));
        assert_eq!(check("x"), Ok("x".into()));
        assert_eq!(kind(Path::new("x.JSON"), &both), Some(ArtifactKind::Metrics));
        assert_eq!(kind(Path::new("x"), &both), None);
        assert_eq!(
            check("x.obj"),
            Err(".obj cannot be written here; what can: .glb, .json".into())
        );
        assert!(check(".").unwrap_err().contains("a folder"));
        assert!(check("no/such/x.glb").unwrap_err().contains("there is no folder no/such"));
    }
}
