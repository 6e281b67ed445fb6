//! The look of plots: colours that the colour-blind can tell apart, and marks that differ without colour too.

use crate::report::record::StrategyRecord;
use crate::sampling::Strategy;

/// Red, green, blue.
pub use plotters::style::RGBColor as Colour;

/// The family of the unseen words of an SVG; Verdana has the same widths as the embedded font.
pub const FONT: &str = "DejaVu Sans,Verdana,sans-serif";

pub const PAPER: Colour = Colour(0xff, 0xff, 0xff);
pub const INK: Colour = Colour(0x22, 0x22, 0x22);
pub const GREY: Colour = Colour(0x66, 0x66, 0x66);
pub const GUIDE: Colour = Colour(0x99, 0x99, 0x99);
pub const GRID: Colour = Colour(0xe4, 0xe4, 0xe4);

/// Sizes of text, points.
pub const TITLE: f64 = 16.0;
pub const TEXT: f64 = 12.5;
pub const SMALL: f64 = 11.5;

/// How a line is broken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dash {
    Solid,
    Dashed,
    Dotted,
    Alternating,
    /// Long dashes.
    Striding,
    /// A dash and two dots.
    Morse,
    /// Short dashes.
    Tripping,
}

impl Dash {
    /// Lengths of dash and gap in turn, points; `None` where the line is whole.
    pub fn lengths(self) -> Option<&'static [f64]> {
        match self {
            Dash::Solid => None,
            Dash::Dashed => Some(&[7.0, 4.0]),
            Dash::Dotted => Some(&[1.8, 3.2]),
            Dash::Alternating => Some(&[8.0, 3.0, 1.8, 3.0]),
            Dash::Striding => Some(&[13.0, 4.0]),
            Dash::Morse => Some(&[8.0, 3.0, 1.8, 3.0, 1.8, 3.0]),
            Dash::Tripping => Some(&[4.0, 2.5]),
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Marker {
    Circle,
    Square,
    Triangle,
    Diamond,
    /// A triangle on its tip.
    Funnel,
    /// An upright cross.
    Plus,
    Star,
}

impl Marker {
    /// Corners around the middle for size 1, y downwards; all markers cover about the same area.
    pub fn outline(self) -> &'static [(f64, f64)] {
        match self {
            Marker::Circle => &[],
            Marker::Square => &[(-0.9, -0.9), (0.9, -0.9), (0.9, 0.9), (-0.9, 0.9)],
            Marker::Triangle => &[(0.0, -1.3), (1.2, 0.8), (-1.2, 0.8)],
            Marker::Diamond => &[(0.0, -1.3), (1.2, 0.0), (0.0, 1.3), (-1.2, 0.0)],
            Marker::Funnel => &[(0.0, 1.3), (-1.2, -0.8), (1.2, -0.8)],
            Marker::Plus => &[
                (-0.4, -1.2),
                (0.4, -1.2),
                (0.4, -0.4),
                (1.2, -0.4),
                (1.2, 0.4),
                (0.4, 0.4),
                (0.4, 1.2),
                (-0.4, 1.2),
                (-0.4, 0.4),
                (-1.2, 0.4),
                (-1.2, -0.4),
                (-0.4, -0.4),
            ],
            // Five tips at 1.5, five notches at 0.66.
            Marker::Star => &[
                (0.0, -1.5),
                (0.388, -0.534),
                (1.427, -0.464),
                (0.628, 0.204),
                (0.882, 1.214),
                (0.0, 0.66),
                (-0.882, 1.214),
                (-0.628, 0.204),
                (-1.427, -0.464),
                (-0.388, -0.534),
            ],
        }
    }
}

/// How one series looks everywhere.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    pub colour: Colour,
    pub marker: Marker,
    pub dash: Dash,
}

/// Colours of Okabe and Ito (2008), all but yellow, which is lost on white: blue, vermilion, bluish green, orange, sky blue,
/// reddish purple, black; for techniques beside sampling by area those of Tol's muted scheme (2021): indigo, wine, olive,
/// purple.
pub fn look(strategy: Strategy) -> Look {
    match strategy {
        Strategy::Random => Look { colour: Colour(0x00, 0x72, 0xb2), marker: Marker::Circle, dash: Dash::Solid },
        Strategy::Correlated => Look { colour: Colour(0xd5, 0x5e, 0x00), marker: Marker::Square, dash: Dash::Dashed },
        Strategy::Stratified => {
            Look { colour: Colour(0x00, 0x9e, 0x73), marker: Marker::Triangle, dash: Dash::Alternating }
        }
        Strategy::UniformJitter => {
            Look { colour: Colour(0xe6, 0x9f, 0x00), marker: Marker::Funnel, dash: Dash::Dotted }
        }
        Strategy::LatinHypercube => {
            Look { colour: Colour(0x56, 0xb4, 0xe9), marker: Marker::Plus, dash: Dash::Striding }
        }
        Strategy::MultiJittered => {
            Look { colour: Colour(0xcc, 0x79, 0xa7), marker: Marker::Diamond, dash: Dash::Morse }
        }
        Strategy::Sobol => Look { colour: Colour(0x00, 0x00, 0x00), marker: Marker::Star, dash: Dash::Tripping },
        Strategy::SolidAngle => {
            Look { colour: Colour(0x33, 0x22, 0x88), marker: Marker::Diamond, dash: Dash::Dotted }
        }
        Strategy::Cosine => Look { colour: Colour(0x88, 0x22, 0x55), marker: Marker::Circle, dash: Dash::Dashed },
        Strategy::MisBalance => Look { colour: Colour(0x99, 0x99, 0x33), marker: Marker::Square, dash: Dash::Dotted },
        Strategy::MisPower => Look { colour: Colour(0xaa, 0x44, 0x99), marker: Marker::Triangle, dash: Dash::Dashed },
    }
}

/// A guest is none of the strategies: grey, and a funnel.
const GUEST: Look = Look { colour: Colour(0x55, 0x55, 0x55), marker: Marker::Funnel, dash: Dash::Tripping };

/// The look of whoever made the estimates.
pub fn look_of(made: &StrategyRecord) -> Look {
    made.known().map_or(GUEST, look)
}

/// What people read for whoever made the estimates.
pub fn shown_of(made: &StrategyRecord) -> &str {
    match made.known() {
        Some(strategy) => shown(strategy),
        None => &made.name,
    }
}

/// What people read for a strategy.
pub fn shown(strategy: Strategy) -> &'static str {
    match strategy {
        Strategy::Random => "random",
        Strategy::Correlated => "shared points",
        Strategy::Stratified => "stratified",
        Strategy::UniformJitter => "uniform jitter",
        Strategy::LatinHypercube => "Latin hypercube",
        Strategy::MultiJittered => "multi-jittered",
        Strategy::Sobol => "Sobol’, scrambled",
        Strategy::SolidAngle => "solid angle",
        Strategy::Cosine => "cosine",
        Strategy::MisBalance => "MIS, balance",
        Strategy::MisPower => "MIS, power",
    }
}
