//! The reader of Wavefront OBJ (Wavefront, "Object Files", 1995): polygonal geometry, with vertex
//! colours behind the positions as most tools write them. Curves, surfaces, points and lines are
//! passed over.

use std::collections::BTreeMap;

use super::document::{ObjCorner, ObjDocument, ObjRun};
use crate::contract::{Limits, Warning, WarningCode};
use crate::mesh::import::ImportError;
use crate::mesh::scene::ABSENT;

/// Changes of group or material that a file may have: each becomes a primitive.
pub(super) const MOST_RUNS: usize = 16_384;
/// Vertices, normals or texture coordinates that a file may have, per triangle that it may have.
const MOST_VERTICES_PER_TRIANGLE: u64 = 4;

/// Bytes of a name that are kept.
const NAME_LENGTH: usize = 120;

/// A document and its warnings.
type Read = (ObjDocument, Vec<Warning>);

/// Read an OBJ file.
pub(super) fn read(bytes: &[u8], limits: &Limits) -> Result<Read, ImportError> {
    let mut reader = Reader {
        limits,
        document: ObjDocument::default(),
        line: 0,
        group: String::new(),
        material: String::new(),
        material_number: Some(None),
        materials: BTreeMap::new(),
        triangles: 0,
        polygon: Vec::new(),
        last: Default::default(),
        counts: Counts::default(),
    };
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    let mut joined = Vec::new();
    for line in bytes.split(|&b| b == b'\n') {
        reader.line += 1;
        let line = line.trim_ascii();
        if let Some(start) = line.strip_suffix(b"\\") {
            joined.extend_from_slice(start);
            joined.push(b' ');
        } else if joined.is_empty() {
            reader.statement(line)?;
        } else {
            joined.extend_from_slice(line);
            reader.statement(&joined)?;
            joined.clear();
        }
    }
    if !joined.is_empty() {
        reader.statement(&joined)?;
    }
    reader.finish()
}

/// What is worth a warning at the end.
#[derive(Default)]
struct Counts {
    short_faces: u64,
    bad_colors: u64,
    bad_normals: u64,
    bad_texcoords: u64,
    libraries: u64,
}

struct Reader<'a> {
    limits: &'a Limits,
    document: ObjDocument,
    line: u64,
    /// Name of the current object or group.
    group: String,
    /// Name of the current material, or empty.
    material: String,
    /// Its number, once a face has used it.
    material_number: Option<Option<u32>>,
    /// Numbers of the materials in use.
    materials: BTreeMap<String, u32>,
    triangles: u64,
    /// Corners of the current face.
    polygon: Vec<ObjCorner>,
    /// The highest index used of positions, texture coordinates and normals, and its line: a face
    /// may stand before its vertices.
    last: [(u32, u64); 3],
    counts: Counts,
}

impl Reader<'_> {
    fn wrong<T>(&self, what: impl std::fmt::Display) -> Result<T, ImportError> {
        Err(ImportError::invalid(format!("line {} of the OBJ file: {what}", self.line)))
    }

    fn statement(&mut self, line: &[u8]) -> Result<(), ImportError> {
        let (word, rest) = match line.iter().position(u8::is_ascii_whitespace) {
            Some(end) => (&line[..end], line[end..].trim_ascii()),
            None => (line, &line[..0]),
        };
        match word {
            b"v" => self.vertex(rest),
            b"vt" => self.texcoord(rest),
            b"vn" => self.normal(rest),
            b"f" | b"fo" => self.face(rest),
            b"o" | b"g" => {
                self.group = name(rest);
                Ok(())
            }
            b"usemtl" => {
                self.material = name(rest);
                self.material_number = None;
                Ok(())
            }
            b"mtllib" => {
                self.counts.libraries += 1;
                Ok(())
            }
            _ => Ok(()),
        }
    }

    /// The numbers of a statement, at most eight.
    fn numbers<'n>(&self, rest: &[u8], out: &'n mut [f64; 8]) -> Result<&'n [f64], ImportError> {
        let mut count = 0;
        for word in words(rest).take(out.len()) {
            match std::str::from_utf8(word).ok().and_then(|word| word.parse().ok()) {
                Some(number) => out[count] = number,
                None => {
                    return self.wrong(format!("{:?} is no number", String::from_utf8_lossy(word)));
                }
            }
            count += 1;
        }
        Ok(&out[..count])
    }

    fn vertex(&mut self, rest: &[u8]) -> Result<(), ImportError> {
        let mut room = [0.0; 8];
        let numbers = self.numbers(rest, &mut room)?;
        let [x, y, z, more @ ..] = numbers else {
            return self
                .wrong(format!("a vertex needs x, y and z and has {} numbers", numbers.len()));
        };
        if ![x, y, z].iter().all(|c| (**c as f32).is_finite()) {
            return self.wrong(format!(
                "the position ({x}, {y}, {z}) is not finite in single precision: repair the mesh"
            ));
        }
        self.check_room(self.document.positions.len(), "vertices")?;
        self.document.positions.push([*x, *y, *z].map(|c| c as f32));
        let held = self.document.positions.len();
        // Colours stand behind x y z, or behind x y z w.
        if let [.., r, g, b] = *more {
            let mut bad = false;
            let color = [r, g, b].map(|c| {
                bad |= !(0.0..=1.0).contains(&c);
                if c.is_nan() { 1.0 } else { c.clamp(0.0, 1.0) as f32 }
            });
            self.counts.bad_colors += u64::from(bad);
            let colors = self.document.colors.get_or_insert_default();
            colors.resize(held - 1, [1.0; 3]);
            colors.push(color);
        }
        Ok(())
    }

    fn texcoord(&mut self, rest: &[u8]) -> Result<(), ImportError> {
        let mut room = [0.0; 8];
        let [u, v] = match *self.numbers(rest, &mut room)? {
            [] => return self.wrong("a texture coordinate needs a number"),
            [u] => [u as f32, 0.0],
            [u, v, ..] => [u as f32, v as f32],
        };
        self.check_room(self.document.texcoords.len(), "texture coordinates")?;
        let finite = u.is_finite() && v.is_finite();
        self.counts.bad_texcoords += u64::from(!finite);
        self.document.texcoords.push(if finite { [u, v] } else { [0.0; 2] });
        Ok(())
    }

    fn normal(&mut self, rest: &[u8]) -> Result<(), ImportError> {
        let mut room = [0.0; 8];
        let [x, y, z, ..] = *self.numbers(rest, &mut room)? else {
            return self.wrong("a normal needs x, y and z");
        };
        self.check_room(self.document.normals.len(), "normals")?;
        let unit = glam::DVec3::new(x, y, z).try_normalize();
        self.counts.bad_normals += u64::from(unit.is_none());
        self.document.normals.push(unit.unwrap_or_default().as_vec3().to_array());
        Ok(())
    }

    fn check_room(&self, held: usize, what: &str) -> Result<(), ImportError> {
        let most = self.limits.triangles.saturating_mul(MOST_VERTICES_PER_TRIANGLE);
        if (held as u64) < most.min(u64::from(ABSENT) - 1) {
            return Ok(());
        }
        Err(ImportError::TooLarge(format!(
            "line {} of the OBJ file: more than {most} {what}, the limit: simplify it or split it \
             into several files",
            self.line
        )))
    }

    /// The number of the current material.
    fn material(&mut self) -> Option<u32> {
        if let Some(number) = self.material_number {
            return number;
        }
        let document = &mut self.document;
        let number = (!self.material.is_empty()).then(|| {
            *self.materials.entry(self.material.clone()).or_insert_with_key(|name| {
                document.materials.push(name.clone());
                document.materials.len() as u32 - 1
            })
        });
        self.material_number = Some(number);
        number
    }

    fn face(&mut self, rest: &[u8]) -> Result<(), ImportError> {
        let mut polygon = std::mem::take(&mut self.polygon);
        polygon.clear();
        for word in words(rest) {
            polygon.push(self.corner(word)?);
            self.check_triangles(polygon.len())?;
        }
        if polygon.len() < 3 {
            self.counts.short_faces += 1;
        } else {
            self.add(&polygon)?;
        }
        self.polygon = polygon;
        Ok(())
    }

    fn corner(&mut self, word: &[u8]) -> Result<ObjCorner, ImportError> {
        let mut parts = word.split(|&b| b == b'/');
        let mut part = || parts.next().unwrap_or_default();
        let [position, texcoord, normal] = [part(), part(), part()];
        let held = &self.document;
        let held = [held.positions.len(), held.texcoords.len(), held.normals.len()];
        let position = self.index(position, held[0], 0)?;
        if position == ABSENT {
            let shown = String::from_utf8_lossy(word);
            return self.wrong(format!("the corner {shown:?} names no vertex"));
        }
        let texcoord = self.index(texcoord, held[1], 1)?;
        let normal = self.index(normal, held[2], 2)?;
        Ok(ObjCorner { position, texcoord, normal })
    }

    /// An index of a corner: from 1, or from −1 backwards. `list` says which list it points into.
    fn index(&mut self, word: &[u8], held: usize, list: usize) -> Result<u32, ImportError> {
        if word.is_empty() {
            return Ok(ABSENT);
        }
        let number = std::str::from_utf8(word).ok().and_then(|word| word.parse::<i64>().ok());
        let index = match number {
            Some(n @ 1..) => n - 1,
            Some(n @ ..=-1) => n.saturating_add(held as i64),
            _ => -1,
        };
        let what = LISTS[list];
        match u32::try_from(index) {
            Ok(index) if index != ABSENT => {
                if (index as usize) >= held && index >= self.last[list].0 {
                    self.last[list] = (index, self.line);
                }
                Ok(index)
            }
            _ => self.wrong(format!(
                "{:?} is no index of a {what}: there are {held} before this line, counted from 1, \
                 or from -1 backwards",
                String::from_utf8_lossy(word)
            )),
        }
    }

    /// Whether a polygon of so many corners still fits.
    fn check_triangles(&self, corners: usize) -> Result<(), ImportError> {
        if self.triangles + corners as u64 <= self.limits.triangles.saturating_add(2) {
            return Ok(());
        }
        Err(ImportError::TooLarge(format!(
            "line {} of the OBJ file: more than {} triangles, the limit: simplify it or split it \
             into several files",
            self.line, self.limits.triangles
        )))
    }

    /// Add a polygon to its run.
    fn add(&mut self, polygon: &[ObjCorner]) -> Result<(), ImportError> {
        self.triangles += polygon.len() as u64 - 2;
        let material = self.material();
        let document = &mut self.document;
        if document.groups.last() != Some(&self.group) {
            document.groups.push(self.group.clone());
        }
        let group = document.groups.len() as u32 - 1;
        let goes_on = |run: &ObjRun| run.group == group && run.material == material;
        if !document.runs.last().is_some_and(goes_on) {
            if document.runs.len() == MOST_RUNS {
                return Err(ImportError::TooLarge(format!(
                    "line {} of the OBJ file: the group or the material changes more than \
                     {MOST_RUNS} times, the limit: sort the faces by material",
                    self.line
                )));
            }
            document.runs.push(ObjRun { group, material, ..ObjRun::default() });
        }
        if let Some(run) = document.runs.last_mut() {
            run.add(polygon);
        }
        Ok(())
    }

    fn finish(mut self) -> Result<Read, ImportError> {
        let document = &mut self.document;
        let held = [document.positions.len(), document.texcoords.len(), document.normals.len()];
        for (list, (&(index, line), held)) in self.last.iter().zip(held).enumerate() {
            if line > 0 && index as usize >= held {
                return Err(ImportError::invalid(format!(
                    "line {line} of the OBJ file: {} is no index of a {}: the file has {held}",
                    u64::from(index) + 1,
                    LISTS[list]
                )));
            }
        }
        if let Some(colors) = &mut document.colors {
            colors.resize(held[0], [1.0; 3]);
        }
        let counts = &self.counts;
        let warnings = [
            (
                counts.short_faces,
                WarningCode::ShortFaces,
                "faces of fewer than three corners, left out",
            ),
            (counts.bad_colors, WarningCode::BadColors, "vertex colours outside 0 to 1, clamped"),
            (
                counts.bad_normals,
                WarningCode::BadNormals,
                "normals without a direction: groups that use them lose their normals",
            ),
            (
                counts.bad_texcoords,
                WarningCode::BadTexcoords,
                "texture coordinates that are not finite, set to 0",
            ),
            (
                counts.libraries,
                WarningCode::MtllibIgnored,
                "material libraries, not read: materials keep their names only",
            ),
        ];
        let warnings = warnings.into_iter().filter(|(count, ..)| *count > 0);
        let warnings = warnings
            .map(|(count, code, what)| Warning::new(code, format!("{what}: {count} in the file")));
        let warnings = warnings.collect();
        Ok((self.document, warnings))
    }
}

/// The name in a statement, cut to a bearable length.
fn name(rest: &[u8]) -> String {
    String::from_utf8_lossy(&rest[..rest.len().min(NAME_LENGTH)]).into_owned()
}

/// What the three indices of a corner point at.
const LISTS: [&str; 3] = ["vertex", "texture coordinate", "normal"];

/// The words of a statement, up to a comment.
fn words(rest: &[u8]) -> impl Iterator<Item = &[u8]> {
    rest.split(u8::is_ascii_whitespace)
        .filter(|word| !word.is_empty())
        .take_while(|word| word[0] != b'#')
}
