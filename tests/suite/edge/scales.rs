//! Size and brightness: neither moves more than the numbers that they are in.

use etendue::case::shipped;
use etendue::estimator::{Job, Scratch, for_technique};
use etendue::oracle::Oracle;
use etendue::sampling::{Purpose, Strategy, StreamKey};
use etendue::trial::{Effort, Overrides, Settings};

use super::{Change, SAME, assert_sound, bound, irradiance};

/// About 10⁻⁶ and 10⁶ of all lengths, 10⁻¹² and 10¹² of all light.
const SIZES: [f64; 2] = [1.0 / (1 << 20) as f64, (1 << 20) as f64];
const LIGHTS: [f64; 2] = [1.0 / (1_u64 << 40) as f64, (1_u64 << 40) as f64];

fn changes() -> impl Iterator<Item = Change> {
    SIZES.into_iter().zip(LIGHTS).map(|(size, light)| Change { size, light, ..SAME })
}

/// Shipped cases that are one text.
fn names() -> Vec<String> {
    let names = shipped().map(|case| case.name().to_owned());
    // A mesh and a picture are files beside it; the tiled ball's chessboard is an albedo.
    names
        .filter(|name| !["eclipse-mesh", "picture-panel", "tiled-ball"].iter().any(|end| name.ends_with(end)))
        .collect()
}

#[test]
fn a_change_reaches_every_number_that_it_is_about() {
    let text = "radius = 0.5 # 7\nline = { from = [1.0, 0.0], points = 3 }\nvertices = [\n  [2.0, 3.0],\n]\npower = 2\n\
                exitance = 1_0.0\nfile = \"radius = 2.0\"\nnormal = [0.0, -1.0]\n";
    let change = Change { size: 2.0, shift: 1.0, light: 3.0 };
    let expected = "radius = 1e0 \nline = { from = [3e0, 1e0], points = 3 }\nvertices = [\n  [5e0, 7e0],\n]\npower = 2.4e1\n\
                    exitance = 3e1\nfile = \"radius = 2.0\"\nnormal = [0.0, -1.0]\n";
    assert_eq!(change.text(text), expected);
    for name in names() {
        let plain = shipped().find(|case| case.name() == name).unwrap().read().unwrap();
        assert_eq!(SAME.case(&name).unwrap().configuration, plain.configuration, "{name}");
    }
}

#[test]
fn size_and_brightness_move_no_bit_of_the_exact_side() {
    let mut told = 0;
    for name in names() {
        let plain = SAME.case(&name).unwrap();
        for change in changes() {
            let other = change.case(&name).unwrap_or_else(|mistakes| panic!("{name}: {mistakes}"));
            let [here, there] = [&plain, &other].map(|case| Oracle::new(&case.configuration));
            let points = plain.configuration.points().iter().zip(other.configuration.points());
            for (k, (p, q)) in points.step_by(2).enumerate() {
                let (a, b) = (here.at(p), there.at(q));
                let what = format!("{name} {k} {change:?}: {a:?} {b:?}");
                assert_eq!((a.region, a.method, a.shadow_edge), (b.region, b.method, b.shadow_edge), "{what}");
                assert_eq!(a.form_factor, b.form_factor, "{what}");
                assert_eq!(irradiance(&a) * change.light, irradiance(&b), "{what}");
                assert_eq!(bound(&a) * change.light, bound(&b), "{what}");
                if k % 8 == 0 && name.starts_with("penumbra") {
                    let of =
                        |oracle: &Oracle, point| oracle.area_moments(0, point).map(|found| found.spread().variance);
                    let square = change.light * change.light;
                    assert_eq!(of(&here, p).map(|v| v * square), of(&there, q), "{what}");
                }
                told += 1;
            }
        }
    }
    assert!(told > 1000, "{told} points");
}

#[test]
fn size_and_brightness_move_no_bit_of_an_estimate() {
    let names = [
        "direct/diffuser-box",
        "direct/l-shaped-source",
        "penumbra/overlapping-occluders",
        "penumbra/spheres",
        "penumbra/l-shaped-occluder",
        "texture/checker-panel",
    ];
    for name in names {
        for change in changes() {
            let [plain, other] = [SAME, change].map(|change| change.case(name).unwrap().configuration);
            for strategy in Strategy::ALL {
                let cell = StreamKey::cell(1, 2, Purpose::Measurement, strategy, 49);
                let estimates = [&plain, &other].map(|room| {
                    let points = &room.points()[room.points().len() / 3..][..8];
                    let mut estimates = vec![f64::NAN; 2 * points.len()];
                    let job = Job { strategy, samples: 49, cell, replicates: 0..2, points };
                    for_technique(room, strategy.technique()).estimate(&job, &mut Scratch::default(), &mut estimates);
                    estimates
                });
                assert!(estimates[0].iter().sum::<f64>() > 0.0, "{name} {strategy}");
                let scaled: Vec<f64> = estimates[0].iter().map(|estimate| estimate * change.light).collect();
                assert_eq!(scaled, estimates[1], "{name} {strategy} {change:?}");
            }
        }
    }
}

/// Shapes, optics, eye paths and rays from the light; decimals, which no power of two makes.
#[test]
fn a_micrometre_and_a_thousand_kilometres_pass_as_a_metre_does() {
    let names = [
        "caustic/glass-ball",
        "caustic/paraboloid",
        "caustic/slab",
        "caustic/spherical-mirror",
        "interreflection/furnace-with-glass",
        "interreflection/lampshade",
        "penumbra/three-regions",
        "texture/checker-panel",
    ];
    let overrides = Overrides { samples: Some(vec![1, 9]), ..Overrides::default() };
    let settings = Settings { seed: 3, effort: Effort::Quick, overrides };
    let changes = [(1e-6, 1e-12), (1e6, 1e12)].map(|(size, light)| Change { size, light, ..SAME });
    let [plain, small, large] = [SAME, changes[0], changes[1]].map(|change| {
        let cases = names.map(|name| change.case(name).unwrap_or_else(|mistakes| panic!("{mistakes}")));
        assert_sound(&format!("{change:?}"), &cases, &settings)
    });
    for (change, other) in changes.into_iter().zip([small, large]) {
        for (here, there) in plain.cases.iter().zip(&other.cases) {
            assert_eq!(here.verdicts().count(), there.verdicts().count(), "{}", here.name);
            for (a, b) in here.truths.iter().zip(&there.truths) {
                assert_eq!(a.region, b.region, "{}", here.name);
            }
            // Variances are those of the same room, times the square of its light.
            for (a, b) in here.strategies.iter().zip(&there.strategies) {
                for (a, b) in a.cells.iter().zip(&b.cells).flat_map(|(a, b)| a.points.iter().zip(&b.points)) {
                    let [a, b] = [(a, 1.0), (b, change.light)]
                        .map(|(point, light)| point.predicted_variance.map(|variance| variance / (light * light)));
                    assert_eq!(a.is_some(), b.is_some(), "{}", here.name);
                    let (a, b) = (a.unwrap_or(0.0), b.unwrap_or(0.0));
                    assert!((a - b).abs() <= 1e-6 * a, "{} {change:?}: {a:e} {b:e}", here.name);
                }
            }
        }
    }
}

/// Beyond, squares of variances are no numbers, and the gate would see faults in what is right.
#[test]
fn light_that_no_square_of_a_variance_can_hold_is_refused() {
    let said = |change: Change| change.case("penumbra/eclipse").map(|_| ()).unwrap_err().to_string();
    for (light, words) in [
        (1e-300, "exitance is 1e-300 W/m²; where it is not zero it lies from 1e-30 to 1e30"),
        (1e300, "`source.disk.exitance` is 1e300; no number lies beyond ±1e30"),
    ] {
        let said = said(Change { light, ..SAME });
        assert!(said.contains(words) && said.contains("penumbra/eclipse:"), "{said}");
    }
    for light in [1e-30, 1e30] {
        let change = Change { light, ..SAME };
        let settings = Settings { seed: 5, effort: Effort::Quick, overrides: Overrides::default() };
        assert_sound(&format!("{change:?}"), &[change.case("penumbra/three-regions").unwrap()], &settings);
    }
    let lamp = Change { light: 1e-200, ..SAME }.case("interreflection/lampshade").unwrap_err().to_string();
    assert!(lamp.contains("the power is 6") && lamp.contains("from 1e-30 to 1e30"), "{lamp}");
}
