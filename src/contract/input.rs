//! The files that a job can be given, by what each is for: one line a role, and everything between
//! the request and the pipeline passes them on without looking.

use std::str::FromStr;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

macro_rules! input_roles {
    ($($variant:ident $name:literal $part:literal $holds:literal $what:literal,)*) => {
        /// What an input file is for.
        #[derive(
            Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, ToSchema,
        )]
        #[serde(rename_all = "snake_case")]
        pub enum InputRole {
            $(#[doc = concat!($what, ".")] $variant,)*
        }

        impl InputRole {
            /// Every role, in the order in which inputs are kept.
            pub const ALL: &'static [InputRole] = &[$(InputRole::$variant),*];

            /// The role as it is written in JSON and in the database.
            pub fn as_str(self) -> &'static str {
                match self { $(InputRole::$variant => $name,)* }
            }

            /// The part of a form that holds it, and the flag of the command line that names it.
            pub fn form_part(self) -> &'static str {
                match self { $(InputRole::$variant => $part,)* }
            }

            /// What it holds, to go on after "it".
            pub fn holds(self) -> &'static str {
                match self { $(InputRole::$variant => $holds,)* }
            }

            /// What it is, in a few words.
            pub fn what(self) -> &'static str {
                match self { $(InputRole::$variant => $what,)* }
            }
        }
    };
}

input_roles! {
    Mesh "mesh" "file" "holds the mesh" "The mesh",
    Labels "labels" "labels" "has one integer a line, one line a face"
        "Part labels: one integer a line, line i for face i, −1 for unknown",
}

impl FromStr for InputRole {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = InputRole::ALL.iter().find(|role| role.as_str() == text);
        found.copied().ok_or_else(|| format!("unknown role of an input {text:?}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roles_are_written_as_in_json() {
        for role in InputRole::ALL {
            assert_eq!(serde_json::to_value(role).unwrap(), role.as_str());
            assert_eq!(role.as_str().parse(), Ok(*role));
        }
        assert!("file".parse::<InputRole>().is_err());
    }
}
