//! How options are declared: each once, in `options!`, with its text, default, range and group. The
//! struct, its JSON and its schema, the flags of the command line, the check of every range and the
//! tables of the documentation follow from that.

use std::ops::RangeInclusive;
use std::str::FromStr;

use clap::builder::{EnumValueParser, ValueParser};
use clap::{Arg, ArgMatches, ValueEnum};

/// What an option is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OptionGroup {
    /// Where the parts come from.
    Parts,
    /// How parts are cut into charts.
    Charts,
    /// How the maps are made.
    Maps,
    /// How charts are placed.
    Pages,
    /// What the job may use, and where it ends.
    Job,
}

impl OptionGroup {
    /// Every group, in the order of the documentation.
    pub const ALL: [Self; 5] = [Self::Parts, Self::Charts, Self::Maps, Self::Pages, Self::Job];

    /// Its heading.
    pub fn heading(self) -> &'static str {
        match self {
            Self::Parts => "Parts",
            Self::Charts => "Charts",
            Self::Maps => "Maps",
            Self::Pages => "Pages",
            Self::Job => "The job",
        }
    }
}

/// One option, as documentation tells of it.
#[derive(Debug, Clone, PartialEq)]
pub struct OptionInfo {
    /// Its name, as in JSON.
    pub name: &'static str,
    /// What it is about.
    pub group: OptionGroup,
    /// What it does.
    pub text: &'static str,
    /// Its default, as JSON.
    pub default: serde_json::Value,
    /// Least and greatest number.
    pub range: Option<[f64; 2]>,
    /// Unit of the number; empty where it has none.
    pub unit: &'static str,
    /// The words that it takes, each with what it means; empty where it takes no words.
    pub words: Vec<(String, String)>,
}

/// A value that an option can have: how it is written on the command line, and what of it has a range.
pub trait OptionValue: Clone + Send + Sync + Sized + 'static {
    /// The flag that takes such a value.
    fn flag(&self, arg: Arg) -> Arg;

    /// The value that was given, or the default.
    fn given(matches: &mut ArgMatches, name: &str) -> Option<Self>;

    /// The number that must lie within the range, where there is one.
    fn number(&self) -> Option<f64> {
        None
    }

    /// The words that it takes.
    fn words() -> Vec<(String, String)> {
        Vec::new()
    }
}

macro_rules! numbers {
    ($($type:ty),*) => {$(
        impl OptionValue for $type {
            fn flag(&self, arg: Arg) -> Arg {
                arg.value_parser(clap::value_parser!($type)).default_value(self.to_string())
            }

            fn given(matches: &mut ArgMatches, name: &str) -> Option<Self> {
                taken(matches, name)
            }

            fn number(&self) -> Option<f64> {
                Some(*self as f64)
            }
        }
    )*};
}
numbers!(u8, u32, u64, f64);

/// A value that may be absent: its flag has no default.
impl<T: OptionValue + Default> OptionValue for Option<T> {
    fn flag(&self, arg: Arg) -> Arg {
        T::default().flag(arg).default_value(None::<&str>)
    }

    fn given(matches: &mut ArgMatches, name: &str) -> Option<Self> {
        Some(T::given(matches, name))
    }

    fn number(&self) -> Option<f64> {
        self.as_ref().and_then(T::number)
    }

    fn words() -> Vec<(String, String)> {
        T::words()
    }
}

impl OptionValue for String {
    fn flag(&self, arg: Arg) -> Arg {
        arg.value_parser(ValueParser::string())
    }

    fn given(matches: &mut ArgMatches, name: &str) -> Option<Self> {
        taken(matches, name)
    }
}

/// What was given for a flag; nothing where the command does not have that flag.
pub fn taken<T: Clone + Send + Sync + 'static>(matches: &mut ArgMatches, name: &str) -> Option<T> {
    matches.try_remove_one(name).ok().flatten()
}

/// The flag of a value that is one of a few words.
pub fn word_flag<T: ValueEnum + Clone + Send + Sync + 'static>(value: &T, arg: Arg) -> Arg {
    let arg = arg.value_parser(EnumValueParser::<T>::new());
    match value.to_possible_value() {
        Some(word) => arg.default_value(word.get_name().to_owned()),
        None => arg,
    }
}

/// The words of such a value.
pub fn words_of<T: ValueEnum>() -> Vec<(String, String)> {
    let words = T::value_variants().iter().filter_map(ValueEnum::to_possible_value);
    let told = |word: clap::builder::PossibleValue| {
        let help = word.get_help().map(ToString::to_string).unwrap_or_default();
        (word.get_name().to_owned(), help)
    };
    words.map(told).collect()
}

/// The flag of a value that is read from text.
pub fn text_flag<T>(value: &T, arg: Arg) -> Arg
where
    T: ToString + FromStr + Clone + Send + Sync + 'static,
    T::Err: Into<Box<dyn std::error::Error + Send + Sync>>,
{
    let parse = |text: &str| text.parse::<T>();
    arg.value_parser(ValueParser::new(parse)).default_value(value.to_string())
}

/// What is wrong with a number that has a range, if anything.
pub fn outside(value: &impl OptionValue, range: &RangeInclusive<f64>) -> Option<String> {
    let number = value.number()?;
    let [least, most] = [range.start(), range.end()];
    (!range.contains(&number)).then(|| format!("must be from {least} to {most}, not {number}"))
}

/// A table of options: `/// text`, then `name: Type = default, Group, least..=most "unit";`, the range
/// where there is one. `#[schema(…)]` before the name goes to the schema.
macro_rules! options {
    (
        $(#[$meta:meta])* pub struct $struct:ident {
            $(
                $(#[doc = $text:literal])+
                $(#[schema($($schema:tt)*)])?
                $name:ident: $type:ty = $default:expr, $group:ident
                    $(, $least:tt..=$most:tt $($unit:literal)?)?;
            )*
        }
    ) => {
        $(#[$meta])*
        #[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, utoipa::ToSchema)]
        #[serde(default, deny_unknown_fields)]
        pub struct $struct {
            $(
                $(#[doc = $text])+
                $(#[schema($($schema)*)])?
                $(#[schema(minimum = $least, maximum = $most)])?
                pub $name: $type,
            )*
        }

        impl Default for $struct {
            fn default() -> Self {
                Self { $($name: $default,)* }
            }
        }

        impl $struct {
            /// Every option, in the order of the declaration.
            pub fn table() -> Vec<$crate::contract::OptionInfo> {
                let defaults = serde_json::to_value(Self::default()).unwrap_or_default();
                vec![$($crate::contract::OptionInfo {
                    name: stringify!($name),
                    group: $crate::contract::OptionGroup::$group,
                    text: concat!($($text),+).trim_ascii(),
                    default: defaults[stringify!($name)].clone(),
                    range: None$(.or(Some([$least as f64, $most as f64])))?,
                    unit: concat!($($($unit)?)?),
                    words: <$type as $crate::contract::option_table::OptionValue>::words(),
                }),*]
            }

            /// Every number that lies outside of its range.
            fn outside(&self) -> Vec<OptionError> {
                let mut errors = Vec::new();
                $($(
                    let range = $least as f64..=$most as f64;
                    if let Some(detail) =
                        $crate::contract::option_table::outside(&self.$name, &range)
                    {
                        let pointer = concat!("/", stringify!($name)).to_owned();
                        errors.push(OptionError { pointer, detail });
                    }
                )?)*
                errors
            }
        }

        /// Each option is a flag, `--page-size` for `page_size`.
        impl clap::Args for $struct {
            fn augment_args(command: clap::Command) -> clap::Command {
                use $crate::contract::option_table::{OptionValue, flag};
                let defaults = Self::default();
                let table = Self::table();
                let mut told = table.iter();
                $(let command = command.arg(defaults.$name.flag(flag(told.next())));)*
                command
            }

            fn augment_args_for_update(command: clap::Command) -> clap::Command {
                Self::augment_args(command)
            }
        }

        impl clap::FromArgMatches for $struct {
            fn from_arg_matches(matches: &clap::ArgMatches) -> Result<Self, clap::Error> {
                Self::from_arg_matches_mut(&mut matches.clone())
            }

            fn from_arg_matches_mut(matches: &mut clap::ArgMatches) -> Result<Self, clap::Error> {
                let mut options = Self::default();
                options.update_from_arg_matches_mut(matches)?;
                Ok(options)
            }

            fn update_from_arg_matches(
                &mut self,
                matches: &clap::ArgMatches,
            ) -> Result<(), clap::Error> {
                self.update_from_arg_matches_mut(&mut matches.clone())
            }

            fn update_from_arg_matches_mut(
                &mut self,
                matches: &mut clap::ArgMatches,
            ) -> Result<(), clap::Error> {
                use $crate::contract::option_table::OptionValue;
                $(if let Some(given) = OptionValue::given(matches, stringify!($name)) {
                    self.$name = given;
                })*
                Ok(())
            }
        }
    };
}
pub(super) use options;

/// The bare flag of an option: `--page-size` for `page_size`, with its text, range and unit.
pub fn flag(info: Option<&OptionInfo>) -> Arg {
    let Some(info) = info else { return Arg::new("") };
    let range = info.range.map(|[least, most]| match info.unit {
        "" => format!(" [{least} to {most}]"),
        unit => format!(" [{least} to {most} {unit}]"),
    });
    let help = format!("{}{}", info.text.trim_end_matches('.'), range.unwrap_or_default());
    Arg::new(info.name)
        .long(info.name.replace('_', "-"))
        .value_name(info.name.to_uppercase())
        .help(help)
}

#[cfg(test)]
mod tests {
    use clap::Args;

    use super::*;
    use crate::contract::{Quality, Seed, UnwrapOptions};

    /// The options that these words of the command line give.
    fn given(words: &[&str]) -> Result<UnwrapOptions, clap::Error> {
        let command = UnwrapOptions::augment_args(clap::Command::new("test"));
        let words = std::iter::once("test").chain(words.iter().copied());
        clap::FromArgMatches::from_arg_matches(&command.try_get_matches_from(words)?)
    }

    #[test]
    fn without_flags_every_option_has_its_default() {
        assert_eq!(given(&[]).unwrap(), UnwrapOptions::default());
    }

    #[test]
    fn a_flag_of_each_type_sets_its_option() {
        let words = "--uv-channel 3 --page-size 256 --budget-mib 99 --part-boundary 0.25 --udim \
                     --density seat=2 --max-charts 7 --quality best --seed 18446744073709551615 \
                     --stop-after charts --budget-s 1.5 --no-preview";
        let options = given(&words.split_whitespace().collect::<Vec<_>>()).unwrap();
        let wanted = UnwrapOptions {
            uv_channel: 3,
            page_size: 256,
            budget_mib: 99,
            part_boundary: 0.25,
            udim: true,
            density: Some("seat=2".into()),
            max_charts: Some(7),
            quality: Quality::Best,
            seed: Seed(u64::MAX),
            stop_after: Some(crate::contract::StopAfter::Charts),
            budget_s: Some(1.5),
            preview: false,
            ..Default::default()
        };
        assert_eq!(options, wanted);
        assert!(given(&["--preview"]).is_err(), "what is done anyway has no flag that asks for it");
        assert!(given(&["--quality", "finest"]).is_err() && given(&["--padding", "x"]).is_err());
    }

    #[test]
    fn the_table_tells_words_ranges_units_and_groups() {
        let table = UnwrapOptions::table();
        let option = |name: &str| table.iter().find(|o| o.name == name).unwrap();
        let words: Vec<&str> = option("quality").words.iter().map(|w| w.0.as_str()).collect();
        assert_eq!(words, ["fast", "balanced", "best"]);
        assert!(option("quality").words.iter().all(|w| !w.1.is_empty()));
        // A word may be absent; a number and a switch take none.
        let words: Vec<&str> = option("stop_after").words.iter().map(|w| w.0.as_str()).collect();
        assert_eq!(words, ["segmentation", "charts"]);
        for name in ["padding", "udim", "density", "max_charts"] {
            assert!(option(name).words.is_empty(), "{name}");
        }
        let padding = option("padding");
        assert_eq!((padding.range, padding.unit), (Some([0.0, 64.0]), "texels"));
        assert_eq!((padding.default.as_u64(), padding.group.heading()), (Some(2), "Pages"));
        let headings = OptionGroup::ALL.map(OptionGroup::heading);
        assert_eq!(headings, ["Parts", "Charts", "Maps", "Pages", "The job"]);
    }

    #[test]
    fn help_tells_the_range_and_the_unit() {
        let table = UnwrapOptions::table();
        let help = |name: &str| {
            let flag = flag(table.iter().find(|o| o.name == name));
            (flag.get_long().map(str::to_owned), flag.get_help().map(ToString::to_string))
        };
        let (long, text) = help("page_size");
        assert_eq!(long.as_deref(), Some("page-size"));
        assert!(text.unwrap().ends_with(" [64 to 16384 texels]"));
        assert!(help("part_boundary").1.unwrap().ends_with(" [0 to 1]"));
        assert!(!help("block_align").1.unwrap().contains('['));
    }

    #[test]
    fn only_numbers_outside_of_their_range_are_wrong() {
        let range = 1.0..=10.0;
        assert_eq!(outside(&1u32, &range), None);
        assert_eq!(outside(&Some(10u32), &range), None);
        assert_eq!(outside(&None::<u32>, &range), None);
        assert_eq!(outside(&true, &range), None);
        assert_eq!(outside(&11u64, &range).unwrap(), "must be from 1 to 10, not 11");
        assert_eq!(outside(&Some(0.5), &range).unwrap(), "must be from 1 to 10, not 0.5");
        assert!(outside(&f64::NAN, &range).is_some());
    }
}
