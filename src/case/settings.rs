//! Reading how a case is to be studied.

use toml::de::DeValue;

use super::error::CaseError;
use super::schema::{self, Key, MAX_COUNT};
use super::study::{Accepted, PROPERTIES, Replicates, SmallestBias, Study};
use super::walk::{Log, Node};
use crate::geometry::TexelGrid;
use crate::intake::STUDY_ENTRIES;
use crate::light::{Aim, LightSettings, Rings, Split};
use crate::sampling::Strategy;

/// The word for "as many as the smallest bias needs".
const AUTO: &str = "auto";

/// Whatever is not said, or said wrongly, is the default.
pub(super) fn study(node: &Node, log: &mut Log) -> Study {
    let default = Study::default();
    let names = Strategy::ALL.map(Strategy::name);
    let strategies = node.list(&schema::STRATEGIES, log, |node, value, log| {
        node.name_among(&schema::STRATEGIES, value, &names, log).and_then(Strategy::from_name)
    });
    let samples = node
        .list(&schema::SAMPLES, log, |node, value, log| node.count_of(&schema::SAMPLES, value, 1, MAX_COUNT, log));
    let samples = samples.map(|mut samples| {
        samples.sort_unstable();
        samples
    });
    Study {
        strategies: strategies.unwrap_or(default.strategies),
        samples: samples.unwrap_or(default.samples),
        replicates: replicates(node, log).unwrap_or(default.replicates),
        smallest_bias: smallest_bias(node, default.smallest_bias, log),
        tolerance: tolerance(node, log).unwrap_or(default.tolerance),
        accepted: accepted(node, log),
    }
}

/// How light is followed. Whatever is not said, or said wrongly, is the default.
pub(super) fn light(node: &Node, log: &mut Log) -> LightSettings {
    let default = LightSettings::default();
    let within = |key: &Key, least: u64, most: u64, log: &mut Log| {
        if node.has(key) { node.count(key, least, most, log) } else { None }
    };
    let rays = within(&schema::RAYS, 1, LightSettings::MOST_RAYS, log);
    let depth = within(&schema::DEPTH, 0, LightSettings::MOST_DEPTH as u64, log);
    let named = |key: &'static Key, names: &[&'static str], log: &mut Log| {
        node.raw(key).and_then(|value| node.name_among(key, value, names, log))
    };
    let aim = named(&schema::AIM, &Aim::ALL.map(Aim::name), log);
    let split = named(&schema::SPLIT, &Split::ALL.map(Split::name), log);
    LightSettings {
        rays: rays.unwrap_or(default.rays),
        map: pair(node, &schema::TEXELS, "texels", LightSettings::MOST_TEXELS, log).unwrap_or(default.map),
        depth: depth.map_or(default.depth, |depth| depth as usize),
        aim: Aim::ALL.into_iter().find(|known| Some(known.name()) == aim).unwrap_or(default.aim),
        split: Split::ALL.into_iter().find(|known| Some(known.name()) == split).unwrap_or(default.split),
        rings: rings(node, log),
        tiles: pair(node, &schema::TILES, "tiles", Rings::MOST, log).and_then(|[ns, nt]| TexelGrid::new(ns, nt).ok()),
    }
}

/// Fields along s and t, no more than `most` in all.
fn pair(node: &Node, key: &'static Key, what: &'static str, most: usize, log: &mut Log) -> Option<[usize; 2]> {
    let value = node.raw(key)?;
    let items = node.items(key, value, log)?;
    let sides: Vec<_> = items.iter().map(|item| node.count_of(key, item, 1, 1 << 16, log)).collect();
    let [ns, nt] = sides[..] else {
        let key = node.schema.full_name(key.name);
        log.add(value.span(), CaseError::Length { key, what: "numbers", said: sides.len(), expected: 2 });
        return None;
    };
    let (ns, nt) = (ns?, nt?);
    if ns * nt > most as u64 {
        log.add(value.span(), CaseError::TooMany { what, said: (ns * nt).into(), limit: most as u64 });
        return None;
    }
    Some([usize::try_from(ns).ok()?, usize::try_from(nt).ok()?])
}

fn rings(node: &Node, log: &mut Log) -> Option<Rings> {
    if !node.has(&schema::RINGS) {
        return None;
    }
    let table = node.table(&schema::RINGS, &schema::LIGHT_RINGS, log)?;
    let center = table.vector(&schema::CENTER, log);
    let wanted = "a radius is greater than 0 (metres)";
    let radius = number_within(&table, &schema::RING_RADIUS, |said| said > 0.0, wanted, log);
    let count = table.count(&schema::RING_COUNT, 1, Rings::MOST as u64, log);
    Some(Rings { center: center?, radius: radius?, count: count? as usize })
}

fn accepted(node: &Node, log: &mut Log) -> Vec<Accepted> {
    let tables = node.tables(&schema::ACCEPTED, &schema::ACCEPTANCE, log);
    if tables.len() as u64 > STUDY_ENTRIES {
        let (said, limit) = (tables.len() as u128, STUDY_ENTRIES);
        let span = node.span_of(schema::ACCEPTED.name);
        log.add(span, CaseError::TooMany { what: "accepted deviations", said, limit });
        return Vec::new();
    }
    let one = |table: &Node, log: &mut Log| {
        let property =
            table.raw(&schema::PROPERTY).and_then(|v| table.name_among(&schema::PROPERTY, v, &PROPERTIES, log));
        let names = Strategy::ALL.map(Strategy::name);
        let strategy = match table.raw(&schema::OF_STRATEGY) {
            Some(value) => {
                Some(table.name_among(&schema::OF_STRATEGY, value, &names, log).and_then(Strategy::from_name)?)
            }
            None => None,
        };
        let wanted = "a relative deviation greater than 0";
        let size = number_within(table, &schema::SIZE, |said| said > 0.0, wanted, log);
        let reason = table.text(&schema::REASON, log);
        Some(Accepted { property: property?, strategy, size: size?, reason: reason?.to_owned() })
    };
    tables.iter().filter_map(|table| one(table, log)).collect()
}

fn replicates(node: &Node, log: &mut Log) -> Option<Replicates> {
    let key = &schema::REPLICATES;
    let value = node.raw(key)?;
    match value.get_ref() {
        DeValue::String(_) => node.name_among(key, value, &[AUTO], log).map(|_| Replicates::Auto),
        _ => node.count_of(key, value, 2, MAX_COUNT, log).map(Replicates::Fixed),
    }
}

fn smallest_bias(node: &Node, default: SmallestBias, log: &mut Log) -> SmallestBias {
    let Some(table) = node.table(&schema::SMALLEST_BIAS, &schema::BIAS, log) else { return default };
    let relative = |key: &Key, log: &mut Log| {
        let accepted = "a relative bias is greater than 0 and less than 1";
        number_within(&table, key, |said| said > 0.0 && said < 1.0, accepted, log)
    };
    SmallestBias {
        mean: relative(&schema::MEAN, log).unwrap_or(default.mean),
        point: relative(&schema::AT_POINT, log).unwrap_or(default.point),
    }
}

fn tolerance(node: &Node, log: &mut Log) -> Option<f64> {
    let accepted = "a tolerance is relative: 0 or greater, and less than 1";
    number_within(node, &schema::TOLERANCE, |said| (0.0..1.0).contains(&said), accepted, log)
}

fn number_within(
    node: &Node,
    key: &Key,
    within: impl Fn(f64) -> bool,
    accepted: &'static str,
    log: &mut Log,
) -> Option<f64> {
    let said = node.number(key, log)?;
    if within(said) {
        return Some(said);
    }
    let error = CaseError::Number { key: node.schema.full_name(key.name), said, accepted };
    log.add(node.span_of(key.name), error);
    None
}
