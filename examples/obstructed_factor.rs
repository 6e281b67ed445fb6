//! How much of a lamp does a place on the floor see past an obstacle, how sure is that, and what would change it?
//!
//! `cargo run --example obstructed_factor`

use std::error::Error;

use etendue::configuration::{Arrangement, MeasurementPoint, Source};
use etendue::geometry::{DVec3, Disk, Rectangle, Shape};
use etendue::oracle::Parameter;
use etendue::radiometry::Exitance;
use etendue::{Configuration, Oracle};

fn main() -> Result<(), Box<dyn Error>> {
    // A round lamp of radius 0.5 m that faces down from 2 m, a square board of 0.75 m half way, a place on the floor.
    let lamp = Disk::new(DVec3::Z * 2.0, DVec3::NEG_Z, 0.5)?;
    let board = Rectangle::new(DVec3::Z, DVec3::X * 0.75, DVec3::Y * 0.75)?;
    let place = MeasurementPoint::new(DVec3::new(0.5, 0.125, 0.0), DVec3::Z)?;

    // With an exitance of 1 W/m² the irradiance in W/m² is the form factor, and so is its bound.
    let source = Source::new(Shape::Disk(lamp), Exitance::new(1.0))?;
    let occluders = vec![Shape::Rectangle(board)];
    let room = Configuration::new(vec![source], occluders, None, vec![place], Arrangement::Scattered)
        .map_err(|mistakes| mistakes.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))?;
    let oracle = Oracle::new(&room);

    let truth = oracle.at(&place);
    println!("seen past the board  {:.15}", truth.form_factor.ratio());
    println!("without the board    {:.15}", truth.unoccluded_irradiance.watts_per_square_metre());
    println!("off by no more than  {:.1e}", truth.bound.watts_per_square_metre());
    println!("region               {} ({})", truth.region, truth.method.name());

    // The same once more by strips, which share no formula with the above.
    let witness = oracle.by_quadrature(&place);
    println!(
        "second witness       {:.15} ± {:.1e}",
        witness.form_factor.ratio(),
        witness.bound.watts_per_square_metre()
    );

    // What a small change of the room does, the motion of the shadow's edge included.
    let names =
        ["source.0.radius", "occluder.0.center.x", "occluder.0.edge_u.x", "point.position.x", "point.normal.x"];
    let asked: Vec<Parameter> = names.iter().map(|name| name.parse()).collect::<Result<_, _>>()?;
    let found = oracle.derivatives(&place, &oracle.parameters(&room, &asked)?);
    println!("derivatives hold to  {} sides", found.side.name());
    for (parameter, slope) in asked.iter().zip(found.values.ok_or("no closed form here, so no derivative")?) {
        println!("d/d {parameter:<20} {slope:+.12} {}", parameter.unit_of_derivative());
    }
    Ok(())
}
