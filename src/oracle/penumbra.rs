//! The visible part of one source behind any occluders: one mechanism for every pair of shapes.
//!
//! Boundary curves of the source S and of the occluders O_j are split where they meet. The visible set of directions is
//! S less all O_j, and its boundary consists of
//!
//! - sub-arcs of ∂S whose inner side no occluder covers, run forward;
//! - sub-arcs of ∂O_j inside S whose outer side no occluder covers, run backward; where outlines lie on one another and
//!   bound the same side, the first occluder speaks for all.
//!
//! Each adds one closed-form contour integral (Lambert 1760 for edges; Moon 1936 and Sparrow 1963 for the contour form;
//! polygons behind polygons: Nishita and Nakamae 1985), since ∮ n·(r × dr)/|r|² depends on directions alone.
//!
//! Inside or outside is decided on a sub-arc itself, where it is farthest from the other outline; curves that run along
//! one another are known as such from the start. So nothing is decided below the rounding of a direction, except
//! where nothing that matters hangs on it; what does is booked in `doubt`.

use glam::DVec3;

use super::crossing::crossings;
use super::piece::{Curve, Piece};
use super::rim::Term;

/// Where on a sub-arc to ask: irregular, so that no symmetry of a case puts a contact on every one of them.
const PROBES: [f64; 5] = [0.4142, 0.7321, 0.2361, 0.8541, 0.0902];
/// A direction this far from an outline (radians) is surely on its side.
const CLEAR: f64 = 1e-7;
/// A direction this near to an outline may be on either.
const DOUBTFUL: f64 = 16.0 * f64::EPSILON;

/// What is left of a source, as contour terms (each still to be divided by 2π).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Visible {
    /// Over the seen parts of the source's own boundary.
    pub source: Term,
    /// Over the occluders' boundaries seen against the source; to be subtracted.
    pub occluders: Term,
    /// Sizes of terms whose side is in doubt.
    pub doubt: f64,
    pub source_seen: bool,
    pub source_hidden: bool,
    pub shadow_edge: bool,
    /// Whether something beyond doubt is seen, and is hidden.
    pub surely_seen: bool,
    pub surely_hidden: bool,
}

struct Boundary<'a> {
    /// 0 is the source, j the occluder j − 1.
    owner: usize,
    curve: &'a Curve,
}

/// Two curves on one circle.
struct Together {
    curves: [usize; 2],
    alike: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Side {
    Inside,
    Outside,
    /// On the outline, which bounds the same side as the curve in question.
    Along,
    /// On the outline, which bounds the other side.
    Against,
}

/// - `n`: the receiver's unit normal
/// - `source`: its part above the horizon
/// - `occluders`: their parts before the source
pub(super) fn visible(n: DVec3, source: &Piece, occluders: &[Piece]) -> Visible {
    let pieces: Vec<&Piece> = std::iter::once(source).chain(occluders).collect();
    let boundaries: Vec<Boundary> = pieces
        .iter()
        .enumerate()
        .flat_map(|(owner, piece)| piece.curves.iter().map(move |curve| Boundary { owner, curve }))
        .collect();
    let mut splits: Vec<(usize, f64)> = Vec::with_capacity(4 * boundaries.len());
    let mut together: Vec<Together> = Vec::new();
    for (i, a) in boundaries.iter().enumerate() {
        for (j, b) in boundaries.iter().enumerate().skip(i + 1) {
            if a.owner == b.owner {
                continue;
            }
            let alike = crossings(a.curve, b.curve, |s, t| splits.extend([(i, s), (j, t)]));
            together.extend(alike.map(|alike| Together { curves: [i, j], alike }));
        }
    }
    for (i, boundary) in boundaries.iter().enumerate() {
        if !boundary.curve.is_closed() {
            let (from, to) = boundary.curve.range();
            splits.extend([(i, from), (i, to)]);
        }
    }
    splits.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));

    let contour = Contour { n, pieces, boundaries, together };
    let mut sum = Visible::default();
    let mut rest = splits.as_slice();
    for i in 0..contour.boundaries.len() {
        let (own, others) = rest.split_at(rest.partition_point(|s| s.0 == i));
        rest = others;
        contour.add_curve(i, own, &mut sum);
    }
    sum
}

struct Contour<'a> {
    n: DVec3,
    pieces: Vec<&'a Piece>,
    boundaries: Vec<Boundary<'a>>,
    together: Vec<Together>,
}

impl Contour<'_> {
    fn add_curve(&self, i: usize, splits: &[(usize, f64)], sum: &mut Visible) {
        let curve = self.boundaries[i].curve;
        if curve.is_closed() {
            let turn = std::f64::consts::TAU;
            match splits {
                [] => self.add_arc(i, 0.0, turn, sum),
                [.., last] => self.add_arc(i, last.1 - turn, splits[0].1, sum),
            }
        }
        for pair in splits.windows(2) {
            self.add_arc(i, pair[0].1, pair[1].1, sum);
        }
    }

    fn add_arc(&self, i: usize, from: f64, to: f64, sum: &mut Visible) {
        if to - from <= 2.0 * f64::EPSILON * from.abs().max(to.abs()) {
            return;
        }
        let own = self.boundaries[i].owner;
        let mut arc = Arc { contour: self, curve: i, from, to, nearest: f64::INFINITY };
        if own == 0 {
            let hidden = (1..self.pieces.len()).any(|j| matches!(arc.side(j), Side::Inside | Side::Along));
            let doubtful = arc.nearest < DOUBTFUL;
            if hidden {
                sum.source_hidden = true;
                sum.surely_hidden |= !doubtful;
            } else {
                sum.source_seen = true;
                sum.surely_seen |= !doubtful;
                sum.source += self.boundaries[i].curve.contour(self.n, from, to);
            }
            if doubtful {
                sum.doubt += self.boundaries[i].curve.contour(self.n, from, to).value.abs();
            }
            return;
        }
        if arc.side(0) == Side::Inside {
            let edge = (1..self.pieces.len()).filter(|j| *j != own).all(|j| match arc.side(j) {
                Side::Inside | Side::Against => false,
                Side::Outside => true,
                Side::Along => own < j,
            });
            let doubtful = arc.nearest < DOUBTFUL;
            if edge {
                sum.shadow_edge = true;
                sum.surely_seen |= !doubtful;
                sum.surely_hidden |= !doubtful;
                sum.occluders += self.boundaries[i].curve.contour(self.n, from, to);
            }
            if doubtful {
                sum.doubt += self.boundaries[i].curve.contour(self.n, from, to).value.abs();
            }
        } else if arc.nearest < DOUBTFUL {
            sum.doubt += self.boundaries[i].curve.contour(self.n, from, to).value.abs();
        }
    }
}

/// A sub-arc between two neighbouring splits: it crosses nothing.
struct Arc<'a> {
    contour: &'a Contour<'a>,
    curve: usize,
    from: f64,
    to: f64,
    /// The least decisive of the distances that decided.
    nearest: f64,
}

impl Arc<'_> {
    fn side(&mut self, piece: usize) -> Side {
        let Contour { boundaries, together, pieces, .. } = self.contour;
        let curve = boundaries[self.curve].curve;
        for Together { curves: [a, b], alike } in together {
            let other = if *a == self.curve {
                *b
            } else if *b == self.curve {
                *a
            } else {
                continue;
            };
            let direction = curve.point(0.5 * (self.from + self.to));
            if boundaries[other].owner == piece && covers(boundaries[other].curve, direction) {
                return if *alike { Side::Along } else { Side::Against };
            }
        }
        let mut decisive: f64 = 0.0;
        for share in PROBES {
            let direction = curve.point(self.from + (self.to - self.from) * share).normalize();
            let margin = pieces[piece].margin(direction);
            if margin.abs() > decisive.abs() {
                decisive = margin;
            }
            if margin.abs() > CLEAR {
                break;
            }
        }
        self.nearest = self.nearest.min(decisive.abs());
        if decisive > 0.0 { Side::Inside } else { Side::Outside }
    }
}

/// Whether a direction on a curve's circle lies between the curve's ends.
fn covers(curve: &Curve, direction: DVec3) -> bool {
    let (from, to) = curve.range();
    match curve {
        Curve::Straight(arc) => (from..=to).contains(&arc.parameter(direction)),
        Curve::Round { rim, .. } => {
            let t = rim.parameter(direction);
            (-1..=1).any(|turn| (from..=to).contains(&(t + f64::from(turn) * std::f64::consts::TAU)))
        }
    }
}
