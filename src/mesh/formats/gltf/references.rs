//! Every place where a glTF document refers to an accessor or a buffer view, and what follows from
//! knowing them all: what nothing refers to can be left out.

use serde_json::Value;

use super::extensions;

/// Leave out the accessors and buffer views that nothing refers to any more. Returns which buffer
/// views were kept. If the document uses an extension whose references are not known, nothing is
/// left out.
pub(super) fn prune(json: &mut Value) -> Vec<usize> {
    let views = length(json, "bufferViews");
    if uses_unknown_extensions(json) {
        return (0..views).collect();
    }
    let mut live = vec![false; length(json, "accessors")];
    accessors(json, &mut |reference| mark(&mut live, reference));
    let numbers = compact(json, "accessors", &live);
    accessors(json, &mut |reference| renumber(&numbers, reference));

    let mut live = vec![false; views];
    buffer_views(json, &mut |reference| mark(&mut live, reference));
    let numbers = compact(json, "bufferViews", &live);
    buffer_views(json, &mut |reference| renumber(&numbers, reference));
    (0..views).filter(|&view| live[view]).collect()
}

fn length(json: &Value, list: &str) -> usize {
    json.get(list).and_then(Value::as_array).map_or(0, Vec::len)
}

fn mark(live: &mut [bool], reference: &Value) {
    let index = reference.as_u64().and_then(|i| usize::try_from(i).ok());
    if let Some(live) = index.and_then(|i| live.get_mut(i)) {
        *live = true;
    }
}

/// Keep the live elements of a list. Returns the new number of each.
fn compact(json: &mut Value, list: &str, live: &[bool]) -> Vec<u64> {
    if let Some(items) = json.get_mut(list).and_then(Value::as_array_mut) {
        let mut live = live.iter();
        items.retain(|_| live.next().copied().unwrap_or(true));
        if items.is_empty() {
            json.as_object_mut().map(|object| object.shift_remove(list));
        }
    }
    let mut next = 0;
    let number = |&live: &bool| {
        next += u64::from(live);
        next.saturating_sub(1)
    };
    live.iter().map(number).collect()
}

fn renumber(numbers: &[u64], reference: &mut Value) {
    let index = reference.as_u64().and_then(|i| usize::try_from(i).ok());
    if let Some(&number) = index.and_then(|i| numbers.get(i)) {
        *reference = number.into();
    }
}

/// Visit every reference to an accessor.
fn accessors(json: &mut Value, visit: &mut impl FnMut(&mut Value)) {
    for primitive in items(json, "meshes").flat_map(|mesh| items(mesh, "primitives")) {
        fields(primitive.get_mut("attributes")).for_each(&mut *visit);
        primitive.get_mut("indices").into_iter().for_each(&mut *visit);
        for target in items(primitive, "targets") {
            fields(Some(target)).for_each(&mut *visit);
        }
    }
    for skin in items(json, "skins") {
        skin.get_mut("inverseBindMatrices").into_iter().for_each(&mut *visit);
    }
    for sampler in items(json, "animations").flat_map(|animation| items(animation, "samplers")) {
        for key in ["input", "output"] {
            sampler.get_mut(key).into_iter().for_each(&mut *visit);
        }
    }
    for node in items(json, "nodes") {
        let instances = node.pointer_mut("/extensions/EXT_mesh_gpu_instancing/attributes");
        fields(instances).for_each(&mut *visit);
    }
}

fn items<'a>(value: &'a mut Value, list: &str) -> impl Iterator<Item = &'a mut Value> + use<'a> {
    value.get_mut(list).and_then(Value::as_array_mut).into_iter().flatten()
}

fn fields(value: Option<&mut Value>) -> impl Iterator<Item = &mut Value> {
    value.and_then(Value::as_object_mut).into_iter().flat_map(|map| map.values_mut())
}

/// Visit every reference to a buffer view: the property has one name wherever it stands. The
/// parser bounds the depth.
fn buffer_views(value: &mut Value, visit: &mut impl FnMut(&mut Value)) {
    match value {
        Value::Object(map) => {
            for (key, inner) in map.iter_mut().filter(|(key, _)| *key != "extras") {
                match key == "bufferView" {
                    true => visit(inner),
                    false => buffer_views(inner, visit),
                }
            }
        }
        Value::Array(items) => items.iter_mut().for_each(|item| buffer_views(item, visit)),
        _ => {}
    }
}

fn uses_unknown_extensions(value: &Value) -> bool {
    match value {
        Value::Object(map) => map.iter().filter(|(key, _)| *key != "extras").any(|(key, inner)| {
            let unknown = |names: &serde_json::Map<String, Value>| {
                names.keys().any(|name| !extensions::known(name))
            };
            (key == "extensions" && inner.as_object().is_some_and(unknown))
                || uses_unknown_extensions(inner)
        }),
        Value::Array(items) => items.iter().any(uses_unknown_extensions),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn document() -> Value {
        json!({
            "meshes": [{"primitives": [
                {"attributes": {"POSITION": 2}, "indices": 3, "targets": [{"POSITION": 4}]}
            ]}],
            "skins": [{"inverseBindMatrices": 5}],
            "animations": [{"samplers": [{"input": 6, "output": 7}]}],
            "nodes": [{"extensions": {"EXT_mesh_gpu_instancing": {"attributes": {"SCALE": 9}}}}],
            "images": [{"bufferView": 8}],
            "accessors": (0..10).map(|i| json!({"bufferView": i % 8, "extras": {"was": i}})).collect::<Vec<_>>(),
            "bufferViews": (0..9).map(|i| json!({"was": i})).collect::<Vec<_>>(),
        })
    }

    #[test]
    fn every_reference_still_points_at_what_it_did() {
        let mut json = document();
        assert_eq!(prune(&mut json), [1, 2, 3, 4, 5, 6, 7, 8]);
        let was = |path: &str| {
            let number = json.pointer(path).and_then(Value::as_u64).unwrap();
            json["accessors"][number as usize]["extras"]["was"].as_u64().unwrap()
        };
        let paths = [
            ("/meshes/0/primitives/0/attributes/POSITION", 2),
            ("/meshes/0/primitives/0/indices", 3),
            ("/meshes/0/primitives/0/targets/0/POSITION", 4),
            ("/skins/0/inverseBindMatrices", 5),
            ("/animations/0/samplers/0/input", 6),
            ("/animations/0/samplers/0/output", 7),
            ("/nodes/0/extensions/EXT_mesh_gpu_instancing/attributes/SCALE", 9),
        ];
        for (path, old) in paths {
            assert_eq!(was(path), old, "{path}");
        }
        for accessor in json["accessors"].as_array().unwrap() {
            let view = accessor["bufferView"].as_u64().unwrap() as usize;
            let old = accessor["extras"]["was"].as_u64().unwrap() % 8;
            assert_eq!(json["bufferViews"][view]["was"], old);
        }
        let image = json["images"][0]["bufferView"].as_u64().unwrap() as usize;
        assert_eq!(json["bufferViews"][image]["was"], 8);
    }

    #[test]
    fn nothing_moves_under_an_unknown_extension() {
        let mut json = document();
        json["extensions"] = json!({"ACME_points": {"accessor": 0}});
        let before = json.clone();
        assert_eq!(prune(&mut json).len(), 9);
        assert_eq!(json, before);
    }

    #[test]
    fn broken_references_are_left_as_they_are() {
        let mut json = json!({"animations": [{"samplers": [{"input": 99, "output": "x"}]}],
            "accessors": [{}], "images": [{"bufferView": 99}], "bufferViews": [{}]});
        assert!(prune(&mut json).is_empty());
        assert_eq!(json["animations"][0]["samplers"][0]["input"], 99);
        assert!(json.get("accessors").is_none());
    }
}
