//! Which glTF extensions are understood: that is, known not to hide geometry, and known not to
//! refer to accessors or buffer views in ways that are not known here.

use serde_json::Value;

use crate::mesh::import::ImportError;

/// Names, or families of names, of extensions that leave triangles where the core says they are.
const KNOWN: [&str; 16] = [
    "KHR_mesh_quantization",
    "KHR_materials_*",
    "KHR_texture_*",
    "EXT_texture_*",
    "MSFT_texture_dds",
    "MSFT_lod",
    "KHR_lights_punctual",
    "EXT_lights_image_based",
    "EXT_mesh_gpu_instancing",
    "KHR_animation_pointer",
    "KHR_node_visibility",
    "KHR_node_hoverability",
    "KHR_node_selectability",
    "KHR_xmp",
    "KHR_xmp_json_ld",
    "KHR_techniques_webgl",
];

/// Extensions that hold a compressed copy of the geometry.
pub(in crate::mesh) const COMPRESSED: [&str; 3] =
    ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression"];

/// Whether an extension is understood.
pub(in crate::mesh) fn known(name: &str) -> bool {
    COMPRESSED.contains(&name)
        || KNOWN.iter().any(|known| match known.strip_suffix('*') {
            Some(family) => name.starts_with(family),
            None => name == *known,
        })
}

/// Refuse a document that cannot be read rightly without an extension that is not supported.
pub(super) fn check_required(json: &Value) -> Result<(), ImportError> {
    let required = json.get("extensionsRequired").and_then(Value::as_array);
    for name in required.map_or(&[][..], Vec::as_slice).iter().filter_map(Value::as_str) {
        let mend = match name {
            "KHR_draco_mesh_compression" => {
                "save it without Draco, for example with `gltf-transform copy in.glb out.glb`"
            }
            _ if COMPRESSED.contains(&name) => {
                "save it without meshopt compression, for example with `gltf-transform copy in.glb out.glb`"
            }
            _ if !known(name) => "export it without this extension",
            _ => continue,
        };
        return Err(ImportError::Extension(format!(
            "the file requires the extension {name}, which is not supported: {mend}"
        )));
    }
    Ok(())
}

/// Whether the document lists an extension as used.
pub(super) fn used(json: &Value, name: &str) -> bool {
    let lists = ["extensionsUsed", "extensionsRequired"];
    lists.iter().filter_map(|list| json.get(list)?.as_array()).flatten().any(|used| used == name)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contract::ErrorCode;
    use serde_json::json;

    #[test]
    fn what_may_hide_geometry_is_refused() {
        let check = |name: &str| check_required(&json!({"extensionsRequired": [name]}));
        for name in ["KHR_mesh_quantization", "KHR_materials_unlit", "KHR_texture_transform"] {
            assert!(check(name).is_ok(), "{name}");
        }
        for name in COMPRESSED.iter().chain(&["ACME_secret_mesh"]) {
            let error = check(name).unwrap_err();
            assert_eq!(error.code(), ErrorCode::UnsupportedExtension);
            assert!(error.to_string().contains(name));
        }
        assert!(check_required(&json!({"extensionsUsed": ["ACME_secret_mesh"]})).is_ok());
    }
}
