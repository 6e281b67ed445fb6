//! Triangles from Wavefront OBJ text.
//!
//! Understood are `v` and `f` (with `v`, `v/vt`, `v//vn`, `v/vt/vn`; indices from 1, or from −1 backwards), comments
//! and lines continued with `\`. `vn vt g o s usemtl mtllib` are skipped: light is blocked by geometry alone. A face
//! with more than three corners is cut into a fan of triangles about its first corner, which is right only if the face
//! is convex and flat; one that is not (to 1e-6 of its size: files often hold six digits) is refused, as is everything
//! else.

use glam::DVec3;

use super::schema::MAX_MAGNITUDE;
use crate::errors::errors;
use crate::geometry::{Mesh, ShapeError};
use crate::intake::{OBJ_STATEMENT, TRIANGLES};

/// How far a corner may lie off its face's plane, or turn the wrong way, in units of the face's size.
const FLAT: f64 = 1e-6;

errors! {
    /// Why OBJ text was refused; lines count from 1.
    #[derive(Clone, Debug, PartialEq)]
    #[non_exhaustive]
    pub enum ObjError {
        #[error(
            "line {line}: `{said}` is no OBJ statement that a mesh of triangles needs; v and f are read, vn vt g o s usemtl mtllib skipped"
        )]
        Statement { line: usize, said: String },
        #[error("line {line}: `{said}` is not a finite number of at most 1e30 in magnitude")]
        Number { line: usize, said: String },
        #[error("line {line}: a vertex with {said} numbers; it has 3 (x y z), 4 (with a weight) or 6 (with a colour)")]
        VertexNumbers { line: usize, said: usize },
        #[error("line {line}: a face with {said} corners; it has at least 3")]
        FaceCorners { line: usize, said: usize },
        #[error("line {line}: `{said}` is no corner of a face; v, v/vt, v//vn and v/vt/vn are understood")]
        Corner { line: usize, said: String },
        #[error("line {line}: a corner names vertex {said}, but {vertices} vertices stand above it")]
        NoSuchVertex { line: usize, said: i64, vertices: usize },
        #[error("line {line}: a face of {corners} corners that is not flat and convex; cut it into triangles")]
        NotFlatAndConvex { line: usize, corners: usize },
        #[error("line {line}: it goes on for more than {OBJ_STATEMENT} bytes; a line, with those that continue it, is as long at most")]
        LongStatement { line: usize },
        #[error("line {line}: more than {TRIANGLES} triangles; more would not fit into memory")]
        TooManyTriangles { line: usize },
        #[error("it has no face")]
        NoFace,
        #[error(transparent)]
        Shape(#[from] ShapeError),
    }
}

/// The mesh that OBJ text describes. Bytes that are no UTF-8 may stand in comments and names.
pub fn read(bytes: &[u8]) -> Result<Mesh, ObjError> {
    let mut vertices: Vec<DVec3> = Vec::new();
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    for statement in statements(bytes) {
        let (line, statement) = statement?;
        let mut words = statement.split_ascii_whitespace();
        match words.next() {
            None => {}
            Some("v") => vertices.push(vertex(line, words)?),
            Some("f") => face(line, words, &vertices, &mut triangles)?,
            Some("vn" | "vt" | "g" | "o" | "s" | "usemtl" | "mtllib") => {}
            Some(other) => return Err(ObjError::Statement { line, said: shortened(other) }),
        }
    }
    if triangles.is_empty() {
        return Err(ObjError::NoFace);
    }
    Ok(Mesh::new(vertices, triangles)?)
}

/// Statements without comments, continued lines joined, each with the number of its first line.
fn statements(bytes: &[u8]) -> impl Iterator<Item = Result<(usize, String), ObjError>> {
    let mut lines = bytes.split(|b| *b == b'\n').enumerate();
    std::iter::from_fn(move || {
        let mut joined: Option<(usize, String)> = None;
        let mut length = 0;
        for (index, bytes) in lines.by_ref() {
            length += bytes.len() as u64;
            if length > OBJ_STATEMENT {
                let line = joined.map_or(index + 1, |(line, _)| line);
                return Some(Err(ObjError::LongStatement { line }));
            }
            let text = String::from_utf8_lossy(bytes);
            let text = text.split('#').next().unwrap_or_default().trim_end();
            let (_, so_far) = joined.get_or_insert((index + 1, String::new()));
            match text.strip_suffix('\\') {
                Some(text) => so_far.push_str(&format!("{text} ")),
                None => {
                    so_far.push_str(text);
                    break;
                }
            }
        }
        joined.map(Ok)
    })
}

fn vertex<'w>(line: usize, words: impl Iterator<Item = &'w str>) -> Result<DVec3, ObjError> {
    let numbers = words.map(|word| match word.parse::<f64>() {
        Ok(number) if number.abs() <= MAX_MAGNITUDE => Ok(number),
        _ => Err(ObjError::Number { line, said: shortened(word) }),
    });
    let numbers = numbers.collect::<Result<Vec<f64>, _>>()?;
    match numbers.len() {
        3 | 4 | 6 => Ok(DVec3::new(numbers[0], numbers[1], numbers[2])),
        said => Err(ObjError::VertexNumbers { line, said }),
    }
}

fn face<'w>(
    line: usize,
    words: impl Iterator<Item = &'w str>,
    vertices: &[DVec3],
    triangles: &mut Vec<[u32; 3]>,
) -> Result<(), ObjError> {
    let corners = words.map(|word| corner(line, word, vertices.len())).collect::<Result<Vec<u32>, _>>()?;
    if (triangles.len() + corners.len()) as u64 > TRIANGLES + 2 {
        return Err(ObjError::TooManyTriangles { line });
    }
    if corners.len() < 3 {
        return Err(ObjError::FaceCorners { line, said: corners.len() });
    }
    if corners.len() > 3 && !is_flat_and_convex(&corners, vertices) {
        return Err(ObjError::NotFlatAndConvex { line, corners: corners.len() });
    }
    triangles.extend(corners[1..].windows(2).map(|pair| [corners[0], pair[0], pair[1]]));
    Ok(())
}

/// Index from 0 of the vertex that a corner names.
fn corner(line: usize, word: &str, vertices: usize) -> Result<u32, ObjError> {
    let broken = || ObjError::Corner { line, said: shortened(word) };
    let indices: Vec<&str> = word.splitn(4, '/').collect();
    // After the vertex: nothing, a texture index (which may be empty before a normal), a normal index.
    let others_are_indices = match indices[1..] {
        [] => true,
        [texture] => texture.parse::<i64>().is_ok(),
        [texture, normal] => (texture.is_empty() || texture.parse::<i64>().is_ok()) && normal.parse::<i64>().is_ok(),
        _ => false,
    };
    let said = indices[0].parse::<i64>().ok().filter(|_| others_are_indices).ok_or_else(broken)?;
    let index = if said > 0 { said - 1 } else { said.saturating_add(vertices as i64) };
    if said == 0 || index < 0 || index >= vertices as i64 {
        return Err(ObjError::NoSuchVertex { line, said, vertices });
    }
    u32::try_from(index).map_err(|_| broken())
}

/// Whether a fan about the first corner covers the face exactly: no corner off the plane, none turning inwards, and no
/// second turn around the first corner.
fn is_flat_and_convex(corners: &[u32], vertices: &[DVec3]) -> bool {
    let at = |i: usize| vertices[corners[i % corners.len()] as usize];
    let n = corners.len();
    let size = (1..n).map(|i| (at(i) - at(0)).length()).fold(0.0, f64::max);
    if size == 0.0 {
        return true; // no area, dropped later
    }
    let offset = |i: usize| (at(i) - at(0)) / size;
    let normal = (1..n - 1).map(|i| offset(i).cross(offset(i + 1))).sum::<DVec3>().normalize_or_zero();
    let flat = (1..n).all(|i| offset(i).dot(normal).abs() <= FLAT);
    let turn = |a: DVec3, b: DVec3| a.cross(b).dot(normal);
    let convex = (0..n).all(|i| turn(offset(i + 1) - offset(i), offset(i + 2) - offset(i + 1)) >= -FLAT);
    let fan = (1..n - 1).map(|i| (turn(offset(i), offset(i + 1)), offset(i).dot(offset(i + 1))));
    let in_order = fan.clone().all(|(turn, _)| turn >= -FLAT);
    let swept: f64 = fan.map(|(turn, along)| turn.atan2(along)).sum();
    flat && convex && in_order && swept <= std::f64::consts::PI + 1e-3
}

fn shortened(word: &str) -> String {
    word.chars().take(40).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn triangles(text: &str) -> Result<Vec<[u32; 3]>, ObjError> {
        read(text.as_bytes()).map(|mesh| mesh.triangles().to_vec())
    }
    const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

    #[test]
    fn corners_come_in_four_forms_and_count_from_either_end() {
        for face in ["f 1 2 3", "f 1/1 2/2 3/3", "f 1//1 2//1 3//1", "f 1/1/1 2/2/1 3/3/1", "f -4 -3 -2"] {
            assert_eq!(triangles(&format!("{SQUARE}{face}")), Ok(vec![[0, 1, 2]]), "{face}");
        }
    }

    #[test]
    fn what_blocks_no_light_is_skipped() {
        let text = format!(
            "# a square\r\nmtllib a.mtl\no square\ng\ns off\nusemtl grey\nvn 0 0 1\nvt 0 0\n{SQUARE}\n\
             f 1 2 \\\r\n  3 # half\n"
        );
        assert_eq!(triangles(&text), Ok(vec![[0, 1, 2]]));
        let mut latin1 = format!("{SQUARE}f 1 2 3\n# caf").into_bytes();
        latin1.push(0xe9);
        assert!(read(&latin1).is_ok());
        assert!(read(format!("{SQUARE}f 1 2 3\\").as_bytes()).is_ok(), "a continuation at the end continues nothing");
    }

    #[test]
    fn a_flat_convex_face_is_cut_into_a_fan() {
        assert_eq!(triangles(&format!("{SQUARE}f 1 2 3 4")), Ok(vec![[0, 1, 2], [0, 2, 3]]));
        let corner = |i: i32| f64::from(i) * std::f64::consts::TAU / 7.0;
        let ring: String = (0..7).map(|i| format!("v {} {} 1\n", corner(i).cos(), corner(i).sin())).collect();
        let mesh = read(format!("{ring}f 1 2 3 4 5 6 7").as_bytes()).unwrap();
        assert_eq!(mesh.triangles().len(), 5);
        approx::assert_relative_eq!(mesh.area(), 3.5 * corner(1).sin(), max_relative = 1e-14);
        let twice_around = triangles(&format!("{ring}f 1 3 5 7 2 4 6"));
        assert_eq!(twice_around, Err(ObjError::NotFlatAndConvex { line: 8, corners: 7 }));
    }

    #[test]
    fn a_face_that_no_fan_covers_is_refused() {
        let arrow = "v 0 0 0\nv 2 0 0\nv 0.5 0.5 0\nv 0 2 0\n";
        for order in ["1 2 3 4", "2 3 4 1", "3 4 1 2", "4 3 2 1"] {
            let found = triangles(&format!("{arrow}f {order}"));
            assert_eq!(found, Err(ObjError::NotFlatAndConvex { line: 5, corners: 4 }), "{order}");
        }
        let bent = "v 0 0 0\nv 1 0 0\nv 1 1 0.01\nv 0 1 0\nf 1 2 3 4";
        assert_eq!(triangles(bent), Err(ObjError::NotFlatAndConvex { line: 5, corners: 4 }));
    }

    #[test]
    fn each_broken_line_is_told_by_its_number() {
        let broken = [
            ("f 1 2 9", ObjError::NoSuchVertex { line: 5, said: 9, vertices: 4 }),
            ("f 1 2 0", ObjError::NoSuchVertex { line: 5, said: 0, vertices: 4 }),
            ("f 1 2 -5", ObjError::NoSuchVertex { line: 5, said: -5, vertices: 4 }),
            ("f 1 2 -9223372036854775808", ObjError::NoSuchVertex { line: 5, said: i64::MIN, vertices: 4 }),
            ("f 1 2", ObjError::FaceCorners { line: 5, said: 2 }),
            ("f 1 2 x", ObjError::Corner { line: 5, said: "x".into() }),
            ("f 1 2 3/", ObjError::Corner { line: 5, said: "3/".into() }),
            ("f 1 2 3/1/1/1", ObjError::Corner { line: 5, said: "3/1/1/1".into() }),
            ("v 0 0", ObjError::VertexNumbers { line: 5, said: 2 }),
            ("v 0 0 nan", ObjError::Number { line: 5, said: "nan".into() }),
            ("v 0 0 1e31", ObjError::Number { line: 5, said: "1e31".into() }),
            ("v 0 0 1,5", ObjError::Number { line: 5, said: "1,5".into() }),
            ("vx 0 0 1", ObjError::Statement { line: 5, said: "vx".into() }),
            ("l 1 2", ObjError::Statement { line: 5, said: "l".into() }),
        ];
        for (line, error) in broken {
            assert_eq!(triangles(&format!("{SQUARE}{line}\n")), Err(error), "{line}");
        }
        assert_eq!(triangles(SQUARE), Err(ObjError::NoFace));
        assert_eq!(triangles(""), Err(ObjError::NoFace));
        assert_eq!(triangles(&format!("{SQUARE}f 1 2 2")), Err(ObjError::Shape(ShapeError::NoTriangles)));
    }
}
