//! How eye paths are followed, and which light is told apart.

/// Light by the way that it has come.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// All of it.
    Total,
    /// By way of mirrors and glass alone.
    Caustic,
    /// By way of at least one diffuse surface that does not emit it.
    Indirect,
}

impl Part {
    /// All, in the order of their names' table.
    pub const ALL: [Part; 3] = [Part::Total, Part::Caustic, Part::Indirect];
    /// The name that tables use.
    pub fn name(self) -> &'static str {
        match self {
            Part::Total => "total",
            Part::Caustic => "caustic",
            Part::Indirect => "indirect",
        }
    }
    pub(super) fn index(self) -> usize {
        match self {
            Part::Total => 0,
            Part::Caustic => 1,
            Part::Indirect => 2,
        }
    }
}

/// How eye paths are followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PathSettings {
    /// Whether every diffuse surface on the way sends shadow rays to the sources.
    pub next_event: bool,
    /// Diffuse reflections before roulette decides whether a path goes on.
    pub roulette_after: usize,
    /// Most diffuse reflections of a path.
    pub depth: usize,
    /// Most mirrors and faces of glass between two diffuse surfaces.
    pub chain: usize,
}

impl Default for PathSettings {
    fn default() -> PathSettings {
        PathSettings { next_event: false, roulette_after: 2, depth: 4096, chain: 256 }
    }
}
