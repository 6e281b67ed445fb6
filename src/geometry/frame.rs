//! A right-handed orthonormal frame built around one given direction.

use glam::DVec3;

use crate::number::Vector;

/// Three unit vectors, mutually perpendicular, with `tangent × bitangent = normal`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    pub tangent: DVec3,
    pub bitangent: DVec3,
    pub normal: DVec3,
}

impl Frame {
    /// The frame whose `normal` is the given unit vector; the other two axes are chosen without branches that jump
    /// except across the plane z = 0.
    ///
    /// - `normal`: unit vector
    /// - error: the axes are orthonormal to a few units in the last place
    /// - source: Duff et al., *Building an Orthonormal Basis, Revisited*, JCGT 6(1), 2017, listing 3
    pub fn around(normal: DVec3) -> Frame {
        let (tangent, bitangent) = Vector::<f64>::constant(normal).frame();
        Frame { tangent: tangent.primal(), bitangent: bitangent.primal(), normal }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_frame_is_orthonormal_and_right_handed(x in -1.0..1.0, y in -1.0..1.0, z in -1.0..1.0) {
            let v = DVec3::new(x, y, z);
            prop_assume!(v.length() > 1e-3);
            let f = Frame::around(v.normalize());
            // Each of three products of components that are themselves off by three roundings of 2⁻⁵³.
            for (a, b) in [(f.tangent, f.bitangent), (f.bitangent, f.normal), (f.normal, f.tangent)] {
                assert_abs_diff_eq!(a.dot(b), 0.0, epsilon = 1e-15);
                assert_abs_diff_eq!(a.length(), 1.0, epsilon = 1e-15);
            }
            assert_abs_diff_eq!(f.tangent.cross(f.bitangent).dot(f.normal), 1.0, epsilon = 2e-15);
        }
    }

    #[test]
    fn the_poles_are_no_exception() {
        for z in [1.0, -1.0] {
            let f = Frame::around(DVec3::new(0.0, 0.0, z));
            assert_eq!(f.tangent.cross(f.bitangent), f.normal);
        }
    }
}
