//! The words of the tables' `geometry` column, read back into shapes: what is printed is what is computed.
//!
//! Things are separated by `; `. A thing is its role (`source`, `occluder`, `point`, `from`, `to`), but for a point its kind
//! (`disk`, `rectangle`, `sphere`), and fields, each a name and its numbers: `occluder disk center 0 0 1 normal 0 0 1 radius 0.25`.

use etendue::configuration::{Arrangement, Configuration, MeasurementPoint, Source};
use etendue::geometry::{DVec3, Disk, Rectangle, Shape, Sphere};
use etendue::oracle::patch::Patch;
use etendue::radiometry::Exitance;

pub struct Thing<'a> {
    pub role: &'a str,
    words: Vec<&'a str>,
}

impl<'a> Thing<'a> {
    fn field(&self, name: &str) -> &[&'a str] {
        let at = self.words.iter().position(|word| *word == name);
        &self.words[at.unwrap_or_else(|| panic!("{} {:?} has no {name}", self.role, self.words)) + 1..]
    }
    pub fn number(&self, name: &str) -> f64 {
        self.field(name)[0].parse().unwrap_or_else(|error| panic!("{name} of {:?}: {error}", self.words))
    }
    pub fn vector(&self, name: &str) -> DVec3 {
        let number = |k: usize| self.field(name)[k].parse::<f64>().expect("three numbers");
        DVec3::new(number(0), number(1), number(2))
    }
    fn disk(&self) -> Disk {
        Disk::new(self.vector("center"), self.vector("normal"), self.number("radius")).expect("a disk")
    }
    fn rectangle(&self) -> Rectangle {
        Rectangle::new(self.vector("center"), self.vector("edge_u"), self.vector("edge_v")).expect("a rectangle")
    }
    pub fn shape(&self) -> Shape {
        match self.words[0] {
            "disk" => Shape::Disk(self.disk()),
            "rectangle" => Shape::Rectangle(self.rectangle()),
            "sphere" => Shape::Sphere(Sphere::new(self.vector("center"), self.number("radius")).expect("a sphere")),
            other => panic!("`{other}` is no shape"),
        }
    }
    pub fn patch(&self) -> Patch {
        match self.words[0] {
            "disk" => Patch::Disk(self.disk()),
            "rectangle" => Patch::Rectangle(self.rectangle()),
            other => panic!("`{other}` is no patch"),
        }
    }
    pub fn point(&self) -> MeasurementPoint {
        MeasurementPoint::new(self.vector("position"), self.vector("normal")).expect("a point")
    }
}

/// The things of a sentence, in order.
pub fn things(sentence: &str) -> Vec<Thing<'_>> {
    let thing = |part| {
        let words: Vec<&str> = str::split_whitespace(part).collect();
        Thing { role: words[0], words: words[1..].to_vec() }
    };
    sentence.split(';').map(thing).collect()
}

/// The one thing of that role.
pub fn the<'a, 'b>(things: &'b [Thing<'a>], role: &str) -> &'b Thing<'a> {
    let mut of_role = things.iter().filter(|thing| thing.role == role);
    let found = of_role.next().unwrap_or_else(|| panic!("there is a `{role}`"));
    assert!(of_role.next().is_none(), "there is one `{role}`");
    found
}

pub fn occluders(things: &[Thing]) -> Vec<Shape> {
    things.iter().filter(|thing| thing.role == "occluder").map(Thing::shape).collect()
}

/// The room in which a source of exitance 1 is seen from a point.
pub fn room(source: Shape, occluders: Vec<Shape>, point: MeasurementPoint) -> Configuration {
    let source = Source::new(source, Exitance::new(1.0)).expect("a source");
    Configuration::new(vec![source], occluders, None, vec![point], Arrangement::Scattered)
        .unwrap_or_else(|mistakes| panic!("{mistakes:?}"))
}

/// Every number is one that `f64` holds to the last digit, so that nothing is lost in reading it.
pub fn assert_exact_numbers(sentence: &str) {
    for word in sentence.split([' ', ';']) {
        if let Ok(number) = word.parse::<f64>() {
            let scaled = number * 65_536.0;
            assert!(scaled == scaled.trunc() && number.abs() < 1e6, "{word} is no short dyadic number: {sentence}");
        }
    }
}
