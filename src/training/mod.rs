//! Training of the segmentation network: examples from procedural objects (`procedural`) and from data sets
//! (`data_sets`); pre-training without labels and fine-tuning with them (`trainer`),
//! resumable, with loss curves; the boundary classifier (`joins`), from labelled meshes (`labelled`).

mod augment;
mod checkpoint;
mod committee;
mod data_sets;
#[cfg(test)]
mod data_sets_tests;
mod example;
mod folder;
mod joins;
mod labelled;
mod loss;
mod names;
mod partnet_tree;
mod points;
mod procedural;
mod recipe;
mod shapenet_part;
mod structure;
#[cfg(test)]
mod tests;
mod trainer;
mod union;
mod validation;
mod weather;

pub use data_sets::{load_examples, load_meshes};
pub use example::Example;
pub use folder::{FolderError, LabelledMesh, read as read_labelled};
pub use joins::{Known, know, train_joins};
pub use labelled::procedural_mesh;
pub use names::name_index;
pub use procedural::{ProceduralStyle, example as procedural_example};
pub use recipe::{Data, Recipe, Task};
pub use trainer::{Event, Report, TrainError, held_out, train};
pub use validation::Score;
