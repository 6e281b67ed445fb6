//! Vectors in space over any number.

use std::ops::{Add, Mul, Neg, Sub};

use glam::DVec3;

use super::Number;

/// A vector in space.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vector<T> {
    pub x: T,
    pub y: T,
    pub z: T,
}

impl<T: Number> Vector<T> {
    #[inline]
    pub fn new(x: T, y: T, z: T) -> Vector<T> {
        Vector { x, y, z }
    }
    /// A vector that depends on nothing.
    #[inline]
    pub fn constant(v: DVec3) -> Vector<T> {
        Vector::new(T::constant(v.x), T::constant(v.y), T::constant(v.z))
    }
    #[inline]
    pub fn primal(self) -> DVec3 {
        DVec3::new(self.x.primal(), self.y.primal(), self.z.primal())
    }
    #[inline]
    pub fn dot(self, other: Vector<T>) -> T {
        self.x * other.x + self.y * other.y + self.z * other.z
    }
    #[inline]
    pub fn cross(self, other: Vector<T>) -> Vector<T> {
        Vector::new(
            self.y * other.z - self.z * other.y,
            self.z * other.x - self.x * other.z,
            self.x * other.y - self.y * other.x,
        )
    }
    #[inline]
    pub fn length_squared(self) -> T {
        self.dot(self)
    }
    #[inline]
    pub fn length(self) -> T {
        self.length_squared().sqrt()
    }
    #[inline]
    pub fn normalize(self) -> Vector<T> {
        self * (T::constant(1.0) / self.length())
    }

    /// Two unit vectors `(tangent, bitangent)` that make a right-handed frame with this unit vector.
    ///
    /// - source: Duff et al., *Building an Orthonormal Basis, Revisited*, JCGT 6(1), 2017, listing 3
    pub fn frame(self) -> (Vector<T>, Vector<T>) {
        let sign = 1.0_f64.copysign(self.z.primal());
        let a = T::constant(-1.0) / (self.z + sign);
        let b = self.x * self.y * a;
        (
            Vector::new(self.x * self.x * a * sign + 1.0, b * sign, self.x * -sign),
            Vector::new(b, self.y * self.y * a + sign, -self.y),
        )
    }
}

impl<T: Number> Add for Vector<T> {
    type Output = Vector<T>;
    #[inline]
    fn add(self, other: Vector<T>) -> Vector<T> {
        Vector::new(self.x + other.x, self.y + other.y, self.z + other.z)
    }
}

impl<T: Number> Sub for Vector<T> {
    type Output = Vector<T>;
    #[inline]
    fn sub(self, other: Vector<T>) -> Vector<T> {
        Vector::new(self.x - other.x, self.y - other.y, self.z - other.z)
    }
}

impl<T: Number> Neg for Vector<T> {
    type Output = Vector<T>;
    #[inline]
    fn neg(self) -> Vector<T> {
        Vector::new(-self.x, -self.y, -self.z)
    }
}

impl<T: Number> Mul<T> for Vector<T> {
    type Output = Vector<T>;
    #[inline]
    fn mul(self, factor: T) -> Vector<T> {
        Vector::new(self.x * factor, self.y * factor, self.z * factor)
    }
}
