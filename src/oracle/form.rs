//! A body relative to the eye, over any number: what its outline as seen from there is made from.

use glam::DVec3;
use smallvec::SmallVec;

use super::body::{Body, Figure, Flat};
use super::silhouette::SurfaceForm;
use crate::number::{Dual, Number, Vector, Wide};

/// A list that needs no allocation while it has no more entries than a flat figure has corners as a rule.
pub(super) type Few<T> = SmallVec<[T; 8]>;

/// A body relative to the eye.
#[derive(Clone, Debug)]
pub(super) enum Form<'a, T = f64> {
    Disk { center: Vector<T>, normal: Vector<T>, radius: T },
    Ball { center: Vector<T>, radius: T },
    Flat(FlatForm<'a, T>),
    Mesh(SurfaceForm<'a, T>),
}

#[derive(Clone, Debug)]
pub(super) struct FlatForm<'a, T = f64> {
    pub shape: &'a Flat,
    pub normal: Vector<T>,
    pub corners: Few<Vector<T>>,
    /// The middle of the corners, relative to the eye and as an offset of the shape.
    pub center: Vector<T>,
    middle: Vector<T>,
    /// From the middle to the farthest corner.
    pub reach: f64,
    /// The shape's own offsets, where they are not to be taken as they stand.
    moved: Option<Vec<Vector<T>>>,
}

/// A parameter of a body, and how far its parts move when it grows by one.
#[derive(Clone, Debug)]
pub(super) enum Motion {
    /// The whole body.
    Center(DVec3),
    /// The unit normal, before it is made unit again.
    Normal(DVec3),
    Radius(f64),
    /// Each corner of a flat figure.
    Corners(Vec<DVec3>),
}

impl<'a, T: Number> FlatForm<'a, T> {
    /// Corner `j` less corner `i`, from the shape rather than from the difference of two far points.
    pub fn line(&self, i: usize, j: usize) -> Vector<T> {
        match &self.moved {
            Some(moved) => moved[j] - moved[i],
            None => Vector::constant(self.shape.offsets[j]) - Vector::constant(self.shape.offsets[i]),
        }
    }

    /// Corner `i` less the middle.
    pub fn beside_middle(&self, i: usize) -> Vector<T> {
        match &self.moved {
            Some(moved) => moved[i] - self.middle,
            None => Vector::constant(self.shape.offsets[i]) - self.middle,
        }
    }

    /// The unit normal of the corners as they are (Newell's sum), on the side of the shape's own.
    fn newell(&self) -> Vector<T> {
        let zero = Vector::constant(DVec3::ZERO);
        let sum = self
            .shape
            .edges
            .iter()
            .fold(zero, |sum, [i, j]| sum + self.line(0, *i as usize).cross(self.line(0, *j as usize)));
        sum.normalize()
    }
}

impl<'a> Form<'a, f64> {
    pub fn plain(body: &'a Body, eye: DVec3) -> Form<'a> {
        Form::seen(body, Vector::constant(eye))
    }
}

impl<'a> Form<'a, Wide> {
    /// To the digits of what was said of the body.
    pub fn refined(body: &'a Body, eye: Vector<Wide>) -> Form<'a, Wide> {
        let mut form = Form::seen(body, eye);
        form.refine(body);
        form
    }
}

impl<'a, const N: usize, T: Number> Form<'a, Dual<N, T>> {
    /// With the slopes of the motions that are asked for.
    ///
    /// - `motions`: (parameter, motion), the parameter below `N`
    pub fn moving<'m>(
        body: &'a Body,
        eye: Vector<Dual<N, T>>,
        motions: impl Iterator<Item = (usize, &'m Motion)>,
    ) -> Form<'a, Dual<N, T>> {
        let mut form = Form::seen(body, eye);
        if T::CANCELS_FREELY {
            form.refine(body);
        }
        for (k, motion) in motions {
            match (&mut form, motion) {
                (Form::Disk { center, .. } | Form::Ball { center, .. }, Motion::Center(by)) => push(center, k, *by),
                (Form::Disk { normal, .. }, Motion::Normal(by)) => {
                    let unit = normal.primal();
                    push(normal, k, *by - unit * unit.dot(*by));
                }
                (Form::Disk { radius, .. } | Form::Ball { radius, .. }, Motion::Radius(by)) => {
                    radius.slopes[k] = radius.slopes[k] + *by;
                }
                (Form::Flat(flat), Motion::Corners(by)) => flat.push(k, |i| by[i]),
                (Form::Flat(flat), Motion::Center(by)) => flat.push(k, |_| *by),
                // Seen from the mesh, the eye moves.
                (Form::Mesh(mesh), Motion::Center(by)) => push(&mut mesh.eye, k, -*by),
                _ => unreachable!("a motion is made for its body"),
            }
        }
        if let Form::Flat(flat) = &mut form
            && flat.moved.is_some()
        {
            // Rounding of a recomputed normal must not turn decisions: only its slopes are taken over.
            let (own, newell) = (flat.normal, flat.newell());
            let with = |value: Dual<N, T>, slopes: Dual<N, T>| Dual { value: value.value, slopes: slopes.slopes };
            flat.normal = Vector::new(with(own.x, newell.x), with(own.y, newell.y), with(own.z, newell.z));
        }
        form
    }
}

impl<const N: usize, T: Number> FlatForm<'_, Dual<N, T>> {
    fn push(&mut self, k: usize, by: impl Fn(usize) -> DVec3) {
        let offsets = &self.shape.offsets;
        let moved = self.moved.get_or_insert_with(|| offsets.iter().map(|p| Vector::constant(*p)).collect());
        for (i, (offset, corner)) in moved.iter_mut().zip(&mut self.corners).enumerate() {
            push(offset, k, by(i));
            push(corner, k, by(i));
        }
        let mean = (0..offsets.len()).map(by).sum::<DVec3>() / offsets.len() as f64;
        push(&mut self.center, k, mean);
        push(&mut self.middle, k, mean);
    }
}

/// Adds to the slope of a vector with respect to one parameter.
pub(super) fn push<const N: usize, T: Number>(v: &mut Vector<Dual<N, T>>, k: usize, by: DVec3) {
    v.x.slopes[k] = v.x.slopes[k] + by.x;
    v.y.slopes[k] = v.y.slopes[k] + by.y;
    v.z.slopes[k] = v.z.slopes[k] + by.z;
}

impl<'a, T: Number> Form<'a, T> {
    /// Unit normals are rounded; takes them from what they were made from.
    fn refine(&mut self, body: &Body) {
        match (self, &body.figure) {
            (Form::Disk { normal, .. }, Figure::Disk { as_given, .. }) => {
                *normal = Vector::constant(*as_given).normalize();
            }
            (Form::Flat(flat), _) => flat.normal = flat.newell(),
            _ => {}
        }
    }

    fn seen(body: &'a Body, eye: Vector<T>) -> Form<'a, T> {
        match &body.figure {
            Figure::Disk { normal, radius, .. } => Form::Disk {
                center: Vector::constant(body.center) - eye,
                normal: Vector::constant(*normal),
                radius: T::constant(*radius),
            },
            Figure::Ball { radius } => {
                Form::Ball { center: Vector::constant(body.center) - eye, radius: T::constant(*radius) }
            }
            Figure::Mesh(surface) => Form::Mesh(SurfaceForm { surface, eye, center: body.center, reach: body.reach }),
            Figure::Flat(shape) => {
                let origin = Vector::constant(shape.origin) - eye;
                let corners = shape.offsets.iter().map(|offset| origin + Vector::constant(*offset)).collect();
                Form::Flat(FlatForm {
                    shape,
                    normal: Vector::constant(shape.normal),
                    corners,
                    center: Vector::constant(body.center) - eye,
                    middle: Vector::constant(body.center - shape.origin),
                    reach: body.reach,
                    moved: None,
                })
            }
        }
    }

    /// What an occluder must lie before to block this source: `normal · r + k ≥ 0`, a flat source's own plane or the
    /// plane of a sphere's silhouette.
    pub fn front(&self) -> HalfSpace<T> {
        match self {
            Form::Disk { center, normal, .. } => HalfSpace { normal: *normal, k: -normal.dot(*center) },
            Form::Flat(flat) => HalfSpace { normal: flat.normal, k: -flat.normal.dot(flat.corners[0]) },
            // No source: nothing lies before it.
            Form::Mesh(_) => HalfSpace { normal: Vector::constant(DVec3::ZERO), k: T::constant(-1.0) },
            Form::Ball { center, radius } => {
                let distance = center.length();
                let k = (distance - *radius) * (distance + *radius) / distance;
                HalfSpace { normal: *center * (T::constant(-1.0) / distance), k }
            }
        }
    }
}

/// A half-space `normal · r + k ≥ 0`.
#[derive(Clone, Copy, Debug)]
pub(super) struct HalfSpace<T = f64> {
    pub normal: Vector<T>,
    pub k: T,
}

impl<T: Number> HalfSpace<T> {
    pub fn height(&self, p: Vector<T>) -> T {
        self.normal.dot(p) + self.k
    }
}
