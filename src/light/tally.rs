//! What a batch of rays leaves behind, booked group by group.
//!
//! The rays of a group share their place on the source, and the branches of a ray share its fate: so what falls into one
//! cell is added up over a group before it is squared.

use super::ledger::{Moments, Sum};

/// Adds to a cell among those that a group has touched, each once: all from `first` on.
#[inline(always)]
fn add_to(cells: &mut Vec<(u32, f64)>, first: usize, cell: u32, flux: f64) {
    match cells[first..].iter_mut().find(|(known, _)| *known == cell) {
        Some((_, sum)) => *sum += flux,
        None => cells.push((cell, flux)),
    }
}

/// Few cells, all in memory: by order of interaction, rings or tiles.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "studies", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Dense {
    pub cells: Vec<Moments>,
    /// What the group that is not closed yet has left in which of them.
    #[cfg_attr(feature = "studies", serde(skip))]
    touched: Vec<(u32, f64)>,
}

impl Dense {
    pub fn new(n: usize) -> Dense {
        Dense { cells: vec![Moments::default(); n], touched: Vec::new() }
    }
    #[inline(always)]
    pub fn add(&mut self, cell: usize, flux: f64) {
        add_to(&mut self.touched, 0, cell as u32, flux);
    }
    #[inline(always)]
    fn settle(&mut self) {
        for (cell, flux) in self.touched.drain(..) {
            self.cells[cell as usize].add(flux);
        }
    }
    pub fn merge(&mut self, other: &Dense) {
        self.cells.iter_mut().zip(&other.cells).for_each(|(cell, other)| cell.merge(other));
    }
}

/// A batch's books.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "studies", derive(serde::Serialize, serde::Deserialize))]
pub(crate) struct Tally {
    pub rays: u64,
    pub groups: u64,
    pub emitted: Sum,
    pub deposited: Moments,
    pub absorbed: Sum,
    pub escaped: Sum,
    pub terminated: Sum,
    /// `[n_maps][depth + 1]`.
    pub orders: Dense,
    /// `[depth + 1][n_rings]`.
    pub rings: Dense,
    /// `[depth + 1][n_tiles]`.
    pub tiles: Dense,
    /// What each group left in each texel, in order. Texels are counted through all maps: twice the texel's number, plus
    /// one where the light has met an optic.
    #[cfg_attr(feature = "studies", serde(skip))]
    pub texels: Vec<(u32, f64)>,
    /// How many of them closed groups have left.
    #[cfg_attr(feature = "studies", serde(skip))]
    closed: usize,
    /// Interactions at which polarised light changed its plane of incidence, and the flux of them.
    pub depolarised: u64,
    pub depolarised_flux: Sum,
    /// Rays and branches that met each optic.
    pub reached: Vec<u64>,
    #[cfg_attr(feature = "studies", serde(skip))]
    in_group: f64,
}

impl Tally {
    pub fn new(n_maps: usize, depth: usize, [n_rings, n_tiles]: [usize; 2], n_optics: usize) -> Tally {
        Tally {
            rays: 0,
            groups: 0,
            emitted: Sum::default(),
            deposited: Moments::default(),
            absorbed: Sum::default(),
            escaped: Sum::default(),
            terminated: Sum::default(),
            orders: Dense::new(n_maps * (depth + 1)),
            rings: Dense::new((depth + 1) * n_rings),
            tiles: Dense::new((depth + 1) * n_tiles),
            texels: Vec::new(),
            closed: 0,
            depolarised: 0,
            depolarised_flux: Sum::default(),
            reached: vec![0; n_optics],
            in_group: 0.0,
        }
    }

    /// Flux left in a texel.
    #[inline(always)]
    pub fn deposit(&mut self, texel: u32, flux: f64) {
        self.in_group += flux;
        add_to(&mut self.texels, self.closed, texel, flux);
    }

    /// Closes a group of rays.
    #[inline(always)]
    pub fn settle(&mut self) {
        self.groups += 1;
        self.deposited.add(std::mem::take(&mut self.in_group));
        self.closed = self.texels.len();
        self.orders.settle();
        self.rings.settle();
        self.tiles.settle();
    }

    /// Whether the books of both have the same pages.
    pub fn is_alike(&self, other: &Tally) -> bool {
        let sizes = |t: &Tally| [&t.orders, &t.rings, &t.tiles].map(|dense| dense.cells.len());
        sizes(self) == sizes(other) && self.reached.len() == other.reached.len()
    }

    /// Adds a later batch, all but its texels.
    pub fn merge(&mut self, other: &Tally) {
        self.rays += other.rays;
        self.groups += other.groups;
        self.emitted += other.emitted;
        self.deposited.merge(&other.deposited);
        self.absorbed += other.absorbed;
        self.escaped += other.escaped;
        self.terminated += other.terminated;
        self.orders.merge(&other.orders);
        self.rings.merge(&other.rings);
        self.tiles.merge(&other.tiles);
        self.depolarised += other.depolarised;
        self.depolarised_flux += other.depolarised_flux;
        self.reached.iter_mut().zip(&other.reached).for_each(|(sum, n)| *sum += n);
    }
}
