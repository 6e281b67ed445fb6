//! Does my ray tracer agree, in a room that I build in code?
//!
//! `cargo run --example own_ray_tracer`

use std::f64::consts::PI;

use etendue::case::Study;
use etendue::configuration::{Arrangement, MeasurementPoint, Source};
use etendue::geometry::{DVec3, Rectangle, Shape, Sphere};
use etendue::radiometry::Exitance;
use etendue::{Case, Configuration, Draws, judge};

/// Stands for a renderer: it knows its scene, and gives the radiance that comes along a ray.
struct Tracer {
    ball: (DVec3, f64),
    /// The lamp: a corner, two edges; it faces down.
    lamp: [DVec3; 3],
}

impl Tracer {
    /// W/(m² sr): of the lamp where the ray meets it and the ball is not before it, else none.
    fn radiance(&self, from: DVec3, direction: DVec3) -> f64 {
        let [corner, u, v] = self.lamp;
        let t = (corner.z - from.z) / direction.z;
        let on = from + direction * t - corner;
        let inside = |edge: DVec3| (0.0..=1.0).contains(&(on.dot(edge) / edge.length_squared()));
        let (center, radius) = self.ball;
        let nearest = (center - from).dot(direction).clamp(0.0, t.max(0.0));
        let blocked = (from + direction * nearest).distance(center) < radius;
        if t > 0.0 && direction.z > 0.0 && inside(u) && inside(v) && !blocked { 1.0 / PI } else { 0.0 }
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // The room once for etendue, checked as a case file is ...
    let lamp = Rectangle::new(DVec3::Z, DVec3::Y * 1.5, DVec3::X * 1.5)?;
    let ball = Sphere::new(DVec3::new(0.2, 0.1, 0.5), 0.2)?;
    let source = Source::new(Shape::Rectangle(lamp), Exitance::new(1.0))?;
    let points = [-0.4, 0.0, 0.3, 0.9].map(|x| MeasurementPoint::new(DVec3::new(x, 0.0, 0.0), DVec3::Z));
    let points = points.into_iter().collect::<Result<Vec<_>, _>>()?;
    let room = Configuration::new(vec![source], vec![Shape::Sphere(ball)], None, points, Arrangement::Scattered)
        .map_err(|mistakes| format!("{mistakes:?}"))?;
    let case = Case::new("lamp-and-ball", "A lamp, a ball, a floor", room, Study::default());

    // ... and once for the tracer, which is asked for irradiance: cosine-weighted directions, E = π × mean radiance.
    let tracer = Tracer {
        ball: (DVec3::new(0.2, 0.1, 0.5), 0.2),
        lamp: [DVec3::new(-0.75, -0.75, 1.0), DVec3::X * 1.5, DVec3::Y * 1.5],
    };
    let closure = |_: &Configuration, point: &MeasurementPoint, samples: u64, draws: &mut Draws| {
        let mut sum = 0.0;
        for _ in 0..samples {
            let (r, turn) = (draws.unit().sqrt(), 2.0 * PI * draws.unit());
            let direction = DVec3::new(r * turn.cos(), r * turn.sin(), (1.0 - r * r).sqrt());
            sum += tracer.radiance(point.position(), direction);
        }
        PI * sum / samples as f64
    };
    let judgement = judge(&case).quick().samples(&[16]).estimator("my tracer", &closure);
    println!("{judgement}");
    judgement.assert_passes();
    Ok(())
}

#[test]
fn my_ray_tracer_agrees() {
    main().unwrap();
}
