//! The options of a job: one struct that is the JSON of a request, the query of a raw upload and
//! the flags of the command line.

use clap::Args;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use utoipa::ToSchema;

use super::density::weights;
use super::{
    AtlasGrouping, DoubleSided, LossForm, Quality, Rotation, Seed, SegmentationSource, StopAfter,
};

/// Everything that a job can be told. JSON and query keys are snake_case, flags kebab-case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, ToSchema, Args)]
#[serde(default, deny_unknown_fields)]
pub struct UnwrapOptions {
    /// Where the parts come from.
    #[arg(long, value_enum, default_value_t)]
    pub segmentation: SegmentationSource,
    /// Which form of the training losses.
    #[arg(long, value_enum, default_value_t)]
    pub losses: LossForm,
    /// What happens to faces that stand twice, with both windings.
    #[arg(long, value_enum, default_value_t)]
    pub double_sided: DoubleSided,
    /// How many atlases a scene gets.
    #[arg(long, value_enum, default_value_t)]
    pub atlas: AtlasGrouping,
    /// Which TEXCOORD set to write, 0 to 7.
    #[arg(long, default_value_t = 0)]
    #[schema(minimum = 0, maximum = 7)]
    pub uv_channel: u8,
    /// Side of the square atlas page in texels, 64 to 16384.
    #[arg(long, default_value_t = 1024)]
    #[schema(minimum = 64, maximum = 16384)]
    pub page_size: u32,
    /// Least gutter between two charts in texels, 0 to 64.
    #[arg(long, default_value_t = 2)]
    #[schema(minimum = 0, maximum = 64)]
    pub padding: u32,
    /// How charts may be turned when they are placed.
    #[arg(long, value_enum, default_value_t)]
    pub rotation: Rotation,
    /// Keep charts to whole blocks of 4 × 4 texels that no other chart touches, for block-compressed
    /// textures; `page_size` must be a multiple of 4.
    #[arg(long)]
    pub block_align: bool,
    /// Most pages that an atlas is spread over, 1 to 64; more are used only where the charts fit on
    /// so many at no density.
    #[arg(long, default_value_t = 1)]
    #[schema(minimum = 1, maximum = 64)]
    pub pages: u32,
    /// Write page k, counted from 0, to UDIM tile 1001 + k: u is moved by k mod 10 and v, upwards,
    /// by k div 10. Otherwise all pages share [0, 1]².
    #[arg(long)]
    pub udim: bool,
    /// Texel density of parts relative to the others, as in `0=2,seat=0.5`: numbers or names of
    /// parts as in metrics.json, factors from 0.01 to 100.
    #[arg(long)]
    pub density: Option<String>,
    /// Neighbouring regions are one part if the probability that a part ends between them is at most
    /// this, 0 to 1: lower gives more parts.
    #[arg(long, default_value_t = 0.55)]
    #[schema(minimum = 0.0, maximum = 1.0)]
    pub part_boundary: f64,
    /// Bound on a chart's area-weighted mean symmetric Dirichlet energy, minus 1.
    #[arg(long, default_value_t = 0.01)]
    #[schema(exclusive_minimum = 0.0)]
    pub distortion_bound: f64,
    /// Most charts to aim for; null for no aim. Validity comes first.
    #[arg(long)]
    #[schema(minimum = 1)]
    pub max_charts: Option<u32>,
    /// How much work goes into the maps.
    #[arg(long, value_enum, default_value_t)]
    pub quality: Quality,
    /// Width of the mappers' hidden layers, 8 to 512.
    #[arg(long, default_value_t = 64)]
    #[schema(minimum = 8, maximum = 512)]
    pub width: u32,
    /// Most training steps of a job, 1 to 100000.
    #[arg(long, default_value_t = 200)]
    #[schema(minimum = 1, maximum = 100000)]
    pub steps: u32,
    /// Points a chart is trained on, 64 to 16384.
    #[arg(long, default_value_t = 512)]
    #[schema(minimum = 64, maximum = 16384)]
    pub points: u32,
    /// Seed of everything that is drawn at random; a string in JSON above 2^53.
    #[arg(long, default_value_t)]
    #[schema(value_type = u64)]
    pub seed: Seed,
    /// Wall-clock seconds the job may use.
    #[arg(long, default_value_t = 600.0)]
    #[schema(exclusive_minimum = 0.0)]
    pub budget_s: f64,
    /// MiB of memory the job may use.
    #[arg(long, default_value_t = 4096)]
    #[schema(minimum = 64)]
    pub budget_mib: u64,
    /// Where the job ends early; null to run it whole.
    #[arg(long, value_enum)]
    pub stop_after: Option<StopAfter>,
}

impl Default for UnwrapOptions {
    fn default() -> Self {
        Self {
            segmentation: Default::default(),
            losses: Default::default(),
            double_sided: Default::default(),
            atlas: Default::default(),
            uv_channel: 0,
            page_size: 1024,
            padding: 2,
            rotation: Default::default(),
            block_align: false,
            pages: 1,
            udim: false,
            density: None,
            part_boundary: 0.55,
            distortion_bound: 0.01,
            max_charts: None,
            quality: Default::default(),
            width: 64,
            steps: 200,
            points: 512,
            seed: Seed(0),
            budget_s: 600.0,
            budget_mib: 4096,
            stop_after: None,
        }
    }
}

/// What is wrong with one option.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema, thiserror::Error)]
#[error("option {pointer}: {detail}")]
pub struct OptionError {
    /// JSON pointer to the option, as in `/padding`.
    pub pointer: String,
    /// What is wrong and what would be right.
    pub detail: String,
}

impl UnwrapOptions {
    /// Read options from a JSON object. Every wrong key is told, each with its own pointer.
    pub fn from_json(value: &Value) -> Result<Self, Vec<OptionError>> {
        let Value::Object(object) = value else {
            let detail = "expected a JSON object of options, as in {\"padding\": 4}".into();
            return Err(vec![OptionError { pointer: String::new(), detail }]);
        };
        // One key at a time, so that an error can be laid at that key's door.
        let wrong = |(key, value): (&String, &Value)| {
            let single = Value::Object(Map::from_iter([(key.clone(), value.clone())]));
            let error = serde_json::from_value::<Self>(single).err()?;
            Some(OptionError { pointer: format!("/{key}"), detail: error.to_string() })
        };
        let errors: Vec<_> = object.iter().filter_map(wrong).collect();
        if !errors.is_empty() {
            return Err(errors);
        }
        let options: Self = serde_json::from_value(value.clone()).map_err(|error| {
            vec![OptionError { pointer: String::new(), detail: error.to_string() }]
        })?;
        options.validate()?;
        Ok(options)
    }

    /// Read options from the pairs of a query string: values are JSON where they parse as a
    /// number, `true`, `false` or `null`, and strings otherwise.
    pub fn from_pairs<'a>(
        pairs: impl IntoIterator<Item = (&'a str, &'a str)>,
    ) -> Result<Self, Vec<OptionError>> {
        let mut object = Map::new();
        for (key, text) in pairs {
            let value = match serde_json::from_str(text) {
                Ok(value @ (Value::Number(_) | Value::Bool(_) | Value::Null)) => value,
                _ => Value::String(text.to_owned()),
            };
            if object.insert(key.to_owned(), value).is_some() {
                let detail = "given twice; give it once".to_owned();
                return Err(vec![OptionError { pointer: format!("/{key}"), detail }]);
            }
        }
        Self::from_json(&Value::Object(object))
    }

    /// Check every range.
    pub fn validate(&self) -> Result<(), Vec<OptionError>> {
        let mut errors = Vec::new();
        let mut check = |name: &str, ok: bool, want: &str, got: String| {
            if !ok {
                let detail = format!("must be {want}, not {got}");
                errors.push(OptionError { pointer: format!("/{name}"), detail });
            }
        };
        let positive = |x: f64| x.is_finite() && x > 0.0;
        check("uv_channel", self.uv_channel <= 7, "from 0 to 7", self.uv_channel.to_string());
        let page = (64..=16384).contains(&self.page_size);
        check("page_size", page, "from 64 to 16384", self.page_size.to_string());
        let blocks = !self.block_align || self.page_size.is_multiple_of(4);
        let want = "a multiple of 4 with block_align";
        check("page_size", blocks, want, self.page_size.to_string());
        check("pages", (1..=64).contains(&self.pages), "from 1 to 64", self.pages.to_string());
        if let Some(text) = &self.density
            && let Err(want) = weights(text)
        {
            check("density", false, &want, format!("{text:?}"));
        }
        check("padding", self.padding <= 64, "from 0 to 64", self.padding.to_string());
        let share = (0.0..=1.0).contains(&self.part_boundary);
        check("part_boundary", share, "0 to 1", self.part_boundary.to_string());
        let bound = positive(self.distortion_bound);
        check("distortion_bound", bound, "above 0", self.distortion_bound.to_string());
        let most = self.max_charts.is_none_or(|n| n >= 1);
        check("max_charts", most, "1 or more, or null", format!("{:?}", self.max_charts));
        check("width", (8..=512).contains(&self.width), "from 8 to 512", self.width.to_string());
        let steps = (1..=100_000).contains(&self.steps);
        check("steps", steps, "from 1 to 100000", self.steps.to_string());
        let points = (64..=16384).contains(&self.points);
        check("points", points, "from 64 to 16384", self.points.to_string());
        check("budget_s", positive(self.budget_s), "above 0", self.budget_s.to_string());
        check("budget_mib", self.budget_mib >= 64, "64 or more", self.budget_mib.to_string());
        if errors.is_empty() { Ok(()) } else { Err(errors) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn json_round_trips_and_defaults_fill_in() {
        let options =
            UnwrapOptions::from_json(&json!({"padding": 4, "seed": "18446744073709551615"}))
                .unwrap();
        assert_eq!(options.padding, 4);
        assert_eq!(options.seed.0, u64::MAX);
        let again = UnwrapOptions::from_json(&serde_json::to_value(&options).unwrap()).unwrap();
        assert_eq!(again, options);
    }

    #[test]
    fn every_wrong_key_is_named() {
        let errors = UnwrapOptions::from_json(&json!({"paddign": 4, "steps": "many", "width": 64}))
            .unwrap_err();
        let pointers: Vec<_> = errors.iter().map(|e| e.pointer.as_str()).collect();
        assert_eq!(pointers, ["/paddign", "/steps"]);
        let errors = UnwrapOptions::from_json(&json!({"padding": 65, "page_size": 1})).unwrap_err();
        assert_eq!(errors.len(), 2);
    }

    #[test]
    fn blocks_pages_and_densities_have_their_ranges() {
        let pointers = |value| -> Vec<String> {
            let errors = UnwrapOptions::from_json(&value).err().unwrap_or_default();
            errors.into_iter().map(|e| e.pointer).collect()
        };
        assert_eq!(pointers(json!({"page_size": 1022, "block_align": true})), ["/page_size"]);
        assert!(pointers(json!({"page_size": 1022})).is_empty());
        assert_eq!(pointers(json!({"pages": 0})), ["/pages"]);
        assert_eq!(pointers(json!({"pages": 65})), ["/pages"]);
        assert!(pointers(json!({"pages": 64, "udim": true, "rotation": "none"})).is_empty());
        for wrong in ["2", "seat=0.001", "seat=101", "seat=x", "seat=1,seat=2", "=1"] {
            assert_eq!(pointers(json!({"density": wrong})), ["/density"], "{wrong}");
        }
        assert!(pointers(json!({"density": "0=2, seat = 0.5"})).is_empty());
    }

    #[test]
    fn query_pairs_are_typed() {
        let pairs = [("padding", "3"), ("quality", "best"), ("max_charts", "null"), ("seed", "7")];
        let options = UnwrapOptions::from_pairs(pairs).unwrap();
        assert_eq!((options.padding, options.quality, options.seed.0), (3, Quality::Best, 7));
        assert!(UnwrapOptions::from_pairs([("padding", "1"), ("padding", "2")]).is_err());
    }
}
