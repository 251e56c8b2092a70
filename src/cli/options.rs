//! The options of a job as the flags of a command: all of them, or those that a command is about; checked
//! before any work, and told by their flags.

use anyhow::{Result, bail};
use clap::{ArgMatches, Args, Command, FromArgMatches};

use crate::contract::{OptionError, UnwrapOptions};

/// An error that names every flag whose value cannot be.
pub fn valid(options: &UnwrapOptions) -> Result<()> {
    let Err(errors) = options.validate() else { return Ok(()) };
    let line = |e: &OptionError| {
        format!("--{} {}", e.pointer.trim_start_matches('/').replace('_', "-"), e.detail)
    };
    bail!("{}", errors.iter().map(line).collect::<Vec<_>>().join("\n"))
}

/// The options that the parts depend on; all others have their defaults.
#[derive(Debug, Clone)]
pub struct PartOptions(pub UnwrapOptions);

/// Their names.
const OF_PARTS: [&str; 4] = ["segmentation", "part_boundary", "seed", "budget_mib"];

impl Args for PartOptions {
    fn augment_args(command: Command) -> Command {
        let all = UnwrapOptions::augment_args(Command::new("options"));
        let own = all.get_arguments().filter(|arg| OF_PARTS.contains(&arg.get_id().as_str()));
        command.args(own.cloned())
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for PartOptions {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        UnwrapOptions::from_arg_matches(matches).map(Self)
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        self.0.update_from_arg_matches(matches)
    }
}

#[cfg(test)]
mod tests {
    use clap::Parser;

    use super::*;
    use crate::contract::{Seed, SegmentationSource};

    #[derive(Parser)]
    struct Flags {
        #[command(flatten)]
        options: PartOptions,
    }

    #[test]
    fn a_command_takes_the_options_that_it_is_about_and_no_other() {
        let flags = ["x", "--segmentation", "authored", "--part-boundary", "0.2", "--seed", "7"];
        let PartOptions(options) = Flags::parse_from(flags).options;
        let segmentation = SegmentationSource::Authored;
        let seed = Seed(7);
        let want =
            UnwrapOptions { segmentation, part_boundary: 0.2, seed, ..UnwrapOptions::default() };
        assert_eq!(options, want);
        assert!(Flags::try_parse_from(["x", "--padding", "4"]).is_err());
        let wrong = Flags::parse_from(["x", "--part-boundary", "7"]).options.0;
        assert!(valid(&wrong).unwrap_err().to_string().contains("--part-boundary must be"));
    }
}
