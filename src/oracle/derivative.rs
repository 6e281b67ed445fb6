//! Exact derivatives of the irradiance with respect to the numbers of a case.
//!
//! The shadow's topology is decided over `f64`; the contour that it leaves is run once more over dual numbers, crossings
//! included. So the derivative of *visibility* (how the shadow's edge moves) is in it.

use std::fmt;
use std::str::FromStr;

use glam::DVec3;

use super::exact::{BodyAt, Oracle, PARTED, Seen};
use super::form::{self, Form, Motion};
use super::truth::{Method, Sight, Truth};
use crate::configuration::{Configuration, MeasurementPoint};
use crate::geometry::Shape;
use crate::number::{Dual, Number, Vector, Wide};

/// Parameters that one run over dual numbers carries along: few enough that asking for one does not cost as much as asking
/// for many, enough that the parameters of two bodies and a point take two runs.
const LANES: usize = 10;

/// A number of a case, by its path: `source.0.center.x`, `occluder.1.radius`, `point.position.z`.
///
/// | path below | fields |
/// |---|---|
/// | `source.N`, `occluder.N` (counted from 0, in the case's order) | disk: `center`, `normal`, `radius`; rectangle: `center`, `edge_u`, `edge_v`; polygon: `vertices.K`, `position` (all of it); sphere: `center`, `radius`; mesh: `position` |
/// | `source.N` | `exitance` |
/// | `point` (each measurement point) | `position`, `normal` |
///
/// Vectors take `.x`, `.y` or `.z`. A normal's component is that of the unit normal, which stays a unit vector. Edges and
/// vertices are free to leave the right angle or the plane: then what is differentiated is the outline as seen.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Parameter {
    path: String,
    owner: Owner,
    field: Field,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Owner {
    Source(usize),
    Occluder(usize),
    Point,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Field {
    Center(usize),
    Position(usize),
    Normal(usize),
    EdgeU(usize),
    EdgeV(usize),
    Vertex(usize, usize),
    Radius,
    Exitance,
}

/// What is wrong with a parameter.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ParameterError {
    /// No such path in any case.
    #[error(
        "`{said}` names no number of a case; accepted are source.N.FIELD, occluder.N.FIELD and point.FIELD with the fields \
         center, position, normal, edge_u, edge_v, vertices.K (each followed by .x, .y or .z), radius and exitance"
    )]
    Path {
        /// The parameter as it was given.
        said: String,
    },
    /// No source or occluder has that number.
    #[error("`{said}`: there are {count} {kind}s, counted from 0")]
    Missing {
        /// The parameter as it was given.
        said: String,
        /// `source` or `occluder`.
        kind: &'static str,
        /// How many of them the configuration has.
        count: usize,
    },
    /// A shape without that field.
    #[error("`{said}`: a {shape} has {accepted}")]
    Field {
        /// The parameter as it was given.
        said: String,
        /// The shape's kind, as in a case file.
        shape: &'static str,
        /// The fields that it has.
        accepted: String,
    },
}

impl FromStr for Parameter {
    type Err = ParameterError;

    fn from_str(said: &str) -> Result<Parameter, ParameterError> {
        let wrong = || ParameterError::Path { said: said.to_owned() };
        let words: Vec<&str> = said.trim().split('.').collect();
        let index = |word: &str| word.parse::<usize>().map_err(|_| wrong());
        let (owner, rest) = match words.as_slice() {
            ["source", i, rest @ ..] => (Owner::Source(index(i)?), rest),
            ["occluder", i, rest @ ..] => (Owner::Occluder(index(i)?), rest),
            ["point", rest @ ..] => (Owner::Point, rest),
            _ => return Err(wrong()),
        };
        let axis = |word: &str| ["x", "y", "z"].iter().position(|axis| *axis == word).ok_or_else(wrong);
        let field = match rest {
            ["center", a] => Field::Center(axis(a)?),
            ["position", a] => Field::Position(axis(a)?),
            ["normal", a] => Field::Normal(axis(a)?),
            ["edge_u", a] => Field::EdgeU(axis(a)?),
            ["edge_v", a] => Field::EdgeV(axis(a)?),
            ["vertices", k, a] => Field::Vertex(index(k)?, axis(a)?),
            ["radius"] => Field::Radius,
            ["exitance"] => Field::Exitance,
            _ => return Err(wrong()),
        };
        let fits = match owner {
            Owner::Point => matches!(field, Field::Position(_) | Field::Normal(_)),
            Owner::Occluder(_) => field != Field::Exitance,
            Owner::Source(_) => true,
        };
        fits.then(|| Parameter { path: said.trim().to_owned(), owner, field }).ok_or_else(wrong)
    }
}

impl fmt::Display for Parameter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(&self.path)
    }
}

impl Parameter {
    /// The unit of the irradiance's derivative, as in a column's name: per metre, per unit of a unit vector, or per W/m².
    pub fn unit_of_derivative(&self) -> &'static str {
        match self.field {
            Field::Normal(_) => "W_m2",
            Field::Exitance => "1",
            _ => "W_m3",
        }
    }
}

/// What a parameter does to a configuration.
#[derive(Clone, Debug)]
enum Effect {
    Body(BodyAt, Motion),
    Exitance(usize),
    Position(usize),
    Normal(usize),
}

/// Parameters of one configuration, ready to differentiate by.
#[derive(Clone, Debug)]
pub struct Parameters {
    effects: Vec<(usize, Effect)>,
    count: usize,
}

/// Whether a small move either way keeps the shadow's topology.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// The derivative is that of both sides.
    Both,
    /// Outlines touch or coincide here: the derivative is that of moves which keep the contact as it was decided, and
    /// moves the other way may have another.
    One,
}

impl Side {
    /// The name that tables use.
    pub fn name(self) -> &'static str {
        match self {
            Side::Both => "both",
            Side::One => "one",
        }
    }
}

/// The irradiance at one point with its derivatives.
#[derive(Clone, Debug, PartialEq)]
pub struct Derivatives {
    /// The value itself, as [`Oracle::at`] gives it.
    pub truth: Truth,
    /// One for each parameter; W/m² per unit of the parameter. `None` where the irradiance has no closed form, a textured
    /// source is seen, or outlines touch in a way that leaves its slopes undecided.
    pub values: Option<Vec<f64>>,
    /// Whether they are the derivatives of moves both ways.
    pub side: Side,
}

impl Oracle {
    /// Parameters of the configuration that this oracle was made from.
    pub fn parameters(
        &self,
        configuration: &Configuration,
        parameters: &[Parameter],
    ) -> Result<Parameters, ParameterError> {
        let mut effects = Vec::new();
        for (k, parameter) in parameters.iter().enumerate() {
            let said = || parameter.path.clone();
            let shape = match parameter.owner {
                Owner::Point => None,
                Owner::Source(i) => {
                    let list = configuration.sources();
                    let missing = || ParameterError::Missing { said: said(), kind: "source", count: list.len() };
                    Some(list.get(i).ok_or_else(missing)?.shape())
                }
                Owner::Occluder(i) => {
                    let list = configuration.occluders();
                    let missing = || ParameterError::Missing { said: said(), kind: "occluder", count: list.len() };
                    Some(list.get(i).ok_or_else(missing)?)
                }
            };
            match (parameter.owner, parameter.field, shape) {
                (Owner::Source(i), Field::Exitance, _) => effects.push((k, Effect::Exitance(i))),
                (Owner::Point, Field::Position(axis), _) => effects.push((k, Effect::Position(axis))),
                (Owner::Point, Field::Normal(axis), _) => effects.push((k, Effect::Normal(axis))),
                (owner, field, Some(shape)) => {
                    let motion = motion(shape, field, self.scale).ok_or_else(|| ParameterError::Field {
                        said: said(),
                        shape: shape.kind(),
                        accepted: accepted(shape),
                    })?;
                    effects.extend(self.bodies(owner).map(|at| (k, Effect::Body(at, motion.clone()))));
                }
                _ => return Err(ParameterError::Path { said: said() }),
            }
        }
        Ok(Parameters { effects, count: parameters.len() })
    }

    fn bodies(&self, owner: Owner) -> impl Iterator<Item = BodyAt> {
        let occluders = self.occluder_of.iter().enumerate();
        let of_occluder = occluders.filter(move |(_, shape)| owner == Owner::Occluder(**shape));
        let of_source = match owner {
            Owner::Source(i) => Some(BodyAt::Source(i)),
            _ => None,
        };
        of_occluder.map(|(body, _)| BodyAt::Occluder(body)).chain(of_source)
    }

    /// The exact irradiance at a point and its derivatives.
    ///
    /// - error: of the derivatives, about 1e-12 relative to irradiance over the distance that the parameter would have to
    ///   move to matter; more where outlines nearly touch
    /// - second witness: `slopes_are_differences_of_wide_values`, `a_growing_occluder_takes_what_its_rim_sweeps`
    pub fn derivatives(&self, point: &MeasurementPoint, parameters: &Parameters) -> Derivatives {
        let seen = self.seen(point);
        let truth = self.together(&seen);
        let touching = seen.iter().any(|seen| seen.touching || seen.sight == Sight::Unclear);
        let side = if touching { Side::One } else { Side::Both };
        let mut values = vec![0.0; parameters.count];
        for first in (0..parameters.count).step_by(LANES) {
            let lanes = Lanes { parameters, first };
            for (i, seen) in seen.iter().enumerate() {
                for (lane, effect) in lanes.effects() {
                    if matches!(effect, Effect::Exitance(of) if *of == i) {
                        values[first + lane] += seen.visible.value;
                    }
                }
                if matches!(seen.sight, Sight::Hidden | Sight::Below) {
                    continue;
                }
                // The outlines that move are those of every texel.
                if seen.light.is_some() {
                    return Derivatives { truth, values: None, side };
                }
                // What cancels in the value cancels in its slopes.
                let slopes = match seen.method {
                    Method::Quadrature => None,
                    Method::ClosedForm if seen.is_wide => {
                        let unit = Vector::constant(point.normal_as_given()).normalize();
                        self.slopes::<Wide>(i, seen, point, unit, &lanes).map(|slopes| slopes.map(Wide::narrow))
                    }
                    Method::ClosedForm => {
                        self.slopes::<f64>(i, seen, point, Vector::constant(point.normal()), &lanes)
                    }
                };
                let Some(slopes) = slopes else { return Derivatives { truth, values: None, side } };
                for (value, slope) in values[first..].iter_mut().zip(slopes) {
                    *value += self.sources[i].exitance * slope;
                }
            }
        }
        Derivatives { truth, values: Some(values), side }
    }

    /// Slopes of one source's visible form factor.
    ///
    /// - `unit`: the receiver's unit normal
    fn slopes<T: Number>(
        &self,
        source: usize,
        seen: &Seen,
        point: &MeasurementPoint,
        unit: Vector<T>,
        lanes: &Lanes,
    ) -> Option<[T; LANES]> {
        let constant = |x: T| Dual { value: x, slopes: [T::zero(); LANES] };
        let mut eye = Vector::<Dual<LANES, T>>::constant(point.position()) * Dual::constant(self.scale);
        let mut n = Vector::new(constant(unit.x), constant(unit.y), constant(unit.z));
        for (lane, effect) in lanes.effects() {
            match effect {
                Effect::Position(axis) => form::push(&mut eye, lane, DVec3::AXES[*axis] * self.scale),
                Effect::Normal(axis) => {
                    let unit = point.normal();
                    form::push(&mut n, lane, DVec3::AXES[*axis] - unit * unit[*axis]);
                }
                Effect::Body(..) | Effect::Exitance(_) => {}
            }
        }
        let motions = |at: BodyAt| {
            lanes.effects().filter_map(move |(lane, effect)| match effect {
                Effect::Body(of, motion) if *of == at => Some((lane, motion)),
                _ => None,
            })
        };
        let form = |at: BodyAt| Form::moving(self.body(at), eye, motions(at));
        let factor = self.factor(BodyAt::Source(source), seen.shadow.as_ref(), n, form)?;
        // Where outlines touch, crossings found anew may be others than those that were decided on.
        let off = (factor.value.primal() - seen.visible.value).abs();
        (off <= 1e-12 * seen.unoccluded + PARTED * seen.visible.bound).then_some(factor.value.slopes)
    }
}

/// The parameters that one run carries along.
struct Lanes<'a> {
    parameters: &'a Parameters,
    first: usize,
}

impl Lanes<'_> {
    fn effects(&self) -> impl Iterator<Item = (usize, &Effect)> {
        let lanes = self.first..self.first + LANES;
        self.parameters
            .effects
            .iter()
            .filter(move |(k, _)| lanes.contains(k))
            .map(|(k, effect)| (k - self.first, effect))
    }
}

/// How a shape moves as one of its numbers grows; `None` where it has no such number.
fn motion(shape: &Shape, field: Field, scale: f64) -> Option<Motion> {
    let along = |axis: usize| DVec3::AXES[axis] * scale;
    // Corners are −u−v, u−v, u+v, v−u about the centre, u and v half the edges.
    let corners = |shares: [f64; 4], axis: usize| Motion::Corners(shares.map(|s| along(axis) * (0.5 * s)).to_vec());
    Some(match (shape, field) {
        (Shape::Disk(_) | Shape::Sphere(_) | Shape::Rectangle(_), Field::Center(axis))
        | (Shape::Polygon(_) | Shape::Mesh(_), Field::Position(axis)) => Motion::Center(along(axis)),
        (Shape::Disk(_), Field::Normal(axis)) => Motion::Normal(DVec3::AXES[axis]),
        (Shape::Disk(_) | Shape::Sphere(_), Field::Radius) => Motion::Radius(scale),
        (Shape::Rectangle(_), Field::EdgeU(axis)) => corners([-1.0, 1.0, 1.0, -1.0], axis),
        (Shape::Rectangle(_), Field::EdgeV(axis)) => corners([-1.0, -1.0, 1.0, 1.0], axis),
        (Shape::Polygon(polygon), Field::Vertex(k, axis)) if k < polygon.vertices().len() => {
            let mut by = vec![DVec3::ZERO; polygon.vertices().len()];
            by[k] = along(axis);
            Motion::Corners(by)
        }
        _ => return None,
    })
}

fn accepted(shape: &Shape) -> String {
    match shape {
        Shape::Disk(_) => "center.x, .y, .z, normal.x, .y, .z and radius".to_owned(),
        Shape::Rectangle(_) => "center, edge_u and edge_v, each with .x, .y, .z".to_owned(),
        Shape::Polygon(polygon) => {
            let last = polygon.vertices().len() - 1;
            format!("vertices.0 to vertices.{last} and position, each with .x, .y, .z")
        }
        Shape::Sphere(_) => "center.x, .y, .z and radius".to_owned(),
        Shape::Mesh(_) => "position.x, .y, .z".to_owned(),
    }
}
