//! What a map of texels is off by, and why: its bias, which texels of a size have, and its noise, which rays take away.
//!
//! Where all bent light is known, the mean over a square of texels has an exact value Ē, its middle has another one, E₀, and
//! what the square holds, Ê, is told from both: E (Ê − Ē)² is the noise, known beforehand where each group is one ray that
//! lands or does not (m (g − m) for groups of flux g that bring m on average), and Ē − E₀ is the bias of reading the square
//! as if it were its middle.

use super::outcome::MapRow;
use crate::configuration::Configuration;
use crate::geometry::Texel;
use crate::light::{Light, LightRun};
use crate::oracle::optics::CausticLayout;

/// Squares of this many texels across, around one texel each.
const SIZES: [usize; 4] = [1, 3, 5, 9];
/// Fewer places tell nothing.
const FEWEST: usize = 8;

/// A square of texels around a place.
struct Square {
    /// Its texels: the first, and how many across.
    first: Texel,
    across: usize,
    /// Exact irradiance at its middle, and on average, W/m².
    middle: f64,
    mean: f64,
    area: f64,
}

/// The squares of one size, over all places.
pub(super) struct Squares {
    size: f64,
    squares: Vec<Square>,
}

/// Squares around places that lie apart from each other, from edges of the light and from caustics. Empty where bent light is
/// not known wholly.
pub(super) fn squares(
    room: &Configuration,
    layout: &CausticLayout,
    grid: crate::geometry::TexelGrid,
) -> Vec<Squares> {
    let orders: Vec<usize> = layout.orders().collect();
    // Glass sends light by other orders, too.
    let ([order], [], [_]) = (&orders[..], room.glass(), room.mirrors()) else { return Vec::new() };
    let of_size = |across: usize| {
        let half = across / 2;
        let mut squares = Vec::new();
        let step = SIZES[SIZES.len() - 1];
        for j in (half..grid.nt().saturating_sub(half)).step_by(step) {
            for i in (half..grid.ns().saturating_sub(half)).step_by(step) {
                let first = Texel { i: i - half, j: j - half };
                let [[s0, _], [t0, _]] = grid.extent(first);
                let [[_, s1], [_, t1]] = grid.extent(Texel { i: i + half, j: j + half });
                let Some((middle, mean, area)) = layout.irradiance_of_part(*order, [s0, s1], [t0, t1]) else {
                    continue;
                };
                squares.push(Square { first, across, middle, mean, area });
            }
        }
        squares
    };
    let all = SIZES.into_iter().map(of_size).filter(|squares| squares.len() >= FEWEST);
    all.map(|squares| Squares { size: squares[0].area.sqrt(), squares }).collect()
}

/// What one run's map is off by.
pub(super) fn rows(run: &LightRun, squares: &[Squares]) -> Vec<MapRow> {
    let Some(map) = run.maps.first() else { return Vec::new() };
    let n = run.ledger.groups.max(1) as f64;
    let most = run.ledger.source_power / n;
    let of_size = |all: &Squares| {
        let count = all.squares.len() as f64;
        let mean = |value: &dyn Fn(&Square) -> f64| all.squares.iter().map(value).sum::<f64>() / count;
        let found = |square: &Square| {
            let texels = (0..square.across * square.across)
                .map(|k| Texel { i: square.first.i + k % square.across, j: square.first.j + k / square.across });
            texels.map(|texel| map.moments(texel, Light::Bent).watts()).sum::<f64>() / square.area
        };
        let predicted = |square: &Square| {
            let due = square.mean * square.area / n;
            n * due * (most - due).max(0.0) / (square.area * square.area)
        };
        let predicted = mean(&predicted);
        let off_middle = mean(&|square| (found(square) - square.middle).powi(2));
        MapRow {
            rays: run.ledger.rays,
            size: all.size,
            places: all.squares.len(),
            irradiance: mean(&|square| square.middle),
            bias: (off_middle - predicted).max(0.0).sqrt(),
            exact_bias: mean(&|square| (square.mean - square.middle).powi(2)).sqrt(),
            variance: mean(&|square| (found(square) - square.mean).powi(2)),
            predicted_variance: predicted,
        }
    };
    squares.iter().map(of_size).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::shipped_caustics;
    use crate::light::{LightSettings, trace};

    #[test]
    fn noise_is_as_predicted_and_bias_is_the_texels() {
        let case = shipped_caustics().find(|case| case.name() == "caustic/paraboloid").unwrap().read().unwrap();
        let layout = CausticLayout::of(&case.configuration).unwrap();
        let run = |rays| trace(&case.configuration, &LightSettings { rays, ..case.light.clone() }, 5);
        let runs = [run(100_000), run(1_600_000)];
        let squares = squares(&case.configuration, &layout, runs[0].maps[0].grid());
        assert_eq!(squares.len(), SIZES.len());
        for run in &runs {
            for row in rows(run, &squares) {
                // Some hundred places: their mean square is within a few tenths.
                let ratio = row.variance / row.predicted_variance;
                let tolerance = 6.0 * (2.0 / row.places as f64).sqrt();
                assert!((ratio - 1.0).abs() < tolerance, "{row:?}: {ratio}");
            }
        }
        // Sixteen times the rays, a sixteenth of the noise; the bias is the size's alone, and grows as its square.
        let [few, many] = [rows(&runs[0], &squares), rows(&runs[1], &squares)];
        for (few, many) in few.iter().zip(&many) {
            assert!((few.predicted_variance / many.predicted_variance - 16.0).abs() < 0.01);
            assert_eq!(few.exact_bias, many.exact_bias);
        }
        let growth = (many[3].exact_bias / many[1].exact_bias).ln() / (many[3].size / many[1].size).ln();
        assert!((growth - 2.0).abs() < 0.2, "{growth}");
    }
}
