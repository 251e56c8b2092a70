//! What a run promises: it learns, it can be ended and taken up again without a trace, another recipe
//! does not overwrite it, and families are held out whole.

use std::path::Path;

use super::*;
use crate::contract::{Budget, Cancel, Run};
use crate::device::Device;
use crate::segmentation::point_mae::ModelSize;

fn recipe(task: Task, steps: u32) -> Recipe {
    let data = Data {
        procedural: 10,
        folders: Vec::new(),
        licences: Vec::new(),
        real_percent: 0,
        held_out_percent: 20,
    };
    let (size, start) = (ModelSize::Small, None);
    Recipe { task, size, data, steps, batch: 2, rate: 1e-3, seed: 3, start, every: 4 }
}

fn go(recipe: &Recipe, folder: &Path) -> Result<Report, TrainError> {
    train(recipe, folder, &Device::cpu(), &Run::quiet(), &mut |_| {})
}

#[test]
fn a_run_that_was_ended_goes_on_as_if_it_had_not() {
    for task in [Task::Finetune, Task::Pretrain] {
        let (whole, parts) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let recipe = recipe(task, 8);
        let report = go(&recipe, whole.path()).unwrap();
        assert_eq!(report.steps, 8);

        let cancel = Cancel::default();
        let run = Run::new(|_| {}, cancel.clone(), Budget::default());
        let ended = train(&recipe, parts.path(), &Device::cpu(), &run, &mut |event| {
            // Past the checkpoint at step 4.
            if matches!(event, Event::Step(6, _)) {
                cancel.cancel();
            }
        });
        assert!(matches!(ended, Err(TrainError::Canceled(_))), "{ended:?}");
        assert_eq!(go(&recipe, parts.path()).unwrap().steps, 8);
        for file in ["model.safetensors", "best.safetensors"] {
            let read = |dir: &tempfile::TempDir| std::fs::read(dir.path().join(file)).unwrap();
            assert!(read(&whole) == read(&parts), "{task:?}: {file} differs");
        }
        let picture = std::fs::read(whole.path().join("curves.png")).unwrap();
        assert!(picture.starts_with(b"\x89PNG"));
    }
}

#[test]
fn fine_tuning_learns_and_starts_from_a_pre_trained_encoder() {
    let (first, second) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    go(&recipe(Task::Pretrain, 4), first.path()).unwrap();
    let start = Some(first.path().join("model.safetensors"));
    let recipe = Recipe { start, every: 40, ..recipe(Task::Finetune, 40) };
    let mut losses = Vec::new();
    let device = Device::cpu();
    let report = train(&recipe, second.path(), &device, &Run::quiet(), &mut |event| {
        if let Event::Step(_, loss) = event {
            losses.push(loss);
        }
    });
    let mean = |l: &[f64]| l.iter().sum::<f64>() / l.len() as f64;
    let (early, late) = (mean(&losses[..8]), mean(&losses[32..]));
    assert!(late < 0.8 * early, "{early} → {late}");
    let score = report.unwrap().score.unwrap();
    assert!(score.objects > 0 && score.miou > 0.1 && score.rand > 0.3, "{score:?}");
}

#[test]
fn a_folder_of_another_recipe_is_left_alone() {
    let folder = tempfile::tempdir().unwrap();
    go(&recipe(Task::Finetune, 1), folder.path()).unwrap();
    let error = go(&recipe(Task::Finetune, 2), folder.path()).unwrap_err();
    assert!(matches!(error, TrainError::OtherRecipe(_)), "{error}");
    let mut nothing = recipe(Task::Finetune, 1);
    nothing.data.procedural = 0;
    let empty = tempfile::tempdir().unwrap();
    assert_eq!(go(&nothing, empty.path()).unwrap_err(), TrainError::NoExamples);
}

#[test]
fn families_are_held_out_in_the_share_that_was_asked_for() {
    let families: Vec<String> = (0..2000).map(|i| format!("family_{i}")).collect();
    let share = |percent| {
        families.iter().filter(|f| held_out(f, 1, percent)).count() as f64 / families.len() as f64
    };
    assert!((share(20) - 0.2).abs() < 0.03 && share(0) == 0.0);
    assert!(
        families.iter().all(|f| !held_out(f, 1, 20) || held_out(f, 1, 50)),
        "more holds the same"
    );
}

#[test]
fn a_labelled_folder_is_read_with_its_names_and_licences() {
    let folder = tempfile::tempdir().unwrap();
    let cube = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
        f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    for (name, licence) in [("free", "MIT (repo)"), ("bound", "non-commercial")] {
        write(&format!("{name}.obj"), cube);
        write(&format!("{name}.labels.txt"), "0\n0\n1\n1\n1\n1\n1\n1\n1\n1\n1\n1\n");
        let about = format!(
            "{{\"family\": \"f_{name}\", \"category\": \"Chair\", \"licence\": \"{licence}\",
              \"labels\": {{\"0\": \"seat\", \"1\": \"part_01\"}}, \"instances\": null}}"
        );
        write(&format!("{name}.parts.json"), &about);
    }
    let all = load_examples(folder.path(), &[], 1, &Run::quiet()).unwrap();
    assert_eq!((all.0.len(), all.1), (2, 0));
    let licences = ["MIT".to_owned(), "CC-BY-4.0".to_owned()];
    let (free, left_out) = load_examples(folder.path(), &licences, 1, &Run::quiet()).unwrap();
    assert_eq!((free.len(), left_out), (1, 1));
    let example = &free[0];
    assert_eq!((example.id.as_str(), example.family.as_str()), ("free", "f_free"));
    let seat = name_index("seat").map_or(-1, |i| i as i32);
    for (&part, &name) in example.part.iter().zip(&example.name) {
        assert_eq!(name, if part == 0 { seat } else { -1 });
    }
    write("free.labels.txt", "0\n");
    let error = load_examples(folder.path(), &licences, 1, &Run::quiet()).unwrap_err();
    assert!(
        error.file.ends_with("free.labels.txt") && error.reason.contains("12 faces"),
        "{error}"
    );
}
