//! Every warning, in one table: its code and what it means. A warning tells the user something; the job
//! goes on.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

macro_rules! warnings {
    ($($variant:ident $code:literal $meaning:literal,)*) => {
        /// A machine-readable kind of warning.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, ToSchema)]
        #[serde(rename_all = "snake_case")]
        pub enum WarningCode {
            $(#[doc = $meaning] $variant,)*
        }

        impl WarningCode {
            /// Every code, in the table's order.
            pub const ALL: &'static [WarningCode] = &[$(WarningCode::$variant),*];

            /// The code as it is written in JSON.
            pub fn as_str(self) -> &'static str {
                match self { $(WarningCode::$variant => $code,)* }
            }

            /// What it means, the same for every occurrence.
            pub fn meaning(self) -> &'static str {
                match self { $(WarningCode::$variant => $meaning,)* }
            }
        }
    };
}

warnings! {
    PassedOver "passed_over" "What stands in the file behind its known parts was left out",
    SkippedPrimitive "skipped_primitive" "A primitive without positions stays as it is",
    LeftOverCorners "left_over_corners" "Corners at the end of a primitive make no triangle and were left out",
    PartAttributeIgnored "part_attribute_ignored" "The vertex attribute `_PART` is not one whole number a face and was not read",
    Textured "textured" "Textures are drawn through a set of coordinates that the job replaces",
    ShortFaces "short_faces" "Faces of fewer than three corners were left out",
    BadColors "bad_colors" "Vertex colours outside 0 to 1 were clamped",
    BadNormals "bad_normals" "Normals have no direction: groups that use them lose their normals",
    BadTexcoords "bad_texcoords" "Texture coordinates that are not finite were set to 0",
    MtllibIgnored "mtllib_ignored" "Material libraries are not read: materials keep their names only",
    MixedWindings "mixed_windings" "With `winding=file`, many faces are wound against their neighbours, which tears charts apart",
    ManyCharts "many_charts" "There are many charts a part",
    MaxChartsMissed "max_charts_missed" "More charts are needed than `max_charts` asks for",
    Degraded "degraded" "A stage took a cheaper form, for the job's time or memory ran low",
}

/// Something the user should know.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct Warning {
    /// Its kind.
    pub code: WarningCode,
    /// A sentence on this occurrence.
    pub message: String,
}

impl Warning {
    /// A code and its sentence.
    pub fn new(code: WarningCode, message: impl Into<String>) -> Self {
        Self { code, message: message.into() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn json_name_is_the_table_name() {
        for code in WarningCode::ALL {
            assert_eq!(serde_json::to_value(code).unwrap(), code.as_str());
        }
    }
}
