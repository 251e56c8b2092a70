//! Which half-edge lies on the other side of which. Only half-edges that run in opposite directions
//! are paired; at an edge of more than two faces the flattest pairs go together, so that a
//! double-sided object, in which every face stands twice, becomes two consistent sheets instead of
//! single triangles.

use glam::DVec3;

use super::NONE;

/// Two faces folded back onto each other (cosine of the angle between their normals) are not one
/// surface: they are the rim of a double-sided object.
const FOLDED: f64 = -0.9999;

/// Half-edges grouped by the (unordered) edge they run along: half-edge numbers sorted by edge, and
/// where each group starts. Half-edges of unusable faces and of zero length are left out.
pub struct EdgeGroups {
    order: Vec<u32>,
    starts: Vec<u32>,
}

impl EdgeGroups {
    /// Group the half-edges of the usable `triangles`.
    pub fn new(triangles: &[[u32; 3]], usable: &[bool]) -> Self {
        let mut keyed: Vec<(u64, u32)> = Vec::with_capacity(3 * triangles.len());
        for (f, t) in triangles.iter().enumerate().filter(|&(f, _)| usable[f]) {
            for k in 0..3 {
                let (a, b) = (u64::from(t[k]), u64::from(t[(k + 1) % 3]));
                if a != b {
                    keyed.push(((a.min(b) << 32) | a.max(b), (3 * f + k) as u32));
                }
            }
        }
        keyed.sort_unstable();
        let mut starts = Vec::new();
        for i in 0..keyed.len() {
            if i == 0 || keyed[i].0 != keyed[i - 1].0 {
                starts.push(i as u32);
            }
        }
        starts.push(keyed.len() as u32);
        Self { order: keyed.into_iter().map(|(_, h)| h).collect(), starts }
    }

    /// The half-edges of each edge, ascending.
    pub fn iter(&self) -> impl Iterator<Item = &[u32]> {
        self.starts.windows(2).map(|w| &self.order[w[0] as usize..w[1] as usize])
    }
}

/// What pairing looks at besides the edges: one entry a face each.
pub struct FaceTraits<'a> {
    /// Unit normals.
    pub normals: &'a [DVec3],
    /// Connected component within the primitive.
    pub components: &'a [u32],
    /// Faces that were turned over. A turned face pairs only with turned faces: a renderer takes the
    /// handedness of a texture from the file's winding, so that a chart of both would be mirrored in
    /// places.
    pub turned: &'a [bool],
}

/// The twin of every half-edge, [`NONE`] where there is none.
pub fn pair(triangles: &[[u32; 3]], faces: &FaceTraits, groups: &EdgeGroups) -> Vec<u32> {
    let &FaceTraits { normals, components, turned } = faces;
    let mut twin = vec![NONE; 3 * triangles.len()];
    let forward = |h: u32| {
        let (f, k) = (h as usize / 3, h as usize % 3);
        triangles[f][k] < triangles[f][(k + 1) % 3]
    };
    let mut candidates: Vec<(bool, i64, usize, u32, u32)> = Vec::new();
    for group in groups.iter() {
        let (ahead, back): (Vec<u32>, Vec<u32>) = group.iter().partition(|&&h| forward(h));
        candidates.clear();
        for (i, &a) in ahead.iter().enumerate() {
            for (j, &b) in back.iter().enumerate() {
                let (f, g) = (a as usize / 3, b as usize / 3);
                let cosine = normals[f].dot(normals[g]);
                let one_winding = turned[f] == turned[g];
                if cosine > FOLDED && f != g && one_winding {
                    // The same component first, then the flattest; among equals (faces that stand
                    // twice with one winding) the layers keep their order. The cosine is rounded so
                    // that equal layers compare equal.
                    let stranger = components[f] != components[g];
                    let angle = -(cosine * 1e6).round() as i64;
                    candidates.push((stranger, angle, i.abs_diff(j), a, b));
                }
            }
        }
        candidates.sort_unstable();
        for &(_, _, _, a, b) in &candidates {
            if twin[a as usize] == NONE && twin[b as usize] == NONE {
                twin[a as usize] = b;
                twin[b as usize] = a;
            }
        }
    }
    twin
}
