//! Reading case files: every mistake is found, told where it stands, and told together with all others.

use std::path::Path;

use etendue::case::{
    Case, CaseError, CaseErrors, Ink, MeshFileFault, Mistake, Reach, Replicates, SelectError, Study, obj::ObjError,
    select, select_reaching, shipped, shipped_direct,
};
use etendue::configuration::{Arrangement, ConfigurationError, GlassShape, Mirror, MirrorShape};
use etendue::geometry::{DVec3, Shape, ShapeError};
use etendue::light::{Aim, LightSettings, Rings, Split};
use etendue::sampling;
use proptest::prelude::*;

/// A sound case that the tests break in one place or more.
const SOUND: &str = r#"title = "sound"
[[source.disk]]
center = [0.0, 0.0, 2.0]
normal = [0.0, 0.0, -1.0]
radius = 0.5
exitance = 1.0
[[source.rectangle]]
center = [1.0, 0.0, 2.0]
edge_u = [0.4, 0.0, 0.0]
edge_v = [0.0, -0.4, 0.0]
exitance = 2
[[occluder.polygon]]
vertices = [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [1.0, 1.0, 1.0], [0.0, 1.0, 1.0]]
[receiver]
albedo = 0.5
[receiver.rectangle]
center = [0.0, 0.0, 0.0]
edge_u = [4.0, 0.0, 0.0]
edge_v = [0.0, 4.0, 0.0]
[measure]
line = { from = [0.0, 0.0, 0.0], to = [1.5, 0.0, 0.0], points = 5 }
[study]
strategies = ["stratified", "random"]
samples = [16, 4]
replicates = 8
smallest_bias = { mean = 0.02 }
tolerance = 1e-5
"#;

fn mistakes(text: &str) -> CaseErrors {
    Case::from_toml("test.toml", text).expect_err("a faulty case")
}

/// The sound case with one text replaced, and its only mistake.
fn broken(from: &str, to: &str) -> Mistake {
    assert_eq!(SOUND.matches(from).count(), 1, "{from} stands there once");
    let found = mistakes(&SOUND.replace(from, to));
    assert_eq!(found.mistakes().len(), 1, "{found}");
    found.mistakes()[0].clone()
}

/// Line, column and error.
fn told(mistake: &Mistake) -> (usize, usize, &CaseError) {
    assert_eq!(mistake.path(), "test.toml");
    (mistake.line(), mistake.column(), &mistake.error)
}

#[test]
fn a_sound_case_says_what_it_says() {
    let case = Case::from_toml("a/b", SOUND).unwrap_or_else(|mistakes| panic!("{mistakes}"));
    assert_eq!((case.name.as_str(), case.title.as_str()), ("a/b", "sound"));
    let configuration = &case.configuration;
    assert_eq!(configuration.sources().len(), 2);
    assert_eq!(configuration.sources()[1].exitance().watts_per_square_metre(), 2.0, "an integer is a number");
    assert!(matches!(configuration.occluders(), [Shape::Polygon(_)]));
    assert_eq!(configuration.albedo().map(|albedo| albedo.ratio()), Some(0.5));
    assert_eq!((configuration.points().len(), configuration.arrangement()), (5, Arrangement::Line));
    assert_eq!(case.study.strategies, [sampling::Strategy::Stratified, sampling::Strategy::Random]);
    assert_eq!(case.study.samples, [4, 16], "ascending");
    assert_eq!(case.study.replicates, Replicates::Fixed(8));
    assert_eq!((case.study.smallest_bias.mean, case.study.smallest_bias.point), (0.02, 0.1));
    assert_eq!(case.study.tolerance, 1e-5);
}

#[test]
fn what_is_left_out_has_its_default() {
    let (sound, _) = SOUND.split_once("[study]").unwrap();
    let case = Case::from_toml("a", &sound.replace("title = \"sound\"\n", "").replace("albedo = 0.5\n", "")).unwrap();
    assert_eq!((case.title.as_str(), case.study), ("a", Study::default()));
    assert_eq!(case.configuration.albedo(), None);
}

#[test]
fn shapes_keep_the_order_of_the_file() {
    let mut text = String::new();
    for (i, shape) in ["sphere", "disk", "sphere", "disk"].iter().enumerate() {
        let normal = if *shape == "disk" { "normal = [0, 0, -1]\n" } else { "" };
        text += &format!("[[source.{shape}]]\ncenter = [{i}, 0, 9]\n{normal}radius = 0.1\nexitance = {i}\n");
    }
    text += "[measure.point]\nposition = [0, 0, 0]\nnormal = [0, 0, 1]\n";
    let case = Case::from_toml("a", &text).unwrap();
    let exitances = case.configuration.sources().iter().map(|source| source.exitance().watts_per_square_metre());
    assert_eq!(exitances.collect::<Vec<_>>(), [0.0, 1.0, 2.0, 3.0]);
    assert_eq!(case.configuration.arrangement(), Arrangement::Scattered);
}

#[test]
fn line_grid_and_points_follow_one_another() {
    let more = "grid = [3, 2]\n[[measure.point]]\nposition = [9.0, 0.0, 0.0]\nnormal = [1.0, 0.0, 0.0]\n[study]";
    let case = Case::from_toml("a", &SOUND.replace("[study]", more)).unwrap();
    assert_eq!(case.configuration.points().len(), 5 + 6 + 1);
    assert_eq!(case.configuration.points()[11].position().x, 9.0);
    assert_eq!(case.configuration.arrangement(), Arrangement::Scattered);
    let grid = SOUND.lines().map(|line| if line.starts_with("line") { "grid = [3, 2]" } else { line });
    let case = Case::from_toml("a", &grid.collect::<Vec<_>>().join("\n")).unwrap();
    assert_eq!(case.configuration.arrangement(), Arrangement::Grid { nu: 3, nv: 2 });
}

#[test]
fn a_misspelt_key_is_told_with_the_nearest_one() {
    let mistake = broken("radius = 0.5", "raduis = 0.5");
    let CaseError::UnknownKey { said, accepted, nearest, .. } = &mistake.error else { panic!("{mistake}") };
    assert_eq!((said.as_str(), *nearest), ("raduis", Some("radius")));
    assert_eq!(accepted, &["center", "normal", "radius", "exitance"]);
    assert_eq!((mistake.line(), mistake.column(), mistake.span().len()), (5, 1, 6));
    for (from, to, nearest, line, column) in [
        ("[[source.disk]]", "[[source.disc]]", "disk", 2, 10),
        ("[[occluder.polygon]]", "[[ocluder.polygon]]", "occluder", 12, 3),
        ("[receiver.rectangle]", "[receiver.rectangel]", "rectangle", 16, 11),
        ("[measure]", "[mesure]", "measure", 20, 2),
        ("points = 5", "point = 5", "points", 21, 56),
        ("[study]", "[Study]", "study", 22, 2),
        ("tolerance =", "tolerence =", "tolerance", 27, 1),
        ("mean =", "maen =", "mean", 26, 19),
    ] {
        let found = mistakes(&SOUND.replace(from, to));
        let mistake = &found.mistakes()[0];
        assert_eq!(
            (mistake.error.nearest(), mistake.line(), mistake.column()),
            (Some(nearest), line, column),
            "{found}"
        );
    }
}

#[test]
fn a_missing_key_is_told_at_its_table() {
    let mistake = broken("radius = 0.5\n", "");
    let CaseError::MissingKey { table, key, expected } = &mistake.error else { panic!("{mistake}") };
    assert_eq!((table.as_str(), *key, expected.as_str()), ("[source.disk]", "radius", "a number (m)"));
    assert_eq!((mistake.line(), mistake.column()), (2, 1));
    for (from, key, line) in [
        ("exitance = 1.0\n", "exitance", 2),
        ("edge_v = [0.0, -0.4, 0.0]\n", "edge_v", 7),
        (", points = 5", "points", 21),
        ("from = [0.0, 0.0, 0.0], ", "from", 21),
    ] {
        let mistake = broken(from, "");
        assert!(matches!(&mistake.error, CaseError::MissingKey { key: missing, .. } if *missing == key), "{mistake}");
        assert_eq!(mistake.line(), line, "{mistake}");
    }
}

#[test]
fn a_wrong_type_is_told_with_what_was_said() {
    for (from, to, said, expected, line, column) in [
        ("radius = 0.5", "radius = \"0.5\"", "a string", "a number", 5, 10),
        ("normal = [0.0, 0.0, -1.0]", "normal = -1", "an integer", "an array of three numbers", 4, 10),
        ("normal = [0.0, 0.0, -1.0]", "normal = [0, true, 1]", "true or false", "a number", 4, 14),
        ("vertices = [[0.0, 0.0, 1.0],", "vertices = [7, ", "an integer", "an array of three numbers", 13, 13),
        ("points = 5", "points = 5.0", "a number with a fraction", "an integer", 21, 65),
        ("title = \"sound\"", "title = 3", "an integer", "a string", 1, 9),
        ("replicates = 8", "replicates = []", "an array", "an integer", 25, 14),
        ("samples = [16, 4]", "samples = 16", "an integer", "an array of integers", 24, 11),
        ("[\"stratified\", \"random\"]", "[1]", "an integer", "a string", 23, 15),
        ("{ mean = 0.02 }", "0.02", "a number with a fraction", "a table", 26, 17),
        (
            "[[source.disk]]",
            "[[source.sphere]]\ncenter=[9,9,9]\nradius=1\nexitance=1979-05-27\n[[source.disk]]",
            "a date or a time",
            "a number",
            5,
            10,
        ),
    ] {
        let mistake = broken(from, to);
        let CaseError::WrongType { said: found, expected: accepted, .. } = &mistake.error else {
            panic!("{mistake}")
        };
        assert_eq!(
            (*found, *accepted, mistake.line(), mistake.column()),
            (said, expected, line, column),
            "{mistake}"
        );
    }
    let found = mistakes("source = 1\nmeasure = [1]\n[occluder]\ndisk = 3");
    let kinds: Vec<_> = found.mistakes().iter().map(|m| (m.line(), m.column(), &m.error)).collect();
    assert!(
        matches!(
            kinds[..],
            [
                (1, 10, CaseError::WrongType { .. }),
                (2, 11, CaseError::WrongType { .. }),
                (4, 8, CaseError::WrongType { .. })
            ]
        ),
        "{found}"
    );
}

#[test]
fn numbers_that_are_none_are_refused() {
    for (number, column) in [("nan", 11), ("inf", 11), ("-inf", 11), ("1e999", 11)] {
        let mistake = broken("center = [1.0, 0.0, 2.0]", &format!("center = [{number}, 0.0, 2.0]"));
        assert!(matches!(mistake.error, CaseError::NotFinite { .. }), "{mistake}");
        assert_eq!((mistake.line(), mistake.column()), (8, column));
    }
    let mistake = broken("radius = 0.5", "radius = 2e30");
    assert_eq!(told(&mistake), (5, 10, &CaseError::TooFar { key: "source.disk.radius".into(), said: 2e30 }));
    let huge = format!("radius = {}", "9".repeat(50));
    assert!(matches!(broken("radius = 0.5", &huge).error, CaseError::TooFar { .. }));
    let sound = SOUND.replace("normal = [0.0, 0.0, -1.0]", "normal = [0.0, 0.0, -1e300]");
    assert!(Case::from_toml("a", &sound).is_ok(), "a direction has no size");
}

#[test]
fn impossible_shapes_are_told_at_the_key_at_fault() {
    for (from, to, line, column, error) in [
        ("radius = 0.5", "radius = -0.3", 5, 10, ShapeError::NotPositive { field: "radius", said: -0.3 }),
        ("radius = 0.5", "radius = 0", 5, 10, ShapeError::NotPositive { field: "radius", said: 0.0 }),
        ("normal = [0.0, 0.0, -1.0]", "normal = [0, 0, 0]", 4, 10, ShapeError::NoDirection { field: "normal" }),
        ("edge_u = [0.4, 0.0, 0.0]", "edge_u = [0, 0, 0]", 9, 10, ShapeError::NoDirection { field: "edge_u" }),
        ("edge_v = [0.0, -0.4, 0.0]", "edge_v = [0, 0, 0]", 10, 10, ShapeError::NoDirection { field: "edge_v" }),
        (
            "edge_v = [0.0, -0.4, 0.0]",
            "edge_v = [0.3, -0.4, 0]",
            10,
            10,
            ShapeError::NotPerpendicular { cosine: 0.6 },
        ),
        (
            "[1.0, 1.0, 1.0], [0.0, 1.0, 1.0]]",
            "[0.1, 1.0, 1.0], [1.0, 1.0, 1.0]]",
            13,
            12,
            ShapeError::SelfCrossing { first: 1, second: 3 },
        ),
        (", [1.0, 1.0, 1.0], [0.0, 1.0, 1.0]]", "]", 13, 12, ShapeError::TooFewVertices { said: 2 }),
        (
            "[1.0, 1.0, 1.0], [0.0, 1.0, 1.0]]",
            "[0.0, 0.0, 1.0]]",
            13,
            12,
            ShapeError::RepeatedVertex { first: 0, second: 2 },
        ),
        ("[1.0, 1.0, 1.0], [0.0, 1.0, 1.0]]", "[2.0, 0.0, 1.0]]", 13, 12, ShapeError::NoArea),
    ] {
        let mistake = broken(from, to);
        let CaseError::Shape { error: found, .. } = &mistake.error else { panic!("{mistake}") };
        match (found, &error) {
            (ShapeError::NotPerpendicular { cosine: a }, ShapeError::NotPerpendicular { cosine: b }) => {
                approx::assert_abs_diff_eq!(a.abs(), b, epsilon = 1e-15);
            }
            _ => assert_eq!(found, &error),
        }
        assert_eq!((mistake.line(), mistake.column()), (line, column), "{mistake}");
    }
    let bent = broken("[1.0, 1.0, 1.0]", "[1.0, 1.0, 1.1]");
    assert!(matches!(bent.error, CaseError::Shape { error: ShapeError::NotPlanar { .. }, .. }), "{bent}");
    let mistake = broken("radius = 0.5", "radius = 1e-31");
    assert!(matches!(mistake.error, CaseError::Area { table: "source.disk", .. }), "{mistake}");
    let short = broken("center = [1.0, 0.0, 2.0]", "center = [1.0, 2.0]");
    assert!(matches!(short.error, CaseError::Length { said: 2, expected: 3, .. }), "{short}");
    assert_eq!((short.line(), short.column()), (8, 10));
}

#[test]
fn every_mistake_of_one_shape_is_told() {
    let text = SOUND
        .replace("center = [0.0, 0.0, 2.0]", "center = [nan, inf, 2.0]")
        .replace("normal = [0.0, 0.0, -1.0]", "normal = [0, 0, 0]")
        .replace("radius = 0.5", "radius = -1")
        .replace("exitance = 1.0", "exitance = -5")
        .replace("edge_u = [0.4, 0.0, 0.0]", "edge_u = [0, 0, 0]")
        .replace("edge_v = [0.0, -0.4, 0.0]", "edge_v = [0, 0, 0]");
    let found = mistakes(&text);
    let places: Vec<_> = found.mistakes().iter().map(|m| (m.line(), m.column())).collect();
    assert_eq!(places, [(3, 11), (3, 16), (4, 10), (5, 10), (6, 12), (9, 10), (10, 10)], "{found}");
}

#[test]
fn light_that_cannot_be_is_refused() {
    let mistake = broken("exitance = 2", "exitance = -2");
    let error = CaseError::Configuration(ConfigurationError::Exitance { said: -2.0 });
    assert_eq!(told(&mistake), (11, 12, &error));
    for albedo in [1.5, -0.1] {
        let mistake = broken("albedo = 0.5", &format!("albedo = {albedo}"));
        let error = CaseError::Configuration(ConfigurationError::Albedo { said: albedo });
        assert_eq!(told(&mistake), (15, 10, &error));
    }
}

#[test]
fn a_case_needs_a_source_and_something_to_measure() {
    let point = "[[measure.point]]\nposition = [0, 0, 0]\nnormal = [0, 0, 1]\n";
    let found = mistakes(point);
    let error = CaseError::Configuration(ConfigurationError::NoSource);
    assert_eq!(found.mistakes().iter().map(|m| &m.error).collect::<Vec<_>>(), [&error]);
    let (sound, _) = SOUND.split_once("line =").unwrap();
    let found = mistakes(sound);
    let error = CaseError::Configuration(ConfigurationError::NothingToMeasure);
    assert_eq!(found.mistakes().len(), 1);
    assert_eq!(told(&found.mistakes()[0]), (20, 1, &error));
    let nothing = mistakes("");
    assert_eq!(nothing.mistakes().len(), 2, "{nothing}");
    let empty = mistakes("[source]\ndisk = []\n[measure]\npoint = []\n");
    assert_eq!(empty.mistakes().len(), 2, "{empty}");
}

#[test]
fn a_receiver_has_one_shape() {
    let found =
        mistakes(&SOUND.replace("[measure]", "[receiver.disk]\ncenter=[0,0,0]\nnormal=[0,0,1]\nradius=1\n[measure]"));
    assert_eq!(told(&found.mistakes()[0]), (20, 1, &CaseError::SecondReceiverShape { said: "disk" }));
    let none = mistakes(
        "[source.sphere]\ncenter=[0,0,2]\nradius=1\nexitance=1\n[receiver]\nalbedo=2\n[measure]\ngrid=[2,2]",
    );
    let errors: Vec<_> = none.mistakes().iter().map(|m| (m.line(), &m.error)).collect();
    assert!(
        matches!(
            errors[..],
            [
                (5, CaseError::NoReceiverShape { .. }),
                (6, CaseError::Configuration(ConfigurationError::Albedo { .. }))
            ]
        ),
        "{none}"
    );
    let four = "[receiver.triangle]\nvertices = [[0,0,0],[1,0,0],[1,1,0],[0,1,0]]\n";
    let found = mistakes(four);
    assert!(matches!(found.mistakes()[0].error, CaseError::Configuration(_)), "no source: {found}");
    assert!(
        matches!(found.mistakes().last().unwrap().error, CaseError::Length { said: 4, expected: 3, .. }),
        "{found}"
    );
}

#[test]
fn lines_and_grids_lie_on_a_receiver() {
    let source = "[source.sphere]\ncenter=[0,0,2]\nradius=1\nexitance=1\n";
    let found =
        mistakes(&format!("{source}[measure]\ngrid = [2, 2]\nline = {{ from = [0,0,0], to = [1,0,0], points = 3 }}"));
    let errors: Vec<_> = found.mistakes().iter().map(told).collect();
    let (grid, line) = (CaseError::NoReceiver { key: "grid" }, CaseError::NoReceiver { key: "line" });
    assert_eq!(errors, [(6, 8, &grid), (7, 8, &line)]);
    let off = broken("to = [1.5, 0.0, 0.0]", "to = [2.5, 0.0, 0.0]");
    let error = ConfigurationError::OffReceiver { end: "to", distance: 0.5 };
    assert_eq!(told(&off), (21, 39, &CaseError::Configuration(error)));
    let both = mistakes(&SOUND.replace("from = [0.0, 0.0, 0.0], to = [1.5", "from = [0.0, 0.0, 0.1], to = [2.5"));
    assert_eq!(both.mistakes().len(), 2, "{both}");
    let point = broken("to = [1.5, 0.0, 0.0]", "to = [0.0, 0.0, 0.0]");
    assert_eq!(told(&point), (21, 8, &CaseError::LineWithoutLength));
    let few = broken("points = 5", "points = 1");
    assert!(matches!(few.error, CaseError::Count { least: 2, .. }), "{few}");
    let arc = "[receiver.sphere]\ncenter=[0,0,0]\nradius=1\n[measure]\nline = { from = [0,0,1], to = [0,0,-1], points = 3 }\n";
    let found = mistakes(&format!("[source.sphere]\ncenter=[0,0,9]\nradius=1\nexitance=1\n{arc}"));
    assert_eq!(found.mistakes()[0].error, CaseError::Configuration(ConfigurationError::AmbiguousArc));
    assert_eq!((found.mistakes()[0].line(), found.mistakes().len()), (9, 1));
}

#[test]
fn more_points_than_memory_holds_are_refused() {
    let grid = SOUND.replace("[study]", "grid = [4096, 4096]\n[study]");
    let found = mistakes(&grid);
    let error = CaseError::TooMany { what: "measurement points", said: (1 << 24) + 5, limit: 1 << 20 };
    assert_eq!(found.mistakes().iter().map(told).collect::<Vec<_>>(), [(22, 8, &error)]);
    assert!(error.to_string().contains("memory"), "{error}");
    let mistake = broken("points = 5", "points = 99999999999999999999");
    assert!(matches!(&mistake.error, CaseError::Count { said, .. } if said == "99999999999999999999"), "{mistake}");
    for bad in ["[0, 4]", "[4, -1]", "[4, 999999999999]"] {
        let found = mistakes(&SOUND.replace("[study]", &format!("grid = {bad}\n[study]")));
        assert!(matches!(found.mistakes()[0].error, CaseError::Count { least: 1, .. }), "{found}");
    }
    let three = mistakes(&SOUND.replace("[study]", "grid = [4, 4, 4]\n[study]"));
    assert!(matches!(three.mistakes()[0].error, CaseError::Length { said: 3, expected: 2, .. }), "{three}");
    let long = SOUND.replace("[[0.0, 0.0, 1.0],", &format!("[{}", "[0.0, 0.0, 1.0],".repeat(10_001)));
    let found = mistakes(&long);
    assert!(matches!(found.mistakes()[0].error, CaseError::TooMany { what: "vertices", .. }));
}

#[test]
fn a_point_exactly_on_a_surface_is_refused() {
    let occluder = "[[occluder.disk]]\ncenter = [1.5, 0.0, 0.0]\nnormal = [1.0, 0.0, 0.0]\nradius = 0.1\n[receiver]";
    let found = mistakes(&SOUND.replace("[receiver]\n", &format!("{occluder}\n")));
    let error = CaseError::Configuration(ConfigurationError::PointOnSurface {
        point: 4,
        others: 0,
        role: "occluder",
        index: 1,
        kind: "disk",
    });
    let [mistake] = found.mistakes() else { panic!("{found}") };
    assert_eq!(told(mistake), (25, 8, &error));
    assert_eq!(mistake.also.len(), 1, "the occluder is pointed at too");
    let source = "[[measure.point]]\nposition = [0.1, 0.0, 2.0]\nnormal = [0.0, 0.0, 1.0]\n[study]";
    let found = mistakes(&SOUND.replace("[study]", source));
    let [mistake] = found.mistakes() else { panic!("{found}") };
    assert!(matches!(
        mistake.error,
        CaseError::Configuration(ConfigurationError::PointOnSurface { point: 5, role: "source", index: 0, .. })
    ));
    assert_eq!((mistake.line(), mistake.column()), (23, 12));
}

#[test]
fn settings_that_make_no_sense_are_refused() {
    let zero = broken("samples = [16, 4]", "samples = [16, 0]");
    assert!(matches!(&zero.error, CaseError::Count { said, least: 1, .. } if said == "0"), "{zero}");
    assert_eq!((zero.line(), zero.column()), (24, 16));
    let once = broken("replicates = 8", "replicates = 1");
    assert!(matches!(once.error, CaseError::Count { least: 2, .. }), "{once}");
    let auto = broken("replicates = 8", "replicates = \"atuo\"");
    assert_eq!(auto.error.nearest(), Some("auto"));
    let strategy = broken("\"stratified\"", "\"stratifed\"");
    let CaseError::UnknownName { said, nearest, accepted, .. } = &strategy.error else { panic!("{strategy}") };
    assert_eq!(
        (said.as_str(), *nearest, accepted.len()),
        ("stratifed", Some("stratified"), sampling::Strategy::ALL.len())
    );
    assert_eq!((strategy.line(), strategy.column()), (23, 15));
    let twice = broken("\"stratified\"", "\"random\"");
    assert_eq!(told(&twice), (23, 25, &CaseError::Twice { key: "study.strategies".into(), said: "random".into() }));
    let empty = broken("[\"stratified\", \"random\"]", "[]");
    assert_eq!(told(&empty), (23, 14, &CaseError::Empty { key: "study.strategies".into() }));
    for (from, to) in
        [("mean = 0.02", "mean = 0"), ("mean = 0.02", "point = 1.0"), ("1e-5", "-1e-5"), ("1e-5", "1.0")]
    {
        let mistake = broken(from, to);
        assert!(matches!(mistake.error, CaseError::Number { .. }), "{mistake}");
    }
}

#[test]
fn what_later_versions_will_read_is_named() {
    let found = mistakes(&format!("[[source.mesh]]\nfile=\"a.obj\"\n{SOUND}").replace("title = \"sound\"\n", ""));
    let [mistake] = found.mistakes() else { panic!("{found}") };
    assert_eq!(told(mistake), (1, 10, &CaseError::NotYet { key: "source.mesh".into() }));
    assert!(mistake.error.to_string().ends_with("is not supported by this version yet"));
}

/// A texture in the place of the rectangle's exitance.
fn broken_texture(keys: &str) -> Mistake {
    broken("exitance = 2", &format!("exitance = {{ {keys} }}"))
}

#[test]
fn textures_are_read() {
    let checker = "exitance = { checker = [4, 2], white = 3.0, black = 1.0, lookup = \"bilinear\" }";
    let case = Case::from_toml("a", &SOUND.replace("exitance = 2", checker)).unwrap();
    let source = &case.configuration.sources()[1];
    let texture = source.texture().expect("a texture");
    assert_eq!(texture.range(), [1.0, 3.0]);
    assert_eq!(source.exitance().watts_per_square_metre(), 2.0, "the mean");
    assert_eq!(texture.integral(), 2.0 * source.shape().area());
    let plain = Case::from_toml("a", SOUND).unwrap();
    assert_ne!(case.configuration.digest(), plain.configuration.digest());
    let other = Case::from_toml("a", &SOUND.replace("exitance = 2", &checker.replace("[4, 2]", "[2, 4]"))).unwrap();
    assert_ne!(case.configuration.digest(), other.configuration.digest());
    let albedo = SOUND.replace("albedo = 0.5", "albedo = { checker = [2, 1], white = 0.75, black = 0.25 }");
    let case = Case::from_toml("a", &albedo).unwrap();
    let albedos: Vec<f64> = case.configuration.albedos().unwrap().iter().map(|albedo| albedo.ratio()).collect();
    assert_eq!(albedos, [0.25; 5], "the line runs over the right half");
    let hill = "exitance = { polynomial = [2.0, 0.0, 0.0, -1.0, 0.0, -1.0] }";
    let case = Case::from_toml("a", &SOUND.replace("exitance = 2", hill)).unwrap();
    let mean = case.configuration.sources()[1].exitance().watts_per_square_metre();
    approx::assert_relative_eq!(mean, 2.0 - 2.0 * 0.16 / 12.0, max_relative = 1e-15);
}

#[test]
fn a_texture_that_cannot_be_is_told() {
    let error = |keys: &str| broken_texture(keys).error;
    let said = |keys: &str| error(keys).to_string();
    assert!(matches!(error("white = 1.0"), CaseError::NoTexture { .. }));
    let two = error("checker = [2, 2], polynomial = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]");
    assert!(matches!(two, CaseError::TwoTextures { first: "checker", second: "polynomial", .. }), "{two}");
    assert!(matches!(error("checker = [0, 2]"), CaseError::Count { .. }));
    assert!(matches!(error("checker = [2]"), CaseError::Length { .. }));
    assert!(matches!(error("checker = [60000, 60000]"), CaseError::TooMany { what: "texels", .. }));
    assert!(matches!(error("checker = [2, 2], white = -1.0"), CaseError::Number { said: -1.0, .. }));
    assert!(matches!(error("checker = [2, 2], white = inf"), CaseError::NotFinite { .. }));
    assert!(said("checker = [2, 2], white = 0.0").contains("every texel of the surface is zero"));
    let north = error("checker = [2, 2], north = [0, 0, 1]");
    assert!(matches!(north, CaseError::ForeignKey { accepted: "spheres", shape: "rectangle", .. }), "{north}");
    assert_eq!(broken_texture("cheker = [2, 2]").error.nearest(), Some("checker"));
    assert!(matches!(error("checker = [2, 2], lookup = \"cubic\""), CaseError::UnknownName { .. }));
    assert!(said("polynomial = [1.0, 9.0, 0.0, 0.0, 0.0, 0.0]").contains("falls to -0.8"));
    assert!(matches!(error("polynomial = [1.0, 9.0]"), CaseError::Length { expected: 6, .. }));
    assert!(matches!(error("image = \"a.png\""), CaseError::MissingKey { key: "encoding", .. }));
    let bright = broken("albedo = 0.5", "albedo = { checker = [2, 2], white = 1.5 }");
    assert_eq!(bright.error, CaseError::Configuration(ConfigurationError::Albedo { said: 1.5 }));
    let quadrangle = "[[source.polygon]]\nvertices = [[0, 0, 3], [0, 1, 3], [1, 1, 3], [1, 0, 3]]\nexitance = { checker = [2, 2] }\n";
    let found = mistakes(&SOUND.replace("[[occluder.polygon]]", &format!("{quadrangle}[[occluder.polygon]]")));
    assert!(matches!(found.mistakes(), [only] if only.error == CaseError::NoMap { said: 4 }), "{found}");
    let folded =
        quadrangle.replace(", [1, 0, 3]", "").replace("[2, 2]", "[2, 2], map = [[0, 0], [1, 1], [0.5, 0.5]]");
    let found = mistakes(&SOUND.replace("[[occluder.polygon]]", &format!("{folded}[[occluder.polygon]]")));
    assert!(found.to_string().contains("the map's triangle is degenerate"), "{found}");
    let globe =
        "[[source.sphere]]\ncenter = [0, 0, 5]\nradius = 1\nexitance = { checker = [2, 2], equator = [0, 0, -1] }\n";
    let found = mistakes(&SOUND.replace("[[occluder.polygon]]", &format!("{globe}[[occluder.polygon]]")));
    assert!(found.to_string().contains("equator points along north"), "{found}");
}

#[test]
fn a_picture_that_cannot_be_used_is_told() {
    let told = |file: &str| {
        let text =
            SOUND.replace("exitance = 2", &format!("exitance = {{ image = \"{file}\", encoding = \"linear\" }}"));
        let folder = folder(&[("a.toml", &text), ("no.png", "v 0 0 0"), ("empty.png", "")]);
        let found = Case::read(&folder.path().join("a.toml")).unwrap_err();
        let [mistake] = found.mistakes() else { panic!("{found}") };
        assert_eq!(mistake.line(), 11);
        mistake.error.clone()
    };
    assert!(matches!(told("missing.png"), CaseError::MeshFile { fault: MeshFileFault::Unreadable { .. }, .. }));
    assert!(matches!(told("../no.png"), CaseError::MeshFile { fault: MeshFileFault::Outside, .. }));
    for file in ["no.png", "empty.png"] {
        assert!(matches!(told(file), CaseError::Picture { .. }), "{file}");
    }
}

/// Light that takes a bend, all kinds once.
const BENT: &str = r#"[[source.point]]
position = [0.0, 0.0, 5.0]
power = 2.0
[[source.beam]]
center = [0.0, 0.0, 4.0]
direction = [0.0, 0.0, -2.0]
radius = 0.5
irradiance = 3.0
[[mirror.sphere]]
center = [0.0, 0.0, 9.0]
radius = 1.0
axis = [0.0, 0.0, 1.0]
rim_radius = 0.5
reflectance = 0.9
[[mirror.cylinder]]
center = [9.0, 0.0, 0.0]
axis = [0.0, 0.0, 1.0]
radius = 2.0
height = 1.0
toward = [1.0, 0.0, 0.0]
arc = 0.25
reflectance = 1
[[mirror.paraboloid]]
vertex = [0.0, 9.0, 0.0]
axis = [0.0, 0.0, 1.0]
focal_length = 0.5
rim_radius = 0.75
reflectance = 0.5
[[glass.slab]]
center = [0.0, 0.0, 1.0]
edge_u = [4.0, 0.0, 0.0]
edge_v = [0.0, 4.0, 0.0]
thickness = 0.125
ior = 1.5
[[glass.plano_convex]]
vertex = [0.0, 0.0, 2.0]
axis = [0.0, 0.0, 1.0]
curvature_radius = 4.0
rim_radius = 0.625
ior = 1.25
[[diffuse.sphere]]
center = [1.0, 0.0, 0.0]
radius = 50.0
albedo = 0.8
exitance = 0.5
inward = true
[receiver.disk]
center = [0.0, 0.0, 0.0]
normal = [0.0, 0.0, 1.0]
radius = 3.0
[light]
rays = 1000
map = [32, 16]
depth = 5
aim = "nowhere"
split = "both"
rings = { center = [0.0, 0.0, 0.0], radius = 1.5, count = 3 }
"#;

#[test]
fn lamps_and_optics_are_read() {
    let case = Case::from_toml("bent", BENT).unwrap_or_else(|mistakes| panic!("{mistakes}"));
    let room = &case.configuration;
    assert_eq!((room.lamps().len(), room.mirrors().len(), room.glass().len()), (2, 3, 2));
    assert_eq!(room.lamps()[0].power(), 2.0);
    assert_eq!(room.mirrors().iter().map(Mirror::reflectance).collect::<Vec<_>>(), [0.9, 1.0, 0.5]);
    assert!(matches!(room.mirrors()[0].shape(), MirrorShape::SphereCap(cap) if cap.rim_radius() == 0.5));
    assert!(matches!(room.mirrors()[1].shape(), MirrorShape::Cylinder(wall) if wall.arc() == 0.25));
    assert!(matches!(room.mirrors()[2].shape(), MirrorShape::Paraboloid(dish) if dish.focal_length() == 0.5));
    assert!(matches!(room.glass()[0].shape(), GlassShape::Slab(slab) if slab.thickness() == 0.125));
    assert!(matches!(room.glass()[1].shape(), GlassShape::PlanoConvex(lens) if lens.curvature_radius() == 4.0));
    assert!(room.diffuse()[0].is_inward() && room.diffuse()[0].albedo().ratio() == 0.8);
    assert!(room.points().is_empty(), "a map is measurement enough");
    let rings = Some(Rings { center: DVec3::ZERO, radius: 1.5, count: 3 });
    let (aim, split) = (Aim::Nowhere, Split::Both);
    assert_eq!(case.light, LightSettings { rays: 1000, map: [32, 16], depth: 5, aim, split, rings, tiles: None });
    let plain = Case::from_toml("plain", SOUND).unwrap();
    assert_eq!(plain.light, LightSettings::default());
}

#[test]
fn what_is_wrong_with_optics_is_told_in_its_place() {
    for (from, to, at, words) in [
        ("reflectance = 0.9", "reflectance = 1.1", "1.1", "reflectance is 1.1; it lies between 0 and 1"),
        ("reflectance = 0.9", "reflectance = nan", "nan", "every number is finite"),
        ("ior = 1.5", "ior = 0.9", "0.9", "ior is 0.9; an index of refraction is finite, 1 or greater"),
        ("ior = 1.5", "ior = nan", "nan", "every number is finite"),
        ("power = 2.0", "power = -2.0", "-2.0", "the power is -2 W"),
        ("irradiance = 3.0", "irradiance = -3.0", "-3.0", "the irradiance is -3 W/m²"),
        ("direction = [0.0, 0.0, -2.0]", "direction = [0, 0, 0]", "[0, 0, 0]", "direction is the zero vector"),
        ("rim_radius = 0.5\n", "rim_radius = 1.5\n", "1.5", "at most 1 (metres)"),
        ("rim_radius = 0.625", "rim_radius = 4.5", "4.5", "at most 4 (metres)"),
        ("rim_radius = 0.5\n", "", "[[mirror.sphere]]", "lacks the key `rim_radius`"),
        ("arc = 0.25", "arc = 1.25", "1.25", "arc is 1.25; it is a share"),
        ("toward = [1.0, 0.0, 0.0]", "toward = [0.0, 0.0, 1.0]", "[0.0, 0.0, 1.0]", "toward points along the axis"),
        ("toward = [1.0, 0.0, 0.0]\n", "", "[[mirror.cylinder]]", "lacks the key `toward`"),
        ("thickness = 0.125", "thickness = 0", "0", "thickness is 0; it is greater than zero"),
        ("focal_length = 0.5", "focal_length = -0.5", "-0.5", "focal_length is -0.5; it is greater than zero"),
        ("albedo = 0.8", "albedo = 1.5", "1.5", "albedo is 1.5"),
        ("exitance = 0.5", "exitance = -0.5", "-0.5", "exitance is -0.5"),
        ("inward = true", "inward = 1", "1", "true or false is accepted"),
        ("vertex = [0.0, 0.0, 2.0]", "vertex = [0.0, 0.0, 1.03]", "[[glass.plano_convex]]", "cut into each other"),
        ("radius = 50.0", "radius = 9.5", "[[mirror.sphere]]", "reaches out of the enclosure"),
        ("aim = \"nowhere\"", "aim = \"optic\"", "\"optic\"", "accepted: optics, nowhere"),
        ("split = \"both\"", "split = \"all\"", "\"all\"", "accepted: one, both"),
        ("map = [32, 16]", "map = [4096, 4096]", "[4096, 4096]", "16777216 texels"),
        ("map = [32, 16]", "map = [32]", "[32]", "2 are accepted"),
        ("depth = 5", "depth = 1000", "1000", "from 0 to 256"),
        ("rays = 1000", "rays = 0", "0", "from 1 to"),
        ("count = 3", "count = 0", "0", "from 1 to 4096"),
        ("radius = 1.5,", "radius = 0.0,", "0.0", "greater than 0"),
    ] {
        assert_eq!(BENT.matches(from).count(), 1, "{from} stands there once");
        let found = mistakes(&BENT.replace(from, to));
        let mistake = &found.mistakes()[0];
        assert!(mistake.error.to_string().contains(words), "{to}: {mistake}");
        assert_eq!(found.underlined(mistake), at, "{to}: {mistake}");
    }
    // Curved optics hide sources with area in no closed form.
    let area = "[[source.disk]]\ncenter = [0.0, 0.0, 8.0]\nnormal = [0.0, 0.0, -1.0]\nradius = 0.5\nexitance = 1.0\n";
    let measured = format!("{area}{BENT}[[measure.point]]\nposition = [0.0, 0.0, 0.5]\nnormal = [0.0, 0.0, 1.0]\n");
    let found = mistakes(&measured);
    let [mistake] = found.mistakes() else { panic!("{found}") };
    assert_eq!(found.underlined(mistake), "[[glass.plano_convex]]", "{found}");
    assert!(mistake.error.to_string().contains("no closed form"), "{mistake}");
    // Beside it, the point is measured.
    let beside = measured.replace("position = [0.0, 0.0, 0.5]", "position = [20.0, 0.0, 0.5]");
    assert!(Case::from_toml("beside", &beside).is_ok());
    let alone = "[[mirror.disk]]\ncenter=[0,0,0]\nnormal=[0,0,1]\nradius=1\nreflectance=0.9\n";
    assert_eq!(mistakes(alone).mistakes().len(), 2, "no source, and nothing to measure");
}

#[test]
fn text_that_is_no_toml_is_told_where_it_breaks() {
    let found = mistakes(&SOUND.replace("radius = 0.5", "radius = 0.5 0.6").replace("exitance = 2", "exitance = -2"));
    let places: Vec<_> =
        found.mistakes().iter().map(|m| (m.line(), matches!(m.error, CaseError::Syntax { .. }))).collect();
    assert_eq!(places, [(5, true), (11, false)], "what is said elsewhere is judged all the same: {found}");
    let found = mistakes(&SOUND.replace("normal = [0.0, 0.0, -1.0]", "normal = [0.0, 0.0, -1.0"));
    let [mistake] = found.mistakes() else { panic!("one open bracket is one mistake: {found}") };
    assert_eq!((mistake.line(), mistake.column()), (4, 10), "{found}");
    let twice = mistakes(&SOUND.replace("radius = 0.5", "radius = 0.5\nradius = 0.6"));
    assert!(matches!(twice.mistakes(), [only] if only.line() == 6), "{twice}");
    let many = mistakes(&"no toml at all\n".repeat(100));
    assert_eq!(many.mistakes().len(), 21, "{many}");
    assert!(matches!(many.mistakes()[20].error, CaseError::MoreSyntax { more: 80 }), "{many}");
}

#[test]
fn several_mistakes_read_like_this() {
    let text = SOUND
        .replace("raduis", "radius")
        .replace("radius = 0.5", "raduis = 0.5")
        .replace("exitance = 2", "exitance = -2")
        .replace("to = [1.5, 0.0, 0.0]", "to = [2.5, 0.0, 0.0]")
        .replace("\"random\"]", "\"randon\"]");
    let found = mistakes(&text);
    let expected = include_str!("../data/case_mistakes.txt");
    assert_eq!(found.render(Ink::Plain), expected.trim_end(), "\n{found}");
    assert_eq!(found.to_string(), expected.trim_end());
    assert!(found.render(Ink::Coloured).contains("\u{1b}["));
    assert_eq!(
        found.mistakes()[1].to_string(),
        "test.toml:11:12: exitance is -2 W/m²; it is a finite number, zero or greater"
    );
    assert_eq!(found.underlined(&found.mistakes()[1]), "-2");
}

#[test]
fn odd_files_are_told_in_few_words() {
    let marked = mistakes("\u{feff}radius = 1\n");
    assert_eq!((marked.mistakes()[0].line(), marked.mistakes()[0].column()), (1, 1));
    assert!(marked.to_string().contains("--> test.toml:1:1\n"), "{marked}");
    let many: String = (0..1000).map(|i| format!("k{i} = 1\n")).collect();
    let many = mistakes(&many);
    assert_eq!(many.mistakes().len(), 1002);
    assert!(many.to_string().ends_with("error: 802 more mistakes in the same file\n--> test.toml"), "{many}");
    let long = SOUND.replace("[1.0, 1.0, 1.0]", &format!("{}[1.0, 1.0, 1.1]", "\n".repeat(20)));
    let long = mistakes(&long);
    assert!(long.to_string().lines().count() < 8, "{long}");
    let windows = SOUND.replace("radius = 0.5", "radius = -1").replace('\n', "\r\n");
    assert_eq!((mistakes(&windows).mistakes()[0].line(), mistakes(&windows).mistakes()[0].column()), (5, 10));
    let deep = mistakes(&format!("a = {}", "[".repeat(100_000)));
    assert!(matches!(deep.mistakes(), [only] if matches!(only.error, CaseError::Syntax { .. })));
}

#[test]
fn both_places_of_a_clash_are_shown() {
    let occluder = "[[occluder.disk]]\ncenter = [1.5, 0.0, 0.0]\nnormal = [1.0, 0.0, 0.0]\nradius = 0.1\n[receiver]";
    let shown = mistakes(&SOUND.replace("[receiver]\n", &format!("{occluder}\n"))).to_string();
    assert!(shown.contains("14 | [[occluder.disk]]\n   | ----------------- on this occluder"), "{shown}");
    assert!(shown.contains("--> test.toml:25:8\n") && shown.contains(" measured here"), "{shown}");
}

/// A folder of case files.
fn folder(files: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files {
        let path = folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }
    folder
}

const TRIANGLE: &str = "v 0 0 1\nv 1 0 1\nv 0 1 1\nf 1 2 3\n";

fn with_mesh(keys: &str) -> String {
    SOUND.replace("[receiver]\n", &format!("[[occluder.mesh]]\n{keys}\n[receiver]\n"))
}

#[test]
fn meshes_are_read_beside_their_case_and_split() {
    let deep = with_mesh("file = \"../meshes/t.obj\"\nsubdivide = 2");
    let folder = folder(&[("deep/a.toml", &deep), ("meshes/t.obj", TRIANGLE), ("notes.txt", "no case")]);
    let cases = Case::read_folder(folder.path()).unwrap_or_else(|errors| panic!("{}", errors[0]));
    assert_eq!(cases.iter().map(|case| case.name.as_str()).collect::<Vec<_>>(), ["deep/a"]);
    let Shape::Mesh(mesh) = &cases[0].configuration.occluders()[1] else { panic!("a mesh") };
    assert_eq!(mesh.triangles().len(), 16);
    let alone = Case::read(&folder.path().join("deep/a.toml")).unwrap_err();
    assert!(
        matches!(&alone.mistakes()[0].error, CaseError::MeshFile { fault: MeshFileFault::Outside, .. }),
        "a file by itself has its own folder alone: {alone}"
    );
    assert!(alone.to_string().contains("--allow-outside"), "{alone}");
}

#[test]
fn a_case_reaches_outside_where_its_reader_lets_it() {
    let above = with_mesh("file = \"../meshes/t.obj\"");
    let folder = folder(&[("deep/a.toml", &above), ("meshes/t.obj", TRIANGLE)]);
    let path = folder.path().join("deep/a.toml");
    let n_occluders = |case: &Case| case.configuration.occluders().len();
    let read = Case::read_reaching(&path, Reach::Anywhere).unwrap_or_else(|errors| panic!("{errors}"));
    assert_eq!((n_occluders(&read), read.reach), (2, Reach::Anywhere));
    let selectors = [path.to_str().unwrap().to_owned()];
    assert!(matches!(select(&selectors), Err(SelectError::Faulty { .. })));
    let selected = select_reaching(&selectors, Reach::Anywhere).unwrap();
    assert_eq!(selected, [read]);
    let absolute = with_mesh(&format!("file = {:?}", folder.path().join("meshes/t.obj").to_str().unwrap()));
    std::fs::write(&path, absolute).unwrap();
    let found = Case::read_reaching(&path, Reach::Inside).unwrap_err();
    assert!(
        matches!(&found.mistakes()[0].error, CaseError::MeshFile { fault: MeshFileFault::Absolute, .. }),
        "{found}"
    );
    assert_eq!(n_occluders(&Case::read_reaching(&path, Reach::Anywhere).unwrap()), 2);
}

#[cfg(unix)]
#[test]
fn a_link_leads_no_case_out_of_its_folder() {
    use std::os::unix::fs::symlink;
    let folder = folder(&[("rooms/a.toml", &with_mesh("file = \"t.obj\"")), ("elsewhere/t.obj", TRIANGLE)]);
    let rooms = folder.path().join("rooms");
    symlink("../elsewhere/t.obj", rooms.join("t.obj")).unwrap();
    let found = Case::read(&rooms.join("a.toml")).unwrap_err();
    let [mistake] = found.mistakes() else { panic!("{found}") };
    assert_eq!((mistake.line(), mistake.column()), (15, 8));
    assert!(matches!(&mistake.error, CaseError::MeshFile { fault: MeshFileFault::LinkedOutside, .. }), "{found}");
    assert!(Case::read_reaching(&rooms.join("a.toml"), Reach::Anywhere).is_ok());
    // The folder that holds both was given: the link leads about in it.
    assert_eq!(Case::read_folder(folder.path()).map(|cases| cases.len()), Ok(1));
}

/// A pipe has no end until somebody writes to it: it would be waited for.
#[cfg(unix)]
#[test]
fn a_pipe_is_waited_for_by_nobody() {
    let folder = folder(&[("a.toml", &with_mesh("file = \"t.obj\""))]);
    for name in ["t.obj", "b.toml"] {
        assert!(std::process::Command::new("mkfifo").arg(folder.path().join(name)).status().unwrap().success());
    }
    for reach in [Reach::Inside, Reach::Anywhere] {
        let found = Case::read_reaching(&folder.path().join("a.toml"), reach).unwrap_err();
        let error = &found.mistakes()[0].error;
        assert!(matches!(error, CaseError::MeshFile { fault: MeshFileFault::NoFile, .. }), "{found}");
    }
    let faulty = Case::read_folder(folder.path()).unwrap_err();
    assert_eq!(faulty.len(), 1, "b.toml is no file");
}

#[test]
fn what_a_case_asks_for_in_all_is_counted() {
    let told = |text: &str| {
        let found = mistakes(text);
        assert!(found.mistakes().len() < 5, "{found}");
        found.mistakes().last().unwrap().error.clone()
    };
    let many = |error: &CaseError, what: &str| matches!(error, CaseError::TooMany { what: said, .. } if said.starts_with(what));
    let shapes = told(&format!("{SOUND}{}", "[[occluder.sphere]]\n".repeat(1 << 14)));
    assert!(many(&shapes, "shapes and lamps"), "{shapes}");
    let optics = told(&format!("{SOUND}{}", "[[glass.sphere]]\n".repeat(1025)));
    assert!(many(&optics, "mirrors, pieces of glass"), "{optics}");
    let checker = "[[source.rectangle]]\ncenter = [0, 0, 9]\nedge_u = [1, 0, 0]\nedge_v = [0, 1, 0]\n\
                   exitance = { checker = [1024, 1024] }\n";
    let texels = told(&format!("{SOUND}{}", checker.repeat(5)));
    assert!(many(&texels, "texels in this case"), "{texels}");
    let spheres = "[[occluder.sphere]]\ncenter = [0, 0, 99]\nradius = 1\n".repeat(300);
    let pairs = told(&format!("{}{spheres}", SOUND.replace("[study]", "grid = [1024, 1000]\n[study]")));
    assert!(many(&pairs, "pairs of a measurement point and a surface"), "{pairs}");
    let samples: String = (1..=1001).map(|n| format!("{n},")).collect();
    let entries = broken("samples = [16, 4]", &format!("samples = [{samples}]"));
    assert!(many(&entries.error, "entries"), "{entries}");
}

#[test]
fn mistakes_beyond_what_anybody_reads_are_counted() {
    let found = mistakes(&SOUND.replace("[study]", &format!("grid = [{}]\n[study]", "nan,".repeat(20_000))));
    let last = found.mistakes().last().unwrap();
    assert!(matches!(last.error, CaseError::More { more: 10_001 }), "{last}");
    let told = found.render(Ink::Plain);
    assert!(told.contains("19801 more mistakes in the same file"), "those that are not drawn, and those not kept");
    let place = found.mistakes()[1].place.to_string();
    assert!(told.contains(&place), "a line that is too long to be drawn keeps its place: {place}");
    assert!(told.len() < 200_000, "{} bytes", told.len());
}

#[test]
fn nesting_ends_where_the_papers_say() {
    use etendue::intake::CASE_DEPTH;
    let depth = usize::try_from(CASE_DEPTH).unwrap();
    let nested = |n: usize| mistakes(&format!("a = {}{}", "[".repeat(n), "]".repeat(n)));
    let dotted = |n: usize| mistakes(&format!("{} = 1", vec!["a"; n].join(".")));
    let is_syntax = |found: &CaseErrors| found.mistakes().iter().any(|m| matches!(m.error, CaseError::Syntax { .. }));
    for read in [&nested as &dyn Fn(usize) -> CaseErrors, &dotted] {
        assert!(!is_syntax(&read(depth - 1)), "{}", read(depth - 1));
        assert!(is_syntax(&read(depth + 2)), "{}", read(depth + 2));
    }
}

#[test]
fn a_mesh_that_cannot_be_used_is_told() {
    let files = [("broken.obj", "v 0 0 1\nf 1 2 3\n"), ("t.obj", TRIANGLE)];
    let told = |keys: &str| {
        let folder = folder(&[files[0], files[1], ("a.toml", &with_mesh(keys))]);
        let found = Case::read(&folder.path().join("a.toml")).unwrap_err();
        let [mistake] = found.mistakes() else { panic!("{found}") };
        (mistake.line(), mistake.column(), mistake.error.clone())
    };
    let fault = |file: &str| match told(&format!("file = \"{file}\"")) {
        (15, 8, CaseError::MeshFile { fault, .. }) => fault,
        other => panic!("{other:?}"),
    };
    assert!(matches!(fault("missing.obj"), MeshFileFault::Unreadable { .. }));
    assert_eq!(fault("/etc/passwd"), MeshFileFault::Absolute);
    assert_eq!(fault("../t.obj"), MeshFileFault::Outside);
    let error = ObjError::NoSuchVertex { line: 2, said: 2, vertices: 1 };
    assert_eq!(told("file = \"broken.obj\""), (15, 8, CaseError::Mesh { file: "broken.obj".into(), error }));
    let deep = told("file = \"t.obj\"\nsubdivide = 9");
    assert!(matches!(deep, (16, 13, CaseError::Count { least: 0, most: 8, .. })), "{deep:?}");
    let fan = format!("{TRIANGLE}{}", "f 1 2 3\n".repeat(1000));
    let folder = folder(&[("fan.obj", &fan), ("a.toml", &with_mesh("file = \"fan.obj\"\nsubdivide = 8"))]);
    let found = Case::read(&folder.path().join("a.toml")).unwrap_err();
    let error = &found.mistakes()[0].error;
    assert!(matches!(error, CaseError::TooMany { said: 65_601_536, limit: 64_000_000, .. }), "{found}");
    assert!(error.to_string().contains("memory"), "{error}");
}

#[test]
fn all_shipped_cases_are_sound() {
    let names: Vec<_> = shipped_direct().map(|case| case.name()).collect();
    assert!(names.len() >= 18 && names.is_sorted(), "{names:?}");
    for case in shipped_direct() {
        let read = case.read().unwrap_or_else(|mistakes| panic!("{mistakes}"));
        assert_eq!(read.study, Study::default(), "{}: shipped cases study by default", case.name());
        assert!(case.text().starts_with("# "), "{} opens with what it shows", case.name());
        assert!(read.configuration.points().len() <= 65);
    }
    let on_disk = Case::read_folder(&Path::new(env!("CARGO_MANIFEST_DIR")).join("cases")).unwrap();
    let embedded = select(&[]).unwrap();
    assert_eq!(on_disk.len(), embedded.len(), "the program holds what the folder holds");
    for (on_disk, embedded) in on_disk.iter().zip(&embedded) {
        // All but the selector, which says where each was found.
        assert_eq!((&on_disk.name, &on_disk.title), (&embedded.name, &embedded.title));
        assert!(on_disk.configuration == embedded.configuration, "{} differs", embedded.name);
        assert_eq!(on_disk.study, embedded.study, "{}", embedded.name);
    }
}

fn names(selectors: &[&str]) -> Vec<String> {
    let selectors: Vec<String> = selectors.iter().map(|s| s.to_string()).collect();
    select(&selectors).unwrap_or_else(|error| panic!("{error}")).into_iter().map(|case| case.name).collect()
}

#[test]
fn shipped_cases_are_selected_by_name_part_or_pattern() {
    assert_eq!(names(&["penumbra/eclipse"]), ["penumbra/eclipse"], "a whole name means that case alone");
    assert!(names(&["eclipse"]).len() > 3);
    assert_eq!(names(&["*/eclipse-?esh"]), ["penumbra/eclipse-mesh"]);
    assert_eq!(names(&["half-plane", "penumbra/half-plane"]), ["penumbra/half-plane"], "once");
    let Err(SelectError::Nothing { unmatched }) = select(&["eclpise".into(), "spheres".into(), "".into()]) else {
        panic!("nothing is called eclpise")
    };
    assert_eq!(unmatched.len(), 2);
    assert_eq!(unmatched[0].nearest[0], "penumbra/eclipse");
}

#[test]
fn files_and_folders_are_selected_by_path() {
    let folder = folder(&[("b/x.toml", SOUND), ("a.toml", SOUND), ("b/c/y.toml", SOUND), ("empty/z.txt", "")]);
    let path = |below: &str| folder.path().join(below).to_str().unwrap().to_string();
    assert_eq!(names(&[&path("")]), ["a", "b/c/y", "b/x"]);
    assert_eq!(names(&[&path("b/x.toml"), &path("b/../b/x.toml")]), ["x"], "one file, named twice");
    assert!(matches!(select(&[path("empty")]), Err(SelectError::Nothing { .. })));
    std::fs::copy(path("a.toml"), path("b/a.toml")).unwrap();
    let clash = select(&[path("a.toml"), path("b/a.toml")]);
    assert!(matches!(&clash, Err(SelectError::SameName { name, .. }) if name == "a"), "{clash:?}");
}

#[test]
fn all_faulty_files_are_told_together() {
    let folder = folder(&[("a.toml", "x = 1"), ("b.toml", SOUND), ("c.toml", "y = [")]);
    let Err(SelectError::Faulty { files }) = select(&[folder.path().to_str().unwrap().into()]) else {
        panic!("two files are faulty")
    };
    let found: Vec<_> =
        files.iter().map(|file| Path::new(file.path()).file_name().unwrap().to_str().unwrap()).collect();
    assert_eq!(found, ["a.toml", "c.toml"]);
    std::fs::write(folder.path().join("latin1.toml"), b"title = \"caf\xe9\"").unwrap();
    let found = Case::read(&folder.path().join("latin1.toml")).unwrap_err();
    assert!(matches!(found.mistakes(), [one] if one.error == CaseError::NotText && one.column() == 13), "{found}");
    let large = std::fs::File::create(folder.path().join("large.toml")).unwrap();
    large.set_len((4 << 20) + 1).unwrap();
    let found = Case::read(&folder.path().join("large.toml")).unwrap_err();
    assert_eq!(found.mistakes()[0].error, CaseError::TooLarge { limit: 4 << 20 });
    let found = Case::read(&folder.path().join("missing.toml")).unwrap_err();
    assert!(matches!(found.mistakes()[0].error, CaseError::Unreadable { .. }), "{found}");
}

/// A shipped case's text, cut, doubled or with bytes replaced.
fn mangled() -> impl Strategy<Value = Vec<u8>> {
    let snippets = [
        "[",
        "]",
        "\"",
        "=",
        "\n",
        "nan",
        "-1",
        "1e400",
        "{",
        "}}",
        "[[source.disk]]\n",
        "\u{feff}",
        ".",
        "é",
        "'''",
    ];
    let edit =
        (any::<prop::sample::Index>(), any::<prop::sample::Index>(), prop::sample::select(snippets.to_vec()), 0..4);
    (any::<prop::sample::Index>(), prop::collection::vec(edit, 1..6)).prop_map(|(which, edits)| {
        let texts: Vec<&str> =
            shipped().filter(|case| !case.name().contains("mesh")).map(|case| case.text()).collect();
        let mut bytes = texts[which.index(texts.len())].as_bytes().to_vec();
        for (at, to, snippet, kind) in edits {
            let (a, b) = (at.index(bytes.len() + 1), to.index(bytes.len() + 1));
            match kind {
                0 => bytes.truncate(a),
                1 => drop(bytes.splice(a..a, snippet.bytes())),
                2 => drop(bytes.drain(a.min(b)..a.max(b).min(a.min(b) + 40))),
                _ => bytes.splice(a..a.min(bytes.len()), b.to_le_bytes().iter().copied().take(2)).for_each(drop),
            }
        }
        bytes
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_text_makes_the_reader_panic(bytes in mangled()) {
        if let Err(found) = Case::from_toml("mangled", &String::from_utf8_lossy(&bytes)) {
            prop_assert!(!found.mistakes().is_empty());
            for mistake in found.mistakes() {
                prop_assert!(mistake.line() >= 1 && mistake.column() >= 1);
            }
            prop_assert!(found.render(Ink::Plain).contains("error"));
            found.render(Ink::Coloured);
        }
    }

    #[test]
    fn no_text_makes_the_mesh_reader_panic(words in prop::collection::vec("(v|f|-?[0-9]{1,3}|/|//|\\\\|#|\n|[0-9.e-]{1,6}| ){1,4}", 0..60)) {
        let _ = etendue::case::obj::read(words.join(" ").as_bytes());
    }
}
