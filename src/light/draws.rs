//! Random numbers of one batch, and single points of surfaces.

use crate::geometry::DVec3;
use crate::sampling::{LANES, Lanes, Squares, StreamKey, Surface, SurfaceBlock};

/// The numbers of one key, lane after lane.
pub(crate) struct Draws {
    lanes: Lanes,
    drawn: [f64; LANES],
    next: usize,
    squares: Box<Squares>,
    places: Box<SurfaceBlock>,
}

impl Draws {
    pub fn new(key: StreamKey) -> Draws {
        Draws {
            lanes: Lanes::new(key, LANES),
            drawn: [0.0; LANES],
            next: LANES,
            squares: Box::default(),
            places: Box::default(),
        }
    }

    /// Uniform on the multiples of 2⁻⁵² in [0, 1).
    #[inline(always)]
    pub fn unit(&mut self) -> f64 {
        if self.next == LANES {
            self.drawn = self.lanes.next_units();
            self.next = 0;
        }
        self.next += 1;
        self.drawn[self.next - 1]
    }

    /// A uniform point of the unit disk.
    #[inline(always)]
    pub fn disk(&mut self) -> (f64, f64) {
        let (u, v) = (self.unit(), self.unit());
        crate::sampling::concentric(u, v)
    }

    /// A uniform point of a surface, as an offset from its origin, metres.
    #[inline(always)]
    pub fn on(&mut self, surface: &Surface) -> DVec3 {
        (self.squares.u[0][0], self.squares.v[0][0]) = (self.unit(), self.unit());
        surface.place(&self.squares, 1, &mut self.places);
        DVec3::new(self.places.x[0][0], self.places.y[0][0], self.places.z[0][0])
    }
}
