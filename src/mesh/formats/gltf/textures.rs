//! Which texture coordinate sets a glTF material reads.

use std::collections::BTreeSet;

use serde_json::Value;

/// The sets that the textures of a material read, extensions included.
pub(super) fn sets(material: &Value) -> BTreeSet<u64> {
    let mut sets = BTreeSet::new();
    collect(material, &mut sets);
    sets
}

/// The set that a material's tangents belong to: that of its normal texture.
pub(in crate::mesh) fn tangent_set(material: Option<&Value>) -> u64 {
    material.and_then(|material| material.get("normalTexture")).map_or(0, set_of)
}

fn set_of(texture: &Value) -> u64 {
    let moved = texture.pointer("/extensions/KHR_texture_transform/texCoord");
    moved.or_else(|| texture.get("texCoord")).and_then(Value::as_u64).unwrap_or(0)
}

fn collect(value: &Value, sets: &mut BTreeSet<u64>) {
    match value {
        Value::Object(map) => {
            for (key, inner) in map.iter().filter(|(key, _)| *key != "extras") {
                if key.ends_with("Texture") && inner.get("index").is_some() {
                    sets.insert(set_of(inner));
                }
                collect(inner, sets);
            }
        }
        Value::Array(items) => items.iter().for_each(|item| collect(item, sets)),
        _ => {}
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn every_texture_of_a_material_is_seen() {
        let material = json!({
            "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}},
            "normalTexture": {"index": 1, "texCoord": 2},
            "extensions": {"KHR_materials_clearcoat": {"clearcoatTexture": {
                "index": 3, "texCoord": 1, "extensions": {"KHR_texture_transform": {"texCoord": 5}}}}},
            "extras": {"someTexture": {"index": 9, "texCoord": 9}},
        });
        assert_eq!(Vec::from_iter(sets(&material)), [0, 2, 5]);
        assert_eq!(tangent_set(Some(&material)), 2);
        assert_eq!(tangent_set(None), 0);
    }
}
