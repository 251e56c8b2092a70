//! The values that options take.

use std::fmt;
use std::str::FromStr;

use clap::{Arg, ArgMatches, ValueEnum};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use utoipa::openapi::{Object, OneOfBuilder, RefOr, Schema, SchemaFormat, Type};
use utoipa::{PartialSchema, ToSchema};

use super::option_table::{OptionValue, taken, text_flag, word_flag, words_of};

macro_rules! value {
    ($(#[$meta:meta])* $name:ident { $($(#[$vmeta:meta])* $variant:ident),* $(,)? }) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, Serialize, Deserialize, ToSchema, ValueEnum)]
        #[serde(rename_all = "snake_case")]
        #[value(rename_all = "snake_case")]
        pub enum $name { $($(#[$vmeta])* $variant),* }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                let value = self.to_possible_value().map(|v| v.get_name().to_owned());
                f.write_str(value.as_deref().unwrap_or_default())
            }
        }

        impl OptionValue for $name {
            fn flag(&self, arg: Arg) -> Arg {
                word_flag(self, arg)
            }

            fn given(matches: &mut ArgMatches, name: &str) -> Option<Self> {
                taken(matches, name)
            }

            fn words() -> Vec<(String, String)> {
                words_of::<Self>()
            }
        }
    };
}

value! {
    /// Where the parts come from.
    SegmentationSource {
        /// Fuse what is there and say which source decided.
        #[default]
        Auto,
        /// What a trained network sees, alone.
        Learned,
        /// Nodes, primitives, materials and connected components.
        Authored,
        /// A rule over contact, concavity, thickness, size and how well simple shapes fit; needs no weights.
        Geometric,
        /// One label a face, given with the request.
        Labels,
    }
}

value! {
    /// Which form of the training losses.
    LossForm {
        /// Forms whose optimum is an isometry.
        #[default]
        Sound,
        /// The formulas as the paper prints them, for its ablations.
        Paper,
    }
}

value! {
    /// What happens to faces that stand twice, with both windings.
    DoubleSided {
        /// Each sheet has charts of its own; nothing overlaps.
        #[default]
        Separate,
        /// Both sheets carry the same UVs.
        Share,
    }
}

value! {
    /// Which way faces are taken to be wound.
    Winding {
        /// As the surface has it, whatever the file's windings are: charts run over faces that the file winds
        /// against their neighbours.
        #[default]
        Surface,
        /// As the file has it: charts end where its winding changes.
        File,
    }
}

value! {
    /// How many atlases a scene gets.
    AtlasGrouping {
        /// One for all meshes of the default scene.
        #[default]
        Scene,
        /// One for each material.
        Material,
    }
}

value! {
    /// How charts may be turned when they are placed. None is ever mirrored.
    Rotation {
        /// Freely.
        #[default]
        Free,
        /// By quarter turns, so that a chart's own axes stay along the page's.
        Quarter,
        /// Not at all: every chart stands as it was mapped.
        None,
    }
}

value! {
    /// How much work goes into the maps.
    Quality {
        /// No training: start maps, polished.
        Fast,
        /// Train the charts for which training has been shown to pay: none, so far.
        #[default]
        Balanced,
        /// Train every chart that is not already isometric.
        Best,
    }
}

value! {
    /// Where a job ends early.
    StopAfter {
        /// After the parts are known: no UVs are made.
        Segmentation,
        /// After the cut: charts carry their start maps, packed, untrained.
        #[default]
        Charts,
    }
}

/// A seed. In JSON a number, or a string for values above 2⁵³ (which JavaScript would round).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub struct Seed(pub u64);

/// The largest integer that every JSON reader keeps exact.
const EXACT: u64 = 1 << 53;

impl Serialize for Seed {
    fn serialize<S: Serializer>(&self, s: S) -> Result<S::Ok, S::Error> {
        if self.0 <= EXACT { s.serialize_u64(self.0) } else { s.collect_str(&self.0) }
    }
}

impl PartialSchema for Seed {
    fn schema() -> RefOr<Schema> {
        // In a string the range has no keyword; the format says it.
        let format = || Some(SchemaFormat::Custom("uint64".to_owned()));
        let number = Object::builder()
            .schema_type(Type::Integer)
            .format(format())
            .minimum(Some(u64::MIN))
            .maximum(Some(u64::MAX));
        let text = Object::builder().schema_type(Type::String).format(format());
        OneOfBuilder::new().item(number).item(text).into()
    }
}

impl ToSchema for Seed {}

impl<'de> Deserialize<'de> for Seed {
    fn deserialize<D: Deserializer<'de>>(d: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged, expecting = "expected an integer from 0 to 2^64 - 1, or a string of one")]
        enum Either {
            Number(u64),
            Text(String),
        }
        match Either::deserialize(d)? {
            Either::Number(n) => Ok(Self(n)),
            Either::Text(t) => t.parse().map_err(serde::de::Error::custom),
        }
    }
}

impl FromStr for Seed {
    type Err = String;
    fn from_str(s: &str) -> Result<Self, String> {
        s.parse()
            .map(Self)
            .map_err(|_| format!("expected an integer from 0 to 2^64 - 1, not {s:?}"))
    }
}

impl OptionValue for Seed {
    fn flag(&self, arg: Arg) -> Arg {
        text_flag(self, arg)
    }

    fn given(matches: &mut ArgMatches, name: &str) -> Option<Self> {
        taken(matches, name)
    }
}

impl fmt::Display for Seed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}
