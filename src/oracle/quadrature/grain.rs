//! Lines on a source across which its exitance jumps or bends, so that strips are parted there and nothing has to be
//! searched for.

use glam::DVec3;

use super::curves::Circle;
use super::view::{Strip, View};
use crate::geometry::Frame;

/// A line on a source, relative to its centre, in the bodies' unit.
#[derive(Clone, Copy, Debug)]
pub(in crate::oracle) enum Line {
    Segment([DVec3; 2]),
    Circle { center: DVec3, normal: DVec3, radius: f64 },
}

/// The lines of a texture.
#[derive(Clone, Debug, Default)]
pub(in crate::oracle) struct Grain {
    /// Each with its kind: 0 along one s, 1 along one t.
    pub lines: Vec<(usize, Line)>,
    /// Where all lines of one kind meet, relative to the source's centre.
    pub poles: Vec<DVec3>,
    pub is_constant_between: bool,
}

/// The same relative to the eye, in the view's unit.
#[derive(Clone, Debug)]
pub(super) struct SeenGrain {
    pub traces: Vec<(usize, Trace)>,
    pub poles: Vec<DVec3>,
    pub is_constant_between: bool,
    /// Where strips cross them.
    crossings: Vec<Crossing>,
}

#[derive(Clone, Copy, Debug)]
pub(super) enum Trace {
    Segment([DVec3; 2]),
    Circle(Circle),
}

/// A line in a strip's coordinates.
#[derive(Clone, Copy, Debug)]
enum Crossing {
    /// From one (σ, τ) to another.
    Straight([[f64; 2]; 2]),
    /// A circle in the source's plane.
    Round { center: [f64; 2], radius: f64 },
    /// A circle on a ball: centre relative to the eye, and two radii at right angles.
    OnBall { center: DVec3, radii: [DVec3; 2] },
}

impl Grain {
    pub(super) fn seen(&self, view: &View) -> SeenGrain {
        // The anchor is the foot or the centre.
        let shift =
            if view.anchor == [0.0, 0.0] { [view.middle.dot(view.e1), view.middle.dot(view.e2)] } else { [0.0; 2] };
        let flat = |p: DVec3| [p.dot(view.e1) + shift[0], p.dot(view.e2) + shift[1]];
        let (mut traces, mut crossings) = (Vec::new(), Vec::new());
        for (kind, line) in &self.lines {
            match line {
                Line::Segment(ends) => {
                    let ends = ends.map(|p| p / view.unit);
                    traces.push((*kind, Trace::Segment(ends.map(|p| view.middle + p))));
                    crossings.push(Crossing::Straight(ends.map(flat)));
                }
                Line::Circle { center, normal, radius } => {
                    let (off, radius) = (*center / view.unit, radius / view.unit);
                    let center = view.middle + off;
                    traces.push((*kind, Trace::Circle(Circle { center, normal: *normal, radius })));
                    crossings.push(match view.ball {
                        None => Crossing::Round { center: flat(off), radius },
                        Some(_) => {
                            let frame = Frame::around(*normal);
                            Crossing::OnBall { center, radii: [frame.tangent * radius, frame.bitangent * radius] }
                        }
                    });
                }
            }
        }
        let poles = self.poles.iter().map(|pole| view.middle + *pole / view.unit);
        let in_front = |p: &DVec3| view.ball.is_none() || (*p - view.middle).dot(*p) < 0.0;
        SeenGrain {
            traces,
            crossings,
            poles: poles.filter(in_front).collect(),
            is_constant_between: self.is_constant_between,
        }
    }
}

impl SeenGrain {
    /// Adds the τ between two others at which a strip crosses a line.
    pub fn cross(&self, view: &View, strip: &Strip, from: f64, to: f64, found: &mut Vec<f64>) {
        let mut note = |tau: f64| {
            if tau > from && tau < to {
                found.push(tau);
            }
        };
        for crossing in &self.crossings {
            match crossing {
                Crossing::Straight([p, q]) => {
                    if (p[0] > strip.sigma) != (q[0] > strip.sigma) {
                        note(p[1] + (strip.sigma - p[0]) * ((q[1] - p[1]) / (q[0] - p[0])));
                    }
                }
                Crossing::Round { center: [s, t], radius } => {
                    let across = strip.sigma - s;
                    let square = (radius - across) * (radius + across);
                    if square > 0.0 {
                        note(t - square.sqrt());
                        note(t + square.sqrt());
                    }
                }
                Crossing::OnBall { center, radii: [u, v] } => {
                    // In the strip's plane: across · (center + u cos φ + v sin φ) = 0.
                    let (level, a, b) = (strip.across.dot(*center), strip.across.dot(*u), strip.across.dot(*v));
                    let swing = a.hypot(b);
                    if level.abs() > swing {
                        continue;
                    }
                    // cos of the angle to (a, b), and its sine both ways.
                    let cos = -level / swing;
                    let sin = ((swing - level.abs()) * (swing + level.abs())).sqrt() / swing;
                    for sin in [sin, -sin] {
                        let (x, y) = ((a * cos - b * sin) / swing, (b * cos + a * sin) / swing);
                        let point = *center + *u * x + *v * y;
                        // On the side of the ball that is seen.
                        if (point - view.middle).dot(point) < 0.0
                            && let Some([_, tau]) = view.flat(point)
                        {
                            note(tau);
                        }
                    }
                }
            }
        }
    }
}
