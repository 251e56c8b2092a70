//! What the pipeline says, from where the user of the command line stands: its texts name options and files
//! as the API does, in backticks, and here they are flags.

use crate::contract::{InputRole, UnwrapOptions};
use crate::pipeline::UnwrapError;

/// A text with flags for the options and files that it names.
pub fn as_flags(text: &str) -> String {
    let options = UnwrapOptions::table().into_iter().map(|option| option.name);
    let files = InputRole::ALL.iter().map(|role| role.form_part());
    options.chain(files).fold(text.to_owned(), |text, name| {
        text.replace(&format!("`{name}`"), &format!("--{}", name.replace('_', "-")))
    })
}

/// An error of the pipeline.
pub fn error(error: &UnwrapError) -> anyhow::Error {
    anyhow::Error::msg(as_flags(&error.to_string()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_and_files_are_flags() {
        let said = "`budget_s` was over; give `labels` or another `uv_channel`, not `f` or labels";
        let want = "--budget-s was over; give --labels or another --uv-channel, not `f` or labels";
        assert_eq!(as_flags(said), want);
    }
}
