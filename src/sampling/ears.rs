//! A simple polygon as triangles, for maps that need triangles.

/// Triangles that cover a simple polygon without overlap, by clipping ears (Meisters 1975): a corner that bulges outward
/// and whose triangle holds no other corner is cut off, until a triangle is left. Triangles without area are left out.
///
/// - `outline`: counter-clockwise, nowhere meeting itself; any unit of length
/// - returns indices of corners, counter-clockwise
/// - time: up to the cube of the number of corners
pub fn triangulated(outline: &[[f64; 2]]) -> Vec<[usize; 3]> {
    let mut left: Vec<usize> = (0..outline.len()).collect();
    let mut triangles = Vec::with_capacity(outline.len().saturating_sub(2));
    while left.len() >= 3 {
        let n = left.len();
        let corners = |i: usize| [left[(i + n - 1) % n], left[i], left[(i + 1) % n]];
        let is_ear = |i: &usize| {
            let ear = corners(*i);
            let others = left.iter().filter(|k| !ear.contains(k));
            twice_area(outline, ear) >= 0.0 && !others.into_iter().any(|k| holds(outline, ear, outline[*k]))
        };
        // A simple polygon has two ears; where rounding hides them, the largest bulge stands in.
        let bulge = |i: &usize| twice_area(outline, corners(*i));
        let ear = (0..n).find(is_ear).or_else(|| (0..n).max_by(|i, j| bulge(i).total_cmp(&bulge(j)))).unwrap_or(0);
        if bulge(&ear) > 0.0 {
            triangles.push(corners(ear));
        }
        left.remove(ear);
    }
    triangles
}

fn twice_area(outline: &[[f64; 2]], [a, b, c]: [usize; 3]) -> f64 {
    turn(outline[a], outline[b], outline[c])
}

/// Positive where c lies to the left of the line from a to b.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

/// Whether a triangle or its border, but for the side opposite its ear's tip, holds a point. A flat ear holds what lies
/// between its ends.
fn holds(outline: &[[f64; 2]], [a, b, c]: [usize; 3], p: [f64; 2]) -> bool {
    let [a, b, c] = [a, b, c].map(|k| outline[k]);
    let within = (0..2).all(|k| a[k].min(b[k]).min(c[k]) <= p[k] && p[k] <= a[k].max(b[k]).max(c[k]));
    within && turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{Stream, StreamKey};
    use crate::statistics::budget::seed_of;
    use rand::RngExt;

    fn outlines() -> Vec<Vec<[f64; 2]>> {
        let star = (0..14).map(|k| {
            let (sin, cos) = libm::sincos(std::f64::consts::TAU * f64::from(k) / 14.0);
            let radius = if k % 2 == 0 { 1.0 } else { 0.3 };
            [radius * cos, radius * sin]
        });
        let comb = (0..6).flat_map(|k| [[2.0 * f64::from(k), 0.0], [2.0 * f64::from(k) + 1.0, 5.0]]);
        vec![
            vec![[0.0, 0.0], [1.0, 0.2], [0.3, 1.5]],
            vec![[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]],
            vec![[0.0, 0.0], [3.0, 0.0], [3.0, 2.0], [1.5, 0.5], [0.0, 2.0]],
            // Corners on straight sides.
            vec![[0.0, 0.0], [0.5, 0.0], [1.0, 0.0], [1.0, 1.0], [0.4, 1.0], [0.0, 1.0], [0.0, 0.1]],
            // A dart, and a corner level with others.
            vec![[0.0, 0.0], [3.0, 0.0], [1.4, 0.4], [0.9, 1.2]],
            vec![[0.0, 0.0], [4.0, 0.0], [4.0, 2.0], [3.0, 1.0], [2.0, 2.0], [1.0, 1.0], [0.0, 2.0]],
            star.collect(),
            [[11.0, -2.0], [10.5, -3.0], [-1.0, -3.0]].into_iter().chain(comb).collect(),
        ]
    }

    fn area(outline: &[[f64; 2]]) -> f64 {
        let n = outline.len();
        (0..n).map(|i| turn([0.0, 0.0], outline[i], outline[(i + 1) % n])).sum::<f64>() / 2.0
    }

    fn is_inside(outline: &[[f64; 2]], p: [f64; 2]) -> bool {
        let n = outline.len();
        (0..n).fold(false, |inside, i| {
            let (a, b) = (outline[i], outline[(i + 1) % n]);
            let crosses =
                (a[1] > p[1]) != (b[1] > p[1]) && p[0] < a[0] + (b[0] - a[0]) * (p[1] - a[1]) / (b[1] - a[1]);
            inside ^ crosses
        })
    }

    #[test]
    fn every_point_of_a_polygon_lies_in_one_triangle() {
        let mut draws = Stream::new(StreamKey::root(seed_of("every_point_of_a_polygon_lies_in_one_triangle")));
        for mut outline in outlines() {
            if area(&outline) < 0.0 {
                outline.reverse();
            }
            let triangles = triangulated(&outline);
            let parts: f64 = triangles.iter().map(|t| twice_area(&outline, *t) / 2.0).sum();
            approx::assert_relative_eq!(parts, area(&outline), max_relative = 1e-13);
            assert!(triangles.iter().all(|t| twice_area(&outline, *t) > 0.0));
            for _ in 0..2_000 {
                let p = [draws.random_range(-3.0..12.0), draws.random_range(-4.0..6.0)];
                let count = triangles.iter().filter(|t| holds(&outline, **t, p)).count();
                assert_eq!(count, usize::from(is_inside(&outline, p)), "{p:?} of {outline:?}");
            }
        }
    }
}
