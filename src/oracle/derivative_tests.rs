//! Derivatives against differences of wide values, and against integrals along the shadow's edge.

use std::f64::consts::TAU;

use glam::DVec3;
use rand_xoshiro::SplitMix64;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

use super::exact::{self, BodyAt, Oracle};
use super::form::Form;
use super::{Parameter, Side};
use crate::configuration::{Arrangement, Configuration, MeasurementPoint, Source};
use crate::geometry::{Disk, Frame, Polygon, Rectangle, Shape, Sphere};
use crate::number::{Number, Vector, Wide};
use crate::radiometry::Exitance;

/// A deterministic stream of numbers in [0, 1).
struct Numbers(SplitMix64);

impl Numbers {
    fn seeded(seed: u64) -> Numbers {
        Numbers(SplitMix64::seed_from_u64(seed))
    }
    fn next(&mut self) -> f64 {
        // Few digits: what is added to them below stays exact.
        (self.0.next_u64() >> 40) as f64 / (1u32 << 24) as f64
    }
    fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }
    fn vector(&mut self, reach: f64) -> DVec3 {
        DVec3::new(self.within(-reach, reach), self.within(-reach, reach), self.within(-reach, reach))
    }
}

/// A step that adds to the numbers above without rounding.
const STEP: f64 = 1.0 / (1u32 << 20) as f64;

/// The numbers of a shape.
#[derive(Clone, Debug)]
enum Numbered {
    Disk([DVec3; 2], f64),
    Rectangle([DVec3; 3]),
    Polygon(Vec<DVec3>),
    Sphere(DVec3, f64),
}

impl Numbered {
    fn random(numbers: &mut Numbers, center: DVec3) -> Numbered {
        let axis = numbers.vector(1.0) + DVec3::new(0.01, 0.02, 0.03);
        let frame = Frame::around(axis.normalize());
        let (a, b) = (numbers.within(0.1, 0.9), numbers.within(0.1, 0.9));
        match (numbers.next() * 4.0) as u32 {
            0 => Numbered::Disk([center, axis], a),
            1 => Numbered::Rectangle([center, frame.tangent * (2.0 * a), frame.bitangent * (2.0 * b)]),
            2 => Numbered::Sphere(center, 0.7 * a),
            _ => {
                let (u, v) = (frame.tangent, frame.bitangent);
                let corners = [u * a, v * b - u * a, -u * (0.3 * a), -v * b - u * a];
                Numbered::Polygon(corners.iter().map(|c| center + *c).collect())
            }
        }
    }

    fn shape(&self) -> Option<Shape> {
        Some(match self {
            Numbered::Disk([center, normal], radius) => Shape::Disk(Disk::new(*center, *normal, *radius).ok()?),
            Numbered::Rectangle([center, u, v]) => Shape::Rectangle(Rectangle::new(*center, *u, *v).ok()?),
            Numbered::Polygon(vertices) => Shape::Polygon(Polygon::new(vertices.clone()).ok()?),
            Numbered::Sphere(center, radius) => Shape::Sphere(Sphere::new(*center, *radius).ok()?),
        })
    }

    /// Fields whose neighbours are valid shapes too. (An edge that grows along itself keeps the right angle.)
    fn fields(&self) -> Vec<&'static str> {
        match self {
            Numbered::Disk(..) => {
                vec!["center.x", "center.y", "center.z", "normal.x", "normal.y", "normal.z", "radius"]
            }
            Numbered::Rectangle(_) => vec!["center.x", "center.y", "center.z"],
            Numbered::Polygon(_) => vec!["position.x", "position.y", "position.z"],
            Numbered::Sphere(..) => vec!["center.x", "center.y", "center.z", "radius"],
        }
    }

    fn moved(&self, field: &str, by: f64) -> Numbered {
        let mut next = self.clone();
        let axis = "xyz".find(field.chars().last().expect("a field has a name"));
        let step = axis.map_or(DVec3::ZERO, |axis| DVec3::AXES[axis] * by);
        match &mut next {
            Numbered::Disk(vectors, _) if field.starts_with("normal") => {
                // Along the tangent of a unit normal.
                let unit = vectors[1].normalize();
                vectors[1] = unit + step;
            }
            Numbered::Disk(_, radius) | Numbered::Sphere(_, radius) if field == "radius" => *radius += by,
            Numbered::Disk([center, _], _) | Numbered::Rectangle([center, ..]) | Numbered::Sphere(center, _) => {
                *center += step;
            }
            Numbered::Polygon(vertices) => vertices.iter_mut().for_each(|v| *v += step),
        }
        next
    }
}

fn configuration(source: &Numbered, occluders: &[Numbered], point: MeasurementPoint) -> Option<Configuration> {
    let source = Source::new(source.shape()?, Exitance::new(1.0)).ok()?;
    let occluders: Option<Vec<Shape>> = occluders.iter().map(Numbered::shape).collect();
    Configuration::new(vec![source], occluders?, None, vec![point], Arrangement::Scattered).ok()
}

/// The visible form factor over wide numbers, with the shadow's topology.
fn wide(configuration: &Configuration) -> Option<(Wide, u64)> {
    let point = configuration.points()[0];
    let oracle = Oracle::new(configuration);
    let mut seen = oracle.seen(&point);
    let topology = exact::topology(&seen);
    let seen = seen.pop()?;
    let eye = Vector::constant(point.position()) * Wide::constant(oracle.scale);
    let n = Vector::constant(point.normal_as_given()).normalize();
    let factor =
        oracle.factor(BodyAt::Source(0), seen.shadow.as_ref(), n, |at| Form::refined(oracle.body(at), eye))?;
    Some((factor.value, topology))
}

/// Random rooms; returns (those compared, worst error relative to the largest derivative of the room).
fn sweep(seed: u64, rooms: usize) -> (usize, f64) {
    let mut numbers = Numbers::seeded(seed);
    let (mut compared, mut worst) = (0, 0.0_f64);
    for _ in 0..rooms {
        let center = numbers.vector(0.6) + DVec3::Z * 3.0;
        let source = Numbered::random(&mut numbers, center);
        let occluders: Vec<Numbered> = (0..(numbers.next() * 4.0) as u32)
            .map(|_| {
                let center = numbers.vector(0.8) + DVec3::Z * 1.5;
                Numbered::random(&mut numbers, center)
            })
            .collect();
        let normal = numbers.vector(1.0) + DVec3::Z * 0.7;
        let Ok(point) = MeasurementPoint::new(DVec3::ZERO, normal.normalize()) else { continue };
        let Some(room) = configuration(&source, &occluders, point) else { continue };
        let mut names: Vec<(Option<usize>, &str)> = source.fields().into_iter().map(|f| (None, f)).collect();
        for (i, occluder) in occluders.iter().enumerate() {
            names.extend(occluder.fields().into_iter().map(|f| (Some(i), f)));
        }
        let paths: Vec<Parameter> = names
            .iter()
            .map(|(owner, field)| match owner {
                None => format!("source.0.{field}"),
                Some(i) => format!("occluder.{i}.{field}"),
            })
            .map(|path| path.parse().expect("a path"))
            .collect();
        let oracle = Oracle::new(&room);
        let parameters = oracle.parameters(&room, &paths).expect("the shapes have these fields");
        let found = oracle.derivatives(&point, &parameters);
        let Some(values) = found.values else { continue };
        if found.side == Side::One || found.truth.form_factor.ratio() == 0.0 {
            continue;
        }
        let largest = values.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        let here = exact::topology(&oracle.seen(&point));
        for ((owner, field), value) in names.iter().zip(&values) {
            let at = |by: f64| {
                let (mut source, mut occluders) = (source.clone(), occluders.clone());
                let subject = owner.map_or(&mut source, |i| &mut occluders[i]);
                *subject = subject.moved(field, by);
                configuration(&source, &occluders, point).and_then(|room| wide(&room)).filter(|(_, t)| *t == here)
            };
            let (Some(a), Some(b), Some(c), Some(d)) = (at(-2.0 * STEP), at(-STEP), at(STEP), at(2.0 * STEP)) else {
                continue;
            };
            let slope = |low: (Wide, u64), high: (Wide, u64), h: f64| (high.0 - low.0).primal() / (2.0 * h);
            let (fine, coarse) = (slope(b, c, STEP), slope(a, d, 2.0 * STEP));
            // Extrapolation squares the relative error of the differences. Where a source has barely risen, the step is
            // no small one, and they tell nothing.
            if ((fine - coarse) / largest).powi(2) > 1e-11 {
                continue;
            }
            let expected = (4.0 * fine - coarse) / 3.0;
            compared += 1;
            let error = (value - expected).abs() / largest;
            if error > 1e-9 {
                println!(
                    "{field} of {owner:?}: {value:e} against {expected:e} ({error:.1e})\n  {source:?}\n  {occluders:?} {point:?}"
                );
            }
            worst = worst.max(error);
        }
    }
    (compared, worst)
}

#[test]
fn slopes_are_differences_of_wide_values() {
    let (compared, worst) = sweep(1, 120);
    assert!(compared > 300, "only {compared} derivatives could be compared");
    assert!(worst < 1e-9, "{worst:e}");
}

#[test]
#[ignore = "the full sweep takes a minute or two"]
fn slopes_are_differences_of_wide_values_in_ten_thousand_rooms() {
    let (compared, worst) = sweep(2, 10_000);
    println!("{compared} derivatives compared, worst relative error {worst:e}");
    assert!(worst < 1e-9, "{worst:e}");
}

/// dF/da = −(1/π) ∮ (n·d) dω, where dω is the solid angle that the rim sweeps as the radius grows.
#[test]
fn a_growing_occluder_takes_what_its_rim_sweeps() {
    let source = Numbered::Disk([DVec3::Z * 2.0, DVec3::NEG_Z], 1.0);
    let (center, axis, radius) = (DVec3::new(0.05, -0.02, 1.0), DVec3::new(0.2, 0.1, 1.0).normalize(), 0.2);
    let normal = DVec3::new(0.3, -0.2, 1.0).normalize();
    let point = MeasurementPoint::new(DVec3::ZERO, normal).unwrap();
    let room = configuration(&source, &[Numbered::Disk([center, axis], radius)], point).unwrap();
    let oracle = Oracle::new(&room);
    let parameters = oracle.parameters(&room, &["occluder.0.radius".parse().unwrap()]).unwrap();
    let found = oracle.derivatives(&point, &parameters);
    let frame = Frame::around(axis);
    let steps = 400;
    let swept: f64 = (0..steps)
        .map(|i| {
            let (sin, cos) = (TAU * f64::from(i) / f64::from(steps)).sin_cos();
            let out = frame.tangent * cos + frame.bitangent * sin;
            let r = center + out * radius;
            let forward = (frame.bitangent * cos - frame.tangent * sin) * radius;
            normal.dot(r) * r.dot(out.cross(forward)).abs() / r.length().powi(4)
        })
        .sum::<f64>()
        * TAU
        / f64::from(steps);
    approx::assert_relative_eq!(found.values.unwrap()[0], -swept / std::f64::consts::PI, max_relative = 1e-13);
    assert_eq!(found.side, Side::Both);
}

/// The shadow just fills the source: a smaller occluder would let light in, a greater one would not.
#[test]
fn at_a_contact_the_derivative_is_one_sided_and_says_so() {
    let source = Numbered::Disk([DVec3::Z * 2.0, DVec3::NEG_Z], 1.0);
    let point = MeasurementPoint::new(DVec3::ZERO, DVec3::Z).unwrap();
    let room = configuration(&source, &[Numbered::Disk([DVec3::Z, DVec3::Z], 0.5)], point).unwrap();
    let oracle = Oracle::new(&room);
    let parameters = oracle.parameters(&room, &["occluder.0.radius".parse().unwrap()]).unwrap();
    let found = oracle.derivatives(&point, &parameters);
    assert_eq!((found.values, found.side), (Some(vec![0.0]), Side::One));
}

#[test]
fn a_wrong_parameter_is_told_what_there_is() {
    let source = Numbered::Disk([DVec3::Z * 2.0, DVec3::NEG_Z], 1.0);
    let point = MeasurementPoint::new(DVec3::ZERO, DVec3::Z).unwrap();
    let room = configuration(&source, &[], point).unwrap();
    let said = |path: &str| match path.parse::<Parameter>() {
        Err(error) => error.to_string(),
        Ok(parameter) => Oracle::new(&room).parameters(&room, &[parameter]).unwrap_err().to_string(),
    };
    assert_eq!(
        said("source.0.edge_u.x"),
        "`source.0.edge_u.x`: a disk has center.x, .y, .z, normal.x, .y, .z and radius"
    );
    assert_eq!(said("occluder.0.radius"), "`occluder.0.radius`: there are 0 occluders, counted from 0");
    assert!(said("source.0.centre.x").contains("accepted are source.N.FIELD"));
    assert!(said("occluder.0.exitance").contains("names no number"));
}

/// A bipyramid, its silhouette crossed by itself from some sides and cut by the source's plane from others.
#[test]
fn a_mesh_moves_as_a_whole() {
    let mut numbers = Numbers::seeded(41);
    let mut compared = 0;
    for _ in 0..40 {
        let middle = DVec3::Z * 1.5 + numbers.vector(0.4);
        let mut corners = vec![middle + DVec3::Z * 0.375, middle - DVec3::Z * 0.125];
        corners.extend((0..5).map(|k| {
            let (sin, cos) = (TAU * f64::from(k) / 5.0).sin_cos();
            middle + DVec3::new(cos, sin, 0.0) * 0.25 + numbers.vector(0.05)
        }));
        let faces: Vec<_> = (0..5).flat_map(|k| [0, 1].map(|top| [top, 2 + k, 2 + (k + 1) % 5])).collect();
        let oracle_at = |shift: DVec3| {
            let mesh =
                crate::geometry::Mesh::new(corners.iter().map(|c| *c + shift).collect(), faces.clone()).unwrap();
            let disk = Disk::new(DVec3::Z * 3.0, -DVec3::Z, 0.6).unwrap();
            let source = Source::new(Shape::Disk(disk), Exitance::new(1.0)).unwrap();
            let point = MeasurementPoint::new(DVec3::ZERO, DVec3::new(0.1, 0.2, 1.0)).unwrap();
            let configuration =
                Configuration::new(vec![source], vec![Shape::Mesh(mesh)], None, vec![point], Arrangement::Scattered)
                    .unwrap();
            (Oracle::new(&configuration), configuration, point)
        };
        let (oracle, configuration, point) = oracle_at(DVec3::ZERO);
        let names = ["x", "y", "z"].map(|axis| format!("occluder.0.position.{axis}").parse::<Parameter>().unwrap());
        let parameters = oracle.parameters(&configuration, &names).unwrap();
        let values = oracle.derivatives(&point, &parameters).values.unwrap();
        for (axis, value) in DVec3::AXES.iter().zip(values) {
            let step = 2f64.powi(-17);
            let [above, below] = [1.0, -1.0].map(|side| {
                let (oracle, _, point) = oracle_at(*axis * (side * step));
                (oracle.at(&point).irradiance.watts_per_square_metre(), exact::topology(&oracle.seen(&point)))
            });
            if above.1 != below.1 {
                continue;
            }
            let difference = (above.0 - below.0) / (2.0 * step);
            assert!((value - difference).abs() < 1e-9, "{value} against {difference}");
            compared += usize::from(value != 0.0);
        }
    }
    assert!(compared > 60, "{compared}");
}
