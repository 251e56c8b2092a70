//! What the many names of parts in the data sets come to in the network's vocabulary.

use crate::segmentation::point_mae::NAMES;

/// Other words for the names of the vocabulary: procedural kinds, clvrai's roles, IKEA-Manual's
/// automatic names, PartNet's leaves.
const SYNONYMS: [(&str, &str); 83] = [
    ("chair_seat", "seat"),
    ("chair_back", "back"),
    ("chair_arm", "arm"),
    ("chair_base", "base"),
    ("tabletop", "top"),
    ("top_panel", "top"),
    ("countertop", "top"),
    ("board", "panel"),
    ("side", "panel"),
    ("side_panel", "panel"),
    ("bottom_panel", "panel"),
    ("divider", "panel"),
    ("back_panel", "panel"),
    ("vertical_panel", "panel"),
    ("horizontal_panel", "shelf"),
    ("backrest", "back"),
    ("spindle", "back"),
    ("slat", "back"),
    ("rail", "back"),
    ("shell", "back"),
    ("headboard", "back"),
    ("armrest", "arm"),
    ("arm_rest", "arm"),
    ("stretcher_or_support", "stretcher"),
    ("bar_stretcher", "stretcher"),
    ("apron", "frame"),
    ("mattress", "cushion"),
    ("pillow", "cushion"),
    ("footboard", "panel"),
    ("knob", "handle"),
    ("button", "handle"),
    ("camera", "lens"),
    ("grip", "handle"),
    ("bail", "handle"),
    ("pull", "handle"),
    ("lever", "handle"),
    ("switch", "handle"),
    ("display", "screen"),
    ("monitor", "screen"),
    ("base_frame", "base"),
    ("screen_frame", "frame"),
    ("touchpad_surface", "keyboard"),
    ("touchpad", "keyboard"),
    ("key", "keyboard"),
    ("cap", "lid"),
    ("cover", "lid"),
    ("cylinder", "body"),
    ("container", "body"),
    ("bowl", "body"),
    ("fuselage", "body"),
    ("hull", "body"),
    ("hub", "body"),
    ("ball", "body"),
    ("jaw", "blade"),
    ("bolster", "neck"),
    ("collar", "neck"),
    ("shank", "stem"),
    ("pin", "stem"),
    ("shaft", "stem"),
    ("post", "pole"),
    ("column", "pole"),
    ("plinth", "base"),
    ("stand", "base"),
    ("deck", "body"),
    ("truck", "frame"),
    ("castor", "wheel"),
    ("caster", "wheel"),
    ("fin", "tail"),
    ("rudder", "tail"),
    ("stabilizer", "tail"),
    ("stabiliser", "tail"),
    ("turbine", "engine"),
    ("nacelle", "engine"),
    ("glass", "lens"),
    ("lamp_shade", "shade"),
    ("ring", "rim"),
    ("flange", "rim"),
    ("bridge", "frame"),
    ("bezel", "frame"),
    ("feet", "foot"),
    ("glide", "foot"),
    ("leg_bar", "leg"),
    ("tube", "pole"),
];

/// Index into [`NAMES`] of a part's name; composites and names that say nothing have none.
pub fn name_index(name: &str) -> Option<usize> {
    let stem = name.rsplit('/').next().unwrap_or(name).trim().to_ascii_lowercase();
    let stem = stem.trim_end_matches(|c: char| c.is_ascii_digit() || c == '_' || c == ' ');
    let find = |word: &str| NAMES.iter().position(|n| *n == word);
    find(stem).or_else(|| {
        SYNONYMS.iter().find(|(other, _)| *other == stem).and_then(|(_, word)| find(word))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_and_synonyms_are_understood_and_composites_are_not() {
        let of = |name| name_index(name).map(|i| NAMES[i]);
        assert_eq!(of("leg_2"), Some("leg"));
        assert_eq!(of("chair/chair_arm/armrest"), Some("arm"));
        assert_eq!(of("leg_back_frame"), None);
        assert_eq!(of("part_07"), None);
        for (word, name) in SYNONYMS {
            assert!(NAMES.contains(&name), "{word} means {name}, which is no name");
            assert!(!NAMES.contains(&word), "{word} is a name itself");
        }
    }
}
