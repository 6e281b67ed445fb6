//! What stands before a source: which occluders can hide some of it from one eye, and what part of each.

use glam::DVec3;

use super::body::{Body, Figure};
use super::form::{Form, HalfSpace};
use super::piece::Piece;

/// What an occluder must lie before to block a source.
pub(super) struct Front<'a> {
    source: &'a Body,
    /// Relative to the eye.
    center: DVec3,
    /// A flat source's own plane; the plane of a sphere's silhouette.
    keep: HalfSpace,
}

pub(super) enum Blocking {
    None,
    Part {
        piece: Piece,
        /// Whether the part is cut off by the front.
        is_clipped: bool,
    },
    All,
    /// It cuts into a sphere source: no outline of directions tells what is before what.
    Within,
}

impl Front<'_> {
    /// `None` where the source turns its dark side, or the eye is inside it.
    pub fn of<'a>(source: &'a Body, form: &Form) -> Option<Front<'a>> {
        let (center, on_plane) = match form {
            Form::Disk { center, .. } => (center.primal(), center.primal()),
            Form::Flat(flat) => (flat.center.primal(), flat.corners[0].primal()),
            Form::Ball { center, radius } => {
                let center = center.primal();
                return (center.length() > *radius).then(|| Front { source, center, keep: form.front() });
            }
            Form::Mesh(_) => return None,
        };
        let keep = form.front();
        let noise = 4.0 * f64::EPSILON * (on_plane.length() + source.reach);
        (keep.k > noise).then_some(Front { source, center, keep })
    }

    /// What an occluder can hide of the source.
    pub fn before(&self, occluder: &Body, eye: DVec3) -> Blocking {
        let center = occluder.center - eye;
        if let Figure::Ball { radius } = occluder.figure
            && center.length() <= radius
        {
            return Blocking::All;
        }
        let keep = self.keep.normal.primal();
        if keep.dot(center) + self.keep.k <= -occluder.reach || self.is_beside(center, occluder.reach) {
            return Blocking::None;
        }
        let (piece, is_clipped) = match (&self.source.figure, &occluder.figure) {
            (Figure::Ball { .. }, Figure::Ball { radius }) => {
                let between = self.center.distance(center);
                let own = self.source.reach;
                if between + radius <= own {
                    return Blocking::None;
                } else if between + own <= *radius {
                    return Blocking::All;
                } else if between < own + radius {
                    return Blocking::Within;
                } else if self.sphere_comes_first(center, *radius) {
                    return Blocking::None;
                }
                (Piece::of_occluder(&Form::plain(occluder, eye), None), false)
            }
            (Figure::Ball { radius }, Figure::Disk { normal, .. })
                if self.is_cut_by(occluder, center, *normal, center, *radius) =>
            {
                return Blocking::Within;
            }
            (Figure::Ball { radius }, Figure::Flat(shape))
                if self.is_cut_by(occluder, center, shape.normal, shape.origin - eye + shape.offsets[0], *radius) =>
            {
                return Blocking::Within;
            }
            (Figure::Ball { radius }, Figure::Mesh(surface))
                if center.distance(self.center) < occluder.reach + radius
                    && surface.may_reach_into(self.source.center, *radius) =>
            {
                return Blocking::Within;
            }
            _ => (Piece::of_occluder(&Form::plain(occluder, eye), Some(self.keep)), true),
        };
        piece.map_or(Blocking::None, |piece| Blocking::Part { piece, is_clipped })
    }

    /// Whether a flat occluder may reach into a sphere source.
    fn is_cut_by(&self, occluder: &Body, center: DVec3, normal: DVec3, on_plane: DVec3, radius: f64) -> bool {
        normal.dot(self.center - on_plane).abs() < radius && center.distance(self.center) < occluder.reach + radius
    }

    /// Whether the cones around a body and around the source surely share no direction.
    fn is_beside(&self, center: DVec3, reach: f64) -> bool {
        let (own, other) = (self.center.length(), center.length());
        let (s, t) = (self.source.reach / own, reach / other);
        if s >= 1.0 || t >= 1.0 {
            return false;
        }
        let apart = self.center.dot(center) / (own * other);
        let touching = ((1.0 - s * s) * (1.0 - t * t)).sqrt() - s * t;
        // Beyond a half turn the cones always meet.
        s * s + t * t < 1.0 && apart < touching - 1e-12
    }

    /// Two balls apart have a plane between them; whichever lies on the eye's side of it is met first.
    fn sphere_comes_first(&self, center: DVec3, radius: f64) -> bool {
        let between = self.center - center;
        let gap = between.length() - self.source.reach - radius;
        let direction = between.normalize();
        direction.dot(center + direction * (radius + 0.5 * gap)) < 0.0
    }
}
