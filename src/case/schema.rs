//! The keys of a case file: each name, unit, default and meaning stands here, once.
//!
//! The reader asks for keys by these constants, and messages list what is accepted from the same tables, so that the
//! format, its documentation and its error messages cannot drift apart. [`ROOT`] is the whole tree; its `Display`
//! prints it as text.

use std::fmt;

/// Largest sample count and replicate count.
pub const MAX_COUNT: u64 = 1 << 40;
/// Largest magnitude of a length (metres), an exitance (W/m²) or any other number but a normal's component: its fourth
/// power is still a number.
pub const MAX_MAGNITUDE: f64 = 1e30;
/// Smallest area of a shape, square metres: its square is still a number.
pub const MIN_AREA: f64 = 1e-60;

/// One table of the format.
#[derive(Debug)]
pub struct Table {
    /// `source.disk`; empty for the top of the file.
    pub path: &'static str,
    /// All keys, those of later versions included.
    pub keys: &'static [Key],
}

/// One key of the format.
#[derive(Clone, Copy, Debug)]
pub struct Key {
    pub name: &'static str,
    pub value: Value,
    /// `m`, `W/m²`, or empty for a pure number or a name.
    pub unit: &'static str,
    pub need: Need,
    pub meaning: &'static str,
}

/// What a key holds.
#[derive(Clone, Copy, Debug)]
pub enum Value {
    Number,
    /// A number, or a table that describes a texture over the surface.
    Field(&'static Table),
    /// A number that is an integer, zero or greater.
    Count,
    Counts,
    Text,
    Texts,
    /// Three numbers.
    Vector,
    Vectors,
    /// `"auto"` or a count.
    AutoOrCount,
    /// `[nu, nv]`.
    CountPair,
    /// true or false.
    Flag,
    /// e00, e10, e01, e20, e11, e02.
    Coefficients,
    /// `"similar"`, `"half-square"` or three corners `[s, t]`.
    MapTriangle,
    /// One table.
    Table(&'static Table),
    /// One table, or an array of them.
    Tables(&'static Table),
}

/// Whether a key may be left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Need {
    Required,
    /// May be left out; what holds then.
    Default(&'static str),
    /// Part of the format, but not of this version.
    Later,
}

impl Table {
    /// Names that this version accepts, in the order of the format.
    pub fn accepted(&self) -> impl Iterator<Item = &'static str> {
        self.keys.iter().filter(|key| key.need != Need::Later).map(|key| key.name)
    }
    /// The key of that name, those of later versions included.
    pub fn key(&self, name: &str) -> Option<&'static Key> {
        self.keys.iter().find(|key| key.name == name)
    }
    /// `[source.disk]`, or `the file` for its top.
    pub fn title(&self) -> String {
        if self.path.is_empty() { "the top of the file".into() } else { format!("[{}]", self.path) }
    }
    /// The full name of a key in this table: `source.disk.radius`.
    pub fn full_name(&self, key: &str) -> String {
        if self.path.is_empty() { key.into() } else { format!("{}.{key}", self.path) }
    }
}

impl Value {
    /// What is accepted, in words: `a number`.
    pub fn expected(&self) -> &'static str {
        match self {
            Value::Number => "a number",
            Value::Field(_) => "a number or a texture",
            Value::Coefficients => "an array of six numbers",
            Value::MapTriangle => {
                "\"similar\", \"half-square\" or an array of three corners, each an array of two numbers"
            }
            Value::Count => "an integer",
            Value::Counts => "an array of integers",
            Value::Text => "a string",
            Value::Texts => "an array of strings",
            Value::Vector => "an array of three numbers",
            Value::Vectors => "an array of points, each an array of three numbers",
            Value::AutoOrCount => "\"auto\" or an integer",
            Value::CountPair => "an array of two integers",
            Value::Flag => "true or false",
            Value::Table(_) => "a table",
            Value::Tables(_) => "a table or an array of tables",
        }
    }
    /// The table below, but for textures, which are listed once for all.
    fn table(&self) -> Option<&'static Table> {
        match self {
            Value::Table(table) | Value::Tables(table) => Some(table),
            _ => None,
        }
    }
}

impl fmt::Display for Table {
    /// A line a key, tables below one another.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if !self.path.is_empty() {
            writeln!(f, "[{}]", self.path)?;
        }
        for key in self.keys {
            let unit = if key.unit.is_empty() { String::new() } else { format!(", {}", key.unit) };
            let need = match key.need {
                Need::Required => "required".to_string(),
                Need::Default(default) => format!("default: {default}"),
                Need::Later => "not supported by this version yet".to_string(),
            };
            writeln!(f, "  {:<13} {}{unit}; {need}. {}", key.name, key.value.expected(), key.meaning)?;
        }
        self.keys.iter().filter(|key| key.need != Need::Later).filter_map(|key| key.value.table()).try_for_each(
            |table| {
                writeln!(f)?;
                table.fmt(f)
            },
        )?;
        if self.path.is_empty() {
            writeln!(f, "\nA texture, in the place of a number:\n")?;
            EXITANCE_TEXTURE.fmt(f)?;
        }
        Ok(())
    }
}

const fn key(name: &'static str, value: Value, unit: &'static str, need: Need, meaning: &'static str) -> Key {
    Key { name, value, unit, need, meaning }
}
const fn later(name: &'static str, meaning: &'static str) -> Key {
    key(name, Value::Tables(&LATER), "", Need::Later, meaning)
}
const NONE: Need = Need::Default("none");

/// Stands for the tables of later versions, whose keys are not written down yet.
const LATER: Table = Table { path: "", keys: &[] };

pub const TITLE: Key = key("title", Value::Text, "", Need::Default("the case's name"), "What people read.");
pub const SOURCE: Key = key(
    "source",
    Value::Table(&SOURCES),
    "",
    Need::Required,
    "What emits: at least one shape; they block one another.",
);
pub const OCCLUDER: Key =
    key("occluder", Value::Table(&OCCLUDERS), "", NONE, "What blocks light, from both sides; spheres are solid.");
pub const RECEIVER: Key = key(
    "receiver",
    Value::Table(&RECEIVERS),
    "",
    NONE,
    "Where light arrives; a line or a grid needs it. Blocks nothing.",
);
pub const MEASURE: Key = key(
    "measure",
    Value::Table(&MEASURES),
    "",
    Need::Required,
    "Where to look. May be left out where light from a lamp, an optic or a diffuse surface can land.",
);
pub const MIRROR: Key = key(
    "mirror",
    Value::Table(&MIRRORS),
    "",
    NONE,
    "What reflects, on both sides; blocks direct light. No measurement behind curved ones but whole spheres.",
);
pub const GLASS: Key = key(
    "glass",
    Value::Table(&GLASSES),
    "",
    NONE,
    "Clear closed bodies that share no space; block direct light. No measurement behind a lens.",
);
pub const DIFFUSE: Key = key(
    "diffuse",
    Value::Table(&DIFFUSES),
    "",
    NONE,
    "Further diffuse surfaces: light lands on their front, and they may emit. Opaque.",
);
pub const LIGHT: Key = key(
    "light",
    Value::Table(&LIGHTS),
    "",
    Need::Default("all defaults"),
    "How rays are followed from the sources to the receiver and the diffuse surfaces.",
);
pub const STUDY: Key =
    key("study", Value::Table(&STUDIES), "", Need::Default("all defaults"), "How to study the case.");

pub const CAMERA: Key = key(
    "camera",
    Value::Table(&CAMERAS),
    "",
    Need::Default("none: the receiver alone, square on"),
    "From where `etendue render` looks, besides at the receiver.",
);

/// The top of a case file.
pub const ROOT: Table = Table {
    path: "",
    keys: &[TITLE, SOURCE, OCCLUDER, RECEIVER, MEASURE, STUDY, MIRROR, GLASS, DIFFUSE, LIGHT, CAMERA],
};

pub const CENTER: Key = key("center", Value::Vector, "m", Need::Required, "Centre.");
pub const NORMAL: Key =
    key("normal", Value::Vector, "", Need::Required, "Towards the lit or receiving side; any length but zero.");
pub const RADIUS: Key = key("radius", Value::Number, "m", Need::Required, "Greater than zero.");
pub const EDGE_U: Key =
    key("edge_u", Value::Vector, "m", Need::Required, "Full edge; the lit or receiving side is edge_u × edge_v.");
pub const EDGE_V: Key = key("edge_v", Value::Vector, "m", Need::Required, "Full edge, perpendicular to edge_u.");
pub const VERTICES: Key = key(
    "vertices",
    Value::Vectors,
    "m",
    Need::Required,
    "In one plane, convex or not, counter-clockwise seen from the lit or receiving side.",
);
pub const EXITANCE: Key = key(
    "exitance",
    Value::Field(&EXITANCE_TEXTURE),
    "W/m²",
    Need::Required,
    "Power sent out per area, Lambertian; zero or greater.",
);

pub const IMAGE: Key = key(
    "image",
    Value::Text,
    "",
    Need::Default("none, but one of image, checker, polynomial"),
    "A PNG picture, 8 or 16 bits, the lower left pixel at s = t = 0; colours count by their luminance (Rec. 709), opacity \
     not at all. A path relative to the case file, inside the folder of the cases.",
);
pub const ENCODING: Key = key(
    "encoding",
    Value::Text,
    "",
    Need::Default("none; a picture needs it"),
    "What a picture's numbers are: `linear`, in proportion to light, or `srgb`, by the standard's curve.",
);
pub const CHECKER: Key = key(
    "checker",
    Value::CountPair,
    "",
    Need::Default("none"),
    "A chessboard of ns × nt texels, the one at s = t = 0 white.",
);
pub const POLYNOMIAL: Key = key(
    "polynomial",
    Value::Coefficients,
    "W/m² … W/m⁴",
    Need::Default("none"),
    "On a rectangle: e00 + e10 x + e01 y + e20 x² + e11 x y + e02 y², metres from the centre along the edges.",
);
pub const WHITE: Key =
    key("white", Value::Number, "W/m², or none", Need::Default("1.0"), "What white stands for; greys in proportion.");
pub const BLACK: Key = key("black", Value::Number, "W/m², or none", Need::Default("0.0"), "What black stands for.");
pub const LOOKUP: Key = key(
    "lookup",
    Value::Text,
    "",
    Need::Default("\"texel\""),
    "Between texels: `texel`, the value of the one hit, or `bilinear`, interpolated without gain or loss.",
);
pub const MAP: Key = key(
    "map",
    Value::MapTriangle,
    "",
    Need::Default("\"similar\""),
    "Of a triangle: where its vertices lie in the picture. `similar` undoes the distortion, `half-square` is [0, 0], \
     [1, 0], [0, 1].",
);
pub const NORTH: Key =
    key("north", Value::Vector, "", Need::Default("[0, 0, 1]"), "Of a sphere: towards its north pole, where t = 1.");
pub const EQUATOR: Key = key(
    "equator",
    Value::Vector,
    "",
    Need::Default("[1, 0, 0]"),
    "Of a sphere: towards where s = 0, which runs eastwards; the part across north counts.",
);
pub const ZERO: Key = key(
    "zero",
    Value::Vector,
    "",
    Need::Default("x, for a normal along z"),
    "Of a disk: where s = 0, the azimuth over a turn; t is the squared share of the radius.",
);
const TEXTURE_KEYS: &[Key] = &[IMAGE, ENCODING, CHECKER, POLYNOMIAL, WHITE, BLACK, LOOKUP, MAP, NORTH, EQUATOR, ZERO];
/// What varies over a source.
pub const EXITANCE_TEXTURE: Table = Table { path: "exitance", keys: TEXTURE_KEYS };
/// What varies over a receiver.
pub const ALBEDO_TEXTURE: Table = Table { path: "albedo", keys: TEXTURE_KEYS };
pub const FILE: Key = key(
    "file",
    Value::Text,
    "",
    Need::Required,
    "Triangles as Wavefront OBJ; a path relative to the case file, inside the folder of the cases.",
);
pub const SUBDIVIDE: Key = key(
    "subdivide",
    Value::Count,
    "",
    Need::Default("0"),
    "Split every triangle in four, this many times (0 to 8); the shape stays the same.",
);

/// Names of shapes.
pub const DISK: &str = "disk";
pub const RECTANGLE: &str = "rectangle";
pub const POLYGON: &str = "polygon";
pub const TRIANGLE: &str = "triangle";
pub const SPHERE: &str = "sphere";
pub const MESH: &str = "mesh";

/// The shapes that can emit.
pub const SOURCES: Table = Table {
    path: "source",
    keys: &[
        key(DISK, Value::Tables(&SOURCE_DISK), "", NONE, "Flat disk."),
        key(RECTANGLE, Value::Tables(&SOURCE_RECTANGLE), "", NONE, "Flat rectangle."),
        key(POLYGON, Value::Tables(&SOURCE_POLYGON), "", NONE, "Flat polygon."),
        key(SPHERE, Value::Tables(&SOURCE_SPHERE), "", NONE, "Sphere, emitting outwards."),
        later(MESH, "Triangles."),
        key("point", Value::Tables(&SOURCE_POINT), "", NONE, "A point that emits equally in all directions."),
        key("beam", Value::Tables(&SOURCE_BEAM), "", NONE, "Parallel light through a disk."),
    ],
};
pub const SOURCE_DISK: Table = Table { path: "source.disk", keys: &[CENTER, NORMAL, RADIUS, EXITANCE] };
pub const SOURCE_RECTANGLE: Table = Table { path: "source.rectangle", keys: &[CENTER, EDGE_U, EDGE_V, EXITANCE] };
pub const SOURCE_POLYGON: Table = Table { path: "source.polygon", keys: &[VERTICES, EXITANCE] };
pub const SOURCE_SPHERE: Table = Table { path: "source.sphere", keys: &[CENTER, RADIUS, EXITANCE] };

pub const POWER: Key = key("power", Value::Number, "W", Need::Required, "Zero or greater.");
pub const SOURCE_POINT: Table = Table { path: "source.point", keys: &[POSITION, POWER] };
pub const DIRECTION: Key =
    key("direction", Value::Vector, "", Need::Required, "That the light travels along; any length but zero.");
pub const IRRADIANCE: Key =
    key("irradiance", Value::Number, "W/m²", Need::Required, "On a surface across the beam; zero or greater.");
pub const SOURCE_BEAM: Table = Table { path: "source.beam", keys: &[CENTER, DIRECTION, RADIUS, IRRADIANCE] };

/// The shapes that can block.
pub const OCCLUDERS: Table = Table {
    path: "occluder",
    keys: &[
        key(DISK, Value::Tables(&OCCLUDER_DISK), "", NONE, "Flat disk."),
        key(RECTANGLE, Value::Tables(&OCCLUDER_RECTANGLE), "", NONE, "Flat rectangle."),
        key(POLYGON, Value::Tables(&OCCLUDER_POLYGON), "", NONE, "Flat polygon."),
        key(SPHERE, Value::Tables(&OCCLUDER_SPHERE), "", NONE, "Solid ball."),
        key(MESH, Value::Tables(&OCCLUDER_MESH), "", NONE, "Triangles."),
    ],
};
pub const OCCLUDER_DISK: Table = Table { path: "occluder.disk", keys: &[CENTER, NORMAL, RADIUS] };
pub const OCCLUDER_RECTANGLE: Table = Table { path: "occluder.rectangle", keys: &[CENTER, EDGE_U, EDGE_V] };
pub const OCCLUDER_POLYGON: Table = Table { path: "occluder.polygon", keys: &[VERTICES] };
pub const OCCLUDER_SPHERE: Table = Table { path: "occluder.sphere", keys: &[CENTER, RADIUS] };
pub const OCCLUDER_MESH: Table = Table { path: "occluder.mesh", keys: &[FILE, SUBDIVIDE] };

pub const ALBEDO: Key = key(
    "albedo",
    Value::Field(&ALBEDO_TEXTURE),
    "",
    Need::Default("none (no radiosity)"),
    "Share of the arriving power that is sent back, from 0 to 1.",
);

/// The shapes that can receive: one of them.
pub const RECEIVERS: Table = Table {
    path: "receiver",
    keys: &[
        ALBEDO,
        key(RECTANGLE, Value::Table(&RECEIVER_RECTANGLE), "", NONE, "Flat rectangle."),
        key(DISK, Value::Table(&RECEIVER_DISK), "", NONE, "Flat disk."),
        key(TRIANGLE, Value::Table(&RECEIVER_TRIANGLE), "", NONE, "Flat triangle: three vertices."),
        key(SPHERE, Value::Table(&RECEIVER_SPHERE), "", NONE, "Sphere, receiving on its outside."),
    ],
};
pub const RECEIVER_RECTANGLE: Table = Table { path: "receiver.rectangle", keys: &[CENTER, EDGE_U, EDGE_V] };
pub const RECEIVER_DISK: Table = Table { path: "receiver.disk", keys: &[CENTER, NORMAL, RADIUS] };
pub const RECEIVER_TRIANGLE: Table = Table { path: "receiver.triangle", keys: &[VERTICES] };
pub const RECEIVER_SPHERE: Table = Table { path: "receiver.sphere", keys: &[CENTER, RADIUS] };

pub const REFLECTANCE: Key = key(
    "reflectance",
    Value::Number,
    "",
    Need::Required,
    "Share of arriving power that goes on, at every angle, from 0 to 1; the rest is absorbed.",
);
pub const AXIS: Key = key("axis", Value::Vector, "", Need::Required, "Along the cylinder; any length but zero.");
pub const HEIGHT: Key = key("height", Value::Number, "m", Need::Required, "Along the axis; greater than zero.");
pub const TOWARD: Key = key(
    "toward",
    Value::Vector,
    "",
    Need::Default("none (the whole wall)"),
    "From the axis to the middle of the part that there is; not along the axis.",
);
pub const ARC: Key = key(
    "arc",
    Value::Number,
    "",
    Need::Default("1.0"),
    "Share of the full circle, up to 1; less than 1 needs toward.",
);
pub const CAP_AXIS: Key = key(
    "axis",
    Value::Vector,
    "",
    Need::Default("none (the whole sphere)"),
    "From the centre to the middle of the part that there is; with rim_radius.",
);
pub const CAP_RIM: Key = key(
    "rim_radius",
    Value::Number,
    "m",
    Need::Default("none (the whole sphere)"),
    "Of the part's rim, at most the sphere's radius; with axis.",
);
pub const VERTEX: Key = key("vertex", Value::Vector, "m", Need::Required, "Middle of the curved surface.");
pub const FOCUS_AXIS: Key =
    key("axis", Value::Vector, "", Need::Required, "From the vertex to the focus; any length but zero.");
pub const FOCAL_LENGTH: Key = key("focal_length", Value::Number, "m", Need::Required, "Greater than zero.");
pub const RIM_RADIUS: Key = key("rim_radius", Value::Number, "m", Need::Required, "Greater than zero.");

/// The shapes that can reflect.
pub const MIRRORS: Table = Table {
    path: "mirror",
    keys: &[
        key(RECTANGLE, Value::Tables(&MIRROR_RECTANGLE), "", NONE, "Flat rectangle."),
        key(POLYGON, Value::Tables(&MIRROR_POLYGON), "", NONE, "Flat polygon."),
        key(DISK, Value::Tables(&MIRROR_DISK), "", NONE, "Flat disk."),
        key(SPHERE, Value::Tables(&MIRROR_SPHERE), "", NONE, "Sphere, or the part of it within a rim."),
        key("cylinder", Value::Tables(&MIRROR_CYLINDER), "", NONE, "Wall of a cylinder, or a part of its round."),
        key("paraboloid", Value::Tables(&MIRROR_PARABOLOID), "", NONE, "Paraboloid of revolution within a rim."),
    ],
};
pub const MIRROR_RECTANGLE: Table = Table { path: "mirror.rectangle", keys: &[CENTER, EDGE_U, EDGE_V, REFLECTANCE] };
pub const MIRROR_POLYGON: Table = Table { path: "mirror.polygon", keys: &[VERTICES, REFLECTANCE] };
pub const MIRROR_DISK: Table = Table { path: "mirror.disk", keys: &[CENTER, NORMAL, RADIUS, REFLECTANCE] };
pub const MIRROR_SPHERE: Table =
    Table { path: "mirror.sphere", keys: &[CENTER, RADIUS, CAP_AXIS, CAP_RIM, REFLECTANCE] };
pub const MIRROR_CYLINDER: Table =
    Table { path: "mirror.cylinder", keys: &[CENTER, AXIS, RADIUS, HEIGHT, TOWARD, ARC, REFLECTANCE] };
pub const MIRROR_PARABOLOID: Table =
    Table { path: "mirror.paraboloid", keys: &[VERTEX, FOCUS_AXIS, FOCAL_LENGTH, RIM_RADIUS, REFLECTANCE] };

pub const IOR: Key =
    key("ior", Value::Number, "", Need::Required, "Index of refraction relative to the surroundings; 1 or greater.");
pub const THICKNESS: Key =
    key("thickness", Value::Number, "m", Need::Required, "Across the rectangle; greater than zero.");
pub const SLAB_EDGE_U: Key =
    key("edge_u", Value::Vector, "m", Need::Required, "Full edge of the rectangle half-way through the slab.");
pub const CURVATURE_RADIUS: Key =
    key("curvature_radius", Value::Number, "m", Need::Required, "Of the curved face; greater than zero.");
pub const LENS_AXIS: Key =
    key("axis", Value::Vector, "", Need::Required, "From the vertex to the flat face; any length but zero.");
pub const LENS_RIM: Key =
    key("rim_radius", Value::Number, "m", Need::Required, "Of the flat face; at most curvature_radius.");

/// The bodies that can be of glass.
pub const GLASSES: Table = Table {
    path: "glass",
    keys: &[
        key(SPHERE, Value::Tables(&GLASS_SPHERE), "", NONE, "Ball."),
        key("slab", Value::Tables(&GLASS_SLAB), "", NONE, "Rectangular plate."),
        key("plano_convex", Value::Tables(&GLASS_PLANO_CONVEX), "", NONE, "Lens with one flat face."),
    ],
};
pub const GLASS_SPHERE: Table = Table { path: "glass.sphere", keys: &[CENTER, RADIUS, IOR] };
pub const GLASS_SLAB: Table = Table { path: "glass.slab", keys: &[CENTER, SLAB_EDGE_U, EDGE_V, THICKNESS, IOR] };
pub const GLASS_PLANO_CONVEX: Table =
    Table { path: "glass.plano_convex", keys: &[VERTEX, LENS_AXIS, CURVATURE_RADIUS, LENS_RIM, IOR] };

pub const DIFFUSE_ALBEDO: Key =
    key("albedo", Value::Number, "", Need::Required, "Share of the arriving power that is sent back, from 0 to 1.");
pub const DIFFUSE_EXITANCE: Key = key(
    "exitance",
    Value::Number,
    "W/m²",
    Need::Default("0.0"),
    "Power sent out per area of its own accord, Lambertian; zero or greater.",
);
pub const INWARD: Key = key(
    "inward",
    Value::Flag,
    "",
    Need::Default("false"),
    "Whether the inside is the diffuse side: an enclosure, around everything else.",
);
pub const TRANSMITTANCE: Key = key(
    "transmittance",
    Value::Number,
    "",
    Need::Default("0.0"),
    "Of an inward sphere that emits nothing: share of the arriving power that comes out on the other side, diffusely, as \
     of a lampshade, which encloses nothing; at most 1 with the albedo, and the outside sends nothing back.",
);

/// Further diffuse surfaces.
pub const DIFFUSES: Table = Table {
    path: "diffuse",
    keys: &[
        key(RECTANGLE, Value::Tables(&DIFFUSE_RECTANGLE), "", NONE, "Flat rectangle."),
        key(DISK, Value::Tables(&DIFFUSE_DISK), "", NONE, "Flat disk."),
        key(TRIANGLE, Value::Tables(&DIFFUSE_TRIANGLE), "", NONE, "Flat triangle: three vertices."),
        key(SPHERE, Value::Tables(&DIFFUSE_SPHERE), "", NONE, "Sphere, outside or inside."),
    ],
};
pub const DIFFUSE_RECTANGLE: Table =
    Table { path: "diffuse.rectangle", keys: &[CENTER, EDGE_U, EDGE_V, DIFFUSE_ALBEDO, DIFFUSE_EXITANCE] };
pub const DIFFUSE_DISK: Table =
    Table { path: "diffuse.disk", keys: &[CENTER, NORMAL, RADIUS, DIFFUSE_ALBEDO, DIFFUSE_EXITANCE] };
pub const DIFFUSE_TRIANGLE: Table =
    Table { path: "diffuse.triangle", keys: &[VERTICES, DIFFUSE_ALBEDO, DIFFUSE_EXITANCE] };
pub const DIFFUSE_SPHERE: Table = Table {
    path: "diffuse.sphere",
    keys: &[CENTER, RADIUS, DIFFUSE_ALBEDO, DIFFUSE_EXITANCE, INWARD, TRANSMITTANCE],
};

pub const RAYS: Key =
    key("rays", Value::Count, "", Need::Default("1000000"), "Rays that leave the sources, at least; 1 or more.");
pub const TEXELS: Key = key(
    "map",
    Value::CountPair,
    "",
    Need::Default("[64, 64]"),
    "Texels along s and t on the receiver and on each diffuse surface.",
);
pub const DEPTH: Key = key(
    "depth",
    Value::Count,
    "",
    Need::Default("16"),
    "Most interactions with mirrors and glass on one path (0 to 256); what is left is booked as terminated.",
);
pub const AIM: Key = key(
    "aim",
    Value::Text,
    "",
    Need::Default("\"optics\""),
    "Where most rays are sent: optics (the rest elsewhere, weighed so that nothing is lost) or nowhere.",
);
pub const SPLIT: Key = key(
    "split",
    Value::Text,
    "",
    Need::Default("\"one\""),
    "At a face of glass: one (reflected or refracted, at random, whole) or both (each with its share).",
);
pub const RINGS: Key = key(
    "rings",
    Value::Table(&LIGHT_RINGS),
    "",
    NONE,
    "Rings on the receiver in which light is counted by its number of interactions.",
);
pub const TILES: Key = key(
    "tiles",
    Value::CountPair,
    "",
    NONE,
    "Tiles of the receiver, along s and t, in which light is counted by its number of interactions; 4096 at most.",
);
/// How light is followed.
pub const LIGHTS: Table = Table { path: "light", keys: &[RAYS, TEXELS, DEPTH, AIM, SPLIT, RINGS, TILES] };
pub const RING_COUNT: Key = key("count", Value::Count, "", Need::Required, "Rings of equal width, from 1 to 4096.");
pub const RING_RADIUS: Key =
    key("radius", Value::Number, "m", Need::Required, "Outer radius of the last ring; greater than zero.");
pub const LIGHT_RINGS: Table = Table { path: "light.rings", keys: &[CENTER, RING_RADIUS, RING_COUNT] };

pub const KIND: Key = key(
    "kind",
    Value::Text,
    "",
    Need::Required,
    "orthographic (rays side by side, `width`) or perspective (rays from one point, `fov`).",
);
pub const EYE: Key = key("eye", Value::Vector, "m", Need::Required, "Where it stands, outside of all bodies.");
pub const LOOK_AT: Key =
    key("look_at", Value::Vector, "m", Need::Required, "A point that the middle of the picture shows.");
pub const UP: Key = key(
    "up",
    Value::Vector,
    "",
    Need::Default("[0, 0, 1]"),
    "What is upwards in the picture; any length but zero, not along the line of sight.",
);
pub const WIDTH: Key = key(
    "width",
    Value::Number,
    "m",
    Need::Default("none; an orthographic camera needs it"),
    "Of what an orthographic camera sees; greater than zero.",
);
pub const FOV: Key = key(
    "fov",
    Value::Number,
    "degrees",
    Need::Default("none; a perspective camera needs it"),
    "The full angle across the picture's width; between 0 and 180.",
);
pub const PIXELS: Key = key(
    "pixels",
    Value::CountPair,
    "",
    Need::Default("[640, 480]"),
    "Width and height of the picture; at most 4194304 pixels in all.",
);
/// From where pictures are made.
pub const CAMERAS: Table = Table { path: "camera", keys: &[KIND, EYE, LOOK_AT, UP, WIDTH, FOV, PIXELS] };

pub const LINE: Key =
    key("line", Value::Table(&MEASURE_LINE), "", NONE, "Points along a line (an arc, on a sphere).");
pub const GRID: Key =
    key("grid", Value::CountPair, "", NONE, "Centres of nu × nv cells of equal area of the receiver.");
pub const POINT: Key =
    key("point", Value::Tables(&MEASURE_POINT), "", NONE, "Points of any pose; no receiver is needed.");

/// Where to look: any of line, grid and points, measured in that order.
pub const MEASURES: Table = Table { path: "measure", keys: &[LINE, GRID, POINT] };

pub const FROM: Key = key("from", Value::Vector, "m", Need::Required, "First point, on the receiver.");
pub const TO: Key = key("to", Value::Vector, "m", Need::Required, "Last point, on the receiver.");
pub const POINTS: Key = key("points", Value::Count, "", Need::Required, "How many, ends included; at least 2.");
pub const MEASURE_LINE: Table = Table { path: "measure.line", keys: &[FROM, TO, POINTS] };

pub const POSITION: Key = key("position", Value::Vector, "m", Need::Required, "Where.");
pub const MEASURE_POINT: Table = Table { path: "measure.point", keys: &[POSITION, NORMAL] };

pub const STRATEGIES: Key = key(
    "strategies",
    Value::Texts,
    "",
    Need::Default("[\"random\", \"correlated\", \"stratified\"]"),
    "Ways of choosing points on the sources.",
);
pub const SAMPLES: Key = key(
    "samples",
    Value::Counts,
    "",
    Need::Default("[1, 4, 16, 64, 256, 1024]"),
    "Points on each source, per shading point, per replicate.",
);
pub const REPLICATES: Key = key(
    "replicates",
    Value::AutoOrCount,
    "",
    Need::Default("\"auto\""),
    "Independent repeats: at least 2, or as many as smallest_bias needs.",
);
pub const SMALLEST_BIAS: Key = key(
    "smallest_bias",
    Value::Table(&BIAS),
    "",
    Need::Default("{ mean = 1e-2, point = 1e-1 }"),
    "What a pass must have been able to see.",
);
pub const TOLERANCE: Key = key(
    "tolerance",
    Value::Number,
    "",
    Need::Default("0.0"),
    "Relative; a deviation up to this is no fault. From 0 to below 1.",
);

/// How to study the case.
pub const STUDIES: Table =
    Table { path: "study", keys: &[STRATEGIES, SAMPLES, REPLICATES, SMALLEST_BIAS, TOLERANCE, ACCEPTED] };

pub const ACCEPTED: Key = key(
    "accepted",
    Value::Tables(&ACCEPTANCE),
    "",
    NONE,
    "A deviation that is known and accepted: a verdict that fails by no more passes, and says so.",
);
pub const PROPERTY: Key = key("property", Value::Text, "", Need::Required, "bias, variance or covariance.");
pub const OF_STRATEGY: Key =
    key("strategy", Value::Text, "", Need::Default("every strategy"), "The strategy that deviates.");
pub const SIZE: Key = key(
    "size",
    Value::Number,
    "",
    Need::Required,
    "Relative, greater than 0; the failure's whole 95 % interval must lie within.",
);
pub const REASON: Key = key("reason", Value::Text, "", Need::Required, "Why it is accepted, for the report.");
pub const ACCEPTANCE: Table = Table { path: "study.accepted", keys: &[PROPERTY, OF_STRATEGY, SIZE, REASON] };

pub const MEAN: Key = key("mean", Value::Number, "", Need::Default("1e-2"), "Relative, of the mean over the points.");
pub const AT_POINT: Key = key(
    "point",
    Value::Number,
    "",
    Need::Default("1e-1"),
    "Relative, at each point that a tenth of the light reaches.",
);
pub const BIAS: Table = Table { path: "study.smallest_bias", keys: &[MEAN, AT_POINT] };

#[cfg(test)]
mod tests {
    use super::*;

    fn tables_below(table: &'static Table, found: &mut Vec<&'static Table>) {
        found.push(table);
        for key in table.keys.iter().filter(|key| key.need != Need::Later) {
            if let Some(below) = key.value.table() {
                assert_eq!(below.path, table.full_name(key.name), "a table's path is its key's full name");
                tables_below(below, found);
            }
        }
    }

    #[test]
    fn every_key_has_one_meaning_and_stands_in_the_documentation() {
        let mut tables = Vec::new();
        tables_below(&ROOT, &mut tables);
        assert_eq!(tables.len(), 44);
        let text = ROOT.to_string();
        for table in tables {
            for (at, key) in table.keys.iter().enumerate() {
                assert!(table.keys[..at].iter().all(|other| other.name != key.name), "{} twice", key.name);
                assert!(key.meaning.ends_with('.') && text.contains(key.meaning), "{}", key.name);
            }
        }
        assert!(
            text.contains("\n[source.disk]\n  center        an array of three numbers, m; required. Centre.\n"),
            "{text}"
        );
    }
}
