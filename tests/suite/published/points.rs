//! The rows of `points.csv`, and the two ways to each.

use etendue::Oracle;
use etendue::oracle::{Method, Region, Truth};

use super::geometry::{occluders, room, the, things};
use super::{Pair, Row};

/// What a point sees of the source.
pub const VIEWS: [&str; 4] = ["lit", "penumbra", "antumbra", "umbra"];

const DISK: &str = "source disk center 0 0 2 normal 0 0 -1 radius 0.5";
const SQUARE: &str = "source rectangle center 0 0 2 edge_u 0 1 0 edge_v 1 0 0";
const BALL: &str = "source sphere center 0 0 4 radius 1";
const TILTED_DISK: &str = "source disk center 0.25 0.125 2 normal 1 0 -2 radius 0.5";
const TILTED_SQUARE: &str = "source rectangle center 0.25 0.125 2 edge_u 0 1 0 edge_v 0.75 0 0.25";

const SMALL_DISK: &str = "occluder disk center 0 0 1 normal 0 0 1 radius 0.125";
const MEDIUM_DISK: &str = "occluder disk center 0 0 1 normal 0 0 1 radius 0.25";
const LARGE_DISK: &str = "occluder disk center 0 0 1 normal 0 0 1 radius 0.375";
const LEANING_DISK: &str = "occluder disk center 0.125 0 1 normal 1 2 2 radius 0.25";

const SMALL_SQUARE: &str = "occluder rectangle center 0 0 1 edge_u 0.25 0 0 edge_v 0 0.25 0";
const MEDIUM_SQUARE: &str = "occluder rectangle center 0 0 1 edge_u 0.5 0 0 edge_v 0 0.5 0";
const LARGE_SQUARE: &str = "occluder rectangle center 0 0 1 edge_u 0.75 0 0 edge_v 0 0.75 0";
const TURNED_SQUARE: &str = "occluder rectangle center 0 0 1 edge_u 0.25 0.25 0 edge_v -0.25 0.25 0";
const LEANING_SQUARE: &str = "occluder rectangle center 0.125 0 1 edge_u 0.375 0.25 0.125 edge_v -0.25 0.375 0";

const SMALL_BALL: &str = "occluder sphere center 0 0 2 radius 0.25";
const MEDIUM_BALL: &str = "occluder sphere center 0 0 2 radius 0.5";
const LARGE_BALL: &str = "occluder sphere center 0 0 2 radius 0.75";

/// Position and normal of the receiving element.
type At = &'static str;

/// A family's name, and of each row: what is seen, what is special, source, occluder, receiving element.
type Family = (&'static str, &'static [(&'static str, &'static str, &'static str, &'static str, At)]);

const FAMILIES: [Family; 5] = [
    (
        "disk-behind-disk",
        &[
            ("lit", "level", DISK, MEDIUM_DISK, "1.5 0 0 normal 0 0 1"),
            ("penumbra", "shallow", DISK, MEDIUM_DISK, "0.96875 0 0 normal 0 0 1"),
            ("penumbra", "half", DISK, MEDIUM_DISK, "0.5 0.25 0 normal 0 0 1"),
            ("penumbra", "touching-within", DISK, LARGE_DISK, "0.375 0 0 normal 0 0 1"),
            ("penumbra", "deep", DISK, LARGE_DISK, "0.265625 0 0 normal 0 0 1"),
            ("penumbra", "deepest", DISK, LARGE_DISK, "0.2509765625 0 0 normal 0 0 1"),
            ("penumbra", "tilted-receiver", DISK, MEDIUM_DISK, "0.5 0.25 0 normal 0 3 4"),
            ("penumbra", "all-tilted", TILTED_DISK, LEANING_DISK, "0.25 -0.125 0 normal 1 -2 4"),
            ("penumbra", "horizon", DISK, MEDIUM_DISK, "0.25 0 0 normal 6 0 1"),
            ("antumbra", "centred", DISK, SMALL_DISK, "0 0 0 normal 0 0 1"),
            ("antumbra", "off-centre", DISK, SMALL_DISK, "0.125 0.0625 0 normal 0 0 1"),
            ("antumbra", "tilted-receiver", DISK, SMALL_DISK, "0.125 0.0625 0 normal 3 0 4"),
            ("umbra", "level", DISK, LARGE_DISK, "0.125 0.125 0 normal 0 0 1"),
        ],
    ),
    (
        "square-behind-disk",
        &[
            ("lit", "level", SQUARE, MEDIUM_DISK, "1.5 0 0 normal 0 0 1"),
            ("penumbra", "shallow", SQUARE, MEDIUM_DISK, "0.96875 0 0 normal 0 0 1"),
            ("penumbra", "half", SQUARE, MEDIUM_DISK, "0.5 0.25 0 normal 0 0 1"),
            (
                "penumbra",
                "four-corners",
                SQUARE,
                "occluder disk center 0 0 1 normal 0 0 1 radius 0.3125",
                "0 0 0 normal 0 0 1",
            ),
            ("penumbra", "deep", SQUARE, LARGE_DISK, "0.0625 0.0625 0 normal 0 0 1"),
            ("penumbra", "deepest", SQUARE, LARGE_DISK, "0.03125 0.03125 0 normal 0 0 1"),
            ("penumbra", "tilted-receiver", SQUARE, MEDIUM_DISK, "0.5 0.25 0 normal 0 3 4"),
            ("penumbra", "all-tilted", TILTED_SQUARE, LEANING_DISK, "0.25 -0.125 0 normal 1 -2 4"),
            ("penumbra", "horizon", SQUARE, MEDIUM_DISK, "0.25 0 0 normal 6 0 1"),
            ("antumbra", "centred", SQUARE, SMALL_DISK, "0 0 0 normal 0 0 1"),
            ("antumbra", "tilted-receiver", SQUARE, SMALL_DISK, "0.125 0.0625 0 normal 3 0 4"),
            ("umbra", "level", SQUARE, LARGE_DISK, "0.03125 0 0 normal 0 0 1"),
        ],
    ),
    (
        "disk-behind-square",
        &[
            ("lit", "level", DISK, MEDIUM_SQUARE, "1.5 0 0 normal 0 0 1"),
            ("penumbra", "shallow", DISK, MEDIUM_SQUARE, "0.96875 0 0 normal 0 0 1"),
            ("penumbra", "half", DISK, MEDIUM_SQUARE, "0.5 0.25 0 normal 0 0 1"),
            ("penumbra", "turned", DISK, TURNED_SQUARE, "0.5 0.25 0 normal 0 0 1"),
            ("penumbra", "deep", DISK, LARGE_SQUARE, "0.28125 0.125 0 normal 0 0 1"),
            ("penumbra", "deepest", DISK, LARGE_SQUARE, "0.2509765625 0 0 normal 0 0 1"),
            ("penumbra", "tilted-receiver", DISK, MEDIUM_SQUARE, "0.5 0.25 0 normal 0 3 4"),
            ("penumbra", "all-tilted", TILTED_DISK, LEANING_SQUARE, "0.25 -0.125 0 normal 1 -2 4"),
            ("penumbra", "horizon", DISK, MEDIUM_SQUARE, "0.25 0 0 normal 6 0 1"),
            ("antumbra", "centred", DISK, SMALL_SQUARE, "0 0 0 normal 0 0 1"),
            ("antumbra", "tilted-receiver", DISK, SMALL_SQUARE, "0.125 0.0625 0 normal 3 0 4"),
            ("umbra", "level", DISK, LARGE_SQUARE, "0.125 0.125 0 normal 0 0 1"),
        ],
    ),
    (
        "square-behind-square",
        &[
            ("lit", "level", SQUARE, MEDIUM_SQUARE, "1.5 0 0 normal 0 0 1"),
            ("penumbra", "shallow", SQUARE, MEDIUM_SQUARE, "0.96875 0 0 normal 0 0 1"),
            ("penumbra", "half", SQUARE, MEDIUM_SQUARE, "0.5 0.25 0 normal 0 0 1"),
            ("penumbra", "turned", SQUARE, TURNED_SQUARE, "0.5 0.25 0 normal 0 0 1"),
            ("penumbra", "deep", SQUARE, LARGE_SQUARE, "0.265625 0 0 normal 0 0 1"),
            ("penumbra", "deepest", SQUARE, LARGE_SQUARE, "0.2509765625 0.2509765625 0 normal 0 0 1"),
            ("penumbra", "tilted-receiver", SQUARE, MEDIUM_SQUARE, "0.5 0.25 0 normal 0 3 4"),
            ("penumbra", "all-tilted", TILTED_SQUARE, LEANING_SQUARE, "0.25 -0.125 0 normal 1 -2 4"),
            ("penumbra", "horizon", SQUARE, MEDIUM_SQUARE, "0.25 0 0 normal 6 0 1"),
            ("antumbra", "centred", SQUARE, SMALL_SQUARE, "0 0 0 normal 0 0 1"),
            ("antumbra", "tilted-receiver", SQUARE, SMALL_SQUARE, "0.125 0.0625 0 normal 3 0 4"),
            ("umbra", "level", SQUARE, LARGE_SQUARE, "0.125 0.125 0 normal 0 0 1"),
        ],
    ),
    (
        "sphere-behind-sphere",
        &[
            ("lit", "level", BALL, MEDIUM_BALL, "4 0 0 normal 0 0 1"),
            ("penumbra", "shallow", BALL, MEDIUM_BALL, "3 0 0 normal 0 0 1"),
            ("penumbra", "half", BALL, MEDIUM_BALL, "1 0.5 0 normal 0 0 1"),
            ("penumbra", "deep", BALL, LARGE_BALL, "0.5625 0 0 normal 0 0 1"),
            ("penumbra", "deepest", BALL, LARGE_BALL, "0.515625 0 0 normal 0 0 1"),
            ("penumbra", "tilted-receiver", BALL, MEDIUM_BALL, "1 0.5 0 normal 0 3 4"),
            ("penumbra", "horizon", BALL, MEDIUM_BALL, "0.5 0 0 normal 6 0 1"),
            ("antumbra", "centred", BALL, SMALL_BALL, "0 0 0 normal 0 0 1"),
            ("antumbra", "off-centre", BALL, SMALL_BALL, "0.25 0 0 normal 0 0 1"),
            ("antumbra", "tilted-receiver", BALL, SMALL_BALL, "0.25 0 0 normal 3 0 4"),
            ("umbra", "level", BALL, LARGE_BALL, "0.25 0 0 normal 0 0 1"),
        ],
    ),
];

const WAYS: &str = "contour; strips";

/// Every row, computed both ways.
pub fn rows() -> Vec<Row> {
    let rows = FAMILIES.iter().flat_map(|(family, rows)| rows.iter().map(move |row| (family, row)));
    rows.map(|(family, (view, special, source, occluder, at))| {
        let id = format!("{family}-{view}-{special}");
        row(id, view, format!("{source}; {occluder}; point position {at}"))
    })
    .collect()
}

fn row(id: String, view: &str, geometry: String) -> Row {
    let things = things(&geometry);
    let point = the(&things, "point").point();
    let oracle = Oracle::new(&room(the(&things, "source").shape(), occluders(&things), point));
    let (closed, strips) = (oracle.at(&point), oracle.by_quadrature(&point));
    assert_eq!((closed.method, strips.method), (Method::ClosedForm, Method::Quadrature), "{id}");
    let region = match view {
        "lit" => Region::Lit,
        "umbra" => Region::Umbra,
        _ => Region::Penumbra,
    };
    assert!(VIEWS.contains(&view), "{id}");
    assert_eq!((closed.region, strips.region), (region, region), "{id}");
    let seen = |truth: &Truth| truth.form_factor.ratio();
    let whole = |truth: &Truth| truth.unoccluded_irradiance.watts_per_square_metre();
    let bound = |truth: &Truth| truth.bound.watts_per_square_metre();
    let (apart, allowed) = ((seen(&closed) - seen(&strips)).abs(), bound(&closed) + bound(&strips));
    assert!(apart <= allowed, "{id}: {apart:e} apart, bounds {allowed:e}");
    let (unobstructed, obstructed) = (Pair([whole(&closed), whole(&strips)]), Pair([seen(&closed), seen(&strips)]));
    Row { id, view: Some(view.to_owned()), geometry, unobstructed, obstructed, ways: WAYS.to_owned() }
}
