//! Which formulas the exact side used in a room, and where they come from.

use crate::configuration::Role;
use crate::oracle::Region;
use crate::report::record::CaseRecord;

/// A formula, as text, and who found it.
struct Formula {
    says: &'static str,
    source: &'static str,
}

const DISK: Formula = Formula {
    says: "disk: E = M/2 · [1 − (h² + a² − R²) / √((h² + a² + R²)² − 4 a² R²)] for a patch parallel to it, h below and a aside; \
           tilted, the contour integral E = M/(2π) ∮ n · (ω × dω) around the part of its rim above the horizon",
    source: "Hamilton and Morgan 1952; contour: Moon 1936, Sparrow 1963",
};
const POLYGON: Formula = Formula {
    says: "rectangle, polygon: E = M/(2π) Σ γᵢ (n · gᵢ), over the edges: γᵢ the angle under which edge i is seen, gᵢ the unit \
           normal of the plane through it and the point; clipped to the horizon",
    source: "Lambert 1760",
};
const SPHERE: Formula = Formula {
    says: "sphere: E = M (R/d)² cos θ wholly above the horizon; cut by it, the contour integral around what is left of its circle \
           of directions",
    source: "Hamilton and Morgan 1952; cut: Moon 1936",
};
const HIDDEN: Formula = Formula {
    says: "behind occluders: what is left of the source is a set of directions bounded by arcs of great circles (straight \
           edges) and of circles (rims of disks and spheres); E = M/(2π) Σ ∮ n · (ω × dω) over these arcs, each in closed form",
    source: "Moon 1936, Sparrow 1963",
};
const TEXTURED: Formula = Formula {
    says: "where exitance varies over the source: the integral of M(s, t) with the same kernel, texel by texel or moment by \
           moment, in closed form where the pieces allow it and else by quadrature with a stated bound",
    source: "Chen and Arvo 2000",
};
const BENT: Formula = Formula {
    says: "bent light: flux is kept along a tube of rays, so a ring gets the integral over the rays that land in it of Fresnel’s \
           transmittances and the mirrors’ reflectances",
    source: "Burkard and Shealy 1981",
};
const EXCHANGED: Formula = Formula {
    says: "light sent on by diffuse surfaces: B = M + ϱ E with form factors F, solved in closed form in enclosures (a furnace has \
           M/(1 − ϱ) everywhere) and at Gauss’s nodes between plates",
    source: "Hottel and Sarofim 1967",
};

/// As a list of HTML. Empty where nothing is known of the room.
pub fn formulas(case: &CaseRecord) -> String {
    let has = |role: Role, shapes: &[&str]| {
        case.figures.iter().any(|figure| figure.role == role && shapes.contains(&figure.shape.as_str()))
    };
    let any = |role: Role| case.figures.iter().any(|figure| figure.role == role);
    let measured = !case.points.is_empty();
    let in_part = case.points.iter().any(|point| matches!(point.region, Region::Penumbra | Region::Umbra));
    let used = [
        (measured && has(Role::Source, &["disk"]), DISK),
        (measured && has(Role::Source, &["rectangle", "polygon", "triangle"]), POLYGON),
        (measured && has(Role::Source, &["sphere"]), SPHERE),
        (measured && in_part && any(Role::Occluder), HIDDEN),
        (measured && case.figures.iter().any(|figure| figure.role == Role::Source && figure.is_textured), TEXTURED),
        (any(Role::Mirror) || any(Role::Glass), BENT),
        (any(Role::Diffuse), EXCHANGED),
    ];
    let items: String = used
        .iter()
        .filter(|(is_used, _)| *is_used)
        .map(|(_, formula)| format!("<li>{} <span class=\"note\">({})</span></li>", formula.says, formula.source))
        .collect();
    if items.is_empty() { String::new() } else { format!("<ul class=\"formulas\">{items}</ul>\n") }
}
