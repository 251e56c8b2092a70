//! Whatever the schema of the options admits is refused with `invalid_option` or run; nothing panics.

use std::panic::{AssertUnwindSafe, catch_unwind};

use rayon::prelude::*;
use serde_json::{Map, Value, json};
use uvsegnet::atlas::{self, PackOptions};
use uvsegnet::contract::{Budget, Cancel, Limits, OptionInfo, Quality, Run, UnwrapOptions};
use uvsegnet::device::Device;
use uvsegnet::parameterization::{self, TrainOptions};
use uvsegnet::pipeline::{Engine, Input, required_bytes, unwrap_input};

use super::kind_of;

/// A cube of twelve triangles in six parts' worth of sides.
pub const CUBE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
    f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

/// Texts that the schema of `density` admits.
const TEXTS: [&str; 6] = ["", "0=2", "0=0.01", "0=100", "nobody=2", "=,=="];

/// Numbers drawn one after the other (SplitMix64, Steele et al. 2014, doi:10.1145/2714064.2660195).
struct Draw(u64);

impl Draw {
    fn below(&mut self, end: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        (z ^ (z >> 31)) % end
    }

    /// A value of an option that its schema admits, an extreme one as often as not.
    fn value(&mut self, option: &OptionInfo) -> Value {
        let which = self.below(4);
        if option.default.is_null() && which == 3 {
            return Value::Null;
        }
        if !option.words.is_empty() {
            let words = option.words.len() as u64;
            return option.words[self.below(words) as usize].0.as_str().into();
        }
        if let Some([least, most]) = option.range {
            let share = self.below(1001) as f64 / 1000.0;
            let between = least + share * share * share * (most - least);
            let number = [least, most, between, between][which as usize];
            let whole =
                least.fract() == 0.0 && most.fract() == 0.0 && option.name != "part_boundary";
            return if whole { json!(number.round() as u64) } else { json!(number) };
        }
        match option.name {
            "seed" => {
                [json!(0), json!(u64::MAX.to_string()), json!(self.0)][which as usize % 3].clone()
            }
            "density" => TEXTS[self.below(TEXTS.len() as u64) as usize].into(),
            _ => json!(which.is_multiple_of(2)),
        }
    }

    fn options(&mut self) -> Value {
        let table = UnwrapOptions::table();
        Value::Object(table.iter().map(|o| (o.name.to_owned(), self.value(o))).collect())
    }
}

/// Every place where an option enters arithmetic or the size of an allocation before work begins.
fn count(options: &UnwrapOptions) {
    for faces in [0, 12, 2_000_000, u64::from(u32::MAX), u64::MAX] {
        required_bytes(faces, options);
    }
    let training = TrainOptions::from(options);
    for vertices in [0, 1, 100_000, usize::MAX] {
        parameterization::bytes(vertices, &training);
    }
    assert!(parameterization::bytes(usize::MAX, &training) < 1 << 40, "{training:?}");
    let packing = PackOptions::from(options);
    assert!(atlas::raster_bytes(packing.page_size) < 1 << 28);
    let budget = Budget::new(options.budget_s, options.budget_mib);
    let run = Run::new(|_| {}, Cancel::default(), budget);
    assert!(run.budget.spare_bytes() >= 64 << 20);
    let _ = (run.budget.hold(u64::MAX), run.out_of_time());
}

#[test]
fn what_the_schema_admits_is_refused_by_name_or_can_be_counted_with() {
    let mut draw = Draw(1);
    let (mut runs, mut refused) = (0, 0);
    for case in 0..2000 {
        let value = draw.options();
        match UnwrapOptions::from_json(&value) {
            Ok(options) => {
                count(&options);
                runs += 1;
            }
            Err(errors) => {
                refused += 1;
                // Only what one option asks of another, and texts, cannot be said by a schema.
                let known = ["/page_size", "/density"];
                assert!(
                    errors.iter().all(|e| known.contains(&e.pointer.as_str())),
                    "case {case}: {errors:?}"
                );
            }
        }
    }
    assert!(runs > 500 && refused > 100, "{runs} {refused}");
}

#[test]
fn numbers_beyond_their_range_are_refused() {
    for option in UnwrapOptions::table() {
        let Some([least, most]) = option.range else { continue };
        let whole = option.default.is_u64() || option.name == "max_charts";
        let beyond = |x: f64| if whole { json!(x as i64) } else { json!(x) };
        for wrong in [beyond(least - 1.0), beyond(most + 1.0), json!(1e300), json!("many")] {
            let options = Map::from_iter([(option.name.to_owned(), wrong.clone())]);
            let errors = UnwrapOptions::from_json(&Value::Object(options));
            let errors = errors.expect_err(&format!("{} = {wrong}", option.name));
            assert_eq!(errors[0].pointer, format!("/{}", option.name), "{wrong}");
        }
    }
}

/// Whole jobs on a cube: every option at both ends, then random ones, the costly ones bounded by counted
/// work: at most so many units of width, times points, times steps, and few and small pages.
#[test]
fn every_job_that_is_admitted_ends_with_a_valid_atlas_or_a_code() {
    let mut draw = Draw(2);
    let mut jobs: Vec<Value> = Vec::new();
    for option in UnwrapOptions::table() {
        let mut ends: Vec<Value> = option.words.iter().map(|w| w.0.as_str().into()).collect();
        ends.extend(option.range.into_iter().flatten().map(|x| match x.fract() == 0.0 {
            true if option.name != "budget_s" => json!(x as u64),
            _ => json!(x),
        }));
        if ends.is_empty() {
            ends = (0..4).map(|_| draw.value(&option)).collect();
        }
        jobs.extend(ends.into_iter().map(|end| json!({ option.name: end })));
    }
    while jobs.len() < 200 {
        let mut job = draw.options();
        job["page_size"] = json!([64, 256][draw.below(2) as usize]);
        jobs.push(job);
    }
    // What is the default anyway is run once.
    let mut met: Vec<UnwrapOptions> = Vec::new();
    jobs.retain(|job| match UnwrapOptions::from_json(job) {
        Ok(options) if met.contains(&options) => false,
        Ok(options) => {
            met.push(options);
            true
        }
        Err(_) => true,
    });
    let engine = Engine::new(Device::cpu());
    let outcomes: Vec<Option<bool>> = jobs
        .par_iter()
        .map(|job| {
            let mut options = UnwrapOptions::from_json(job).ok()?;
            let work = u64::from(options.width.pow(2)) * u64::from(options.steps.min(200));
            if options.quality == Quality::Best && work > 4_000_000 {
                options.width = 64;
                options.steps = options.steps.min(200);
            }
            // Many pages are searched once, by the job that asks for nothing else.
            if job.as_object().is_some_and(|job| job.len() > 1) {
                options.pages = options.pages.min(8);
            }
            let input = Input::new(kind_of(CUBE.as_bytes()), CUBE.as_bytes());
            let ended = catch_unwind(AssertUnwindSafe(|| {
                let budget = Budget::new(options.budget_s, options.budget_mib);
                let run = Run::new(|_| {}, Cancel::default(), budget);
                unwrap_input(&input, &options, &Limits::default(), &engine, &run)
            }));
            match ended.unwrap_or_else(|_| panic!("{job} panicked")) {
                Ok(result) => {
                    let atlas = &result.metrics.atlas;
                    assert!(atlas.certificate.valid || atlas.charts == 0, "{job}");
                    Some(true)
                }
                Err(error) => {
                    let code = error.job_error().expect("nobody canceled it").code.as_str();
                    let fair = ["invalid_option", "timed_out", "out_of_memory"].contains(&code);
                    assert!(fair, "{job} ended with {code}: {error}");
                    Some(false)
                }
            }
        })
        .collect();
    let (done, refused) = outcomes
        .iter()
        .flatten()
        .fold((0, 0), |(d, r), &ok| (d + usize::from(ok), r + usize::from(!ok)));
    assert!(done > 60 && refused > 5, "{done} were done and {refused} refused");
}
