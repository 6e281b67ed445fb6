//! Where rays are sent: towards spheres around mirrors and glass, and elsewhere.
//!
//! What a source emits is parted in domains, of directions or of places in a beam: one for each sphere (spheres that
//! overlap as the source sees them are joined first), and the rest. The share of each domain is known in closed form, and
//! each gets rays of its own that carry it: together they carry what the source emits, to rounding, whatever the aim.

use std::f64::consts::PI;

use super::draws::Draws;
use crate::geometry::{DVec3, Frame};

/// A domain with a larger share of the whole than this leaves so small a rest that it is not worth telling apart.
const ALMOST_ALL: f64 = 0.9;
/// The least share of tries that a rejection may accept.
const WORTH_TRYING: f64 = 1.0 / 32.0;

/// A ball to aim at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Target {
    pub center: DVec3,
    pub radius: f64,
}

impl Target {
    /// The smallest ball that holds both.
    fn joined(&self, other: &Target) -> Target {
        let between = other.center - self.center;
        let distance = between.length();
        if distance + other.radius <= self.radius {
            *self
        } else if distance + self.radius <= other.radius {
            *other
        } else {
            let radius = 0.5 * (distance + self.radius + other.radius);
            Target { center: self.center + between * ((radius - self.radius) / distance), radius }
        }
    }
}

/// Joins targets until no two may overlap, each seen from anywhere in a ball. Empty where the source may be inside one and
/// there are several, or there is none.
pub(super) fn apart(mut targets: Vec<Target>, seen_from: Target) -> Vec<Target> {
    let overlap = |a: &Target, b: &Target| {
        let half_angle = |target: &Target| {
            let distance = (target.center - seen_from.center).length();
            // Seen from the ball's middle, the direction may turn by the second term.
            let nearest = distance - seen_from.radius;
            (nearest > target.radius)
                .then(|| libm::asin(target.radius / nearest) + libm::asin(seen_from.radius / distance))
        };
        let (Some(alpha), Some(beta)) = (half_angle(a), half_angle(b)) else { return true };
        let (to_a, to_b) = (a.center - seen_from.center, b.center - seen_from.center);
        let angle = libm::atan2(to_a.cross(to_b).length(), to_a.dot(to_b));
        angle <= (alpha + beta) * (1.0 + 1e-9)
    };
    join(&mut targets, overlap);
    targets
}

/// Joins targets until no two overlap.
fn join(targets: &mut Vec<Target>, overlap: impl Fn(&Target, &Target) -> bool) {
    'again: loop {
        for second in 1..targets.len() {
            if let Some(first) = (0..second).find(|first| overlap(&targets[*first], &targets[second])) {
                let other = targets.swap_remove(second);
                targets[first] = targets[first].joined(&other);
                continue 'again;
            }
        }
        return;
    }
}

/// A cone of directions around an axis.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cone {
    axis: DVec3,
    frame: Frame,
    /// 1 − cosα, without cancellation.
    depth: f64,
}

impl Cone {
    /// The directions to a target from a point; `None` from inside it.
    pub fn towards(target: &Target, from: DVec3) -> Option<Cone> {
        let offset = target.center - from;
        let sine = target.radius / offset.length();
        (sine < 1.0).then(|| {
            let axis = offset.normalize();
            Cone {
                axis,
                frame: Frame::around(axis),
                depth: sine * sine / (1.0 + ((1.0 - sine) * (1.0 + sine)).sqrt()),
            }
        })
    }
    /// Of all directions: (1 − cosα)/2.
    pub fn share(&self) -> f64 {
        0.5 * self.depth
    }
    #[inline(always)]
    fn holds(&self, direction: DVec3) -> bool {
        // 1 − cos of the angle from the axis, as half the square of a chord.
        0.5 * (direction - self.axis).length_squared() < self.depth
    }
    /// A uniform direction: heights over the base of a spherical cap are uniform (Archimedes).
    #[inline(always)]
    pub fn draw(&self, draws: &mut Draws) -> DVec3 {
        let (x, y) = draws.disk();
        let fall = self.depth * (x * x + y * y);
        let scale = (self.depth * (2.0 - fall)).sqrt();
        self.frame.tangent * (x * scale) + self.frame.bitangent * (y * scale) + self.axis * (1.0 - fall)
    }
}

/// All cones of a point that shines in all directions; empty where a cone is not worth aiming at.
pub(super) fn cones(targets: &[Target], from: DVec3) -> Vec<Cone> {
    let cones: Option<Vec<Cone>> = targets.iter().map(|target| Cone::towards(target, from)).collect();
    cones.filter(|cones| cones.iter().map(Cone::share).sum::<f64>() < ALMOST_ALL).unwrap_or_default()
}

/// A uniform direction outside of all cones.
#[inline(always)]
pub(super) fn outside(cones: &[Cone], draws: &mut Draws) -> DVec3 {
    let all = Cone { axis: DVec3::Z, frame: Frame::around(DVec3::Z), depth: 2.0 };
    loop {
        let direction = all.draw(draws);
        if !cones.iter().any(|cone| cone.holds(direction)) {
            return direction;
        }
    }
}

/// The part of a cone above a horizon, for directions weighed by the cosine: their density is uniform over the unit disk
/// that the hemisphere stands on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lobe {
    cone: Cone,
    /// Form factor: the share of what a surface element emits.
    share: f64,
    region: Region,
}

/// Where on the disk a lobe lies: axes along the cone's lean and across it.
#[derive(Clone, Copy, Debug)]
enum Region {
    /// Wholly above the horizon: an ellipse, with its middle and half axes along and across the lean.
    Ellipse { middle: f64, along: f64, across: f64 },
    /// Within this rectangle, along from the first to one, and across either way.
    Cut { from: f64, across: f64 },
}

impl Lobe {
    /// What a target takes of a surface element's emission; `None` where it takes none, or is not worth aiming at.
    ///
    /// With s = sinα and c the cosine of the axis: F = s² c where c ≥ s; where the horizon cuts the cone, with
    /// q = √(1 − s²), z = √(1 − c²), γ = arccos(−(q/s)(c/z)) and y = √(1 − c²/s²),
    ///
    /// ```text
    /// F = (γ s² c − s q y + arcsin(s y/z))/π
    /// ```
    ///
    /// - `normal`: of the element, unit vector
    /// - source: Howell's catalogue, B-43 and following; the integral of the cosine over a cap of the sphere
    pub fn new(target: &Target, from: DVec3, normal: DVec3) -> Option<Lobe> {
        let offset = target.center - from;
        let distance = offset.length();
        let s = target.radius / distance;
        let c = offset.dot(normal) / distance;
        if s >= 1.0 || c <= -s {
            return None;
        }
        let cone = Cone::towards(target, from)?;
        let (q, z) = (((1.0 - s) * (1.0 + s)).sqrt(), ((1.0 - c) * (1.0 + c)).max(0.0).sqrt());
        if c >= s {
            return Some(Lobe {
                cone,
                share: s * s * c,
                region: Region::Ellipse { middle: q * z, along: s * c, across: s },
            });
        }
        let gamma = libm::acos((-(q / s) * (c / z)).clamp(-1.0, 1.0));
        let y = (1.0 - (c / s) * (c / s)).max(0.0).sqrt();
        let share = (gamma * s * s * c - s * q * y + libm::asin((s * y / z).min(1.0))) / PI;
        // Along the lean, the lowest point of the cone's rim that is above the horizon, and the widest across.
        let (from, across) = if c >= 0.0 { (z * q - c * s, s) } else { (q / z, s * y / z) };
        // Below the horizon by a bit more than a bit: the corners of the rectangle lie outside of the lobe.
        let tried = 2.0 * across * (1.0 - from) / PI;
        (share > WORTH_TRYING * tried).then_some(Lobe { cone, share, region: Region::Cut { from, across } })
    }
    /// Form factor.
    pub fn share(&self) -> f64 {
        self.share
    }
    #[inline(always)]
    pub fn holds(&self, direction: DVec3) -> bool {
        self.cone.holds(direction)
    }
    /// A direction with density cosθ/(π F).
    #[inline(always)]
    pub fn draw(&self, normal: DVec3, draws: &mut Draws) -> DVec3 {
        let lean = self.cone.axis - normal * self.cone.axis.dot(normal);
        // Straight up there is no lean, and the ellipse is round about the middle.
        let along = if lean.length() > 1e-12 { lean.normalize() } else { Frame::around(normal).tangent };
        let across = normal.cross(along);
        let lifted = |a: f64, b: f64| along * a + across * b + normal * (1.0 - (a * a + b * b)).max(0.0).sqrt();
        match self.region {
            Region::Ellipse { middle, along, across } => {
                let (x, y) = draws.disk();
                lifted(middle + along * x, across * y)
            }
            Region::Cut { from, across } => loop {
                let (a, b) = (from + (1.0 - from) * draws.unit(), across * (2.0 * draws.unit() - 1.0));
                if a * a + b * b < 1.0 {
                    let direction = lifted(a, b);
                    if self.cone.holds(direction) {
                        return direction;
                    }
                }
            },
        }
    }
}

/// The lobes of a surface element; empty where they would leave almost nothing.
#[inline(always)]
pub(super) fn lobes(targets: &[Target], from: DVec3, normal: DVec3, out: &mut Vec<Lobe>) {
    out.clear();
    out.extend(targets.iter().filter_map(|target| Lobe::new(target, from, normal)));
    if out.iter().map(Lobe::share).sum::<f64>() > ALMOST_ALL {
        out.clear();
    }
}

/// A direction of a surface element, weighed by the cosine, outside of all lobes.
#[inline(always)]
pub(super) fn cosine_outside(lobes: &[Lobe], normal: DVec3, draws: &mut Draws) -> DVec3 {
    let frame = Frame::around(normal);
    loop {
        let (x, y) = draws.disk();
        let height = (1.0 - (x * x + y * y)).max(0.0).sqrt();
        let direction = frame.tangent * x + frame.bitangent * y + normal * height;
        if !lobes.iter().any(|lobe| lobe.holds(direction)) {
            return direction;
        }
    }
}

/// A round spot of a beam's section, in units of the beam's radius.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spot {
    x: f64,
    y: f64,
    radius: f64,
    /// Of the beam's section.
    share: f64,
}

impl Spot {
    pub fn share(&self) -> f64 {
        self.share
    }
    fn holds(&self, x: f64, y: f64) -> bool {
        let (a, b) = (x - self.x, y - self.y);
        a * a + b * b < self.radius * self.radius
    }
    /// A uniform place of the spot within the beam's section.
    #[inline(always)]
    pub fn draw(&self, draws: &mut Draws) -> (f64, f64) {
        loop {
            let (a, b) = draws.disk();
            let (x, y) = (self.x + self.radius * a, self.y + self.radius * b);
            if x * x + y * y <= 1.0 {
                return (x, y);
            }
        }
    }
}

/// The spots of a beam that targets take, disjoint; empty where they take almost all, or nothing.
///
/// - `center`, `frame`, `radius`: of the beam's section
pub(super) fn spots(targets: &[Target], center: DVec3, frame: &Frame, radius: f64) -> Vec<Spot> {
    let in_section = |target: &Target| {
        let offset = (target.center - center) / radius;
        Target {
            center: DVec3::new(offset.dot(frame.tangent), offset.dot(frame.bitangent), 0.0),
            radius: target.radius / radius,
        }
    };
    let mut disks: Vec<Target> = targets.iter().map(in_section).collect();
    disks.retain(|disk| disk.center.length() < 1.0 + disk.radius);
    join(&mut disks, |a, b| (a.center - b.center).length() < a.radius + b.radius);
    let spot = |disk: &Target| {
        let (distance, r) = (disk.center.length(), disk.radius);
        let share = if distance + r <= 1.0 {
            r * r
        } else if distance + 1.0 <= r {
            1.0
        } else {
            // Two disks that cut each other: two sectors less a kite.
            let a = libm::acos(((distance * distance + r * r - 1.0) / (2.0 * distance * r)).clamp(-1.0, 1.0));
            let b = libm::acos(((distance * distance + 1.0 - r * r) / (2.0 * distance)).clamp(-1.0, 1.0));
            let kite = (1.0 + r - distance) * (distance + r - 1.0) * (distance + 1.0 - r) * (distance + r + 1.0);
            (r * r * a + b - 0.5 * kite.max(0.0).sqrt()) / PI
        };
        Spot { x: disk.center.x, y: disk.center.y, radius: r, share }
    };
    let mut spots: Vec<Spot> = disks.iter().map(spot).collect();
    spots.retain(|spot| spot.share > WORTH_TRYING * spot.radius * spot.radius);
    if spots.iter().map(Spot::share).sum::<f64>() > ALMOST_ALL {
        spots.clear();
    }
    spots
}

/// A uniform place of the unit disk outside of all spots.
#[inline(always)]
pub(super) fn place_outside(spots: &[Spot], draws: &mut Draws) -> (f64, f64) {
    loop {
        let (x, y) = draws.disk();
        if !spots.iter().any(|spot| spot.holds(x, y)) {
            return (x, y);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::StreamKey;
    use crate::statistics::budget::{plausible, seed_of};

    const N: u64 = 200_000;

    fn draws(name: &str) -> Draws {
        Draws::new(StreamKey::root(seed_of(name)))
    }

    /// The share of cosine-weighted directions within a cone is its form factor, cut by the horizon or not; and drawn
    /// directions lie within, and half of them where half of the share is.
    #[test]
    fn a_lobe_takes_its_form_factor() {
        let mut draws = draws("a_lobe_takes_its_form_factor");
        let mut cut = 0;
        for (center, radius) in [
            (DVec3::Z * 2.0, 1.0),
            (DVec3::new(1.0, 0.5, 1.0), 0.5),
            (DVec3::new(2.0, 0.0, 0.3), 1.0),
            (DVec3::new(2.0, 0.0, -0.3), 1.0),
            (DVec3::new(1.0, 1.0, -0.1), 1.3),
            (DVec3::new(0.3, 0.0, 1.0), 1.04),
        ] {
            let target = Target { center, radius };
            let lobe = Lobe::new(&target, DVec3::ZERO, DVec3::Z).expect("worth aiming at");
            cut += u32::from(matches!(lobe.region, Region::Cut { .. }));
            let mut inside = 0;
            // A plane through the axis that halves nothing in particular.
            let side = |d: DVec3| (d - center.normalize()).dot(DVec3::new(0.3, 0.4, 0.2)) > 0.0;
            let mut inside_and_beside = 0;
            for _ in 0..N {
                let d = cosine_outside(&[], DVec3::Z, &mut draws);
                inside += u64::from(lobe.holds(d));
                inside_and_beside += u64::from(lobe.holds(d) && side(d));
            }
            assert!(plausible(inside, N, lobe.share(), lobe.share()), "{target:?}: {inside} {}", lobe.share());
            let mut beside = 0;
            for _ in 0..N {
                let d = lobe.draw(DVec3::Z, &mut draws);
                assert!(d.z >= 0.0 && (d.length() - 1.0).abs() < 1e-14);
                let angle = libm::acos(d.dot(center.normalize()).min(1.0));
                assert!(angle <= libm::asin(radius / center.length()) + 1e-7, "{target:?} {angle}");
                beside += u64::from(side(d));
            }
            // Both counts estimate the same share; their difference is within five deviations and more.
            let (a, b) = (inside_and_beside as f64 / inside as f64, beside as f64 / N as f64);
            let deviation = (a * (1.0 - a) * (1.0 / inside as f64 + 1.0 / N as f64)).sqrt();
            assert!((a - b).abs() < 6.0 * deviation + 1e-12, "{target:?}: {a} {b}");
        }
        assert!(cut >= 3, "{cut}");
        assert!(Lobe::new(&Target { center: -DVec3::Z, radius: 0.9 }, DVec3::ZERO, DVec3::Z).is_none());
    }

    #[test]
    fn a_cone_takes_its_share_of_all_directions() {
        let mut draws = draws("a_cone_takes_its_share_of_all_directions");
        let target = Target { center: DVec3::new(1.0, -2.0, 0.5), radius: 1.7 };
        let cone = Cone::towards(&target, DVec3::ZERO).unwrap();
        let (mut inside, mut inner) = (0, 0);
        let narrower = Cone { depth: 0.25 * cone.depth, ..cone };
        for _ in 0..N {
            inside += u64::from(cone.holds(outside(&[], &mut draws)));
            let d = cone.draw(&mut draws);
            assert!(cone.holds(d) || (d.dot(cone.axis) - 1.0 + cone.depth).abs() < 1e-14);
            inner += u64::from(narrower.holds(d));
        }
        assert!(plausible(inside, N, cone.share(), cone.share()));
        assert!(plausible(inner, N, 0.25, 0.25), "uniform within: {inner}");
        assert!(!cone.holds(outside(&[cone], &mut draws)));
    }

    #[test]
    fn a_spot_takes_its_share_of_the_beam() {
        let mut draws = draws("a_spot_takes_its_share_of_the_beam");
        let frame = Frame::around(DVec3::Z);
        for (x, r) in [(0.0, 0.5), (0.8, 0.5), (1.3, 0.6), (0.9, 1.2)] {
            let target = Target { center: DVec3::new(2.0 * x, 0.0, -7.0), radius: 2.0 * r };
            let spots = spots(&[target], DVec3::ZERO, &frame, 2.0);
            let [spot] = spots[..] else { panic!("one spot") };
            let inside = (0..N).filter(|_| {
                let (a, b) = draws.disk();
                spot.holds(a, b)
            });
            assert!(plausible(inside.count() as u64, N, spot.share(), spot.share()), "{x} {r}");
            for _ in 0..1000 {
                let (a, b) = spot.draw(&mut draws);
                assert!(a * a + b * b <= 1.0 && (a * a + b * b - 1.0 < 1e-12) && spot.holds(a, b));
            }
        }
        let twins = [1.0, 1.1].map(|x| Target { center: DVec3::new(x, 0.0, 0.0), radius: 0.1 });
        assert_eq!(spots(&twins, DVec3::ZERO, &frame, 2.0).len(), 1, "joined");
        let far = Target { center: DVec3::new(9.0, 0.0, 0.0), radius: 0.1 };
        assert!(spots(&[far], DVec3::ZERO, &frame, 2.0).is_empty());
        let all = Target { center: DVec3::ZERO, radius: 2.0 };
        assert!(spots(&[all], DVec3::ZERO, &frame, 2.0).is_empty());
    }

    #[test]
    fn targets_that_overlap_are_joined() {
        let ball = |x: f64, z: f64| Target { center: DVec3::new(x, 0.0, z), radius: 0.5 };
        let eye = Target { center: DVec3::ZERO, radius: 0.1 };
        assert_eq!(apart(vec![ball(-2.0, 3.0), ball(2.0, 3.0)], eye).len(), 2);
        let joined = apart(vec![ball(-0.4, 3.0), ball(0.4, 5.0)], eye);
        assert_eq!(joined.len(), 1);
        for one in [ball(-0.4, 3.0), ball(0.4, 5.0)] {
            assert!((one.center - joined[0].center).length() + one.radius <= joined[0].radius * (1.0 + 1e-15));
        }
        let close = Target { center: DVec3::new(2.0, 0.0, 3.0), radius: 2.0 };
        assert_eq!(apart(vec![ball(-2.0, 3.0), ball(2.0, 3.0)], close).len(), 1, "one may be around the source");
    }
}
