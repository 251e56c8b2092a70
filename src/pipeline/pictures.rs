//! The pictures of a result: whether they are drawn, and the two of an atlas side by side.

use super::error::Cause;
use super::instances::Instances;
use super::parts::Found;
use crate::contract::{GaveUp, Run, Scarce, Stage, UnwrapOptions};
use crate::metrics::Measured;
use crate::preview;
use crate::tasks;

/// Whether pictures are asked for and there is time and memory for them; if there is not, that is recorded.
pub fn draws(
    found: &Found,
    instances: Option<&Instances>,
    pages: u32,
    options: &UnwrapOptions,
    run: &Run,
) -> bool {
    if !options.preview {
        return false;
    }
    let own = found.surface.face_count();
    let faces = instances.map_or(own, |instances| instances.drawn_faces(own));
    if preview::bytes(faces, pages) > run.budget.spare_bytes() {
        run.give_up(Stage::Preview, GaveUp::Pictures, Scarce::Memory);
        return false;
    }
    !run.skips(Stage::Measure, GaveUp::Pictures)
}

/// The drawing of the layout (SVG) and the preview (PNG) of an atlas.
pub fn of_atlas(
    measured: &Measured,
    found: &Found,
    instances: Option<&Instances>,
    run: &Run,
) -> Result<(Vec<u8>, Vec<u8>), Cause> {
    let names: Vec<String> = found.parts.parts.iter().map(|p| p.name.clone()).collect();
    let shown = instances.map(|instances| instances.shown(measured));
    let shown = shown.as_ref().map(|shown| shown.measured(measured));
    let (layout, picture) = tasks::join(
        "pictures",
        || preview::uv_layout_svg(measured, &names, &run.cancel),
        || preview::preview_png(measured, shown.as_ref(), run),
    );
    Ok((layout?.into_bytes(), picture?))
}
