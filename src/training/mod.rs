//! Training of the segmentation network: examples from procedural objects (`procedural`), from our own
//! labelled folders (`folder`) and from published sets (`partnet`, `shapenet`); pre-training without
//! labels and fine-tuning with them (`trainer`), resumable, with loss curves.

mod augment;
mod checkpoint;
mod example;
mod folder;
mod joins;
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
pub use joins::{Known, know, meshes_of, procedural_mesh, save_whole, train_joins};
pub use names::name_index;
pub use procedural::{ProceduralStyle, example as procedural_example};
pub use recipe::{Data, Recipe, Task};
pub use trainer::{Event, Report, TrainError, held_out, train};
pub use validation::Score;
