//! Training of the segmentation network: examples from procedural objects (`procedural`) and from our own
//! labelled folders (`folder`); pre-training without labels and fine-tuning with them (`trainer`),
//! resumable, with loss curves; the judge of joins (`joins`), from labelled meshes (`labelled`).

mod augment;
mod checkpoint;
mod example;
mod folder;
mod joins;
mod labelled;
mod loss;
mod names;
mod procedural;
mod recipe;
mod structure;
#[cfg(test)]
mod tests;
mod trainer;
mod union;
mod validation;
mod weather;

pub use example::Example;
pub use folder::{FolderError, LabelledMesh, load_folder, read as read_labelled};
pub use joins::{Known, know, train_joins};
pub use labelled::{meshes_of, procedural_mesh};
pub use names::name_index;
pub use procedural::{ProceduralStyle, example as procedural_example};
pub use recipe::{Data, Recipe, Task};
pub use trainer::{Event, Report, TrainError, held_out, train};
pub use validation::Score;
