//! `uvsegnet reference`: the tables of options, formats, files, warnings and error codes as documentation, made from
//! the tables in the source. Tests hold what is committed against it.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, anyhow};

use crate::contract::{
    ArtifactKind, ErrorCode, MeshKind, OptionGroup, OptionInfo, UnwrapOptions, WarningCode,
};

/// The page, from the top of the tree.
const PAGE: &str = "docs/reference.md";

/// Where README.md has the options.
const MARKS: [&str; 2] =
    ["<!-- options, made by `uvsegnet reference` -->\n", "<!-- end of options -->\n"];

/// Options that README.md leaves to the page.
const NOT_IN_README: [&str; 9] = [
    "losses",
    "width",
    "steps",
    "points",
    "seed",
    "uv_channel",
    "atlas",
    "max_charts",
    "budget_mib",
];

/// Arguments of `uvsegnet reference`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Top of the source tree: docs/reference.md is written there, and the options of README.md.
    #[arg(default_value = ".")]
    pub tree: PathBuf,
}

/// Run it.
pub fn run(args: Args) -> Result<()> {
    let write = |path: &Path, text: String| {
        std::fs::write(path, text).with_context(|| format!("cannot write {}", path.display()))
    };
    write(&args.tree.join(PAGE), page())?;
    let readme = args.tree.join("README.md");
    let text = std::fs::read_to_string(&readme)
        .with_context(|| format!("cannot read {}", readme.display()))?;
    let text = with_options(&text).ok_or_else(|| anyhow!("README.md lacks the marks {MARKS:?}"))?;
    write(&readme, text)
}

/// README.md with its options as they are.
fn with_options(readme: &str) -> Option<String> {
    let start = readme.find(MARKS[0])? + MARKS[0].len();
    let end = start + readme[start..].find(MARKS[1])?;
    let told = |o: &OptionInfo| !NOT_IN_README.contains(&o.name);
    let options: Vec<OptionInfo> = UnwrapOptions::table().into_iter().filter(told).collect();
    Some(format!("{}{}{}", &readme[..start], table(&options), &readme[end..]))
}

fn page() -> String {
    let mut page = "# Reference\n\nMade from the tables in the source by `uvsegnet reference`.\n\n\
        ## Options\n\nOne name everywhere: in the JSON of a request and in its query (`page_size`), and as a flag \
        of the command line (`--page-size`).\n"
        .to_owned();
    let options = UnwrapOptions::table();
    for group in OptionGroup::ALL {
        let own: Vec<OptionInfo> = options.iter().filter(|o| o.group == group).cloned().collect();
        let _ = write!(page, "\n### {}\n\n{}", group.heading(), table(&own));
    }
    page += "\n## Formats\n\nWhat a file is, its first bytes tell; an ending or a media type only has to agree. A \
        file must hold everything itself: no other file is opened.\n\n\
        | format | read | written | endings | media types | what is read besides triangles |\n\
        |---|---|---|---|---|---|\n";
    for kind in MeshKind::ALL {
        let (name, written) = (kind.name(), if kind.is_written() { "yes" } else { "no" });
        let read = if kind.note().is_empty() { "yes" } else { kind.note() };
        let endings = list(kind.endings().iter().map(|ending| format!("`.{ending}`")));
        let types = list(kind.media_types().iter().map(|media_type| format!("`{media_type}`")));
        let carries = list(kind.carries().iter().map(|carry| carry.as_str().to_owned()));
        let _ = writeln!(page, "| {name} | {read} | {written} | {endings} | {types} | {carries} |");
    }
    page += "\n## Files\n\n| file | media type | flag of `unwrap` | what it is | written |\n|---|---|---|---|---|\n";
    for kind in ArtifactKind::ALL {
        let flag = match kind.flag() {
            "" => "–".to_owned(),
            flag => format!("`--{flag}`"),
        };
        let (name, media_type) = (kind.name(), kind.media_type());
        let (what, when) = (kind.what(), kind.when().as_str());
        let _ = writeln!(page, "| `{name}` | `{media_type}` | {flag} | {what} | {when} |");
    }
    page += "\n## Warnings\n\nIn the event `warning`, and on standard error of the command line. The job goes on.\n\n\
        | code | meaning |\n|---|---|\n";
    for code in WarningCode::ALL {
        let _ = writeln!(page, "| `{}` | {} |", code.as_str(), code.meaning());
    }
    page += "\n## Error codes\n\nEvery error of the API is `application/problem+json` \
        ([RFC 9457](https://www.rfc-editor.org/rfc/rfc9457)) with `type` (an address of the service that says \
        what the code means), `title`, `status`, `detail` (what is wrong this time, where, and how to mend it), \
        `code`, `request_id` (also the header `X-Request-Id`, and in the service's log) and `errors` (for options: \
        a JSON pointer and a sentence each). The same codes stand in `error.code` of a job that failed.\n";
    for code in ErrorCode::ALL {
        let (name, status, meaning) = (code.as_str(), code.status(), code.meaning());
        let _ = write!(page, "\n### {name}\n\n{status}. {meaning}\n");
    }
    page
}

fn list(items: impl Iterator<Item = String>) -> String {
    items.collect::<Vec<_>>().join(", ")
}

fn table(options: &[OptionInfo]) -> String {
    let mut table = "| option | values | default | what it does |\n|---|---|---|---|\n".to_owned();
    for option in options {
        let default = match &option.default {
            serde_json::Value::String(word) => format!("`{word}`"),
            other => format!("`{other}`"),
        };
        let (name, values, text) = (option.name, values(option), option.text);
        let _ = writeln!(table, "| `{name}` | {values} | {default} | {text} |");
    }
    table
}

/// What an option can be, in a cell.
fn values(option: &OptionInfo) -> String {
    if !option.words.is_empty() {
        let word = |(word, meaning): &(String, String)| {
            let mut meaning = meaning.chars();
            let first = meaning.next().map(|c| c.to_lowercase().to_string()).unwrap_or_default();
            format!("`{word}`: {first}{}", meaning.as_str())
        };
        return option.words.iter().map(word).collect::<Vec<_>>().join("; ");
    }
    match (option.range, &option.default) {
        (Some([least, most]), _) => format!("{least} to {most} {}", option.unit).trim().to_owned(),
        (None, serde_json::Value::Bool(_)) => "`true`, `false`".to_owned(),
        _ => "text".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn committed(path: &str) -> String {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(path);
        std::fs::read_to_string(path).unwrap().replace("\r\n", "\n")
    }

    #[test]
    fn what_is_committed_is_what_the_tables_say() {
        let stale = "is stale: run `cargo run --release -- reference`";
        assert!(committed(PAGE) == page(), "{PAGE} {stale}");
        let readme = committed("README.md");
        assert!(with_options(&readme).as_ref() == Some(&readme), "README.md {stale}");
    }

    #[test]
    fn every_option_file_warning_and_code_is_told() {
        let page = page();
        let options = UnwrapOptions::table();
        let names = options.iter().map(|o| o.name);
        let names = names.chain(ArtifactKind::ALL.iter().map(|k| k.name()));
        for name in names.chain(WarningCode::ALL.iter().map(|c| c.as_str())) {
            assert!(page.contains(&format!("| `{name}` |")), "{name}");
        }
        assert!(ErrorCode::ALL.iter().all(|c| page.contains(&format!("### {}\n", c.as_str()))));
        assert!(NOT_IN_README.iter().all(|name| options.iter().any(|o| o.name == *name)));
    }
}
