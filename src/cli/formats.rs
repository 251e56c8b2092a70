//! `uvsegnet formats`: the table of mesh formats, as `docs/formats.md` has it.

use std::io::Write;
use std::path::PathBuf;

use anyhow::{Context, Result};

use crate::contract::{Carry, MeshKind};

/// Arguments of `uvsegnet formats`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Where it goes; standard output if not given.
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
}

/// Run it.
pub fn run(args: Args) -> Result<()> {
    let text = markdown();
    match args.output {
        Some(path) => {
            std::fs::write(&path, text).with_context(|| format!("cannot write {}", path.display()))
        }
        None => std::io::stdout().write_all(text.as_bytes()).context("cannot write"),
    }
}

/// The document.
fn markdown() -> String {
    let mut text = String::from(
        "# Mesh formats\n\n\
         Made by `uvsegnet formats` from the table in `src/contract/format.rs`. What a file is, its first\n\
         bytes tell; an ending or a media type only has to agree. A file must hold everything itself: no\n\
         other file is opened.\n\n\
         | format | read | written | endings | media types | what is read besides triangles |\n\
         |---|---|---|---|---|---|\n",
    );
    for kind in MeshKind::ALL {
        let read = if kind.note().is_empty() { "yes" } else { kind.note() };
        let written = if kind.is_written() { "yes" } else { "no" };
        let endings = kind.endings().iter().map(|ending| format!("`.{ending}`"));
        let types = kind.media_types().iter().map(|media_type| format!("`{media_type}`"));
        let carries = kind.carries().iter().map(|carry: &Carry| carry.as_str().to_owned());
        let cells = [
            kind.name().to_owned(),
            read.to_owned(),
            written.to_owned(),
            cell(endings),
            cell(types),
            cell(carries),
        ];
        text.push_str(&format!("| {} |\n", cells.join(" | ")));
    }
    text
}

fn cell(items: impl Iterator<Item = String>) -> String {
    items.collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    #[test]
    fn committed_document_is_what_the_table_says() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/formats.md");
        let committed = std::fs::read_to_string(path).unwrap();
        assert!(
            committed == super::markdown(),
            "docs/formats.md is stale: run `cargo run --release -- formats -o docs/formats.md`"
        );
    }
}
