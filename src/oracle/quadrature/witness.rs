//! What the second witness is asked: the whole irradiance at a point, of uniform sources or of textured ones.

use glam::DVec3;

use super::super::body::Body;
use super::super::exact::Oracle;
use super::super::textured::PRECISE;
use super::super::truth::{Method, Region, Sight, Truth};
use super::{Strips, WeightedStrips, visible, visible_weighted};
use crate::configuration::MeasurementPoint;
use crate::radiometry::{FormFactor, Irradiance};

impl Oracle {
    /// The irradiance at a point by deterministic adaptive quadrature: a second way to [`Oracle::at`], which shares no
    /// formula with it but the shapes.
    ///
    /// The source is cut into strips; along a strip the integral is closed, across them it is adaptive.
    ///
    /// - error: at most `bound`, in general below 1e-11 of the unoccluded value, and relative to the visible value where
    ///   little is seen; `bound` is stated, not hoped for: where the rule does not converge it is large
    /// - cost: some 0.3 ms with one occluder, 3 ms with sixteen; use [`Oracle::at`] where a closed form exists
    /// - a point within rounding of a source's plane sees nothing of it
    ///
    /// ```
    /// use etendue::configuration::{Arrangement, Configuration, MeasurementPoint, Source};
    /// use etendue::geometry::{DVec3, Disk, Shape, Sphere};
    /// use etendue::radiometry::Exitance;
    /// use etendue::Oracle;
    ///
    /// let sun = Source::new(Disk::new(DVec3::Z * 2.0, -DVec3::Z, 0.5).map(Shape::Disk)?, Exitance::new(1.0))?;
    /// let moon = Shape::Sphere(Sphere::new(DVec3::new(0.1, 0.0, 1.0), 0.2)?);
    /// let point = MeasurementPoint::new(DVec3::ZERO, DVec3::Z)?;
    /// let room = Configuration::new(vec![sun], vec![moon], None, vec![point], Arrangement::Scattered).unwrap();
    /// let oracle = Oracle::new(&room);
    /// let (first, second) = (oracle.at(&point), oracle.by_quadrature(&point));
    /// let apart = first.irradiance.watts_per_square_metre() - second.irradiance.watts_per_square_metre();
    /// assert!(apart.abs() <= 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn by_quadrature(&self, point: &MeasurementPoint) -> Truth {
        self.witnessed(point, |i, n, body, others, eye| {
            if let Some(texture) = &self.sources[i].texture {
                return self.by_strips_between_seams(texture, n, body, others, eye, PRECISE);
            }
            let strips = visible(n, body, others, eye);
            let exitance = self.sources[i].exitance;
            WeightedStrips {
                factor: strips,
                value: exitance * strips.value,
                unoccluded: exitance * strips.unoccluded,
                error: exitance * strips.error,
            }
        })
    }

    /// The irradiance at a point of sources whose exitance varies over them: textures, polynomials, anything.
    ///
    /// - `exitance`: W/m² at a position (metres) on a source, named by its index in the configuration, whose own
    ///   uniform exitances are not used; the position is on the source to rounding
    /// - `form_factor` and `region` of the answer are those of the sources' shapes, whatever they emit
    /// - error: at most `bound`, below 1e-11 of ∫ |exitance| over what is above the horizon where the exitance is smooth
    ///   or jumps along few lines; many jumps exhaust the work that is allowed (seconds), and `bound` says how far it
    ///   came: to 1e-5 for a checkerboard of 36 fields
    /// - cost: some 10 ms with one occluder
    /// - features narrower than a hundredth of a source may go unseen; an exitance that is not a finite number counts
    ///   as none and makes the bound infinite
    ///
    /// ```
    /// use etendue::configuration::{Arrangement, Configuration, MeasurementPoint, Source};
    /// use etendue::geometry::{DVec3, Rectangle, Shape};
    /// use etendue::radiometry::Exitance;
    /// use etendue::Oracle;
    ///
    /// let panel = Rectangle::new(DVec3::Z, DVec3::Y, DVec3::X)?; // faces down
    /// let source = Source::new(Shape::Rectangle(panel), Exitance::new(1.0))?;
    /// let point = MeasurementPoint::new(DVec3::ZERO, DVec3::Z)?;
    /// let room = Configuration::new(vec![source], vec![], None, vec![point], Arrangement::Scattered).unwrap();
    /// let oracle = Oracle::new(&room);
    /// // Brighter towards +x: seen from below the middle, what is gained there is lost on the other side.
    /// let slanted = oracle.by_quadrature_with(&point, &|_source, position| 1.0 + position.x);
    /// let even = oracle.at(&point);
    /// let apart = slanted.irradiance.watts_per_square_metre() - even.irradiance.watts_per_square_metre();
    /// assert!(apart.abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn by_quadrature_with(&self, point: &MeasurementPoint, exitance: &dyn Fn(usize, DVec3) -> f64) -> Truth {
        self.witnessed(point, |i, n, body, others, eye| {
            let emission = |place: DVec3| exitance(i, (body.center + place) / self.scale);
            visible_weighted(n, body, others, eye, &emission)
        })
    }

    fn witnessed(
        &self,
        point: &MeasurementPoint,
        mut of_source: impl FnMut(usize, DVec3, &Body, &[&Body], DVec3) -> WeightedStrips,
    ) -> Truth {
        let (eye, n) = (point.position() * self.scale, point.normal());
        let mut sum = WeightedStrips::default();
        let (mut sights, mut shadow_edge) = (Vec::new(), false);
        for (i, source) in self.sources.iter().enumerate() {
            let others = self.sources.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, s)| &s.body);
            let others: Vec<&Body> = self.occluders.iter().chain(others).collect();
            let found = of_source(i, n, &source.body, &others, eye);
            sum.value += found.value;
            sum.unoccluded += found.unoccluded;
            sum.error += found.error;
            sum.factor.value += found.factor.value;
            sights.push(sight(&found.factor));
            shadow_edge |= found.factor.seen && found.factor.hidden;
        }
        Truth {
            irradiance: Irradiance::new(sum.value),
            unoccluded_irradiance: Irradiance::new(sum.unoccluded),
            form_factor: FormFactor::new(sum.factor.value),
            bound: Irradiance::new(sum.error),
            region: Region::of(sights.into_iter()),
            method: Method::Quadrature,
            shadow_edge,
        }
    }
}

fn sight(strips: &Strips) -> Sight {
    // What is seen, or hidden, may be no more than rounding.
    let little_seen = strips.value <= strips.error;
    let little_hidden = strips.unoccluded - strips.value <= strips.error;
    match (strips.seen, strips.hidden) {
        (false, false) => Sight::Below,
        (false, true) => Sight::Hidden,
        (true, false) if !strips.cut => Sight::Whole,
        (true, true) if little_seen || (little_hidden && !strips.cut) => Sight::Unclear,
        _ => Sight::Part,
    }
}
