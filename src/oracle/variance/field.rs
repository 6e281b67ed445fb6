//! What one sample brings, over the unit square that its place is drawn from.

use glam::DVec3;

use super::super::exact::{BodyAt, Oracle};
use super::super::form::Form;
use super::super::front::{Blocking, Front};
use super::super::piece::Piece;
use super::chart::{Chart, Place};
use super::grid::TexelCheck;
use crate::configuration::MeasurementPoint;
use crate::texture::Texture;

/// A place on a source as a receiver sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Landing {
    /// Cosine of the angle between the receiver's normal and the direction to the place; 0 where it is negative.
    pub cos_receiver: f64,
    /// Cosine of the angle between the source's normal and the direction to the receiver; 0 where it is negative.
    pub cos_source: f64,
    /// m².
    pub distance_squared: f64,
    /// Of the whole source, m².
    pub area: f64,
    /// W/m².
    pub exitance: f64,
}

/// What a sample that lands somewhere, and is not blocked, brings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contribution {
    /// W/m².
    pub value: f64,
    /// Its probability density there, relative to that of a place drawn uniformly by area.
    pub density: f64,
}

impl Contribution {
    /// A place drawn uniformly by area: A M cosθᵢ cosθₛ / (π r²).
    pub fn by_area(landing: &Landing) -> Contribution {
        let Landing { cos_receiver, cos_source, distance_squared, area, exitance } = *landing;
        let value = area * exitance * cos_receiver * cos_source / (std::f64::consts::PI * distance_squared);
        Contribution { value, density: 1.0 }
    }

    /// A direction drawn uniformly in a solid angle around the source: M cosθᵢ Ω/π, with density A cosθₛ/(r² Ω).
    ///
    /// - `solid_angle`: Ω, sr
    pub fn by_solid_angle(landing: &Landing, solid_angle: f64) -> Contribution {
        let Landing { cos_receiver, cos_source, distance_squared, area, exitance } = *landing;
        let value = exitance * cos_receiver * solid_angle / std::f64::consts::PI;
        Contribution { value, density: area * cos_source / (distance_squared * solid_angle) }
    }

    /// A place drawn by area, weighed against a direction drawn by the cosine: the sample by area times
    /// p_aᵝ/(p_aᵝ + p_cᵝ), with p_a = r²/(A cosθₛ) and p_c = cosθᵢ/π per solid angle (Veach 1997).
    ///
    /// - `power`: β, 1 for the balance heuristic
    pub fn by_area_weighed(landing: &Landing, power: i32) -> Contribution {
        let by_area = Contribution::by_area(landing);
        Contribution { value: by_area.value * (1.0 - share_of_cosine(landing, power)), ..by_area }
    }

    /// A direction drawn by the cosine that meets the source brings M, with density A cosθᵢ cosθₛ/(π r²).
    pub fn by_cosine(landing: &Landing) -> Contribution {
        let Landing { cos_receiver, cos_source, distance_squared, area, exitance } = *landing;
        Contribution {
            value: exitance,
            density: area * cos_receiver * cos_source / (std::f64::consts::PI * distance_squared),
        }
    }

    /// The other half: a direction drawn by the cosine that meets the source brings M p_cᵝ/(p_aᵝ + p_cᵝ).
    pub fn by_cosine_weighed(landing: &Landing, power: i32) -> Contribution {
        let Landing { cos_receiver, cos_source, distance_squared, area, exitance } = *landing;
        Contribution {
            value: exitance * share_of_cosine(landing, power),
            density: area * cos_receiver * cos_source / (std::f64::consts::PI * distance_squared),
        }
    }
}

/// p_cᵝ/(p_aᵝ + p_cᵝ): both over p_a, which is infinite where the source is seen edge-on.
fn share_of_cosine(landing: &Landing, power: i32) -> f64 {
    let Landing { cos_receiver, cos_source, distance_squared, area, .. } = *landing;
    let ratio = (area * cos_receiver * cos_source / (std::f64::consts::PI * distance_squared)).powi(power);
    ratio / (1.0 + ratio)
}

/// One source seen from one point.
pub(super) struct Field<'a> {
    chart: &'a Chart,
    eye: DVec3,
    normal: DVec3,
    area: f64,
    exitance: f64,
    texture: Option<&'a Texture>,
    check: Option<TexelCheck<'a>>,
    /// What can hide some of it; `None` where nothing of it is seen.
    blockers: Option<Vec<Piece>>,
}

impl<'a> Field<'a> {
    /// `None` where visibility is no set of directions (an occluder may reach into a sphere source), or an occluder has so
    /// many edges that this is no way to go about it.
    pub fn new(oracle: &'a Oracle, source: usize, point: &MeasurementPoint) -> Option<Field<'a>> {
        let emitter = &oracle.sources[source];
        let field = |blockers| Field {
            chart: &emitter.chart,
            eye: point.position(),
            normal: point.normal(),
            area: emitter.area,
            exitance: emitter.exitance,
            texture: emitter.texture.as_deref(),
            check: emitter.texture.as_deref().and_then(TexelCheck::of),
            blockers,
        };
        let eye = point.position() * oracle.scale;
        let form = Form::plain(&emitter.body, eye);
        let Some(front) = Front::of(&emitter.body, &form) else { return Some(field(None)) };
        let occluders = (0..oracle.occluders.len()).map(BodyAt::Occluder);
        let others = (0..oracle.sources.len()).filter(|i| *i != source).map(BodyAt::Source);
        let mut pieces = Vec::new();
        for at in occluders.chain(others) {
            match front.before(oracle.body(at), eye) {
                Blocking::None => {}
                Blocking::All => return Some(field(None)),
                Blocking::Part { piece, .. } => pieces.push(piece),
                Blocking::Within => return None,
            }
        }
        let edges: usize = pieces.iter().map(|piece| piece.curves.len()).sum();
        (edges <= MOST_EDGES).then(|| field(Some(pieces)))
    }

    /// Whether nothing of it is seen, from whatever place.
    pub fn is_dark(&self) -> bool {
        self.blockers.is_none()
    }

    /// Whether what is brought may have a crease within [u₀, u₁] × [v₀, v₁], by the map's doing.
    pub fn is_creased(&self, u: [f64; 2], v: [f64; 2]) -> bool {
        self.chart.is_creased(u, v)
    }

    /// Whether the exitance may jump within [u₀, u₁] × [v₀, v₁], or bend on a scale that is not small beside it.
    ///
    /// - `level`: halvings of the unit square that led to it
    pub fn is_uneven(&self, [u0, u1]: [f64; 2], [v0, v1]: [f64; 2], level: u32) -> bool {
        let Some(check) = &self.check else { return false };
        // Borders of texels and of cells often coincide: a hair inside.
        const INSIDE: f64 = 1e-9;
        let inside = |x: [f64; 2]| [x[0] + INSIDE * (x[1] - x[0]), x[1] - INSIDE * (x[1] - x[0])];
        let ([u0, u1], [v0, v1]) = (inside([u0, u1]), inside([v0, v1]));
        let places = [[u0, v0], [u1, v0], [u1, v1], [u0, v1], [0.5 * (u0 + u1), 0.5 * (v0 + v1)]];
        check.is_uneven(level, places.map(|[u, v]| self.chart.place(u, v).position))
    }

    /// The unit direction to a place, and the place, with its exitance.
    pub fn at(&self, u: f64, v: f64) -> (DVec3, Landing) {
        let place = self.place(u, v);
        self.of(&place, self.exitance_at(&place))
    }

    /// The place that is drawn, the same for all receivers.
    pub fn place(&self, u: f64, v: f64) -> Place {
        self.chart.place(u, v)
    }

    /// W/m² at a place.
    pub fn exitance_at(&self, place: &Place) -> f64 {
        self.texture.map_or(self.exitance, |texture| texture.at(place.position))
    }

    /// The unit direction to a place, and the place as it is seen.
    pub fn of(&self, place: &Place, exitance: f64) -> (DVec3, Landing) {
        let way = place.position - self.eye;
        let distance_squared = way.length_squared();
        let direction = way / distance_squared.sqrt();
        let landing = Landing {
            cos_receiver: self.normal.dot(direction).max(0.0),
            cos_source: (-place.normal.dot(direction)).max(0.0),
            distance_squared,
            area: self.area,
            exitance,
        };
        (direction, landing)
    }

    /// Signed angle from a direction to the nearest edge of what is hidden, positive where the source is seen; its size is
    /// a lower bound, tight near the edge.
    pub fn margin(&self, direction: DVec3) -> f64 {
        let Some(blockers) = &self.blockers else { return -1.0 };
        blockers.iter().map(|piece| -piece.margin(direction)).fold(f64::INFINITY, f64::min)
    }
}

/// Curves of all occluders together beyond which a margin costs too much.
const MOST_EDGES: usize = 2048;
