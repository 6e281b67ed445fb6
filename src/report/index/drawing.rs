//! A drawing of the room, from its outlines: from the side and from above, to scale.

use std::fmt::Write as _;

use crate::configuration::{Arrangement, Role, Stroke};
use crate::geometry::{DVec3, Frame};
use crate::oracle::Region;
use crate::report::page::escaped;
use crate::report::record::{CaseRecord, FigureRecord};

/// Of one view, units of the drawing.
const SIZE: [f64; 2] = [360.0, 270.0];
const MARGIN: f64 = 26.0;
/// Corners of a circle that is seen askew.
const ROUND: usize = 72;

/// Two directions of the room that a view shows to the right and upwards.
struct View {
    name: &'static str,
    right: DVec3,
    up: DVec3,
    labels: [String; 2],
}

type Flat = [f64; 2];

/// Both views, beside each other or, where there is no room, below. Empty where nothing is known of the room.
pub fn drawing(case: &CaseRecord) -> String {
    if case.figures.is_empty() {
        return String::new();
    }
    let along = sideways(case);
    let name_of = |v: DVec3| match (v.x.abs(), v.y.abs()) {
        (x, _) if x > 0.999 => "x".to_owned(),
        (_, y) if y > 0.999 => "y".to_owned(),
        _ => format!("({:.2}, {:.2}, 0)", v.x, v.y).replace('-', "−"),
    };
    let across = DVec3::Z.cross(along);
    let views = [
        View { name: "from the side", right: along, up: DVec3::Z, labels: [name_of(along), "z".to_owned()] },
        View { name: "from above", right: along, up: across, labels: [name_of(along), name_of(across)] },
    ];
    let svgs: String = views.iter().map(|view| drawn(case, view)).collect();
    format!("<div class=\"views\">{svgs}</div>\n{}", key(case))
}

/// The horizontal direction that the measured line follows, or x.
fn sideways(case: &CaseRecord) -> DVec3 {
    let ends = case.points.first().zip(case.points.last());
    let along = ends.filter(|_| case.arrangement == Arrangement::Line).map(|(a, b)| b.position - a.position);
    let flat = along.map(|v| DVec3::new(v.x, v.y, 0.0)).filter(|v| v.length() > 1e-9).unwrap_or(DVec3::X);
    let flat = flat.normalize();
    // Not mirrored: x or y to the right.
    if flat.x + flat.y < 0.0 { -flat } else { flat }
}

impl View {
    fn flat(&self, at: DVec3) -> Flat {
        [at.dot(self.right), at.dot(self.up)]
    }

    /// What a stroke looks like: outlines that close or do not.
    fn seen(&self, stroke: &Stroke) -> (Vec<Flat>, bool) {
        match stroke {
            Stroke::Round { center, normal, radius } => {
                let (a, b) = match normal {
                    None => (self.right, self.up),
                    Some(normal) => {
                        let frame = Frame::around(*normal);
                        (frame.tangent, frame.bitangent)
                    }
                };
                let place = |k: usize| {
                    let (sin, cos) = (std::f64::consts::TAU * k as f64 / ROUND as f64).sin_cos();
                    self.flat(*center + (a * cos + b * sin) * *radius)
                };
                ((0..ROUND).map(place).collect(), true)
            }
            Stroke::Closed(through) => (through.iter().map(|at| self.flat(*at)).collect(), true),
            Stroke::Open(through) => (through.iter().map(|at| self.flat(*at)).collect(), false),
            Stroke::Hull(through) => (hull(through.iter().map(|at| self.flat(*at)).collect()), true),
        }
    }
}

/// The convex outline of points in a plane, counter-clockwise (Andrew 1979).
fn hull(mut points: Vec<Flat>) -> Vec<Flat> {
    points.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    points.dedup();
    if points.len() < 3 {
        return points;
    }
    let turns = |a: Flat, b: Flat, c: Flat| (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) > 0.0;
    let half = |points: &mut dyn Iterator<Item = Flat>| {
        let mut chain: Vec<Flat> = Vec::new();
        for point in points {
            while chain.len() > 1 && !turns(chain[chain.len() - 2], chain[chain.len() - 1], point) {
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    let mut outline = half(&mut points.iter().copied());
    outline.extend(half(&mut points.iter().rev().copied()));
    outline
}

/// From room to paper.
struct Scale {
    factor: f64,
    middle: Flat,
}

impl Scale {
    fn of(places: impl Iterator<Item = Flat>) -> Option<Scale> {
        let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for place in places {
            for k in 0..2 {
                low[k] = low[k].min(place[k]);
                high[k] = high[k].max(place[k]);
            }
        }
        let size = [high[0] - low[0], high[1] - low[1]];
        if !size.iter().all(|s| s.is_finite()) {
            return None;
        }
        let fit = |k: usize| (SIZE[k] - 2.0 * MARGIN) / size[k].max(f64::MIN_POSITIVE);
        let factor = fit(0).min(fit(1));
        factor.is_finite().then_some(Scale { factor, middle: [0.5 * (low[0] + high[0]), 0.5 * (low[1] + high[1])] })
    }

    fn at(&self, place: Flat) -> Flat {
        let x = 0.5 * SIZE[0] + (place[0] - self.middle[0]) * self.factor;
        let y = 0.5 * SIZE[1] - (place[1] - self.middle[1]) * self.factor;
        [x, y]
    }
}

fn drawn(case: &CaseRecord, view: &View) -> String {
    let strokes = || case.figures.iter().flat_map(|figure| figure.strokes.iter().map(move |s| (figure, s)));
    let places = strokes().flat_map(|(_, stroke)| view.seen(stroke).0);
    let Some(scale) = Scale::of(places.chain(case.points.iter().map(|p| view.flat(p.position)))) else {
        return String::new();
    };
    let label = format!("The room {}", view.name);
    let mut svg = format!(
        "<svg class=\"room\" viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{label}\"><title>{label}</title>\n",
        SIZE[0], SIZE[1]
    );
    // Large things first, so that they do not hide what stands before them.
    for role in [Role::Receiver, Role::Diffuse, Role::Mirror, Role::Glass, Role::Occluder, Role::Source, Role::Lamp] {
        for figure in case.figures.iter().filter(|figure| figure.role == role) {
            draw(&mut svg, figure, view, &scale);
        }
    }
    borders(&mut svg, case, view, &scale);
    points(&mut svg, case, view, &scale);
    measure(&mut svg, &scale, view);
    svg + "</svg>\n"
}

fn draw(svg: &mut String, figure: &FigureRecord, view: &View, scale: &Scale) {
    for stroke in &figure.strokes {
        let (outline, closes) = view.seen(stroke);
        let outline: Vec<Flat> = outline.into_iter().map(|place| scale.at(place)).collect();
        let class = figure.role.name();
        if let [only] = outline[..] {
            let _ = writeln!(svg, "<circle class=\"{class}\" cx=\"{:.1}\" cy=\"{:.1}\" r=\"4\"/>", only[0], only[1]);
            continue;
        }
        let path: Vec<String> = outline.iter().map(|p| format!("{:.1} {:.1}", p[0], p[1])).collect();
        let (end, open) = if closes { ("Z", "") } else { ("", " open") };
        let _ = writeln!(svg, "<path class=\"{class}{open}\" d=\"M{}{end}\"/>", path.join("L"));
    }
}

/// From where umbra, penumbra and light meet on the line: the ray that just passes an occluder to a rim of a source. In a view
/// that does not show that ray there is none.
fn borders(svg: &mut String, case: &CaseRecord, view: &View, scale: &Scale) {
    if case.arrangement != Arrangement::Line {
        return;
    }
    let outlines = |role: Role| -> Vec<Vec<Flat>> {
        let figures = case.figures.iter().filter(|figure| figure.role == role);
        figures.map(|figure| figure.strokes.iter().flat_map(|stroke| view.seen(stroke).0).collect()).collect()
    };
    let (sources, occluders) = (outlines(Role::Source), outlines(Role::Occluder));
    for pair in case.points.windows(2).filter(|pair| pair[0].region != pair[1].region) {
        let [a, b] = [view.flat(pair[0].position), view.flat(pair[1].position)];
        let from = [0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])];
        let step = (b[0] - a[0]).hypot(b[1] - a[1]);
        let mut best: Option<(f64, Flat)> = None;
        for source in &sources {
            let Some(straight) = middle(source).map(|to| (to[1] - from[1]).atan2(to[0] - from[0])) else { continue };
            let rims = rims(from, straight, source);
            for rim in &rims {
                let far = (rim.1[0] - from[0]).hypot(rim.1[1] - from[1]).max(f64::MIN_POSITIVE);
                for passed in occluders.iter().flat_map(|occluder| self::rims(from, straight, occluder)) {
                    let near = (passed.1[0] - from[0]).hypot(passed.1[1] - from[1]);
                    let off = (passed.0 - rim.0).abs();
                    // As near as points so far apart can tell.
                    if near < far && off < 1.5 * step / near && best.is_none_or(|(least, _)| off < least) {
                        best = Some((off, rim.1));
                    }
                }
            }
        }
        if let Some((_, rim)) = best {
            let ([x1, y1], [x2, y2]) = (scale.at(from), scale.at(rim));
            let _ = writeln!(svg, "<path class=\"ray\" d=\"M{x1:.1} {y1:.1}L{x2:.1} {y2:.1}\"/>");
        }
    }
}

fn middle(outline: &[Flat]) -> Option<Flat> {
    let n = outline.len() as f64;
    let sum = outline.iter().fold([0.0; 2], |sum, p| [sum[0] + p[0], sum[1] + p[1]]);
    (n > 0.0).then(|| [sum[0] / n, sum[1] / n])
}

/// The outermost corners as seen from a place, each with its angle from a direction.
fn rims(from: Flat, straight: f64, outline: &[Flat]) -> Vec<(f64, Flat)> {
    let angle = |p: &Flat| {
        let turned = (p[1] - from[1]).atan2(p[0] - from[0]) - straight;
        turned - std::f64::consts::TAU * (turned / std::f64::consts::TAU).round()
    };
    let seen = || outline.iter().map(|p| (angle(p), *p));
    let low = seen().min_by(|a, b| a.0.total_cmp(&b.0));
    low.into_iter().chain(seen().max_by(|a, b| a.0.total_cmp(&b.0))).collect()
}

/// Where light is measured, by what is seen there.
fn points(svg: &mut String, case: &CaseRecord, view: &View, scale: &Scale) {
    let every = case.points.len().div_ceil(400).max(1);
    let radius = if case.points.len() > 150 { 1.7 } else { 2.6 };
    for point in case.points.iter().step_by(every) {
        let [x, y] = scale.at(view.flat(point.position));
        let _ =
            write!(svg, "<circle class=\"at {}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius}\"/>", point.region.name());
    }
    svg.push('\n');
}

/// A scale bar, and which way the axes go.
fn measure(svg: &mut String, scale: &Scale, view: &View) {
    let rough = 0.22 * SIZE[0] / scale.factor;
    let power = 10f64.powf(rough.log10().floor());
    let length = [5.0, 2.0, 1.0].into_iter().map(|m| m * power).find(|l| *l <= rough).unwrap_or(power);
    let (left, floor) = (10.0, SIZE[1] - 9.0);
    let right = left + length * scale.factor;
    let words = if length >= 1000.0 {
        format!("{} km", length / 1000.0)
    } else if length >= 1.0 {
        format!("{length} m")
    } else if length >= 0.01 {
        format!("{} cm", (100.0 * length).round())
    } else {
        format!("{length:e} m")
    };
    let _ = writeln!(
        svg,
        "<path class=\"scale\" d=\"M{left} {0}V{floor}H{right:.1}V{0}\"/><text x=\"{1:.1}\" y=\"{2}\">{words}</text>",
        floor - 5.0,
        right + 6.0,
        floor + 1.0,
    );
    let [x, y] = [SIZE[0] - 46.0, SIZE[1] - 12.0];
    let _ = writeln!(
        svg,
        "<path class=\"scale\" d=\"M{x} {1}V{y}H{2}\"/><text x=\"{3}\" y=\"{4}\">{5}</text>\
         <text x=\"{0}\" y=\"{6}\">{7}</text>",
        x - 3.0,
        y - 22.0,
        x + 22.0,
        x + 26.0,
        y + 4.0,
        view.labels[0],
        y - 27.0,
        view.labels[1]
    );
}

/// What is what in both views.
fn key(case: &CaseRecord) -> String {
    let mut html = String::from("<p class=\"key\">");
    let mut shown = |class: &str, words: &str| {
        let _ = write!(html, "<span><i class=\"{class}\"></i>{words}</span> ");
    };
    for role in Role::ALL {
        let mut shapes: Vec<&str> = Vec::new();
        for figure in case.figures.iter().filter(|figure| figure.role == role) {
            if !shapes.contains(&figure.shape.as_str()) {
                shapes.push(&figure.shape);
            }
        }
        if !shapes.is_empty() {
            shown(role.name(), &format!("{} ({})", role.name(), escaped(&shapes.join(", "))));
        }
    }
    for (region, words) in [
        (Region::Lit, "measured, in the light"),
        (Region::Penumbra, "in the penumbra"),
        (Region::Umbra, "in the umbra"),
        (Region::BelowHorizon, "source below the horizon"),
        (Region::Edge, "at an edge"),
    ] {
        if case.points.iter().any(|point| point.region == region) {
            shown(&format!("at {}", region.name()), words);
        }
    }
    html + "</p>\n"
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_hull_of_a_square_and_its_middle_is_the_square() {
        let outline = hull(vec![[0.0, 0.0], [1.0, 1.0], [0.5, 0.5], [1.0, 0.0], [0.0, 1.0], [0.5, 0.0]]);
        assert_eq!(outline, [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
    }

    #[test]
    fn a_drawing_keeps_shapes_and_stays_on_its_paper() {
        let scale = Scale::of([[-2.0, 0.0], [2.0, 1.0]].into_iter()).unwrap();
        let [left, bottom] = scale.at([-2.0, 0.0]);
        let [right, top] = scale.at([2.0, 1.0]);
        assert!((left - MARGIN).abs() < 1e-9 && (right - (SIZE[0] - MARGIN)).abs() < 1e-9);
        assert!(((right - left) / (bottom - top) - 4.0).abs() < 1e-9, "to scale");
    }
}
