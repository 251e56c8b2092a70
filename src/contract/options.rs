//! The options of a job: one struct that is the JSON of a request, the query of a raw upload and
//! the flags of the command line.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use utoipa::ToSchema;

use super::density::weights;
use super::option_table::options;
use super::{
    AtlasGrouping, DoubleSided, LossForm, Quality, Rotation, Seed, SegmentationSource, StopAfter,
    Winding,
};

/// Bytes of the option `density`.
const MOST_DENSITY: usize = 65536;

options! {
    /// Everything that a job can be told. JSON and query keys are snake_case, flags kebab-case.
    pub struct UnwrapOptions {
        /// Where the parts come from.
        segmentation: SegmentationSource = SegmentationSource::Auto, Parts;
        /// Which form of the training losses.
        losses: LossForm = LossForm::Sound, Maps;
        /// What happens to faces that stand twice, with both windings.
        double_sided: DoubleSided = DoubleSided::Separate, Charts;
        /// Which way faces are taken to be wound.
        winding: Winding = Winding::Surface, Charts;
        /// How many atlases a scene gets.
        atlas: AtlasGrouping = AtlasGrouping::Scene, Pages;
        /// Which TEXCOORD set to write.
        uv_channel: u8 = 0, Pages, 0..=7;
        /// Side of the square atlas page.
        page_size: u32 = 1024, Pages, 64..=16384 "texels";
        /// Least gutter between two charts.
        padding: u32 = 2, Pages, 0..=64 "texels";
        /// How charts may be turned when they are placed.
        rotation: Rotation = Rotation::Free, Pages;
        /// Keep charts to whole blocks of 4 × 4 texels that no other chart touches, for block-compressed
        /// textures; `page_size` must be a multiple of 4.
        block_align: bool = false, Pages;
        /// Most pages that an atlas is spread over; more are used only where the charts fit on so many at
        /// no density.
        pages: u32 = 1, Pages, 1..=64 "pages";
        /// Write page k, counted from 0, to UDIM tile 1001 + k: u is moved by k mod 10 and v, upwards,
        /// by k div 10. Otherwise all pages share [0, 1]².
        udim: bool = false, Pages;
        /// Texel density of parts relative to the others, as in `0=2,seat=0.5`: numbers or names of
        /// parts as in metrics.json, factors from 0.01 to 100.
        #[schema(max_length = 65536, format = "density")]
        density: Option<String> = None, Pages;
        /// Neighbouring regions are one part if the probability that a part ends between them is at most
        /// this: lower gives more parts.
        part_boundary: f64 = 0.55, Parts, 0.0..=1.0;
        /// Bound on a chart's area-weighted mean symmetric Dirichlet energy, minus 1. Larger gives fewer
        /// charts. Components of more than 12,000 triangles are cut on a coarser surface, whose charts it
        /// bounds: noise of the mesh comes on top.
        distortion_bound: f64 = 0.01, Charts, 0.000000001..=1000.0;
        /// Most charts to aim for; null for no aim. Validity comes first.
        max_charts: Option<u32> = None, Charts, 1..=10000000 "charts";
        /// How much work goes into the maps.
        quality: Quality = Quality::Balanced, Maps;
        /// Width of the mappers' hidden layers.
        width: u32 = 64, Maps, 8..=512 "units";
        /// Most training steps of a job.
        steps: u32 = 200, Maps, 1..=100000 "steps";
        /// Points a chart is trained on.
        points: u32 = 512, Maps, 64..=16384 "points";
        /// Seed of the samples and of the training; a string in JSON above 2^53.
        seed: Seed = Seed(0), Job;
        /// Wall-clock seconds the job may use; null for as many as it takes. As they run out stages take
        /// their cheaper forms, and the metrics say which; the result is then no longer a function of the
        /// input alone.
        budget_s: Option<f64> = None, Job, 0.001..=1000000.0 "seconds";
        /// Memory the job may use, counted from the input and the options.
        budget_mib: u64 = 6144, Job, 64..=1048576 "MiB";
        /// Draw the pictures, uv_layout.svg and preview.png.
        preview: bool = true, Job;
        /// Where the job ends early; null to run it whole.
        stop_after: Option<StopAfter> = None, Job;
    }
}

/// What is wrong with one option.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, ToSchema, thiserror::Error)]
#[error("option `{}`: {detail}", .pointer.trim_start_matches('/'))]
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

    /// Check every range, and what one option asks of another. Whatever passes here is run.
    pub fn validate(&self) -> Result<(), Vec<OptionError>> {
        let mut errors = self.outside();
        let mut wrong = |name: &str, detail: String| {
            errors.push(OptionError { pointer: format!("/{name}"), detail });
        };
        if self.block_align && !self.page_size.is_multiple_of(4) {
            let got = self.page_size;
            wrong("page_size", format!("must be a multiple of 4 with block_align, not {got}"));
        }
        if let Some(text) = &self.density {
            if text.len() > MOST_DENSITY {
                wrong("density", format!("must have at most {MOST_DENSITY} bytes"));
            } else if let Err(want) = weights(text) {
                wrong("density", format!("must be {want}, not {text:?}"));
            }
        }
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
