//! An option that is on or off, as a flag: `--udim` turns on what is off, `--no-preview` off what is on.

use clap::{Arg, ArgAction, ArgMatches};

use super::option_table::{OptionValue, taken};

/// A flag without a value; of what is done unless it is told otherwise, `--no-…`.
impl OptionValue for bool {
    fn flag(&self, arg: Arg) -> Arg {
        if !self {
            return arg.action(ArgAction::SetTrue);
        }
        let help = arg.get_help().map(ToString::to_string).unwrap_or_default();
        let (first, rest) = help.split_at(help.chars().next().map_or(0, char::len_utf8));
        let told = format!("Do not {}{rest}", first.to_lowercase());
        let long = format!("no-{}", arg.get_long().unwrap_or_default());
        let id = not(arg.get_id().as_str());
        arg.id(id).long(long).help(told).action(ArgAction::SetFalse)
    }

    fn given(matches: &mut ArgMatches, name: &str) -> Option<Self> {
        taken(matches, &not(name)).or_else(|| taken(matches, name))
    }
}

/// The name of the flag that turns an option off.
fn not(name: &str) -> String {
    format!("no_{name}")
}
