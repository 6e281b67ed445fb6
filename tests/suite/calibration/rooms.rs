//! Rooms in which faults show.

use etendue::Case;

/// The room of that name.
pub fn room(name: &str) -> Case {
    let (_, text) = ROOMS.iter().find(|(known, _)| *known == name).unwrap_or_else(|| panic!("no room {name}"));
    Case::from_toml(name, text).unwrap_or_else(|errors| panic!("{name}: {errors:?}"))
}

/// All names.
pub fn names() -> impl Iterator<Item = &'static str> {
    ROOMS.iter().map(|(name, _)| *name)
}

const ROOMS: &[(&str, &str)] = &[
    (
        "disk",
        r#"
        source.disk = [{ center = [0.0, 0.0, 1.0], normal = [0.0, 0.0, -1.0], radius = 0.5, exitance = 1.0 }]
        receiver.rectangle = { center = [0.7, 0.0, 0.0], edge_u = [2.0, 0.0, 0.0], edge_v = [0.0, 2.0, 0.0] }
        measure.line = { from = [0.1, 0.0, 0.0], to = [1.3, 0.0, 0.0], points = 5 }
        "#,
    ),
    (
        "rectangle",
        r#"
        source.rectangle = [{ center = [0.2, 0.1, 0.8], edge_u = [1.2, 0.0, 0.0], edge_v = [0.0, -0.8, 0.0], exitance = 1.0 }]
        receiver.rectangle = { center = [0.7, 0.0, 0.0], edge_u = [2.0, 0.0, 0.0], edge_v = [0.0, 2.0, 0.0] }
        measure.line = { from = [0.1, 0.0, 0.0], to = [1.3, 0.0, 0.0], points = 5 }
        "#,
    ),
    (
        "far from the origin",
        r#"
        source.rectangle = [{ center = [2500000.2, 0.1, 0.8], edge_u = [1.2, 0.0, 0.0], edge_v = [0.0, -0.8, 0.0], exitance = 1.0 }]
        receiver.rectangle = { center = [2500000.7, 0.0, 0.0], edge_u = [2.0, 0.0, 0.0], edge_v = [0.0, 2.0, 0.0] }
        measure.line = { from = [2500000.07, 0.0, 0.0], to = [2500001.3, 0.0, 0.0], points = 5 }
        "#,
    ),
    (
        "penumbra",
        r#"
        source.rectangle = [{ center = [0.0, 0.0, 2.0], edge_u = [0.8, 0.0, 0.0], edge_v = [0.0, -0.8, 0.0], exitance = 1.0 }]
        occluder.disk = [{ center = [0.0, 0.0, 1.0], normal = [0.0, 0.0, 1.0], radius = 0.4 }]
        receiver.rectangle = { center = [0.8, 0.0, 0.0], edge_u = [2.0, 0.0, 0.0], edge_v = [0.0, 2.0, 0.0] }
        measure.line = { from = [0.1, 0.05, 0.0], to = [1.6, 0.05, 0.0], points = 6 }
        "#,
    ),
    (
        "contact",
        r#"
        source.disk = [{ center = [0.0, 0.0, 2.0], normal = [0.0, 0.0, -1.0], radius = 0.5, exitance = 1.0 }]
        occluder.disk = [{ center = [0.5, 0.0, 0.15], normal = [0.0, 0.0, -1.0], radius = 0.3 }]
        receiver.rectangle = { center = [0.6, 0.0, 0.0], edge_u = [2.0, 0.0, 0.0], edge_v = [0.0, 2.0, 0.0] }
        measure.line = { from = [0.0, 0.0, 0.0], to = [1.1, 0.0, 0.0], points = 6 }
        "#,
    ),
    (
        "cover near the source",
        r#"
        source.disk = [{ center = [0.0, 0.0, 2.0], normal = [0.0, 0.0, -1.0], radius = 0.5, exitance = 1.0 }]
        occluder.rectangle = [{ center = [0.3, 0.0, 1.85], edge_u = [0.6, 0.0, 0.0], edge_v = [0.0, 1.0, 0.0] }]
        receiver.rectangle = { center = [0.6, 0.0, 0.0], edge_u = [2.0, 0.0, 0.0], edge_v = [0.0, 2.0, 0.0] }
        measure.line = { from = [0.0, 0.0, 0.0], to = [1.2, 0.0, 0.0], points = 5 }
        "#,
    ),
    (
        "two sources",
        r#"
        source.disk = [{ center = [-0.8, 0.0, 2.0], normal = [0.0, 0.0, -1.0], radius = 0.4, exitance = 0.4 }]
        source.rectangle = [{ center = [0.9, 0.2, 1.6], edge_u = [0.5, 0.0, 0.0], edge_v = [0.0, -0.4, 0.0], exitance = 2.5 }]
        receiver.rectangle = { center = [0.0, 0.0, 0.0], edge_u = [4.0, 0.0, 0.0], edge_v = [0.0, 4.0, 0.0] }
        measure.line = { from = [-1.5, 0.0, 0.0], to = [1.5, 0.0, 0.0], points = 5 }
        "#,
    ),
    (
        "sphere",
        r#"
        source.sphere = [{ center = [0.0, 0.0, 1.2], radius = 0.5, exitance = 1.0 }]
        receiver.rectangle = { center = [0.7, 0.0, 0.0], edge_u = [2.0, 0.0, 0.0], edge_v = [0.0, 2.0, 0.0] }
        measure.line = { from = [0.1, 0.0, 0.0], to = [1.3, 0.0, 0.0], points = 5 }
        "#,
    ),
    (
        "checker",
        r#"
        source.rectangle = [{ center = [0.2, 0.1, 0.6], edge_u = [1.6, 0.0, 0.0], edge_v = [0.0, -0.8, 0.0], exitance = { checker = [2, 1], white = 2.0, black = 0.5 } }]
        receiver.rectangle = { center = [0.7, 0.0, 0.0], edge_u = [3.0, 0.0, 0.0], edge_v = [0.0, 2.0, 0.0] }
        measure.line = { from = [-0.6, 0.0, 0.0], to = [1.3, 0.0, 0.0], points = 5 }
        "#,
    ),
    (
        "globe",
        r#"
        source.sphere = [{ center = [0.0, 0.0, 1.2], radius = 0.5, exitance = { checker = [1, 4], white = 2.0, black = 0.5 } }]
        receiver.rectangle = { center = [0.7, 0.0, 0.0], edge_u = [2.0, 0.0, 0.0], edge_v = [0.0, 2.0, 0.0] }
        measure.line = { from = [0.1, 0.0, 0.0], to = [1.3, 0.0, 0.0], points = 5 }
        "#,
    ),
    (
        "triangle",
        r#"
        source.polygon = [{ vertices = [[-0.5, -0.4, 1.0], [0.1, 0.8, 1.0], [0.9, -0.2, 1.0]], exitance = 1.0 }]
        receiver.rectangle = { center = [0.7, 0.0, 0.0], edge_u = [2.0, 0.0, 0.0], edge_v = [0.0, 2.0, 0.0] }
        measure.line = { from = [0.1, 0.0, 0.0], to = [1.3, 0.0, 0.0], points = 5 }
        "#,
    ),
    (
        "behind the source",
        r#"
        source.disk = [{ center = [0.0, 0.0, 1.0], normal = [1.0, 0.0, -0.2], radius = 0.5, exitance = 1.0 }]
        receiver.rectangle = { center = [0.0, 0.0, 0.0], edge_u = [4.0, 0.0, 0.0], edge_v = [0.0, 2.0, 0.0] }
        measure.line = { from = [-0.9, 0.0, 0.0], to = [1.6, 0.0, 0.0], points = 6 }
        "#,
    ),
    (
        "half sunk",
        r#"
        source.disk = [{ center = [0.3, 0.0, 1.0], normal = [0.0, 0.0, -1.0], radius = 0.5, exitance = 1.0 }]
        [[measure.point]]
        position = [0.2, 0.0, 0.0]
        normal = [1.0, 0.0, 0.3]
        [[measure.point]]
        position = [0.4, 0.0, 0.0]
        normal = [1.0, 0.0, 0.3]
        [[measure.point]]
        position = [0.6, 0.0, 0.0]
        normal = [1.0, 0.0, 0.3]
        "#,
    ),
];
