//! The strips on which the list of what crosses a strip changes its make-up: between two of them the integral along a
//! strip is analytic, with square-root ends at worst.
//!
//! They are corners, the ends of rims, the crossings of any two outlines (with the horizon and with the occluders'
//! meeting with the source among them), and places that suit the peak below a near source. An opening is bounded by
//! some of these wherever it is, so that none is too narrow to be looked into.

use glam::DVec3;

use super::blocker::Form;
use super::curves::{Circle, Curve};
use super::grain::{SeenGrain, Trace};
use super::rule::around_a_peak;
use super::view::{Outline, Stretch, View};

/// What a curve belongs to.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Owner {
    Source,
    Horizon,
    Blocker(usize),
    /// A line of one s (0) or one t (1) on the source: those of one kind meet in poles only.
    Line(usize),
}

struct Bound {
    owner: Owner,
    curve: Curve,
    /// σ and τ of a box around it.
    low: [f64; 2],
    high: [f64; 2],
}

/// Ascending, from the source's first strip to its last.
pub(super) fn breaks(view: &View, grain: Option<&SeenGrain>) -> Vec<f64> {
    let (low, high) = view.extent();
    let mut found = Found { view, ends: Vec::new(), scratch: Vec::new(), low, high };
    let mut bounds = found.bounds();
    if let Some(grain) = grain {
        found.grain(grain, &mut bounds);
    }
    for (i, first) in bounds.iter().enumerate() {
        for second in &bounds[i + 1..] {
            found.crossings(first, second);
        }
    }
    let mut ends = found.ends;
    around_a_peak(-view.anchor[0], view.height, low, high, &mut ends);
    ends.retain(|s| *s > low && *s < high);
    ends.sort_by(f64::total_cmp);
    // What lies closer together is one break: half of a panel this narrow holds nothing.
    let mut kept = vec![low];
    for end in ends {
        let near = 1e-11 * (high - low).min(view.height.hypot(view.anchor[0] + end));
        if end - kept[kept.len() - 1] > near && high - end > near {
            kept.push(end);
        }
    }
    kept.push(high);
    kept
}

/// The σ between which an occluder's outline shows; everything where part of it is behind the eye.
pub(super) fn range(view: &View, form: &Form) -> [f64; 2] {
    const EVERYWHERE: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];
    let circle = match form {
        Form::Flat { points, .. } => {
            let mut range = [f64::INFINITY, f64::NEG_INFINITY];
            for point in points {
                let Some([sigma, _]) = view.flat(*point) else { return EVERYWHERE };
                range = [range[0].min(sigma), range[1].max(sigma)];
            }
            return widened(view, range);
        }
        Form::Disk { center, normal, radius } => Some(Circle { center: *center, normal: *normal, radius: *radius }),
        Form::Ball { center, radius } => Circle::silhouette(*center, *radius),
    };
    circle.and_then(|circle| sigmas(view, &circle)).map_or(EVERYWHERE, |range| widened(view, range))
}

/// By more than rounding.
fn widened(view: &View, range: [f64; 2]) -> [f64; 2] {
    let margin = |sigma: f64| 1e-9 * (view.height + sigma.abs() + view.anchor[0].abs());
    [range[0] - margin(range[0]), range[1] + margin(range[1])]
}

/// A circle's ends in σ; `None` where part of it is behind the eye.
fn sigmas(view: &View, circle: &Circle) -> Option<[f64; 2]> {
    let depth = circle.center.dot(view.down);
    let reach = circle.radius * circle.normal.cross(view.down).length();
    if depth <= reach * (1.0 + 1e-9) {
        return None;
    }
    let [(a, _), (b, _)] = extremes(view, circle);
    (a.is_finite() && b.is_finite()).then_some([a.min(b), a.max(b)])
}

/// σ of the strips that touch a circle's trace, and the points that they touch.
fn extremes(view: &View, circle: &Circle) -> [(f64, DVec3); 2] {
    let a = (view.down * view.height + view.e1 * view.anchor[0]).cross(view.e2);
    circle.extremes(a, view.e1.cross(view.e2))
}

struct Found<'a> {
    view: &'a View<'a>,
    ends: Vec<f64>,
    scratch: Vec<Stretch>,
    low: f64,
    high: f64,
}

impl Found<'_> {
    /// All curves; their own corners and ends are noted on the way.
    fn bounds(&mut self) -> Vec<Bound> {
        let view = self.view;
        let mut bounds = Vec::new();
        match &view.outline {
            Outline::Circle(round) => {
                let circle = match view.ball {
                    Some(own) => Circle::silhouette(view.middle, own),
                    None => Some(Circle { center: view.middle, normal: -view.down, radius: round.radius }),
                };
                bounds.extend(circle.map(|circle| self.bound(Owner::Source, Curve::Circle(circle))));
            }
            Outline::Edges(edges) => {
                for edge in edges {
                    self.ends.push(edge.ends[0][0]);
                    let [s, t] = view.anchor;
                    let at = |[sigma, tau]: [f64; 2]| {
                        view.down * view.height + view.e1 * (s + sigma) + view.e2 * (t + tau)
                    };
                    let [p, q] = edge.ends.map(at);
                    bounds.extend(Curve::edge(p, q).map(|curve| self.bound(Owner::Source, curve)));
                }
            }
        }
        bounds.push(self.bound(Owner::Horizon, Curve::Line { normal: view.n, ends: None }));
        let silhouettes = silhouette_edges(view);
        for (i, blocker) in view.blockers.iter().enumerate() {
            let owner = Owner::Blocker(i);
            if blocker.range[1] < self.low || blocker.range[0] > self.high {
                continue;
            }
            match &blocker.form {
                Form::Disk { center, normal, radius } => {
                    let circle = Circle { center: *center, normal: *normal, radius: *radius };
                    self.rim(owner, circle, &mut bounds);
                    let reach = radius * normal.cross(view.down).length();
                    let depth = center.dot(view.down);
                    if self.meets(depth - reach, depth + reach, *center, *radius) {
                        self.meeting(owner, *center, *normal, &mut bounds);
                    }
                }
                Form::Ball { center, radius } => {
                    let section = match view.ball {
                        None => Circle::section(*center, *radius, -view.down, view.down * view.height),
                        Some(own) => common_circle(*center, *radius, view.middle, own),
                    };
                    for circle in Circle::silhouette(*center, *radius).into_iter().chain(section) {
                        self.rim(owner, circle, &mut bounds);
                    }
                }
                Form::Flat { shape, points } => {
                    for (edge, [p, q]) in blocker.edges().enumerate() {
                        if !silhouettes[i][edge] {
                            continue;
                        }
                        for end in [p, q] {
                            self.note(end, &[owner]);
                        }
                        bounds.extend(Curve::edge(p, q).map(|curve| self.bound(owner, curve)));
                    }
                    let depths = points.iter().map(|p| p.dot(view.down));
                    let (near, far) =
                        depths.fold((f64::INFINITY, f64::NEG_INFINITY), |(n, f), d| (n.min(d), f.max(d)));
                    let size = points.iter().map(|p| p.distance(points[0])).fold(0.0, f64::max);
                    if self.meets(near, far, points[0], size) {
                        self.meeting(owner, points[0], shape.normal, &mut bounds);
                    }
                }
            }
        }
        bounds.retain(|b| b.low[0] <= self.high && b.high[0] >= self.low);
        bounds
    }

    /// Lines on the source.
    fn grain(&mut self, grain: &SeenGrain, bounds: &mut Vec<Bound>) {
        for pole in &grain.poles {
            self.note(*pole, &[Owner::Line(0), Owner::Line(1)]);
        }
        for (kind, trace) in &grain.traces {
            let owner = Owner::Line(*kind);
            match trace {
                Trace::Segment([p, q]) => {
                    for end in [p, q] {
                        self.note(*end, &[owner, Owner::Source]);
                    }
                    bounds.extend(Curve::edge(*p, *q).map(|curve| self.bound(owner, curve)));
                }
                Trace::Circle(circle) => {
                    if circle.center.dot(circle.normal).abs() <= 1e-12 * circle.center.length() {
                        // Seen edge-on it is a straight line.
                        bounds.push(self.bound(owner, Curve::Line { normal: circle.normal, ends: None }));
                    } else {
                        self.rim(owner, *circle, bounds);
                    }
                }
            }
        }
        bounds.retain(|b| b.low[0] <= self.high && b.high[0] >= self.low);
    }

    fn rim(&mut self, owner: Owner, circle: Circle, bounds: &mut Vec<Bound>) {
        if circle.center.dot(circle.normal).abs() <= 1e-14 * circle.center.length() {
            // Seen edge-on it hides nothing.
            return;
        }
        for (sigma, point) in extremes(self.view, &circle) {
            if sigma > self.low && sigma < self.high {
                self.note(point, &[owner]);
            }
        }
        bounds.push(self.bound(owner, Curve::Circle(circle)));
    }

    /// Whether what lies in a ball and between two depths may reach into the source, or its plane.
    fn meets(&self, near: f64, far: f64, center: DVec3, radius: f64) -> bool {
        let margin = 1e-9 * (center.length() + radius + self.view.height);
        match self.view.ball {
            Some(own) => center.distance(self.view.middle) <= own + radius + margin,
            None => near <= self.view.height + margin && far >= self.view.height - margin,
        }
    }

    /// Where a flat occluder's plane meets the source.
    fn meeting(&mut self, owner: Owner, anchor: DVec3, normal: DVec3, bounds: &mut Vec<Bound>) {
        let view = self.view;
        match view.ball {
            Some(radius) => {
                if let Some(circle) = Circle::section(view.middle, radius, normal, anchor) {
                    self.rim(owner, circle, bounds);
                }
            }
            None => {
                let along = normal.cross(view.down);
                // Parallel planes meet nowhere, or where rounding says.
                if along.length() > 1e-12 {
                    let apart = normal.dot(anchor - view.middle);
                    let toward = normal - view.down * normal.dot(view.down);
                    let point = view.middle + toward * (apart / toward.length_squared());
                    if let Some(normal) = point.cross(along).try_normalize() {
                        bounds.push(self.bound(owner, Curve::Line { normal, ends: None }));
                    }
                }
            }
        }
    }

    fn bound(&self, owner: Owner, curve: Curve) -> Bound {
        let (mut low, mut high) = ([f64::NEG_INFINITY; 2], [f64::INFINITY; 2]);
        match &curve {
            Curve::Line { ends: Some([p, q]), .. } => {
                if let (Some(p), Some(q)) = (self.view.flat(*p), self.view.flat(*q)) {
                    low = [p[0].min(q[0]), p[1].min(q[1])];
                    high = [p[0].max(q[0]), p[1].max(q[1])];
                }
            }
            Curve::Line { ends: None, .. } => {}
            Curve::Circle(circle) => {
                if let Some([from, to]) = sigmas(self.view, circle) {
                    (low[0], high[0]) = (from, to);
                }
            }
        }
        for k in 0..2 {
            let margin = |x: f64| 1e-7 * (self.high - self.low) + 1e-9 * x.abs();
            (low[k], high[k]) = (low[k] - margin(low[k]), high[k] + margin(high[k]));
        }
        Bound { owner, curve, low, high }
    }

    fn crossings(&mut self, first: &Bound, second: &Bound) {
        let apart = (0..2).any(|k| first.high[k] < second.low[k] || second.high[k] < first.low[k]);
        let is_own = matches!(first.owner, Owner::Source | Owner::Line(_));
        if apart || (first.owner == second.owner && is_own) {
            return;
        }
        let mut directions = Vec::new();
        first.curve.cross(&second.curve, &mut directions);
        for direction in directions {
            self.note(direction, &[first.owner, second.owner]);
        }
    }

    /// Takes a place on the source for a break, unless what goes on there is surely hidden by something else.
    fn note(&mut self, direction: DVec3, owners: &[Owner]) {
        let view = self.view;
        let Some([sigma, tau]) = view.flat(direction) else { return };
        if !(sigma > self.low && sigma < self.high) {
            return;
        }
        // Far above what the place may be off by.
        let margin = 1e-7 * (self.high - self.low).min(view.height.hypot(view.anchor[0] + sigma));
        let is_within = |x: &Stretch, margin: f64| x.from + margin < tau && tau < x.to - margin;
        let strip = view.strip(sigma);
        if !owners.contains(&Owner::Source) {
            view.inside(sigma, &mut self.scratch);
            if !self.scratch.iter().any(|x| is_within(x, -margin)) {
                return;
            }
        }
        if !owners.contains(&Owner::Horizon) {
            let cosine = view.cosine(&strip);
            if cosine.level + cosine.slope * tau < -margin {
                return;
            }
        }
        self.scratch.clear();
        for (i, blocker) in view.blockers.iter().enumerate() {
            if !owners.contains(&Owner::Blocker(i)) {
                blocker.cover(view, &strip, &mut self.scratch);
                if self.scratch.iter().any(|x| is_within(x, margin)) {
                    return;
                }
                self.scratch.clear();
            }
        }
        self.ends.push(sigma);
    }
}

/// The circle that two spheres share.
fn common_circle(center: DVec3, radius: f64, own: DVec3, own_radius: f64) -> Option<Circle> {
    let between = center - own;
    let gap = between.length();
    let along = 0.5 * (gap + (own_radius - radius) * (own_radius + radius) / gap);
    let square = (own_radius - along) * (own_radius + along);
    (square > 0.0).then(|| Circle {
        center: own + between * (along / gap),
        normal: between / gap,
        radius: square.sqrt(),
    })
}

/// Of each flat occluder's edges, those that may part seen from hidden: an edge that two faces of a mesh share, one on
/// either side of it, does not.
fn silhouette_edges(view: &View) -> Vec<Vec<bool>> {
    let mut keep: Vec<Vec<bool>> = Vec::with_capacity(view.blockers.len());
    let mut shared: Vec<([u64; 6], f64, usize, usize)> = Vec::new();
    for (i, blocker) in view.blockers.iter().enumerate() {
        keep.push(blocker.edges().map(|_| true).collect());
        let Form::Flat { shape, points } = &blocker.form else { continue };
        let facing = shape.normal.dot(points[0]);
        for (k, [p, q]) in blocker.edges().enumerate() {
            let bits = |p: DVec3| p.to_array().map(f64::to_bits);
            let (a, b) = (bits(p), bits(q));
            let side = if a < b { facing } else { -facing };
            let (a, b) = if a < b { (a, b) } else { (b, a) };
            shared.push(([a[0], a[1], a[2], b[0], b[1], b[2]], side, i, k));
        }
    }
    shared.sort_by_key(|x| (x.0, x.2, x.3));
    for group in shared.chunk_by(|x, y| x.0 == y.0) {
        if let [(_, a, i, k), (_, b, j, l)] = group
            && a * b < 0.0
        {
            (keep[*i][*k], keep[*j][*l]) = (false, false);
        }
    }
    keep
}
