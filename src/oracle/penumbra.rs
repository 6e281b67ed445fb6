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
use smallvec::{SmallVec, smallvec};

use super::crossing::{self, crossings};
use super::great_arc::GreatArc;
use super::piece::{Curve, Piece};
use super::rim::Term;
use super::silhouette::{Beside, Coverage};
use crate::number::{Number, Vector};

/// Where on a sub-arc to ask: irregular, so that no symmetry of a case puts a contact on every one of them.
const PROBES: [f64; 5] = [0.4142, 0.7321, 0.2361, 0.8541, 0.0902];
/// A direction this far from an outline (radians) is surely on its side.
const CLEAR: f64 = 1e-7;
/// A direction this near to an outline may be on either.
const DOUBTFUL: f64 = 16.0 * f64::EPSILON;
/// An edge whose ends lie this far to one side of a great circle does not meet it, nor run along it.
const APART: f64 = 1e-12;

/// What is left of a source, as contour terms (each still to be divided by 2π).
#[derive(Clone, Debug, Default)]
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
    /// Whether curves touch, or lie on one another, where light passes: moved a little, they would part or cross.
    pub touching: bool,
    /// The visible part's boundary.
    pub outline: Outline,
}

/// The boundary of a visible part: which stretches of which curves it is made of. From this the same contour can be run
/// over any number.
#[derive(Clone, Debug, Default)]
pub(super) struct Outline {
    arcs: Vec<OutlineArc>,
    /// How many curves each piece had.
    n_curves: Vec<usize>,
}

#[derive(Clone, Debug)]
struct OutlineArc {
    curve: CurveAt,
    from: Stop,
    to: Stop,
    /// Radians of the curve's parameter between the stops.
    length: f64,
}

/// A curve by its place: in which piece (0 is the source, j the occluder j − 1), and where in that.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
struct CurveAt {
    piece: usize,
    index: usize,
}

/// Where a stretch of a curve ends.
#[derive(Clone, Copy, Debug)]
enum Stop {
    /// Nowhere: a whole turn.
    Anywhere,
    Start,
    End,
    /// Where another curve crosses it, near a direction.
    Crossing {
        other: CurveAt,
        near: DVec3,
    },
    /// Where another curve on the same circle starts or ends.
    StartOf {
        other: CurveAt,
    },
    EndOf {
        other: CurveAt,
    },
}

impl Visible {
    pub fn nothing_seen(&self) -> bool {
        !self.source_seen && !self.shadow_edge
    }
    pub fn nothing_hidden(&self) -> bool {
        !self.source_hidden && !self.shadow_edge
    }
}

impl Outline {
    /// The pieces whose curves it needs.
    pub fn pieces(&self) -> Vec<usize> {
        let of = |stop: &Stop| match stop {
            Stop::Crossing { other, .. } | Stop::StartOf { other } | Stop::EndOf { other } => Some(other.piece),
            Stop::Anywhere | Stop::Start | Stop::End => None,
        };
        let mut list: Vec<usize> =
            self.arcs.iter().flat_map(|arc| [Some(arc.curve.piece), of(&arc.from), of(&arc.to)]).flatten().collect();
        list.sort_unstable();
        list.dedup();
        list
    }

    /// Names the shadow's topology: which stretches there are, not where they lie.
    pub fn topology(&self, hasher: &mut impl std::hash::Hasher) {
        use std::hash::Hash;
        for arc in &self.arcs {
            arc.curve.hash(hasher);
            for stop in [&arc.from, &arc.to] {
                std::mem::discriminant(stop).hash(hasher);
                if let Stop::Crossing { other, .. } | Stop::StartOf { other } | Stop::EndOf { other } = stop {
                    other.hash(hasher);
                }
            }
        }
    }

    /// The contour over the source's own stretches and over the occluders'. `None` where a piece over this number is not
    /// made of the same curves.
    ///
    /// - `pieces`: at least those that are needed
    pub fn contour<T: Number>(&self, n: Vector<T>, pieces: &[Option<Piece<T>>]) -> Option<[Term<T>; 2]> {
        let alike =
            |(piece, n): (&Option<Piece<T>>, &usize)| piece.as_ref().is_none_or(|piece| piece.curves.len() == *n);
        if !pieces.iter().zip(&self.n_curves).all(alike) {
            // An edge that one rounding leaves and another takes away: places in the lists mean different curves.
            return None;
        }
        let curve = |at: CurveAt| pieces.get(at.piece)?.as_ref()?.curves.get(at.index);
        let mut sums = [Term::default(), Term::default()];
        for arc in &self.arcs {
            let own = curve(arc.curve)?;
            let stop = |stop: &Stop| {
                Some(match stop {
                    Stop::Anywhere => T::zero(),
                    Stop::Start => own.range().0,
                    Stop::End => own.range().1,
                    Stop::Crossing { other, near } => {
                        // In one order, whichever of the two asks: both are given the same direction.
                        let [a, b] = if arc.curve < *other { [own, curve(*other)?] } else { [curve(*other)?, own] };
                        own.parameter(crossing::refined(a, b, *near))
                    }
                    Stop::StartOf { other } => {
                        let other = curve(*other)?;
                        own.parameter(other.point(other.range().0))
                    }
                    Stop::EndOf { other } => {
                        let other = curve(*other)?;
                        own.parameter(other.point(other.range().1))
                    }
                })
            };
            let (from, mut to) = match (&arc.from, &arc.to) {
                (Stop::Anywhere, _) => (T::zero(), T::turn()),
                (from, to) => (stop(from)?, stop(to)?),
            };
            let turns = ((arc.length - (to - from).primal()) / std::f64::consts::TAU).round();
            to = to + T::turn() * turns;
            let term = own.contour(n, from, to);
            let is_complement = pieces[arc.curve.piece].as_ref().is_some_and(|piece| piece.is_complement);
            sums[usize::from(arc.curve.piece > 0)] += if is_complement { term.backward() } else { term };
        }
        Some(sums)
    }
}

#[derive(Clone, Copy)]
struct Boundary<'a> {
    at: CurveAt,
    curve: &'a Curve,
}

/// A place on a curve, and what put it there.
#[derive(Clone, Copy)]
struct Split {
    curve: usize,
    t: f64,
    by: By,
}

#[derive(Clone, Copy)]
enum By {
    Start,
    End,
    Curve(usize),
}

/// Another curve on the same circle.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Together {
    curve: usize,
    other: usize,
    /// Whether both bound the same side.
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
    let pieces: Pieces = std::iter::once(source).chain(occluders).collect();
    let boundaries: Boundaries = pieces
        .iter()
        .enumerate()
        .flat_map(|(piece, p)| {
            p.curves.iter().enumerate().map(move |(index, curve)| Boundary { at: CurveAt { piece, index }, curve })
        })
        .collect();
    let mut splits: SmallVec<[Split; 64]> = SmallVec::new();
    let mut together: Vec<Together> = Vec::new();
    let mut touching: SmallVec<[bool; 24]> = smallvec![false; boundaries.len()];
    for (i, a) in boundaries.iter().enumerate() {
        for (j, b) in boundaries.iter().enumerate().skip(i + 1) {
            let are_one_piece = a.at.piece == b.at.piece;
            if are_one_piece && (pieces[a.at.piece].coverage().is_none() || are_apart(a.curve, b.curve)) {
                continue;
            }
            let known = splits.len();
            let meeting = crossings(a.curve, b.curve, |s, t| {
                splits.extend([Split { curve: i, t: s, by: By::Curve(j) }, Split { curve: j, t, by: By::Curve(i) }]);
            });
            let meets_at_corner = are_one_piece && share_corner(a.curve, b.curve);
            match meeting.along {
                // The same line run on.
                Some(_) if meets_at_corner && splits.len() == known => {}
                Some(alike) => {
                    // Of a complement the other side is bounded.
                    let alike = alike == (pieces[a.at.piece].is_complement == pieces[b.at.piece].is_complement);
                    together.extend([Together { curve: i, other: j, alike }, Together { curve: j, other: i, alike }])
                }
                None if meets_at_corner => splits.truncate(known),
                None => {
                    touching[i] |= meeting.touching;
                    touching[j] |= meeting.touching;
                }
            }
        }
    }
    for (i, boundary) in boundaries.iter().enumerate() {
        if !boundary.curve.is_closed() {
            let (from, to) = boundary.curve.range();
            splits.extend([Split { curve: i, t: from, by: By::Start }, Split { curve: i, t: to, by: By::End }]);
        }
    }
    together.sort_unstable();
    splits.sort_by(|a, b| a.curve.cmp(&b.curve).then(a.t.total_cmp(&b.t)));

    let contour = Contour { n: Vector::constant(n), pieces, boundaries, together, touching };
    let mut sum = Visible::default();
    sum.outline.n_curves = contour.pieces.iter().map(|piece| piece.curves.len()).collect();
    let mut rest = splits.as_slice();
    for i in 0..contour.boundaries.len() {
        let (own, others) = rest.split_at(rest.partition_point(|s| s.curve == i));
        rest = others;
        contour.add_curve(i, own, &mut sum);
    }
    sum
}

struct Contour<'a> {
    n: Vector<f64>,
    pieces: Pieces<'a>,
    boundaries: Boundaries<'a>,
    /// Sorted.
    together: Vec<Together>,
    /// Whether a curve touches another.
    touching: SmallVec<[bool; 24]>,
}

type Pieces<'a> = SmallVec<[&'a Piece; 8]>;
type Boundaries<'a> = SmallVec<[Boundary<'a>; 24]>;

impl Contour<'_> {
    /// The curves on the same circle as one.
    fn together_with(&self, curve: usize) -> impl Iterator<Item = &Together> {
        let first = self.together.partition_point(|pair| pair.curve < curve);
        self.together[first..].iter().take_while(move |pair| pair.curve == curve)
    }

    fn add_curve(&self, i: usize, splits: &[Split], sum: &mut Visible) {
        let curve = self.boundaries[i].curve;
        if curve.is_closed() {
            let turn = std::f64::consts::TAU;
            match splits {
                [] => {
                    let whole = Split { curve: i, t: 0.0, by: By::Start };
                    self.add_arc(whole, Split { t: turn, by: By::End, ..whole }, sum);
                }
                [first, .., last] => self.add_arc(Split { t: last.t - turn, ..*last }, *first, sum),
                [only] => self.add_arc(Split { t: only.t - turn, ..*only }, *only, sum),
            }
        }
        for pair in splits.windows(2) {
            self.add_arc(pair[0], pair[1], sum);
        }
    }

    /// The stretch between two neighbouring splits of a curve: seen or not, edge or not.
    fn add_arc(&self, begin: Split, end: Split, sum: &mut Visible) {
        let (i, from, to) = (begin.curve, begin.t, end.t);
        if to - from <= 2.0 * f64::EPSILON * from.abs().max(to.abs()) {
            return;
        }
        let Boundary { at, curve } = self.boundaries[i];
        let mut arc = Arc { contour: self, curve: i, from, to, nearest: f64::INFINITY, along: false, first: None };
        let is_complement = self.pieces[at.piece].is_complement;
        let term = || {
            let forward = curve.contour(self.n, from, to);
            if is_complement { forward.backward() } else { forward }
        };
        if at.piece == 0 {
            let hidden = (1..self.pieces.len()).any(|j| matches!(arc.side(j), Side::Inside | Side::Along));
            let doubtful = arc.nearest < DOUBTFUL;
            sum.touching |= arc.along;
            if hidden {
                sum.source_hidden = true;
                sum.surely_hidden |= !doubtful;
            } else {
                sum.source_seen = true;
                sum.surely_seen |= !doubtful;
                sum.source += term();
                self.keep(begin, end, sum);
            }
            if doubtful {
                sum.doubt += term().value.abs();
            }
            return;
        }
        if arc.side(0) == Side::Inside {
            let edge = (1..self.pieces.len()).filter(|j| *j != at.piece).all(|j| match arc.side(j) {
                Side::Inside | Side::Against => false,
                Side::Outside => true,
                Side::Along => at.piece < j,
            });
            let edge = edge && arc.bounds_its_piece();
            let doubtful = arc.nearest < DOUBTFUL;
            sum.touching |= arc.along;
            if edge {
                sum.shadow_edge = true;
                sum.surely_seen |= !doubtful;
                sum.surely_hidden |= !doubtful;
                sum.occluders += term();
                self.keep(begin, end, sum);
            }
            if doubtful {
                sum.doubt += term().value.abs();
            }
        } else if arc.nearest < DOUBTFUL {
            sum.doubt += term().value.abs();
        }
    }

    fn keep(&self, begin: Split, end: Split, sum: &mut Visible) {
        let Boundary { at, curve } = self.boundaries[begin.curve];
        let range = curve.range();
        let stop = |split: Split| match split.by {
            _ if !curve.is_closed() && split.t == range.0 => Stop::Start,
            _ if !curve.is_closed() && split.t == range.1 => Stop::End,
            _ if curve.is_closed() && matches!(split.by, By::Start | By::End) => Stop::Anywhere,
            By::Start => Stop::Start,
            By::End => Stop::End,
            By::Curve(j) => {
                let Boundary { at: other, curve: crossed } = self.boundaries[j];
                let point = curve.point(split.t);
                if !self.together_with(begin.curve).any(|pair| pair.other == j) {
                    return Stop::Crossing { other, near: point.primal().normalize() };
                }
                let (start, end) = crossed.range();
                let off = |t: f64| (crossed.point(t).normalize() - point.normalize()).length_squared();
                if off(start) < off(end) { Stop::StartOf { other } } else { Stop::EndOf { other } }
            }
        };
        let arc = OutlineArc { curve: at, from: stop(begin), to: stop(end), length: end.t - begin.t };
        sum.touching |= self.touching[begin.curve];
        sum.outline.arcs.push(arc);
    }
}

/// A sub-arc between two neighbouring splits: it crosses nothing.
struct Arc<'a, 'b> {
    contour: &'a Contour<'b>,
    curve: usize,
    from: f64,
    to: f64,
    /// The least decisive of the distances that decided.
    nearest: f64,
    /// Whether it lies on another outline.
    along: bool,
    /// The first probe, once it was asked for.
    first: Option<DVec3>,
}

impl Arc<'_, '_> {
    fn side(&mut self, piece: usize) -> Side {
        let pieces = &self.contour.pieces;
        if self.contour.together_with(self.curve).next().is_some() {
            let along: Vec<(usize, bool)> = self.along(piece).collect();
            if let Some((_, alike)) = along.first() {
                self.along = true;
                return match pieces[piece].coverage() {
                    Some(coverage) => self.beside(coverage, &along),
                    None if *alike => Side::Along,
                    None => Side::Against,
                };
            }
        }
        let mut decisive: f64 = 0.0;
        for i in 0..PROBES.len() {
            let direction = self.probe(i);
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

    /// The direction at one of the places to ask at; every piece asks at the first.
    fn probe(&mut self, i: usize) -> DVec3 {
        if let (0, Some(first)) = (i, self.first) {
            return first;
        }
        let curve = self.contour.boundaries[self.curve].curve;
        let direction = curve.point(self.from + (self.to - self.from) * PROBES[i]).normalize().primal();
        if i == 0 {
            self.first = Some(direction);
        }
        direction
    }

    /// Curves of a piece that run along this sub-arc, by their place in it.
    fn along(&self, piece: usize) -> impl Iterator<Item = (usize, bool)> {
        let boundaries = &self.contour.boundaries;
        let middle = boundaries[self.curve].curve.point(0.5 * (self.from + self.to));
        self.contour.together_with(self.curve).filter_map(move |Together { other, alike, .. }| {
            let Boundary { at, curve } = boundaries[*other];
            (at.piece == piece && covers(curve, middle)).then_some((at.index, *alike))
        })
    }

    /// Whether its own piece ends here: a mesh may cover both sides, or have several edges one behind the other.
    fn bounds_its_piece(&mut self) -> bool {
        let Contour { boundaries, pieces, .. } = self.contour;
        let at = boundaries[self.curve].at;
        let Some(coverage) = pieces[at.piece].coverage() else { return true };
        let mut along = vec![(at.index, true)];
        along.extend(self.along(at.piece));
        self.along |= along.len() > 1;
        let speaks_for_all = along.iter().all(|(index, alike)| !alike || at.index <= *index);
        speaks_for_all && self.beside(coverage, &along) == Side::Along
    }

    /// - `along`: the mesh's curves that run along this sub-arc
    fn beside(&mut self, coverage: &Coverage, along: &[(usize, bool)]) -> Side {
        let Curve::Straight(arc) = self.contour.boundaries[self.curve].curve else { return Side::Outside };
        let mut decisive: Option<Beside> = None;
        for share in PROBES {
            let direction = arc.point(self.from + (self.to - self.from) * share).primal();
            let beside = coverage.beside(direction, arc.normal.primal(), along);
            if decisive.is_none_or(|best| beside.nearest > best.nearest) {
                decisive = Some(beside);
            }
            if beside.nearest > CLEAR {
                break;
            }
        }
        let Some(Beside { left, right, nearest }) = decisive else { return Side::Outside };
        self.nearest = self.nearest.min(nearest);
        match (left > 0, right > 0) {
            (true, true) => Side::Inside,
            (true, false) => Side::Along,
            (false, true) => Side::Against,
            (false, false) => Side::Outside,
        }
    }
}

/// Whether two straight curves surely do not meet.
fn are_apart(a: &Curve, b: &Curve) -> bool {
    let (Curve::Straight(a), Curve::Straight(b)) = (a, b) else { return false };
    let is_beside = |a: &GreatArc, b: &GreatArc| {
        let [p, q] = b.ends.map(|end| a.normal.dot(end));
        p.min(q) > APART || p.max(q) < -APART
    };
    is_beside(a, b) || is_beside(b, a)
}

/// Whether two straight curves end in one corner: then they meet nowhere else.
fn share_corner(a: &Curve, b: &Curve) -> bool {
    let (Curve::Straight(a), Curve::Straight(b)) = (a, b) else { return false };
    a.ends.iter().any(|p| b.ends.iter().any(|q| p.primal() == q.primal()))
}

/// Whether a direction on a curve's circle lies between the curve's ends.
fn covers(curve: &Curve, direction: Vector<f64>) -> bool {
    let (from, to) = curve.range();
    match curve {
        Curve::Straight(arc) => (from..=to).contains(&arc.parameter(direction)),
        Curve::Round { rim, .. } => {
            let t = rim.angle(direction);
            (-2..=2).any(|turn| (from..=to).contains(&(t + f64::from(turn) * std::f64::consts::TAU)))
        }
    }
}
