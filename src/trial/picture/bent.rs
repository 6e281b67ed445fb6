//! What the exact side knows of bent light, texel by texel.

use std::collections::BTreeMap;
use std::f64::consts::PI;

use rayon::prelude::*;

use crate::configuration::{Configuration, MeasurementPoint, ReceiverShape};
use crate::eye::Eye;
use crate::geometry::{Disk, Parametrisation, Rectangle, TexelGrid};
use crate::light::LightSettings;
use crate::oracle::optics::{Bounded, CausticLayout, MirrorOracle, flat_mirror};
use crate::oracle::patch::{Patch, Tolerance};

/// Relative accuracy that is asked of means over texels in a mirror's light.
const OF_MIRRORS: f64 = 1e-4;
/// How far a foot may lie beside a disk's centre, in units of its radius.
const CENTRED: f64 = 1e-9;

/// The bent light of a room.
pub(super) enum Bent {
    Nothing,
    /// One lamp, one optic on its axis. No direct light reaches the receiver.
    Caustic(CausticLayout),
    /// Sources with area and one flat mirror.
    Mirror(Box<MirrorOracle>),
    /// Why it is not known.
    Unknown(&'static str),
}

/// Means over the texels of the receiver's map, W/m².
pub(super) struct Texels {
    map: Parametrisation,
    grid: TexelGrid,
    means: Vec<Option<Bounded>>,
}

impl Texels {
    /// Around a point of the receiver.
    pub fn at(&self, point: &MeasurementPoint) -> Option<Bounded> {
        self.means[self.index(point)]
    }
    /// Which texel that is.
    pub fn index(&self, point: &MeasurementPoint) -> usize {
        self.grid.index(self.grid.texel(self.map.to_map(point.position())))
    }
    /// The mean over all texels; complete ones only are to be asked.
    pub fn all(&self) -> Bounded {
        let mut sum = Bounded::default();
        for (texel, mean) in self.means.iter().enumerate() {
            let (area, mean) = (self.area(texel), mean.unwrap_or_default());
            sum.value += mean.value * area;
            sum.bound += mean.bound * area;
        }
        sum.scaled(1.0 / self.total_area())
    }
    /// Whether every texel has a value.
    pub fn is_complete(&self) -> bool {
        self.means.iter().all(Option::is_some)
    }
    /// Square metres.
    pub fn total_area(&self) -> f64 {
        self.map.area()
    }
    /// Square metres.
    pub fn area(&self, texel: usize) -> f64 {
        let ns = self.grid.ns();
        self.map.texel_area(self.grid, crate::geometry::Texel { i: texel % ns, j: texel / ns })
    }
}

impl Bent {
    pub fn of(room: &Configuration, eye: &Eye) -> Bent {
        if eye.direct().is_from_map(0) {
            return Bent::Unknown("a lens or a curved mirror may stand before a source: no exact value is known");
        }
        if !room.has_optics() && room.lamps().is_empty() {
            return Bent::Nothing;
        }
        if let Some(layout) = CausticLayout::of(room) {
            return Bent::Caustic(layout);
        }
        match flat_mirror(room) {
            Some(oracle) => Bent::Mirror(Box::new(oracle)),
            None => Bent::Unknown("no exact value of this room's bent light is known"),
        }
    }

    /// How rays are followed: where only some orders are known exactly, no further than those.
    pub fn settings(&self, of_case: &LightSettings) -> LightSettings {
        match self {
            Bent::Caustic(layout) => {
                let known = layout.orders().max().unwrap_or(0);
                LightSettings { depth: of_case.depth.min(known), ..of_case.clone() }
            }
            _ => of_case.clone(),
        }
    }

    /// `None` where no texel's mean is known.
    ///
    /// - `map`: texels along s and t
    pub fn over_texels(&self, room: &Configuration, [ns, nt]: [usize; 2]) -> Option<Texels> {
        let grid = TexelGrid::new(ns, nt).ok()?;
        match room.receiver()?.shape() {
            ReceiverShape::Rectangle(receiver) => Some(self.over_rectangles(receiver, grid)),
            ReceiverShape::Disk(receiver) => self.over_sectors(receiver, grid),
            ReceiverShape::Triangle(_) | ReceiverShape::Sphere(_) => None,
        }
    }

    fn over_rectangles(&self, receiver: &Rectangle, grid: TexelGrid) -> Texels {
        let map = Parametrisation::rectangle(receiver);
        let [du, dv] = [receiver.edge_u() / grid.ns() as f64, receiver.edge_v() / grid.nt() as f64];
        let rectangle = |texel| {
            let [[s0, s1], [t0, t1]] = grid.extent(texel);
            Rectangle::new(map.to_surface([0.5 * (s0 + s1), 0.5 * (t0 + t1)]), du, dv).ok()
        };
        let texels: Vec<Option<Rectangle>> = grid.texels().map(rectangle).collect();
        let mean = |rectangle: &Option<Rectangle>| -> Option<Bounded> {
            let rectangle = rectangle.as_ref()?;
            match self {
                Bent::Caustic(layout) => {
                    layout.power_in_rectangle(rectangle).map(|power| power.scaled(1.0 / rectangle.area()))
                }
                Bent::Mirror(oracle) => {
                    let mean =
                        oracle.average_irradiance(&Patch::Rectangle(*rectangle), Tolerance::relative(OF_MIRRORS));
                    let [value, bound] = [mean.irradiance, mean.bound].map(|x| x.watts_per_square_metre());
                    bound.is_finite().then_some(Bounded { value, bound })
                }
                Bent::Nothing => Some(Bounded::default()),
                Bent::Unknown(_) => None,
            }
        };
        let means = match self {
            // A caustic's symmetry: texels that lie alike around its foot are found once.
            Bent::Caustic(layout) => {
                let alike = |rectangle: &Option<Rectangle>| {
                    let offset = rectangle.as_ref()?.center() - layout.foot();
                    let mut places = [offset.dot(du) / du.length(), offset.dot(dv) / dv.length()].map(f64::abs);
                    if du.length() == dv.length() {
                        places.sort_by(f64::total_cmp);
                    }
                    Some(places.map(f64::to_bits))
                };
                let mut kinds: BTreeMap<_, Option<Rectangle>> = BTreeMap::new();
                texels.iter().for_each(|texel| {
                    kinds.entry(alike(texel)).or_insert(*texel);
                });
                let kinds: Vec<_> = kinds.into_iter().collect();
                let found: BTreeMap<_, _> = kinds.into_par_iter().map(|(kind, texel)| (kind, mean(&texel))).collect();
                texels.iter().map(|texel| found[&alike(texel)]).collect()
            }
            _ => texels.par_iter().map(mean).collect(),
        };
        Texels { map, grid, means }
    }

    /// Sectors of a disk around a caustic's foot: each has its share of a ring.
    fn over_sectors(&self, receiver: &Disk, grid: TexelGrid) -> Option<Texels> {
        let map = Parametrisation::disk(receiver, None).ok()?;
        let Bent::Caustic(layout) = self else { return None };
        if (layout.foot() - receiver.center()).length() > CENTRED * receiver.radius() {
            return None;
        }
        let of_row = |j: usize| {
            let [from, to] = [j, j + 1].map(|k| receiver.radius() * (k as f64 / grid.nt() as f64).sqrt());
            let area = PI * receiver.radius() * receiver.radius() / grid.nt() as f64;
            layout.power_within(from, to).map(|power| power.scaled(1.0 / area))
        };
        let rows: Vec<Option<Bounded>> = (0..grid.nt()).into_par_iter().map(of_row).collect();
        let means = grid.texels().map(|texel| rows[texel.j]).collect();
        Some(Texels { map, grid, means })
    }
}
