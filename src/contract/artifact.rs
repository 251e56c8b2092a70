//! Every file that a job can make, in one table: its name, media type, when it is written, and the flag
//! with which the command line is told where it goes.

macro_rules! artifacts {
    ($($variant:ident $name:literal $media_type:literal $flag:literal $what:literal $when:ident,)*) => {
        /// A file that a job makes.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum ArtifactKind {
            $(#[doc = $what] $variant,)*
        }

        impl ArtifactKind {
            /// Every kind, in the order in which a job lists them.
            pub const ALL: &'static [ArtifactKind] = &[$(ArtifactKind::$variant),*];

            /// The file's name.
            pub fn name(self) -> &'static str {
                match self { $(ArtifactKind::$variant => $name,)* }
            }

            /// Its media type.
            pub fn media_type(self) -> &'static str {
                match self { $(ArtifactKind::$variant => $media_type,)* }
            }

            /// The flag of `uvsegnet unwrap` that says where it goes; empty where the command line does
            /// not write it.
            pub fn flag(self) -> &'static str {
                match self { $(ArtifactKind::$variant => $flag,)* }
            }

            /// What it is, in a few words.
            pub fn what(self) -> &'static str {
                match self { $(ArtifactKind::$variant => $what,)* }
            }

            /// When it is written.
            pub fn when(self) -> Written {
                match self { $(ArtifactKind::$variant => Written::$when,)* }
            }
        }
    };
}

/// When a job writes a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Written {
    /// By every job that succeeds.
    Always,
    /// By a job that succeeds and does not end with its parts.
    Charts,
    /// By a job that ends with its parts (`stop_after = segmentation`).
    Parts,
    /// By every job that succeeds, unless it was to draw none or its time or memory was too short for them.
    Pictures,
    /// The same, of jobs that do not end with their parts.
    ChartPictures,
    /// By every job that a worker has run, whether it succeeded or failed.
    Run,
}

impl Written {
    /// Whether a job that ends with its parts writes it.
    pub fn is_of_parts(self) -> bool {
        matches!(self, Self::Always | Self::Parts | Self::Pictures)
    }

    /// The same in words.
    pub fn as_str(self) -> &'static str {
        match self {
            Self::Always => "always",
            Self::Charts => "unless the job ends with its parts",
            Self::Parts => "where the job ends with its parts (`stop_after=segmentation`)",
            Self::Pictures => "unless `preview=false`, or time or memory ran out before",
            Self::ChartPictures => {
                "unless the job ends with its parts, `preview=false`, or time or memory ran out before"
            }
            Self::Run => "by the service, for jobs that failed too",
        }
    }
}

artifacts! {
    Model "model.glb" "model/gltf-binary" "output" "The same mesh with UVs, as GLB; with its parts in `_PART` where the job ends with them" Always,
    Labels "labels.txt" "text/plain" "parts" "The part of each face as text: one integer a line, line i for face i, −1 for a face without area" Parts,
    Metrics "metrics.json" "application/json" "metrics" "Certificate and figures" Always,
    Layout "uv_layout.svg" "image/svg+xml" "layout" "The drawing of the UV layout" ChartPictures,
    Preview "preview.png" "image/png" "preview" "A picture: checker and seams, parts, layout" Pictures,
    Log "log.jsonl" "application/jsonl" "" "What the worker logged while it ran the job" Run,
}

impl ArtifactKind {
    /// The kind with this file name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.iter().copied().find(|kind| kind.name() == name)
    }

    /// The ending of its file name.
    pub fn ending(self) -> &'static str {
        self.name().rsplit('.').next().unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_flags_and_endings_tell_kinds_apart() {
        for (i, a) in ArtifactKind::ALL.iter().enumerate() {
            assert_eq!(ArtifactKind::named(a.name()), Some(*a));
            for b in &ArtifactKind::ALL[..i] {
                assert!(a.flag() != b.flag() && a.ending() != b.ending(), "{a:?} and {b:?}");
            }
        }
    }

    #[test]
    fn a_job_of_parts_writes_what_needs_no_charts() {
        let of_parts = ArtifactKind::ALL.iter().filter(|kind| kind.when().is_of_parts());
        let names: Vec<_> = of_parts.map(|kind| kind.name()).collect();
        assert_eq!(names, ["model.glb", "labels.txt", "metrics.json", "preview.png"]);
    }

    #[test]
    fn it_is_said_in_words_when_each_is_written() {
        let words = |kind: ArtifactKind| kind.when().as_str();
        assert_eq!(words(ArtifactKind::Model), "always");
        assert!(words(ArtifactKind::Labels).contains("stop_after=segmentation"));
        assert!(words(ArtifactKind::Layout).starts_with("unless the job ends with its parts"));
        assert!(words(ArtifactKind::Preview).contains("`preview=false`"));
        assert!(words(ArtifactKind::Log).contains("failed too"));
    }
}
