//! From the text of a case file to a valid case, or to all of its mistakes.

use std::ops::Range;
use std::sync::Arc;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::Case;
use super::camera;
use super::error::{CaseError, CaseErrors};
use super::folder::{Folder, Reach};
use super::measure::{self, Ground, Measured};
use super::optics;
use super::schema;
use super::shapes::{self, Files};
use super::texture;
use super::walk::{Log, Node};
use super::{Study, settings};
use crate::configuration::{Configuration, ConfigurationError, Contents, Source};
use crate::geometry::{Shape, Sphere};
use crate::intake::{CASE_BYTES, OPTICS, POINTS_AND_FACES, POINTS_AND_SURFACES, POINTS_BEHIND_OPTICS, SURFACES};
use crate::light::LightSettings;
use crate::radiometry::Exitance;

/// More syntax errors than this are counted, not shown: a file that is not TOML at all has one a line.
const MOST_SYNTAX_ERRORS: usize = 20;

/// A case file before it is read.
pub(super) struct CaseFile<'f> {
    /// As it is named in messages.
    pub(super) path: &'f str,
    /// What selects it on a command line.
    pub(super) selector: &'f str,
    /// The case's name.
    pub(super) name: &'f str,
    /// The folder of the cases, for meshes.
    pub(super) folder: &'f Folder,
    /// The file's path below that folder, with `/`.
    pub(super) below: &'f str,
}

/// The case, or everything that is wrong with it.
pub(super) fn read(file: &CaseFile, bytes: &[u8]) -> Result<Case, CaseErrors> {
    if bytes.len() as u64 > CASE_BYTES {
        return Err(whole_file(file.path, CaseError::TooLarge { limit: CASE_BYTES }));
    }
    let text = String::from_utf8_lossy(bytes);
    let mut log = Log::new(file.path, &text);
    let case = match std::str::from_utf8(bytes) {
        Ok(_) => case(file, &text, &mut log),
        Err(error) => {
            let at = error.valid_up_to();
            log.add(at..at + char::REPLACEMENT_CHARACTER.len_utf8(), CaseError::NotText);
            None
        }
    };
    let mistakes = log.into_mistakes();
    match case {
        Some(case) if mistakes.is_empty() => Ok(case),
        _ => {
            assert!(!mistakes.is_empty(), "{} was refused without a reason", file.path);
            Err(CaseErrors { path: file.path.into(), text: Arc::from(&*text), mistakes })
        }
    }
}

/// A mistake of a file whose text is not at hand.
pub(super) fn whole_file(path: &str, error: CaseError) -> CaseErrors {
    let mut log = Log::new(path, "");
    log.add(0..0, error);
    CaseErrors { path: path.into(), text: Arc::from(""), mistakes: log.into_mistakes() }
}

fn case(file: &CaseFile, text: &str, log: &mut Log) -> Option<Case> {
    let (document, errors) = DeTable::parse_recoverable(text);
    note_syntax(document.get_ref(), errors, log);
    let top = first_span(document.get_ref());
    let root = Node::new(document.get_ref(), &schema::ROOT, top.clone(), log);
    let title = if root.has(&schema::TITLE) { root.text(&schema::TITLE, log) } else { Some(file.name) };

    if is_too_full(&root, log) {
        return None;
    }
    let mut files = Files::new(file.folder, file.below);
    // A missing [source] is told once, as the case without a source that it is.
    let before = log.len();
    let source_role = optional(&root, &schema::SOURCE, &schema::SOURCES, log);
    let lamps = source_role.as_ref().map(|role| optics::lamps(role, log)).unwrap_or_default();
    let sources = source_role.map(|role| shapes::all(&role, &mut files, log)).unwrap_or_default();
    let any_source =
        !sources.is_empty() || !lamps.is_empty() || log.len() > before || root.misspells(&schema::SOURCE);
    let (source_spans, sources): (Vec<_>, Vec<_>) = sources
        .into_iter()
        .filter_map(|(node, shape)| Some((node.span.clone(), source(&node, shape, &mut files, log)?)))
        .unzip();

    let occluder_role = optional(&root, &schema::OCCLUDER, &schema::OCCLUDERS, log);
    let occluders = occluder_role.map(|role| shapes::all(&role, &mut files, log)).unwrap_or_default();
    let (occluder_spans, occluders): (Vec<_>, Vec<_>) =
        occluders.into_iter().filter_map(|(node, shape)| Some((node.span, shape?))).unzip();

    let mirror_role = optional(&root, &schema::MIRROR, &schema::MIRRORS, log);
    let mirrors = mirror_role.map(|role| optics::mirrors(&role, &mut files, log)).unwrap_or_default();
    let glass_role = optional(&root, &schema::GLASS, &schema::GLASSES, log);
    let glass = glass_role.map(|role| optics::glass(&role, log)).unwrap_or_default();
    let diffuse_role = optional(&root, &schema::DIFFUSE, &schema::DIFFUSES, log);
    let diffuse = diffuse_role.map(|role| optics::diffuse(&role, log)).unwrap_or_default();
    let (mirror_spans, mirrors) = mirrors.into_iter().unzip();
    let (glass_spans, glass) = glass.into_iter().unzip();
    let (diffuse_spans, diffuse) = diffuse.into_iter().unzip();

    let receiver_node = optional(&root, &schema::RECEIVER, &schema::RECEIVERS, log);
    let receiver = receiver_node.and_then(|node| measure::receiver(&node, &mut files, log));
    let ground = match &receiver {
        Some(receiver) => Ground::Sound(receiver),
        None if root.has(&schema::RECEIVER) => Ground::Faulty,
        None => Ground::None,
    };
    let measure_node = optional(&root, &schema::MEASURE, &schema::MEASURES, log);
    let measured = match measure_node {
        Some(node) => measure::measure(&node, &ground, log),
        None => {
            Measured { any: root.has(&schema::MEASURE) || root.misspells(&schema::MEASURE), ..Measured::nothing() }
        }
    };

    let study_node = optional(&root, &schema::STUDY, &schema::STUDIES, log);
    let study = study_node.map_or_else(Study::default, |node| settings::study(&node, log));

    let light_node = optional(&root, &schema::LIGHT, &schema::LIGHTS, log);
    let light = light_node.map_or_else(LightSettings::default, |node| settings::light(&node, log));

    let camera_node = optional(&root, &schema::CAMERA, &schema::CAMERAS, log);
    let camera = camera_node.as_ref().and_then(|node| camera::camera(node, log));

    let places = Places {
        root: &root,
        any_source,
        sources: source_spans,
        occluders: occluder_spans,
        mirrors: mirror_spans,
        glass: glass_spans,
        diffuse: diffuse_spans,
    };
    let contents = Contents { sources, lamps, occluders, mirrors, glass, diffuse, receiver, ..Contents::default() };
    let configuration = configuration(&places, contents, measured, log)?;
    #[cfg(feature = "studies")]
    if let (Some(node), Some(camera)) = (&camera_node, &camera) {
        camera::place(node, camera, &configuration, log);
    }
    let selector = file.selector.into();
    let (name, title, reach) = (file.name.into(), title?.into(), Reach::Inside);
    Some(Case { name, selector, reach, title, configuration, study, light, camera })
}

/// Whether there are more shapes than are looked at, which is noted before any of them is read.
fn is_too_full(root: &Node, log: &mut Log) -> bool {
    let optics = [&schema::MIRROR, &schema::GLASS, &schema::DIFFUSE];
    let all = [&schema::SOURCE, &schema::OCCLUDER].into_iter().chain(optics);
    let before = log.len();
    for (what, keys, limit) in [
        ("shapes and lamps", all.collect::<Vec<_>>(), SURFACES),
        ("mirrors, pieces of glass and diffuse surfaces", optics.to_vec(), OPTICS),
    ] {
        let said: u64 = keys.iter().map(|key| root.n_tables(key)).sum();
        if said > limit {
            let most = keys.into_iter().max_by_key(|key| root.n_tables(key)).expect("there are roles");
            log.add(root.span_of(most.name), CaseError::TooMany { what, said: said.into(), limit });
        }
    }
    log.len() > before
}

/// Whether it would take too long to hold every point against every surface, which is noted.
fn is_too_long(places: &Places, contents: &Contents, log: &mut Log) -> bool {
    let Contents { sources, occluders, mirrors, glass, diffuse, points, .. } = contents;
    let surfaces = sources.len() + occluders.len() + mirrors.len() + glass.len() + diffuse.len();
    let faces = |shape: &Shape| match shape {
        Shape::Mesh(mesh) => mesh.triangles().len(),
        Shape::Polygon(polygon) => polygon.vertices().len(),
        _ => 0,
    };
    let faces: usize = sources.iter().map(|source| source.shape()).chain(occluders).map(faces).sum();
    let curved = mirrors.iter().filter(|mirror| mirror.shape().outline().is_none()).count()
        + glass.iter().filter(|glass| glass.shape().outline().is_none()).count();
    let before = log.len();
    for (what, others, limit) in [
        ("pairs of a measurement point and a surface", surfaces as u128, POINTS_AND_SURFACES),
        ("pairs of a measurement point and a triangle or an edge", faces as u128, POINTS_AND_FACES),
        (
            "measurement points, times curved mirrors and pieces of glass, times sources",
            curved as u128 * sources.len() as u128,
            POINTS_BEHIND_OPTICS,
        ),
    ] {
        let said = others * points.len() as u128;
        if said > u128::from(limit) {
            log.add(places.root.span_of(schema::MEASURE.name), CaseError::TooMany { what, said, limit });
        }
    }
    log.len() > before
}

/// A table that may be missing without the reader saying so.
fn optional<'t>(
    root: &Node<'t>,
    key: &schema::Key,
    table: &'static schema::Table,
    log: &mut Log,
) -> Option<Node<'t>> {
    if root.has(key) { root.table(key, table, log) } else { None }
}

fn source(node: &Node, shape: Option<Shape>, files: &mut Files, log: &mut Log) -> Option<Source> {
    if let Some(table) = node.texture(&schema::EXITANCE, log) {
        // Without a shape the table is examined all the same.
        let texture = texture::texture(&table, shape.as_ref().map(texture::Canvas::of_source), files, log);
        let made = Source::textured(shape?, texture?);
        return made.map_err(|error| log.add(table.span.clone(), CaseError::Configuration(error))).ok();
    }
    let exitance = Exitance::new(node.number(&schema::EXITANCE, log)?);
    let sound = shape.is_some();
    // Without a shape the exitance is examined all the same.
    let stand_in = || Shape::Sphere(Sphere::new(glam::DVec3::ZERO, 1.0).expect("a unit ball"));
    match Source::new(shape.unwrap_or_else(stand_in), exitance) {
        Ok(source) => sound.then_some(source),
        Err(error) => {
            log.add(node.span_of(schema::EXITANCE.name), CaseError::Configuration(error));
            None
        }
    }
}

/// Where the parts of a configuration stand in the file.
struct Places<'a, 't> {
    root: &'a Node<'t>,
    /// Whether the file names any source, sound or not.
    any_source: bool,
    sources: Vec<Range<usize>>,
    occluders: Vec<Range<usize>>,
    mirrors: Vec<Range<usize>>,
    glass: Vec<Range<usize>>,
    diffuse: Vec<Range<usize>>,
}

impl Places<'_, '_> {
    /// Where one part stands.
    fn of(&self, role: &str, index: usize) -> Option<&Range<usize>> {
        let spans = match role {
            "source" => &self.sources,
            "occluder" => &self.occluders,
            "mirror" => &self.mirrors,
            "glass" => &self.glass,
            "diffuse" => &self.diffuse,
            _ => return None,
        };
        spans.get(index)
    }
}

fn configuration(
    places: &Places,
    contents: Contents,
    mut measured: Measured,
    log: &mut Log,
) -> Option<Configuration> {
    let points = std::mem::take(&mut measured.points);
    let contents = Contents { points, arrangement: measured.arrangement, ..contents };
    if is_too_long(places, &contents, log) {
        return None;
    }
    let errors = match Configuration::of(contents) {
        Ok(configuration) => return Some(configuration),
        Err(errors) => errors,
    };
    for error in errors {
        let mut also = Vec::new();
        let span = match &error {
            // Faulty sources and points were told; that none is left over is no second mistake.
            ConfigurationError::NoSource if places.any_source => continue,
            ConfigurationError::NothingToMeasure if measured.any => continue,
            ConfigurationError::NoSource => places.root.span_of(schema::SOURCE.name),
            ConfigurationError::NothingToMeasure => places.root.span_of(schema::MEASURE.name),
            ConfigurationError::PointOnSurface { point, role, index, .. } => {
                also.extend(places.of(role, *index).map(|span| (span.clone(), format!("on this {role}"))));
                measured.span_of(*point).unwrap_or_else(|| places.root.span.clone())
            }
            ConfigurationError::GlassOverlap { first, second } => {
                also.extend(places.of("glass", *first).map(|span| (span.clone(), "and this".to_string())));
                places.of("glass", *second).cloned().unwrap_or_else(|| places.root.span.clone())
            }
            ConfigurationError::OutsideEnclosure { role, index } => {
                places.of(role, *index).cloned().unwrap_or_else(|| places.root.span.clone())
            }
            ConfigurationError::CurvedBefore { role, index, point, .. } => {
                also.extend(measured.span_of(*point).map(|span| (span, "measured here".to_string())));
                places.of(role, *index).cloned().unwrap_or_else(|| places.root.span.clone())
            }
            _ => places.root.span.clone(),
        };
        log.add_with(span, CaseError::Configuration(error), also);
    }
    None
}

/// Notes where the text is not TOML. An array that is never closed swallows what follows it, and the parser complains
/// about all of that: told is the bracket alone.
fn note_syntax(document: &DeTable, errors: Vec<toml::de::Error>, log: &mut Log) {
    let mut arrays = Vec::new();
    document.values().for_each(|value| spans_of_arrays(value, &mut arrays));
    let mut found: Vec<(Range<usize>, String)> =
        errors.iter().map(|error| (error.span().unwrap_or(0..0), error.message().to_string())).collect();
    let ends: Vec<usize> =
        found.iter().filter(|(_, said)| said.starts_with("unclosed array")).map(|(span, _)| span.start).collect();
    let open: Vec<Range<usize>> = ends
        .iter()
        .filter_map(|end| arrays.iter().filter(|array| array.end == *end).min_by_key(|array| array.start).cloned())
        .collect();
    found.retain(|(span, _)| !open.iter().any(|array| array.start < span.start && span.start <= array.end));
    found.extend(open.iter().map(|array| {
        (array.start..array.start + 1, "an array opens here and is never closed, expected `]`".to_string())
    }));
    found.sort_by_key(|(span, _)| span.start);
    for (span, said) in found.iter().take(MOST_SYNTAX_ERRORS) {
        log.add_syntax(span.clone(), CaseError::Syntax { said: said.clone() });
    }
    if let Some((span, _)) = found.get(MOST_SYNTAX_ERRORS) {
        log.add_syntax(span.clone(), CaseError::MoreSyntax { more: found.len() - MOST_SYNTAX_ERRORS });
    }
    found.iter().map(|(span, _)| span).chain(&open).for_each(|span| log.mark_broken(span));
}

fn spans_of_arrays(value: &Spanned<DeValue>, spans: &mut Vec<Range<usize>>) {
    match value.get_ref() {
        DeValue::Array(items) => {
            spans.push(value.span());
            items.iter().for_each(|item| spans_of_arrays(item, spans));
        }
        DeValue::Table(table) => table.values().for_each(|value| spans_of_arrays(value, spans)),
        _ => {}
    }
}

/// The first key or header of the file: what is missing altogether is told there.
fn first_span(document: &DeTable) -> Range<usize> {
    let keys = document
        .iter()
        .map(|(key, value)| if value.span().start < key.span().start { value.span() } else { key.span() });
    keys.min_by_key(|span| span.start).unwrap_or(0..0)
}
