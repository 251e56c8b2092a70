//! The node hierarchy of a glTF document: a forest no deeper than the limit, and from it each mesh
//! of the default scene at its first use.

use glam::{DMat3, DMat4, DQuat, DVec3};
use gltf::json::Node;
use serde_json::Value;

use super::view::GltfView;
use crate::mesh::import::ImportError;
use crate::mesh::scene::Instance;

/// A mesh of the default scene.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct MeshUse {
    pub mesh: usize,
    /// The node of its first use, depth-first.
    pub node: usize,
    /// World transform of its largest instance, by volume.
    pub world: DMat4,
}

/// The node hierarchy of a document.
pub(super) struct Hierarchy {
    /// The node above each node.
    pub parents: Vec<Option<usize>>,
    /// The meshes of the default scene in the order of their first use, depth-first.
    pub uses: Vec<MeshUse>,
    /// Every use of a mesh by the default scene, depth-first.
    pub instances: Vec<Instance>,
}

/// Read the hierarchy. A document without scenes shows all its root nodes.
pub(super) fn read(view: &GltfView, most_depth: u32) -> Result<Hierarchy, ImportError> {
    let parents = parents(view)?;
    check_depth(view, &parents, most_depth)?;
    let (uses, instances) = mesh_uses(view, &parents)?;
    Ok(Hierarchy { parents, uses, instances })
}

/// The meshes that are shown, and every use of them.
fn mesh_uses(
    view: &GltfView,
    parents: &[Option<usize>],
) -> Result<(Vec<MeshUse>, Vec<Instance>), ImportError> {
    let mut uses: Vec<MeshUse> = Vec::new();
    let mut instances = Vec::new();
    let mut use_of_mesh = vec![None; view.meshes.len()];
    let mut visited = vec![false; view.nodes.len()];
    let mut stack: Vec<(usize, DMat4)> =
        roots(view, parents)?.into_iter().rev().map(|root| (root, DMat4::IDENTITY)).collect();
    while let Some((index, above)) = stack.pop() {
        if std::mem::replace(&mut visited[index], true) {
            continue;
        }
        let node = &view.nodes[index];
        let world = above * local(node);
        if let Some(mesh) = node.mesh.map(|mesh| mesh.value()) {
            let first = use_of_mesh.get_mut(mesh).ok_or_else(|| {
                let held = view.meshes.len();
                ImportError::invalid(format!(
                    "node {index} shows mesh {mesh}, which does not exist: there are {held}"
                ))
            })?;
            instances.push(Instance { mesh: mesh as u32, node: index as u32, world });
            match *first {
                None => {
                    *first = Some(uses.len());
                    uses.push(MeshUse { mesh, node: index, world });
                }
                Some(at) if volume(&world) > volume(&uses[at].world) => uses[at].world = world,
                Some(_) => {}
            }
        }
        stack.extend(children(node).rev().map(|child| (child, world)));
    }
    Ok((uses, instances))
}

fn children(node: &Node) -> impl DoubleEndedIterator<Item = usize> {
    node.children.iter().flatten().map(|child| child.value())
}

/// How much a transform enlarges volumes.
fn volume(world: &DMat4) -> f64 {
    DMat3::from_mat4(*world).determinant().abs()
}

/// The transform of a node against its parent.
pub(super) fn local(node: &Node) -> DMat4 {
    if let Some(matrix) = node.matrix {
        return DMat4::from_cols_array(&matrix.map(f64::from));
    }
    let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    let turn = node.rotation.unwrap_or_default().0.map(f64::from);
    let length = DQuat::from_array(turn).length();
    let turn = if length > 0.0 && length.is_finite() {
        DQuat::from_array(turn.map(|x| x / length))
    } else {
        DQuat::IDENTITY
    };
    DMat4::from_scale_rotation_translation(
        node.scale.map_or(DVec3::ONE, vector),
        turn,
        node.translation.map_or(DVec3::ZERO, vector),
    )
}

/// The parent of each node. A node has at most one.
fn parents(view: &GltfView) -> Result<Vec<Option<usize>>, ImportError> {
    let mut parents = vec![None; view.nodes.len()];
    for (index, node) in view.nodes.iter().enumerate() {
        for child in children(node) {
            let parent = parents.get_mut(child).ok_or_else(|| {
                let held = view.nodes.len();
                ImportError::invalid(format!(
                    "node {index} has the child {child}, which does not exist: there are {held}"
                ))
            })?;
            if let Some(other) = parent.replace(index) {
                return Err(ImportError::invalid(format!(
                    "node {child} is a child of node {other} and again of node {index}: give each \
                     node one parent"
                )));
            }
        }
    }
    Ok(parents)
}

/// Follow the forest downwards from its roots: what is not reached stands in a cycle.
fn check_depth(
    view: &GltfView,
    parents: &[Option<usize>],
    most_depth: u32,
) -> Result<(), ImportError> {
    let mut reached = vec![false; parents.len()];
    let mut level: Vec<usize> = (0..parents.len()).filter(|&i| parents[i].is_none()).collect();
    let mut depth = 0;
    while let Some(&first) = level.first() {
        depth += 1;
        if depth > most_depth {
            return Err(ImportError::TooLarge(format!(
                "node {first} stands at depth {depth} of the hierarchy and the limit is \
                 {most_depth}: flatten the hierarchy"
            )));
        }
        level.iter().for_each(|&i| reached[i] = true);
        level = level.iter().flat_map(|&i| children(&view.nodes[i])).collect();
    }
    match reached.iter().position(|reached| !reached) {
        Some(node) => Err(ImportError::invalid(format!(
            "node {node} is its own ancestor: the node hierarchy must not have cycles"
        ))),
        None => Ok(()),
    }
}

/// The nodes that the default scene starts from.
fn roots(view: &GltfView, parents: &[Option<usize>]) -> Result<Vec<usize>, ImportError> {
    let wrong = |what: String| ImportError::invalid(what);
    let scenes = match view.json.get("scenes") {
        Some(Value::Array(scenes)) if !scenes.is_empty() => scenes,
        None | Some(Value::Array(_)) => {
            return Ok((0..parents.len()).filter(|&i| parents[i].is_none()).collect());
        }
        Some(_) => return Err(wrong("`scenes` must be an array".into())),
    };
    let number = match view.json.get("scene") {
        None => 0,
        Some(value) => value
            .as_u64()
            .ok_or_else(|| wrong("`scene` must be the index of a scene, a whole number".into()))?,
    };
    let scene = usize::try_from(number).ok().and_then(|i| scenes.get(i)).ok_or_else(|| {
        wrong(format!("scene {number} does not exist: there are {}", scenes.len()))
    })?;
    let nodes = match scene.get("nodes") {
        None => return Ok(Vec::new()),
        Some(nodes) => nodes
            .as_array()
            .ok_or_else(|| wrong(format!("scenes[{number}].nodes must be an array")))?,
    };
    let root = |value: &Value| {
        let index = value.as_u64().and_then(|i| usize::try_from(i).ok());
        index.filter(|&i| i < parents.len()).ok_or_else(|| {
            let held = parents.len();
            wrong(format!(
                "scene {number} shows node {value}, which does not exist: there are {held}"
            ))
        })
    };
    nodes.iter().map(root).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn uses(json: Value) -> Result<Vec<MeshUse>, ImportError> {
        read(&GltfView::new(&json, &[])?, 64).map(|hierarchy| hierarchy.uses)
    }

    #[test]
    fn first_use_gives_the_order_and_the_largest_instance_the_transform() {
        let meshes = json!([{"primitives": []}, {"primitives": []}]);
        let nodes = json!([
            {"children": [2, 1]},
            {"mesh": 0, "scale": [3, 3, 3]},
            {"mesh": 1, "children": [3]},
            {"mesh": 0, "translation": [1, 2, 3]},
            {"mesh": 1, "scale": [-2, 2, 2], "translation": [5, 0, 0]},
        ]);
        let json = json!({"meshes": meshes, "nodes": nodes, "scenes": [{"nodes": [0, 4]}]});
        let found = uses(json).unwrap();
        let order: Vec<_> = found.iter().map(|u| (u.mesh, u.node)).collect();
        assert_eq!(order, [(1, 2), (0, 3)]);
        assert_eq!(found[0].world.transform_point3(DVec3::X), DVec3::new(3.0, 0.0, 0.0));
        assert_eq!(found[1].world.transform_point3(DVec3::X), DVec3::new(3.0, 0.0, 0.0));
    }

    #[test]
    fn transforms_are_composed_downwards() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let json = json!({"meshes": [{"primitives": []}], "nodes": [
            {"matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 10,0,0,1], "children": [1]},
            {"mesh": 0, "rotation": [0, 0, 2.0 * half, 2.0 * half], "scale": [2, 1, 1]},
        ]});
        let at = uses(json).unwrap()[0].world.transform_point3(DVec3::X);
        assert!(at.distance(DVec3::new(10.0, 2.0, 0.0)) < 1e-6, "{at}");
    }

    #[test]
    fn what_is_no_forest_is_refused() {
        let refused = |nodes: Value, word: &str| {
            let error = uses(json!({"nodes": nodes})).unwrap_err().to_string();
            assert!(error.contains(word), "{error}");
        };
        refused(json!([{"children": [0]}]), "cycles");
        refused(json!([{}, {"children": [2]}, {"children": [1]}]), "cycles");
        refused(json!([{"children": [1]}, {}, {"children": [1]}]), "one parent");
        refused(json!([{"children": [1, 1]}, {}]), "one parent");
        refused(json!([{"children": [7]}]), "does not exist");
        refused(json!([{"mesh": 7}]), "does not exist");
        let chain: Vec<Value> =
            (1..=65).map(|i| json!({"children": [i]})).chain([json!({})]).collect();
        refused(json!(chain), "limit is 64");
    }

    #[test]
    fn scenes_may_be_missing_but_not_wrong() {
        assert_eq!(uses(json!({"scene": 0})).unwrap(), []);
        let meshes = json!([{"primitives": []}]);
        let json = json!({"meshes": meshes, "nodes": [{"children": [1]}, {"mesh": 0}]});
        assert_eq!(uses(json).unwrap().len(), 1);
        assert!(uses(json!({"scene": 3, "scenes": [{}]})).is_err());
        assert!(uses(json!({"scene": -1, "scenes": [{}]})).is_err());
        assert!(uses(json!({"scenes": [{"nodes": [4]}]})).is_err());
    }
}
