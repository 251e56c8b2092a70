//! The two pictures of a result: the UV layout as SVG, and one PNG that shows a checker on the shaded
//! object, its parts and its layout, drawn on the CPU. Same input, same bytes. A contact sheet shows
//! many results, curves show a training run, and the pictures of the stages what each made of one object.

mod camera;
mod canvas;
mod checker;
mod curves;
mod layout;
mod lines;
mod occlusion;
mod outline;
mod pages;
mod palette;
mod picture;
mod ramp;
mod raster;
mod shade;
mod sheet;
mod shelves;
mod stages;
mod svg;
#[cfg(test)]
mod tests;
mod text;
mod whole_scene;

pub use curves::{Curve, curves_png};
pub use palette::part_color;
pub use picture::{PreviewError, bytes, preview_png};
pub use sheet::{SheetCell, SheetError, contact_sheet};
pub use stages::{STAGE_SIZE, StagePictures};
pub use svg::uv_layout_svg;
pub use whole_scene::{WholeScene, drawn_faces};
