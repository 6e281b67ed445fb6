//! Light that was followed from its sources: are the books in balance, and is what they say right?
//!
//! - *Books* (`energy`): every watt that left a source is deposited, absorbed, escaped or terminated; the sources gave out
//!   what their closed forms say; the map holds what was deposited. All to rounding: 10⁻¹².
//! - *Shares* (`caustic`): where the oracle knows what a ring of the receiver gets from light of one order, the gate asks
//!   whether the rings got that. Rays leave in groups that are independent and alike and carry the same flux g, so one
//!   group's deposit X in a ring is no more than g and no less than nought, and with the exact mean m its variance is at
//!   most m (g − m): known beforehand, whatever the optics, and exact where a group is one ray.

use std::f64::consts::PI;

use super::desk::Stage;
use super::map_error;
use super::onlooker::{Onlooker, Stopped};
use super::outcome::{CausticBin, JudgedProperty, LightOutcome, LightRow, Timing};
use super::pieces;
use crate::case::{Case, SmallestBias};
use crate::configuration::{Configuration, ReceiverShape};
use crate::geometry::{Texel, TexelGrid};
use crate::light::{Light, LightRun, Moments, Sum, TexelMap};
use crate::oracle::optics::{
    Bounded, CausticLayout, CupLayout, deposited_power, power_by_lampshade, power_through_two_spheres,
};
use crate::statistics::evidence::{THRESHOLD_LOG10, ln_average, log10_capped, smallest_shift};
use crate::statistics::interval::Z_95;
use crate::statistics::{Capital, Observed, Statement, Verdict};

/// What the books may be off by, relative to what was emitted.
const ROUNDING: f64 = 1e-12;
/// Share of the power beyond which taking polarised light for unpolarised is told of.
const DEPOLARISED: f64 = 1e-4;
/// Of the flux of all rings of an order: a ring below it is shown, and no promise is made of it.
const WELL_LIT: f64 = 0.01;

/// Follows the light of one case, with three budgets of rays, and judges it.
///
/// - `quick`: a sixteenth of the rays that the case asks for
/// - `onlooker`: told of the rays; where it errs, the case is given up
/// - `None` where there is nothing to follow: no mirror, glass or lamp; or where some of it is somebody else's
pub(super) fn light(
    case: &Case,
    seed: u64,
    quick: bool,
    smallest: SmallestBias,
    reproduce: &str,
    onlooker: &Onlooker,
) -> Result<Option<LightOutcome>, Stopped> {
    let room = &case.configuration;
    if !room.has_optics() && room.lamps().is_empty() {
        return Ok(None);
    }
    onlooker.goes_on()?;
    let layout = CausticLayout::of(room);
    let due = deposited_power(room, case.light.depth);
    let mut rows = Vec::new();
    let mut last = None;
    let (mut all, mut seconds) = (true, 0.0);
    let mut texels = Vec::new();
    let grid = TexelGrid::new(case.light.map[0], case.light.map[1]).ok();
    let squares = match (&layout, grid) {
        (Some(layout), Some(grid)) => map_error::squares(room, layout, grid),
        _ => Vec::new(),
    };
    for rays in budgets(case, quick) {
        let Some((run, of_run)) = pieces::light(case, seed, rays, Stage::Light { rays }, onlooker)? else {
            all = false;
            continue;
        };
        seconds += of_run;
        rows.push(row(&run, room, due.all));
        texels.extend(map_error::rows(&run, &squares));
        last = Some(run);
    }
    let Some(run) = last.filter(|_| all) else { return Ok(None) };
    let mut bins = layout.as_ref().map_or_else(Vec::new, |layout| bins(&run, layout));
    bins.extend(on_all(&run, room, due.by_flat_mirror));
    bins.extend(tiles(&run, room));
    let due = due.all.map(|due| deposit_claim(&run, due));
    let mut books = energy(&rows, due.as_ref(), reproduce);
    books.note = note(&run, room);
    let mut verdicts = vec![books];
    verdicts.extend(caustic(&run, &bins, smallest, reproduce));
    let rays = rows.iter().map(|row| row.rays).sum();
    let timing = Timing { stage: "light", rays, seconds, efficiency: None };
    Ok(Some(LightOutcome { rows, bins, texels, verdicts, timing }))
}

/// Rays of the three runs.
pub(super) fn budgets(case: &Case, quick: bool) -> [u64; 3] {
    let most = if quick { (case.light.rays / 16).max(1) } else { case.light.rays };
    [most.div_ceil(16), most.div_ceil(4), most]
}

/// What a reader should know of a run that no verdict says.
fn note(run: &LightRun, room: &Configuration) -> Option<String> {
    let names = (0..room.mirrors().len()).map(|i| format!("mirror {i}"));
    let names = names.chain((0..room.glass().len()).map(|i| format!("glass {i}")));
    let dark: Vec<String> = names.zip(&run.reached).filter(|(_, rays)| **rays == 0).map(|(name, _)| name).collect();
    let mut told = Vec::new();
    if !dark.is_empty() {
        told.push(format!("no light reaches {}", dark.join(", ")));
    }
    let share = run.depolarised_flux / run.ledger.source_power;
    if share > DEPOLARISED {
        told.push(format!(
            "at {} interactions, {:.2} % of the power, light left its plane of incidence and went on as unpolarised, an \
             approximation",
            run.depolarised,
            100.0 * share
        ));
    }
    (!told.is_empty()).then(|| told.join("; "))
}

/// The books of one run.
fn row(run: &LightRun, room: &Configuration, due: Option<Bounded>) -> LightRow {
    let receiver = room.receiver().map(|receiver| *receiver.shape());
    let surfaces = receiver.into_iter().chain(room.diffuse().iter().map(|surface| *surface.shape()));
    let map_integral = run.maps.iter().zip(surfaces).map(|(map, shape)| integral(map, &shape)).sum::<f64>();
    let ledger = &run.ledger;
    let off = |a: f64, b: f64| (a - b).abs() <= ROUNDING * ledger.source_power.abs();
    let balanced = ledger.relative_residual() <= ROUNDING
        && off(ledger.emitted, ledger.source_power)
        && off(map_integral, ledger.deposited);
    let verdict = if balanced { Verdict::Pass } else { Verdict::Fail };
    LightRow {
        rays: ledger.rays,
        source_power: ledger.source_power,
        emitted: ledger.emitted,
        deposited: ledger.deposited,
        deposited_std_error: ledger.deposited_std_error,
        absorbed: ledger.absorbed,
        escaped: ledger.escaped,
        terminated: ledger.terminated,
        residual: ledger.residual(),
        map_integral,
        exact_deposited: due.map(|due| due.value),
        verdict,
    }
}

/// What the irradiances of a map come to over its surface, W, by areas of texels that are none of the map's own: a map that
/// forgets how its texels shrink towards a pole does not hold what was deposited.
fn integral(map: &TexelMap, shape: &ReceiverShape) -> f64 {
    let grid = map.grid();
    let share = 1.0 / grid.n_texels() as f64;
    let area = |texel: Texel| match shape {
        ReceiverShape::Rectangle(s) => s.edge_u().cross(s.edge_v()).length() * share,
        // Rings of equal area, by (distance/radius)².
        ReceiverShape::Disk(s) => PI * s.radius() * s.radius() * share,
        // Archimedes: as much as on the cylinder around it. The height between two polar angles, without cancellation.
        ReceiverShape::Sphere(s) => {
            let [_, [south, north]] = grid.extent(texel);
            let height = 2.0 * (0.5 * PI * (south + north)).sin() * (0.5 * PI * (north - south)).sin();
            2.0 * PI * s.radius() * s.radius() * height / grid.ns() as f64
        }
        // Cut by its sides.
        ReceiverShape::Triangle(_) => map.area(texel),
    };
    let mut sum = Sum::default();
    for texel in grid.texels() {
        if let Some(irradiance) = map.irradiance(texel, Light::Both) {
            sum += irradiance.watts_per_square_metre() * area(texel);
        }
    }
    sum.value()
}

/// The rings of the known orders, where the case's rings lie around the layout's axis and on its receiver.
fn bins(run: &LightRun, layout: &CausticLayout) -> Vec<CausticBin> {
    let Some(rings) = &run.rings else { return Vec::new() };
    let place = rings.rings;
    if (place.center - layout.foot()).length() > 1e-9 * place.radius {
        return Vec::new();
    }
    let n_groups = rings.n_groups();
    let mut bins = Vec::new();
    for order in layout.orders() {
        for ring in 0..place.count {
            let [from, to] = place.radii(ring);
            let Some(exact) = layout.power_in_ring(order, from, to) else { continue };
            let found = rings.moments(order, ring);
            bins.push(CausticBin {
                order,
                bin: ring,
                radii: Some([from, to]),
                tile: None,
                area: rings.area(ring),
                measured: found.watts(),
                std_error: found.std_error(n_groups),
                exact: exact.value,
                bound: exact.bound,
                verdict: Verdict::Undecided,
                found,
            });
        }
    }
    let judged: Vec<Verdict> = bins.iter().map(|bin| judge(run, bin, bins.len())).collect();
    bins.iter_mut().zip(judged).for_each(|(bin, verdict)| bin.verdict = verdict);
    bins
}

/// The whole of the first map, where it is known what light of one order brings to it: by way of one flat mirror; through a
/// lampshade; from a point source through a sphere of index 1 around it, which the wall must get whole.
fn on_all(run: &LightRun, room: &Configuration, by_flat_mirror: Option<Bounded>) -> Option<CausticBin> {
    let by_mirror = || Some((1, by_flat_mirror?));
    let by_shade = || Some((0, power_by_lampshade(room)?));
    let by_spheres = || Some((1, power_through_two_spheres(room)?));
    let (order, exact) = by_mirror().or_else(by_shade).or_else(by_spheres)?;
    let map = run.maps.first()?;
    let found = run.deposited(0, order);
    let mut bin = CausticBin {
        order,
        bin: 0,
        radii: None,
        tile: None,
        area: map.grid().texels().map(|texel| map.area(texel)).sum(),
        measured: found.watts(),
        std_error: found.std_error(run.ledger.groups),
        exact: exact.value,
        bound: exact.bound,
        verdict: Verdict::Undecided,
        found,
    };
    bin.verdict = judge(run, &bin, 1);
    Some(bin)
}

/// The tiles of a cup's floor that lie within its wall.
fn tiles(run: &LightRun, room: &Configuration) -> Vec<CausticBin> {
    let (Some(map), Some(layout)) = (&run.tiles, CupLayout::of(room)) else { return Vec::new() };
    let bin = |tile| {
        let [s, t] = map.tiles.extent(tile);
        let exact = layout.power_in_part(s, t)?;
        let found = map.moments(CupLayout::ORDER, tile);
        Some(CausticBin {
            order: CupLayout::ORDER,
            bin: map.tiles.index(tile),
            radii: None,
            tile: Some([tile.i, tile.j]),
            area: map.area(tile),
            measured: found.watts(),
            std_error: found.std_error(map.n_groups()),
            exact: exact.value,
            bound: exact.bound,
            verdict: Verdict::Undecided,
            found,
        })
    };
    let mut bins: Vec<CausticBin> = map.tiles.texels().filter_map(bin).collect();
    let judged: Vec<Verdict> = bins.iter().map(|bin| judge(run, bin, bins.len())).collect();
    bins.iter_mut().zip(judged).for_each(|(bin, verdict)| bin.verdict = verdict);
    bins
}

/// The flux that each group carries, and how many there are.
fn groups(run: &LightRun) -> (f64, u64) {
    let n = run.ledger.groups;
    (run.ledger.source_power / n.max(1) as f64, n)
}

/// That groups brought a flux, and what they should have brought.
struct Claim {
    statement: Statement,
    observed: Observed,
    n: u64,
}

impl Claim {
    /// - `exact`, `bound`: of all groups together, W
    fn new(run: &LightRun, found: &Moments, exact: f64, bound: f64) -> Claim {
        let (most, n) = groups(run);
        let count = n.max(1) as f64;
        let (mean, margin) = (exact / count, (bound + ROUNDING * exact) / count);
        // Zero only if nothing can arrive.
        let variance = ((mean + margin) * (most - mean).max(0.0)).max(0.0);
        let observed = Observed { n, pivot: 0.0, sum: found.watts(), sum_of_squares: found.squares };
        Claim { statement: Statement::near(mean, margin, variance), observed, n }
    }

    fn capital(&self) -> f64 {
        Capital::of(&self.statement, &self.observed, self.n).ln()
    }

    /// The relative deviation that would have been caught.
    fn seen(&self, components: usize) -> f64 {
        let mean = 0.5 * (self.statement.low + self.statement.high);
        let margin = 0.5 * (self.statement.high - self.statement.low);
        (smallest_shift(self.statement.variance, self.n, components) + margin) / mean
    }
}

fn judge(run: &LightRun, bin: &CausticBin, components: usize) -> Verdict {
    let claim = Claim::new(run, &bin.found, bin.exact, bin.bound);
    if log10_capped(claim.capital()) >= THRESHOLD_LOG10 {
        Verdict::Fail
    } else if bin.exact > 0.0 && claim.seen(components) > 1.0 {
        Verdict::Undecided
    } else {
        Verdict::Pass
    }
}

/// That as much was deposited as is due.
fn deposit_claim(run: &LightRun, due: Bounded) -> Claim {
    let mut found = Moments::default();
    found.flux += run.ledger.deposited;
    // No group leaves more than it carried: its square is at most that times what it left.
    found.squares = groups(run).0 * run.ledger.deposited;
    Claim::new(run, &found, due.value, due.bound)
}

/// - `due`: what should have been deposited, where that is known
fn energy(rows: &[LightRow], due: Option<&Claim>, reproduce: &str) -> JudgedProperty {
    let worst = rows.iter().map(LightRow::largest_gap).fold(0.0, f64::max);
    let balanced = rows.iter().all(|row| row.verdict == Verdict::Pass);
    let evidence = due.map_or(0.0, |due| log10_capped(due.capital()));
    let is_due = evidence < THRESHOLD_LOG10;
    // Books that do not balance come first; else what the deposited share is off by, where that is known.
    let (effect, error) = due.filter(|_| balanced).map_or((worst, 0.0), deviation);
    let words = if balanced && is_due {
        let share = due.map_or(String::new(), |due| {
            format!("; no deviation of the deposited share above {:.2} %", 100.0 * due.seen(1))
        });
        format!("every watt is booked: gaps in the books of at most {worst:.1e} of what was emitted{share}")
    } else if balanced {
        format!(
            "the books balance, and are wrong: {:+.2} % ± {:.2} % of the flux that should have been deposited",
            100.0 * effect,
            100.0 * Z_95 * error
        )
    } else {
        let row = rows.iter().find(|row| row.verdict != Verdict::Pass).unwrap_or(&rows[0]);
        format!(
            "the books do not balance: of {:e} W that the sources give out, {:e} W left them, {:e} W are unaccounted for, and \
             the maps hold {:e} W of {:e} W deposited ({} rays)",
            row.source_power, row.emitted, row.residual, row.map_integral, row.deposited, row.rays
        )
    };
    JudgedProperty {
        property: "energy",
        verdict: if balanced && is_due { Verdict::Pass } else { Verdict::Fail },
        evidence: if balanced { evidence } else { log10_capped(f64::INFINITY) },
        threshold: THRESHOLD_LOG10,
        effect,
        effect_low: effect - Z_95 * error,
        effect_high: effect + Z_95 * error,
        smallest_bias_mean: Some(due.map_or(ROUNDING, |due| due.seen(1))),
        smallest_bias_point: None,
        words,
        note: None,
        reproduce: reproduce.to_owned(),
    }
}

/// The rings of all known orders, and each order's rings together.
fn caustic(run: &LightRun, bins: &[CausticBin], smallest: SmallestBias, reproduce: &str) -> Option<JudgedProperty> {
    if bins.is_empty() {
        return None;
    }
    let mut orders: Vec<usize> = bins.iter().map(|bin| bin.order).collect();
    orders.dedup();
    let together = |order: usize| {
        let of_order = || bins.iter().filter(move |bin| bin.order == order);
        let mut found = Moments::default();
        of_order().for_each(|bin| found.flux += bin.measured);
        // A group of several rays may reach several rings: its square is at most g times what it brought.
        found.squares = groups(run).0 * found.watts();
        let sum = |value: &dyn Fn(&CausticBin) -> f64| of_order().map(value).sum::<f64>();
        (found, sum(&|bin| bin.exact), sum(&|bin| bin.bound))
    };
    let totals: Vec<_> = orders.iter().map(|order| together(*order)).collect();
    let m = bins.len() + totals.len();
    let of_bins = bins.iter().map(|bin| Claim::new(run, &bin.found, bin.exact, bin.bound));
    let of_totals = totals.iter().map(|(found, exact, bound)| Claim::new(run, found, *exact, *bound));
    let claims: Vec<Claim> = of_bins.chain(of_totals).collect();
    let capitals: Vec<f64> = claims.iter().map(Claim::capital).collect();
    let evidence = log10_capped(ln_average(capitals.iter().copied()));
    // The first order is the caustic itself; the echoes of a slab are a percent of it.
    let mean = claims[bins.len()].seen(m);
    let bright = bins.iter().zip(&claims).filter(|(bin, _)| {
        let order = orders.iter().position(|order| *order == bin.order).unwrap_or(0);
        order == 0 && bin.exact >= WELL_LIT * totals[order].1
    });
    let worst = bright.map(|(_, claim)| claim.seen(m)).reduce(f64::max);
    let verdict = if evidence >= THRESHOLD_LOG10 {
        Verdict::Fail
    } else if mean <= smallest.mean && worst.is_none_or(|worst| worst <= smallest.point) {
        Verdict::Pass
    } else {
        Verdict::Undecided
    };
    let strongest = (0..claims.len()).max_by(|a, b| capitals[*a].total_cmp(&capitals[*b]))?;
    let shown = if verdict == Verdict::Fail { strongest } else { bins.len() };
    let (effect, error) = deviation(&claims[shown]);
    let place = match bins.get(shown).map(|bin| (bin.radii, bin.tile, bin.order)) {
        Some((_, Some([i, j]), order)) => format!("in tile ({i}, {j}), order {order}"),
        Some((Some([from, to]), _, order)) => format!("in the ring from {from:.3} m to {to:.3} m, order {order}"),
        Some((None, _, order)) => format!("on the receiver, order {order}"),
        None => format!("over all of them, order {}", orders[shown - bins.len()]),
    };
    let percent = |x: f64| format!("{:.2} %", 100.0 * x);
    let (whole, part) = match bins.first().map(|bin| (bin.radii, bin.tile)) {
        Some((Some(_), _)) => ("over all rings", "ring"),
        Some((_, Some(_))) => ("over all tiles", "tile"),
        _ => ("on the receiver", "part"),
    };
    let bar = worst.filter(|_| bins.len() > 1);
    let bar = bar.map_or(String::new(), |worst| format!(", {} in the worst bright {part}", percent(worst)));
    let words = match verdict {
        Verdict::Fail => {
            format!("{:+.2} % ± {:.2} % of the flux that is due {place}", 100.0 * effect, 100.0 * Z_95 * error)
        }
        Verdict::Pass => format!("no deviation of the flux above {} {whole}{bar}", percent(mean)),
        Verdict::Undecided => {
            format!("too few rays: a deviation of {} {whole} would have been seen{bar}", percent(mean))
        }
    };
    Some(JudgedProperty {
        property: "caustic",
        verdict,
        evidence,
        threshold: THRESHOLD_LOG10,
        effect,
        effect_low: effect - Z_95 * error,
        effect_high: effect + Z_95 * error,
        smallest_bias_mean: Some(mean),
        smallest_bias_point: worst,
        words,
        note: None,
        reproduce: reproduce.to_owned(),
    })
}

/// Relative deviation of what was found, and its standard error by the stated variance; where nothing is due, of the flux
/// of one group.
fn deviation(claim: &Claim) -> (f64, f64) {
    let n = claim.n.max(1) as f64;
    let mean = 0.5 * (claim.statement.low + claim.statement.high);
    let off = claim.observed.sum / n - mean;
    let error = (claim.statement.variance / n).sqrt();
    if mean > 0.0 { (off / mean, error / mean) } else { (off, error) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::case::shipped_caustics;
    use crate::light::{LightSettings, trace};

    const SMALLEST: SmallestBias = SmallestBias { mean: 1e-2, point: 0.5 };

    fn followed(name: &str) -> (LightRun, Vec<CausticBin>) {
        let case = shipped_caustics().find(|case| case.name() == name).unwrap().read().unwrap();
        let settings = LightSettings { rays: 400_000, ..case.light.clone() };
        let run = trace(&case.configuration, &settings, 11);
        let bins = bins(&run, &CausticLayout::of(&case.configuration).unwrap());
        (run, bins)
    }

    /// What a fault that changes the flux of each packet by a factor would have left.
    fn spoilt(bins: &[CausticBin], factor: impl Fn(&CausticBin) -> f64) -> Vec<CausticBin> {
        let spoil = |bin: &CausticBin| {
            let factor = factor(bin);
            let mut found = Moments::default();
            found.flux += factor * bin.found.watts();
            found.squares = factor * factor * bin.found.squares;
            CausticBin { measured: factor * bin.measured, found, ..bin.clone() }
        };
        bins.iter().map(spoil).collect()
    }

    fn verdict(run: &LightRun, bins: &[CausticBin]) -> Verdict {
        caustic(run, bins, SMALLEST, "").unwrap().verdict
    }

    #[test]
    fn a_second_cosine_is_found() {
        let (run, bins) = followed("caustic/slab");
        assert_ne!(verdict(&run, &bins), Verdict::Fail);
        // The plate moves the image of the lamp up by a sixth of a metre; it stands some 1.33 m over the receiver.
        let slanting = |bin: &CausticBin| {
            let radius = bin.radii.map_or(0.0, |[from, to]| 0.5 * (from + to));
            1.33 / radius.hypot(1.33)
        };
        assert_eq!(verdict(&run, &spoilt(&bins, slanting)), Verdict::Fail);
    }

    #[test]
    fn a_lost_branch_is_found() {
        // Four per cent at each face of glass, taken as let through.
        for name in ["caustic/glass-ball", "caustic/plano-convex"] {
            let (run, bins) = followed(name);
            assert_ne!(verdict(&run, &bins), Verdict::Fail, "{name}");
            assert_eq!(verdict(&run, &spoilt(&bins, |_| 1.0 / 0.96)), Verdict::Fail, "{name}");
        }
    }

    #[test]
    fn flux_that_lands_a_ring_farther_out_is_found() {
        let (run, bins) = followed("caustic/paraboloid");
        assert_ne!(verdict(&run, &bins), Verdict::Fail);
        let mut moved = bins.clone();
        for k in 1..bins.len() {
            (moved[k].found, moved[k].measured) = (bins[k - 1].found, bins[k - 1].measured);
        }
        assert_eq!(verdict(&run, &moved), Verdict::Fail);
    }

    #[test]
    fn books_that_balance_and_are_wrong_fail() {
        for name in ["caustic/glass-ball", "caustic/plano-convex", "caustic/slab", "caustic/spherical-mirror"] {
            let case = shipped_caustics().find(|case| case.name() == name).unwrap().read().unwrap();
            let (run, _) = followed(name);
            let due = deposited_power(&case.configuration, case.light.depth).all.expect("known");
            let sound = row(&run, &case.configuration, Some(due));
            let judged = energy(std::slice::from_ref(&sound), Some(&deposit_claim(&run, due)), "");
            assert_eq!(judged.verdict, Verdict::Pass, "{name}: {}", judged.words);
            // Two per cent booked as deposited that went elsewhere.
            let mut wrong = run.clone();
            let moved = 0.02 * wrong.ledger.deposited;
            wrong.ledger.deposited -= moved;
            wrong.ledger.escaped += moved;
            let judged = energy(std::slice::from_ref(&sound), Some(&deposit_claim(&wrong, due)), "");
            assert_eq!(judged.verdict, Verdict::Fail, "{name}: {}", judged.words);
        }
    }

    #[test]
    fn an_optic_in_the_dark_is_told_of() {
        let case = shipped_caustics().find(|case| case.name() == "caustic/glass-ball").unwrap().read().unwrap();
        let (mut run, _) = followed("caustic/glass-ball");
        assert_eq!(note(&run, &case.configuration), None);
        run.reached = vec![0];
        assert_eq!(note(&run, &case.configuration).as_deref(), Some("no light reaches glass 0"));
    }

    #[test]
    fn books_that_do_not_balance_fail() {
        let case = shipped_caustics().find(|case| case.name() == "caustic/glass-ball").unwrap().read().unwrap();
        let (run, _) = followed("caustic/glass-ball");
        let sound = row(&run, &case.configuration, None);
        assert_eq!(energy(std::slice::from_ref(&sound), None, "").verdict, Verdict::Pass);
        let mut short = run.clone();
        short.ledger.escaped -= 1e-9 * short.ledger.emitted;
        let judged = energy(&[sound, row(&short, &case.configuration, None)], None, "");
        assert_eq!(judged.verdict, Verdict::Fail);
        assert!(judged.words.contains("unaccounted"), "{}", judged.words);
    }
}
