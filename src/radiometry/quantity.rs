//! Quantities as types: only the products that are laws compile.
//!
//! ```
//! use etendue::radiometry::{Albedo, Area, Exitance, Flux, FormFactor, Irradiance, Radiosity};
//!
//! let arriving: Irradiance = Exitance::new(2.0) * FormFactor::new(0.25);   // W/m²
//! let leaving: Radiosity = arriving * Albedo::new(0.5);                    // W/m²
//! let power: Flux = leaving * Area::new(4.0);                              // W
//! assert_eq!(power.watts(), 1.0);
//! ```

use std::f64::consts::PI;
use std::iter::Sum;
use std::ops::{Add, Mul};

macro_rules! quantity {
    ($(#[$doc:meta])* $name:ident, $unit:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
        #[cfg_attr(feature = "studies", derive(serde::Serialize, serde::Deserialize))]
        pub struct $name(f64);

        impl $name {
            /// Wraps a number already in this quantity's unit.
            pub const fn new(value: f64) -> Self {
                Self(value)
            }
            /// The number, in the unit that the method is named after.
            pub const fn $unit(self) -> f64 {
                self.0
            }
        }

        impl Add for $name {
            type Output = Self;
            fn add(self, other: Self) -> Self {
                Self(self.0 + other.0)
            }
        }

        impl Sum for $name {
            fn sum<I: Iterator<Item = Self>>(terms: I) -> Self {
                terms.fold(Self(0.0), Add::add)
            }
        }
    };
}

macro_rules! law {
    ($left:ident * $right:ident = $product:ident) => {
        impl Mul<$right> for $left {
            type Output = $product;
            fn mul(self, other: $right) -> $product {
                $product(self.0 * other.0)
            }
        }
    };
}

quantity!(
    /// Power leaving a surface of its own accord per area, W/m² (the lecture's E).
    Exitance, watts_per_square_metre
);
quantity!(
    /// Power arriving at a surface per area, W/m² (the standards' E).
    Irradiance, watts_per_square_metre
);
quantity!(
    /// Power leaving a surface per area, emitted and reflected together, W/m² (the lecture's B).
    Radiosity, watts_per_square_metre
);
quantity!(
    /// Power per area across the direction and per solid angle, W/(m² sr); kept along a ray in empty space.
    Radiance, watts_per_square_metre_steradian
);
quantity!(
    /// Power per solid angle, W/sr.
    Intensity, watts_per_steradian
);
quantity!(
    /// Power, W.
    Flux, watts
);
quantity!(
    /// Square metres.
    Area, square_metres
);
quantity!(
    /// How much of all directions something fills, sr, in [0, 4π].
    SolidAngle, steradians
);
quantity!(
    /// Solid angle weighed by the cosine to a surface's normal, sr, in [0, π].
    ProjectedSolidAngle, steradians
);
quantity!(
    /// The irradiance at a point per exitance of a source: projected solid angle over π, in [0, 1].
    FormFactor, ratio
);
quantity!(
    /// The share of arriving power that a diffuse surface sends back, in [0, 1].
    Albedo, ratio
);

law!(Exitance * FormFactor = Irradiance);
law!(Exitance * Area = Flux);
law!(Irradiance * Area = Flux);
law!(Irradiance * Albedo = Radiosity);
law!(Radiosity * Area = Flux);
law!(Intensity * SolidAngle = Flux);
law!(Radiance * ProjectedSolidAngle = Irradiance);

macro_rules! spread {
    ($($name:ident)*) => {
        $(impl $name {
            /// The mean over a surface of a power that leaves or reaches it.
            ///
            /// - `area`: > 0
            pub fn mean_of(power: Flux, area: Area) -> Self {
                Self(power.0 / area.0)
            }
        })*
    };
}
spread!(Exitance Irradiance Radiosity);

macro_rules! diffuse {
    ($($name:ident)*) => {
        $(impl $name {
            /// Of a diffuse (Lambertian) surface: the same in all directions, L = M/π.
            pub fn radiance(self) -> Radiance {
                Radiance(self.0 / PI)
            }
            /// Of a diffuse (Lambertian) surface of that radiance: ∫ L cosθ dω = π L over the hemisphere.
            pub fn of_radiance(radiance: Radiance) -> Self {
                Self(radiance.0 * PI)
            }
        })*
    };
}
diffuse!(Exitance Radiosity);

impl From<FormFactor> for ProjectedSolidAngle {
    /// A form factor from a point is a projected solid angle over that of the hemisphere, π.
    fn from(form_factor: FormFactor) -> ProjectedSolidAngle {
        ProjectedSolidAngle(form_factor.0 * PI)
    }
}

impl Add<Exitance> for Radiosity {
    type Output = Radiosity;
    /// What a surface emits joins what it reflects.
    fn add(self, emitted: Exitance) -> Radiosity {
        Radiosity(self.0 + emitted.0)
    }
}
