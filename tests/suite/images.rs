//! Images of other renderers: what is right passes, what is wrong is caught and named, what is no image is refused.
//!
//! Planted images are our own exact means with noise on top, so that nothing but the planted fault is wrong with them.

use std::f64::consts::PI;
#[cfg(feature = "cli")]
use std::path::Path;

#[cfg(feature = "cli")]
use assert_cmd::Command;
use etendue::case::{SmallestBias, Study};
use etendue::configuration::{Arrangement, MeasurementPoint, Receiver, ReceiverShape, Source};
use etendue::external::image::Stack;
use etendue::external::recipe::{self, Inexpressible, Order};
use etendue::external::{Manifest, PixelGrid};
use etendue::geometry::{DVec3, Disk, Rectangle, Shape};
use etendue::radiometry::{Albedo, Exitance};
use etendue::statistics::budget::seed_of;
use etendue::trial::{ImageTerms, ImagesOutcome, as_judged, judge_images};
use etendue::{Case, Configuration, Draws, Verdict};

const RHO: f64 = 0.8;

/// A lamp and a board, neither in the middle, so that no two corners of the receiver look alike.
fn room(occluded: bool) -> Case {
    let lamp = Disk::new(DVec3::new(0.3, 0.15, 1.0), -DVec3::Z, 0.3).unwrap();
    let source = Source::new(Shape::Disk(lamp), Exitance::new(2.0)).unwrap();
    let board = Rectangle::new(DVec3::new(-0.1, -0.2, 0.4), DVec3::X * 0.5, DVec3::Y * 0.7).unwrap();
    let floor = Rectangle::new(DVec3::ZERO, DVec3::X * 2.4, DVec3::Y * 2.4).unwrap();
    let receiver = Receiver::new(ReceiverShape::Rectangle(floor), Some(Albedo::new(RHO))).unwrap();
    let point = MeasurementPoint::new(DVec3::X, DVec3::Z).unwrap();
    let occluders = if occluded { vec![Shape::Rectangle(board)] } else { vec![] };
    let room =
        Configuration::new(vec![source], occluders, Some(receiver), vec![point], Arrangement::Scattered).unwrap();
    Case::new("room", "A room", room, Study::default())
}

/// The exact means of a room's pixels, in radiance, and what is planted into images of them.
struct Planter {
    case: Case,
    grid: PixelGrid,
    exact: Vec<f64>,
    draws: Draws,
}

/// Relative noise of a pixel of one image.
const NOISE: f64 = 0.08;

impl Planter {
    fn new(test: &str, occluded: bool, size: [usize; 2]) -> Planter {
        let case = room(occluded);
        let grid = PixelGrid::of_receiver(&case.configuration, size).unwrap();
        let blank = Stack {
            width: size[0],
            height: size[1],
            values: vec![1.0; size[0] * size[1]],
            variance: None,
            is_half: false,
        };
        let outcome = judge_images(&case, &grid, &blank, &terms());
        assert_eq!(outcome.verdict(), None, "one image without a variance gets no verdict");
        let exact = outcome.pixels.iter().map(|pixel| pixel.truth.irradiance * RHO / PI).collect();
        Planter { case, grid, exact, draws: Draws::new(seed_of(test)) }
    }

    /// A sum of twelve uniform numbers: mean 0, variance 1.
    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.draws.unit()).sum::<f64>() - 6.0
    }

    fn noise(&mut self) -> Vec<f64> {
        (0..self.exact.len()).map(|_| NOISE * self.normal()).collect()
    }

    /// Images whose means are `of`, with fresh noise in proportion to the means.
    fn images(&mut self, n: usize, of: &[f64]) -> Stack {
        let values = (0..n).flat_map(|_| {
            let noise = self.noise();
            of.iter().zip(noise).map(|(x, r)| x * (1.0 + r)).collect::<Vec<_>>()
        });
        let values = values.collect();
        Stack { width: self.grid.width, height: self.grid.height, values, variance: None, is_half: false }
    }

    fn judged(&self, stack: &Stack) -> ImagesOutcome {
        judge_images(&self.case, &self.grid, stack, &terms())
    }

    /// The exact mean in a pixel, or in the nearest that there is.
    fn at(&self, column: isize, row: isize) -> f64 {
        let (w, h) = (self.grid.width as isize, self.grid.height as isize);
        self.exact[(row.clamp(0, h - 1) * w + column.clamp(0, w - 1)) as usize]
    }

    fn picture(&self, value: impl Fn(isize, isize) -> f64) -> Vec<f64> {
        let (w, h) = (self.grid.width as isize, self.grid.height as isize);
        (0..h).flat_map(|row| (0..w).map(move |column| (column, row))).map(|(c, r)| value(c, r)).collect()
    }
}

fn terms() -> ImageTerms<'static> {
    ImageTerms {
        name: "planted",
        reproduce: "etendue verify".to_owned(),
        irradiance_of_value: PI / RHO,
        rho: RHO,
        samples_per_pixel: 64,
        first_sample_at_centre: false,
        tolerance: 0.0,
        ray_epsilon: None,
        smallest_bias: SmallestBias { mean: 5e-2, point: 0.4 },
    }
}

fn of<'a>(outcome: &'a ImagesOutcome, property: &str) -> &'a etendue::trial::JudgedProperty {
    outcome.verdicts.iter().find(|judged| judged.property == property).expect("judged")
}

#[test]
fn right_images_pass() {
    // Sixteen images do not tell the spread along a shadow's edge; what independent samples could have stands in for it, and
    // that is far more than what is planted here.
    for (occluded, size, n, point) in
        [(false, [24, 24], 16, 0.4), (true, [32, 20], 16, 2.5), (true, [5, 5], 400, 0.4), (false, [3, 1], 400, 0.4)]
    {
        let mut planter = Planter::new("right_images_pass", occluded, size);
        let exact = planter.exact.clone();
        for _ in 0..6 {
            let stack = planter.images(n, &exact);
            let terms = ImageTerms { smallest_bias: SmallestBias { mean: 5e-2, point }, ..terms() };
            let outcome = judge_images(&planter.case, &planter.grid, &stack, &terms);
            for judged in &outcome.verdicts {
                // Three pixels are too few to see a correlation in.
                let least =
                    if size == [3, 1] && judged.property != "bias" { Verdict::Undecided } else { Verdict::Pass };
                assert!(judged.verdict == least || judged.verdict == Verdict::Pass, "{size:?}: {}", judged.words);
            }
            assert!(outcome.cause.is_none());
            assert!(outcome.footprint_error.iter().all(|share| *share < 0.011), "{:?}", outcome.footprint_error);
        }
    }
}

#[test]
fn regions_are_told_apart() {
    let mut planter = Planter::new("regions_are_told_apart", true, [48, 48]);
    let exact = planter.exact.clone();
    let stack = planter.images(16, &exact);
    let outcome = planter.judged(&stack);
    let names: Vec<&str> = outcome.parts.iter().map(|part| part.name).collect();
    assert_eq!(names, ["all", "lit", "penumbra", "umbra", "edge"]);
    let all: usize = outcome.parts[1..].iter().map(|part| part.n_pixels).sum();
    assert_eq!(all, 48 * 48);
    assert!(outcome.parts.iter().all(|part| part.n_pixels > 4), "{:?}", outcome.parts);
    let chi_square = outcome.parts[1].chi_square.unwrap();
    assert!((0.85..1.15).contains(&chi_square), "{chi_square}");
}

/// Each fault with the name and a word of its cause.
#[test]
fn planted_faults_are_caught_and_named() {
    let mut planter = Planter::new("planted_faults_are_caught_and_named", false, [24, 24]);
    let exact = planter.exact.clone();
    let scaled = |factor: f64| exact.iter().map(|x| x * factor).collect::<Vec<f64>>();
    let last = 23;
    let cosine = |planter: &Planter| {
        // A small source's cosine at the receiver, h / r; the lamp is large enough to tell.
        let middle = |p: usize| planter.grid.middle(planter.grid.place(p));
        let lost = |(p, x): (usize, &f64)| x * (DVec3::new(0.3, 0.15, 1.0) - middle(p)).length();
        exact.iter().enumerate().map(lost).collect::<Vec<f64>>()
    };
    let most = exact.iter().copied().fold(0.0, f64::max);
    let faults: Vec<(&str, &str, Vec<f64>)> = vec![
        ("factor", "a factor pi (", scaled(PI)),
        ("factor", "a factor 1/pi", scaled(1.0 / PI)),
        ("factor", "a factor 2 (", scaled(2.0)),
        ("factor", "a factor 1/rho", scaled(1.0 / RHO)),
        ("factor", "a factor rho (", scaled(RHO)),
        ("factor", "irradiance already", scaled(PI / RHO)),
        ("factor", "a factor of 0.9", scaled(0.93)),
        ("mirrored", "left to right", planter.picture(|c, r| planter.at(last - c, r))),
        ("mirrored", "upside down", planter.picture(|c, r| planter.at(c, last - r))),
        ("turned", "half a turn", planter.picture(|c, r| planter.at(last - c, last - r))),
        ("transposed", "rows and columns", planter.picture(|c, r| planter.at(r, c))),
        ("shifted", "by a pixel: right", planter.picture(|c, r| planter.at(c - 1, r))),
        ("cosine", "at the receiver", cosine(&planter)),
        ("added", "added everywhere", exact.iter().map(|x| x + 0.02 * most).collect()),
        ("clamped", "clamped", exact.iter().map(|x| x.min(0.7 * most)).collect()),
    ];
    for (name, words, wrong) in faults {
        let stack = planter.images(64, &wrong);
        let outcome = planter.judged(&stack);
        let bias = of(&outcome, "bias");
        assert_eq!(bias.verdict, Verdict::Fail, "{name} {words}");
        let cause = outcome.cause.clone().unwrap_or_else(|| panic!("{name} {words}: no cause; {}", bias.words));
        assert!(cause.name == name && cause.words.contains(words), "{name} {words}: {cause:?}");
        assert!(bias.words.contains("Likely cause"), "{}", bias.words);
    }
}

#[test]
fn half_a_pixel_is_seen_as_such() {
    let mut planter = Planter::new("half_a_pixel_is_seen_as_such", false, [24, 24]);
    // The exact means of a grid twice as fine, joined anew half a pixel on.
    let fine = Planter::new("half_a_pixel_is_seen_as_such", false, [48, 48]);
    for (step, words) in [([1, 0], "half a pixel: right"), ([0, -1], "half a pixel: up"), ([1, 1], "right and down")]
    {
        let shifted = planter.picture(|c, r| {
            let at = |i: isize, j: isize| fine.at(2 * c + i - step[0], 2 * r + j - step[1]);
            0.25 * (at(0, 0) + at(1, 0) + at(0, 1) + at(1, 1))
        });
        let stack = planter.images(64, &shifted);
        let outcome = planter.judged(&stack);
        assert_eq!(of(&outcome, "bias").verdict, Verdict::Fail);
        let cause = outcome.cause.expect("named");
        assert!(cause.name == "shifted" && cause.words.contains(words), "{words}: {cause:?}");
    }
}

#[test]
fn middles_are_told_from_means() {
    let mut planter = Planter::new("middles_are_told_from_means", false, [6, 6]);
    let outcome = {
        let exact = planter.exact.clone();
        let stack = planter.images(2000, &exact);
        planter.judged(&stack)
    };
    let middles: Vec<f64> = outcome.pixels.iter().map(|pixel| pixel.truth.middle * RHO / PI).collect();
    let stack = planter.images(2000, &middles);
    let cause = planter.judged(&stack).cause.expect("named");
    assert_eq!(cause.name, "middles", "{cause:?}");
}

#[test]
fn light_in_the_umbra_is_a_leak() {
    let mut planter = Planter::new("light_in_the_umbra_is_a_leak", true, [48, 48]);
    let exact = planter.exact.clone();
    let right = planter.images(16, &exact);
    let outcome = planter.judged(&right);
    let umbra: Vec<usize> = (0..exact.len())
        .filter(|p| outcome.pixels[*p].truth.region == Some(etendue::oracle::Region::Umbra))
        .collect();
    // A single ray of all of them is one too many.
    let mut stack = right.clone();
    stack.values[7 * exact.len() + umbra[umbra.len() / 2]] = 1e-6;
    let outcome = planter.judged(&stack);
    assert_eq!(of(&outcome, "bias").verdict, Verdict::Fail);
    let mut stack = right;
    for k in 0..16 {
        umbra.iter().for_each(|p| stack.values[k * exact.len() + p] = 1e-4 * (1.0 + 0.5 * planter.draws.unit()));
    }
    let outcome = planter.judged(&stack);
    let cause = outcome.cause.as_ref().expect("named");
    assert!(cause.name == "leak" && of(&outcome, "bias").words.contains("umbra"), "{cause:?}");
}

#[test]
fn a_filter_gives_itself_away() {
    let mut planter = Planter::new("a_filter_gives_itself_away", false, [24, 24]);
    let exact = planter.exact.clone();
    let mut stack = planter.images(16, &exact);
    for k in 0..16 {
        let image: Vec<f64> = stack.image(k).iter().zip(&exact).map(|(x, e)| x / e - 1.0).collect();
        for (p, x) in exact.iter().enumerate() {
            let (c, r) = ((p % 24) as isize, (p / 24) as isize);
            let near = |i: isize, j: isize| image[((r + j).clamp(0, 23) * 24 + (c + i).clamp(0, 23)) as usize];
            let sum: f64 = (-1..=1).flat_map(|j| (-1..=1).map(move |i| (i, j))).map(|(i, j)| near(i, j)).sum();
            stack.values[k * exact.len() + p] = x * (1.0 + sum / 9.0);
        }
    }
    let outcome = planter.judged(&stack);
    let neighbours = of(&outcome, "neighbours");
    assert_eq!(neighbours.verdict, Verdict::Fail, "{}", neighbours.words);
    assert!(neighbours.effect > 0.5 && outcome.cause.as_ref().is_some_and(|cause| cause.name == "filter"));
    assert_ne!(of(&outcome, "bias").verdict, Verdict::Fail, "it is a filter, not a bias");
    assert!(outcome.notes.iter().any(|note| note.contains("move together")), "{:?}", outcome.notes);
}

#[test]
fn streams_that_are_used_twice_are_seen() {
    let mut planter = Planter::new("streams_that_are_used_twice_are_seen", false, [12, 12]);
    let exact = planter.exact.clone();
    let n = exact.len();
    // Half of an image's noise is that of the image before.
    let mut last = planter.noise();
    let mut stack = planter.images(32, &exact);
    for k in 0..32 {
        let fresh = planter.noise();
        let noise: Vec<f64> = last.iter().zip(fresh).map(|(a, b)| 0.6 * a + 0.8 * b).collect();
        (0..n).for_each(|p| stack.values[k * n + p] = exact[p] * (1.0 + noise[p]));
        last = noise;
    }
    let outcome = planter.judged(&stack);
    assert_eq!(of(&outcome, "images").verdict, Verdict::Fail, "{}", of(&outcome, "images").words);
    // The stream of a pixel is that of its right neighbour in the next image, in one row.
    let mut stack = planter.images(40, &exact);
    for k in 1..40 {
        for p in 60..70 {
            stack.values[k * n + p + 1] = exact[p + 1] / exact[p] * stack.values[(k - 1) * n + p];
        }
    }
    let outcome = planter.judged(&stack);
    let images = of(&outcome, "images");
    assert!(images.verdict == Verdict::Fail && images.words.contains("follow pixels"), "{}", images.words);
    assert_eq!(outcome.cause.expect("named").name, "streams");
}

#[test]
fn one_image_is_judged_by_the_variance_that_it_states() {
    let mut planter = Planter::new("one_image_is_judged_by_the_variance_that_it_states", false, [32, 32]);
    let exact = planter.exact.clone();
    let variance: Vec<f64> = exact.iter().map(|x| (x * NOISE).powi(2)).collect();
    let stated = |stack: Stack| Stack { variance: Some(variance.clone()), ..stack };
    let right = stated(planter.images(1, &exact));
    let outcome = planter.judged(&right);
    assert_ne!(outcome.verdict(), Some(Verdict::Fail));
    assert_eq!(of(&outcome, "bias").verdict, Verdict::Pass, "{}", of(&outcome, "bias").words);
    let wrong = stated(planter.images(1, &exact.iter().map(|x| x * PI).collect::<Vec<_>>()));
    let outcome = planter.judged(&wrong);
    assert_eq!(outcome.verdict(), Some(Verdict::Fail));
    let bias = of(&outcome, "bias");
    assert!(
        outcome.cause.as_ref().is_some_and(|cause| cause.words.contains("pi")),
        "{}: {:?}",
        bias.words,
        outcome.cause
    );
}

#[test]
fn what_a_scene_cannot_hold_is_refused_by_name() {
    let order = Order { pixels: None, samples_per_pixel: 16 };
    let refused = |case: &str| -> String {
        let case = Case::shipped(case).unwrap();
        let found = recipe::mitsuba(&case.configuration, &case.name, &order).unwrap_err();
        found.iter().map(|error| format!("{error}\n")).collect()
    };
    for (case, said) in [
        ("texture/blended-panel", "source 0 (counted from 0): an exitance that varies"),
        ("caustic/glass-ball", "glass 0"),
        ("caustic/mirror-ring", "mirror 0"),
        ("direct/sphere-receiver", "a sphere"),
        ("direct/disk-receiver", "a disk"),
        ("penumbra/contact-shadow", "occluder 0"),
    ] {
        let text = refused(case);
        assert!(text.contains(said), "{case}: {text}");
    }
    let case = room(true);
    let most = Order { pixels: Some([1 << 20, 1 << 20]), samples_per_pixel: 16 };
    assert!(matches!(
        recipe::mitsuba(&case.configuration, "room", &most).unwrap_err()[..],
        [Inexpressible::Pixels { .. }]
    ));
}

#[test]
fn a_scene_says_what_the_conventions_ask() {
    let case = room(true);
    let recipe =
        recipe::mitsuba(&case.configuration, "room", &Order { pixels: Some([30, 20]), samples_per_pixel: 16 });
    let recipe = recipe.unwrap();
    let Manifest { rho, pixels, seeds, ref exitance, ref radiance, depth, .. } = recipe.manifest.unwrap();
    assert_eq!((rho, depth, pixels.width, pixels.height), (RHO, 2, 30, 20));
    assert!(seeds.spacing >= 100_003 && exitance[..] == [2.0] && (radiance[0] - 2.0 / PI).abs() < 1e-15);
    // Column 0 is where x begins, row 0 where y ends.
    assert!((pixels.middle([0, 0]) - DVec3::new(-1.16, 1.14, 0.0)).length() < 1e-12);
    assert!((pixels.middle([29, 19]) - DVec3::new(1.16, -1.14, 0.0)).length() < 1e-12);
    let scene = &recipe.files.iter().find(|(name, _)| name == "scene.xml").unwrap().1;
    let scene = std::str::from_utf8(scene).unwrap();
    for said in [
        "\"orthographic\"",
        "\"box\"",
        "float32",
        "\"max_depth\" value=\"2\"",
        "type=\"$sampler\"",
        "\"disk\"",
        "twosided",
    ] {
        assert!(scene.contains(said), "{said}");
    }
    // Half way to the board, looking down.
    assert!(scene.contains("0 0 0 1") && scene.contains("0.0 0.0 -1.0 0.2 "), "{scene}");
}

#[cfg(feature = "cli")]
fn etendue() -> Command {
    Command::cargo_bin("etendue").unwrap()
}

#[cfg(feature = "cli")]
fn npy(path: &Path, [k, h, w]: [usize; 3], values: &[f64]) {
    let header = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': ({k}, {h}, {w}), }}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.bytes());
    bytes.extend(values.iter().flat_map(|x| (*x as f32).to_le_bytes()));
    std::fs::write(path, bytes).unwrap();
}

/// What a script needs to build the scene of any renderer.
#[test]
fn a_case_is_told_in_numbers() {
    let order = Order { pixels: Some([8, 4]), samples_per_pixel: 16 };
    let case = Case::shipped("penumbra/eclipse").unwrap();
    let told = recipe::plain(&case.configuration, &case.name, &order).unwrap();
    let scene: serde_json::Value = serde_json::from_slice(&told.files[0].1).unwrap();
    assert_eq!(scene["sources"][0]["kind"], "disk");
    assert_eq!(scene["sources"][0]["radius"], 0.5);
    assert_eq!(scene["sources"][0]["radiance"], 1.0 / PI);
    assert_eq!(scene["occluders"][0]["center"], serde_json::json!([0.0, 0.0, 1.0]));
    assert_eq!(scene["camera_height"], 0.5);
    assert_eq!(scene["points"].as_array().unwrap().len(), case.configuration.points().len());
    // The same pixels, seeds and numbers as any other export has.
    let mitsuba = recipe::mitsuba(&case.configuration, &case.name, &order).unwrap().manifest.unwrap();
    let manifest = told.manifest.unwrap();
    assert_eq!(manifest, Manifest { renderer: "external".to_owned(), ..mitsuba });
    let l_shape = Case::shipped("direct/l-shaped-source").unwrap();
    let told = recipe::plain(&l_shape.configuration, "l", &order).unwrap();
    let scene: serde_json::Value = serde_json::from_slice(&told.files[0].1).unwrap();
    let source = &scene["sources"][0];
    let n = source["vertices"].as_array().unwrap().len();
    assert_eq!(source["triangles"].as_array().unwrap().len(), n - 2);
    let refused = recipe::plain(&Case::shipped("caustic/cup").unwrap().configuration, "cup", &order).unwrap_err();
    assert!(refused.iter().any(|error| error.to_string().contains("mirror 0")), "{refused:?}");
}

/// Fields of a panel, and a flat mirror, in numbers and in Mitsuba's words.
#[test]
fn fields_and_a_flat_mirror_are_told() {
    let order = Order { pixels: Some([8, 8]), samples_per_pixel: 16 };
    let panel = Case::shipped("texture/checker-panel").unwrap();
    let told = recipe::plain(&panel.configuration, "panel", &order).unwrap();
    let scene: serde_json::Value = serde_json::from_slice(&told.files[0].1).unwrap();
    let fields = &scene["sources"][0]["fields"];
    assert_eq!((&fields["columns"], &fields["rows"]), (&serde_json::json!(4), &serde_json::json!(2)));
    let radiance: Vec<f64> =
        fields["radiance"].as_array().unwrap().iter().map(|l| PI * l.as_f64().unwrap()).collect();
    for (k, due) in [1.75, 0.25, 1.75, 0.25, 0.25, 1.75, 0.25, 1.75].into_iter().enumerate() {
        assert!((radiance[k] - due).abs() < 1e-15, "{radiance:?}");
    }
    let mitsuba = recipe::mitsuba(&panel.configuration, "panel", &order).unwrap();
    let named = |name: &str| &mitsuba.files.iter().find(|(file, _)| file == name).unwrap().1;
    let picture = named("source-0.pfm");
    let head = b"Pf\n4 2\n-1.0\n";
    assert!(picture.starts_with(head) && picture.len() == head.len() + 4 * 8);
    // The row where t ends comes first.
    assert_eq!(picture[head.len()..][..4], ((0.25 / PI) as f32).to_le_bytes());
    assert!(std::str::from_utf8(named("scene.xml")).unwrap().contains("source-0.pfm"));

    let mirror = Case::shipped("caustic/plane-mirror").unwrap();
    let told = recipe::plain(&mirror.configuration, "mirror", &order).unwrap();
    let scene: serde_json::Value = serde_json::from_slice(&told.files[0].1).unwrap();
    assert_eq!(scene["mirrors"][0]["reflectance"], 0.8);
    // Half way to the source, which hangs lower than the mirror.
    assert_eq!(scene["camera_height"], 0.5);
    assert_eq!(told.manifest.unwrap().depth, 3);
    let mitsuba = recipe::mitsuba(&mirror.configuration, "mirror", &order).unwrap();
    let scene = mitsuba.files.iter().find(|(file, _)| file == "scene.xml").unwrap();
    let scene = std::str::from_utf8(&scene.1).unwrap();
    assert!(scene.contains("\"max_depth\" value=\"3\"") && scene.contains("\"conductor\""));
}

/// A mirror that shows all: what its room's pixels are is what they are in the room unfolded, planted and found.
#[test]
fn images_by_a_mirror_are_judged() {
    let room = |half: f64| {
        let text = format!(
            r#"
            title = "Up, and back by a mirror"
            [[source.rectangle]]
            center = [0.2, 0.1, 1.0]
            edge_u = [0.5, 0.0, 0.0]
            edge_v = [0.0, 0.5, 0.0]
            exitance = 2.0
            [[mirror.rectangle]]
            center = [0.0, 0.0, 1.6]
            edge_u = [{side}, 0.0, 0.0]
            edge_v = [0.0, {side}, 0.0]
            reflectance = 0.8
            [receiver]
            albedo = 0.5
            [receiver.rectangle]
            center = [0.0, 0.0, 0.0]
            edge_u = [2.0, 0.0, 0.0]
            edge_v = [0.0, 2.0, 0.0]
            [measure]
            grid = [5, 5]
            "#,
            side = 2.0 * half
        );
        Case::from_toml("mirror", &text).unwrap()
    };
    let case = room(2.0);
    let straight = as_judged(&case).unwrap();
    let oracle = etendue::oracle::optics::RoomLight::new(&case.configuration);
    let grid = PixelGrid::of_receiver(&case.configuration, [40, 40]).unwrap();
    let blank = Stack { width: 40, height: 40, values: vec![1.0; 1600], variance: None, is_half: false };
    let outcome = judge_images(&straight, &grid, &blank, &terms());
    // Metres; and how much finer a pixel is cut, along each side.
    const PIXEL: f64 = 0.05;
    const FINER: usize = 24;
    let mut lit = 0;
    for p in [0, 39, 417, 822, 1010, 1599] {
        let point = MeasurementPoint::new(grid.middle(grid.place(p)), DVec3::Z).unwrap();
        let due = oracle.at(&point).caustic.unwrap().value;
        assert!((outcome.pixels[p].truth.middle - due).abs() < 1e-12, "pixel {p}");
        // The mean by a second route: values at the middles of the pixel's own pixels.
        let (middle, mean) = (grid.middle(grid.place(p)), outcome.pixels[p].truth.irradiance);
        let parts = (0..FINER * FINER).map(|k| {
            let off = |k: usize| PIXEL * ((k as f64 + 0.5) / FINER as f64 - 0.5);
            let place = middle + DVec3::new(off(k % FINER), off(k / FINER), 0.0);
            oracle.at(&MeasurementPoint::new(place, DVec3::Z).unwrap()).caustic.unwrap().value
        });
        let by_parts = parts.sum::<f64>() / (FINER * FINER) as f64;
        // Values at middles are off by what the pixel's own is, over the square of how much finer they are.
        let off = 2.0 * (mean - due).abs() / (FINER * FINER) as f64 + 1e-12;
        assert!((mean - by_parts).abs() <= off, "pixel {p}: {mean}, by parts {by_parts} ± {off:e}");
        lit += u32::from(due > 0.0);
    }
    assert!(lit >= 4, "{lit}");
    let refused = as_judged(&room(0.6)).unwrap_err().to_string();
    assert!(refused.contains("does not see all"), "{refused}");
    assert!(as_judged(&Case::shipped("caustic/cup").unwrap()).is_err());
}

#[test]
fn a_first_sample_in_the_middle_is_allowed_for() {
    let mut planter = Planter::new("a_first_sample_in_the_middle_is_allowed_for", false, [6, 6]);
    let outcome = {
        let exact = planter.exact.clone();
        let stack = planter.images(2, &exact);
        planter.judged(&stack)
    };
    let leaning = |p: usize| {
        let truth = outcome.pixels[p].truth;
        (truth.irradiance + (truth.middle - truth.irradiance) / 2.0) * RHO / PI
    };
    let wrong: Vec<f64> = (0..36).map(leaning).collect();
    let stack = planter.images(4000, &wrong);
    let judged = |first_sample_at_centre| {
        let terms = ImageTerms { samples_per_pixel: 2, first_sample_at_centre, ..terms() };
        judge_images(&planter.case, &planter.grid, &stack, &terms)
    };
    assert_eq!(of(&judged(true), "bias").verdict, Verdict::Pass);
    assert_eq!(of(&judged(false), "bias").verdict, Verdict::Fail);
}

/// The whole way by the command line: a scene, images beside its manifest, a verdict, a report.
#[cfg(feature = "cli")]
#[test]
fn a_scene_and_its_images_by_the_command_line() {
    let folder = tempfile::tempdir().unwrap();
    let dir = folder.path();
    etendue()
        .args(["export", "penumbra/eclipse", "--for", "mitsuba", "--pixels", "16x16", "--samples", "16", "-o"])
        .arg(dir)
        .assert()
        .success();
    assert!(["scene.xml", "render.py", "manifest.json"].iter().all(|name| dir.join(name).is_file()));
    let case = Case::shipped("penumbra/eclipse").unwrap();
    let grid = PixelGrid::of_receiver(&case.configuration, [16, 16]).unwrap();
    let blank = Stack { width: 16, height: 16, values: vec![1.0; 256], variance: None, is_half: false };
    let terms = ImageTerms { irradiance_of_value: 2.0 * PI, rho: 0.5, ..terms() };
    let exact: Vec<f64> =
        judge_images(&case, &grid, &blank, &terms).pixels.iter().map(|p| p.truth.irradiance / (2.0 * PI)).collect();
    let mut draws = Draws::new(seed_of("a_scene_and_its_images_by_the_command_line"));
    let mut noisy = |factor: f64| -> Vec<f64> {
        let mut noise = |x: &f64| factor * x * (1.0 + 0.05 * ((0..12).map(|_| draws.unit()).sum::<f64>() - 6.0));
        (0..64).flat_map(|_| exact.iter().map(&mut noise).collect::<Vec<_>>()).collect()
    };
    npy(&dir.join("right.npy"), [64, 16, 16], &noisy(1.0));
    npy(&dir.join("wrong.npy"), [64, 16, 16], &noisy(PI));
    let verify = |case: &str, file: &str, more: &[&str]| {
        let mut command = etendue();
        command.args(["verify", case]).arg(dir.join(file)).args(more).arg("--out").arg(dir.join("report"));
        let output = command.output().unwrap();
        let said = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
        (output.status.code().unwrap(), said)
    };
    let (code, said) = verify("penumbra/eclipse", "right.npy", &["--smallest-bias", "0.01,0.2"]);
    assert!(code == 0 && said.contains("mitsuba:right") && said.contains("PASS"), "{code} {said}");
    for name in ["pixels.csv", "regions.csv", "verdict.json", "junit.xml"] {
        assert!(dir.join("report").join(name).is_file(), "{name}");
    }
    #[cfg(feature = "plots")]
    assert!(dir.join("report/z.png").is_file() && dir.join("report/difference.png").is_file());
    let (code, said) = verify("penumbra/eclipse", "wrong.npy", &[]);
    assert!(code == 1 && said.contains("a factor pi ("), "{code} {said}");
    let json: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(dir.join("report/verdict.json")).unwrap()).unwrap();
    assert_eq!((json["verdict"].as_str(), json["cause"]["name"].as_str()), (Some("fail"), Some("factor")));
    assert!(std::fs::read_to_string(dir.join("report/junit.xml")).unwrap().contains("failures=\"1\""));

    // The manifest of another case, one that is changed, and none.
    let (code, said) = verify("penumbra/half-plane", "right.npy", &[]);
    assert!(code == 2 && said.contains("another case"), "{code} {said}");
    let manifest = std::fs::read_to_string(dir.join("manifest.json")).unwrap();
    for (from, to, expected) in [
        ("\"rho\": 0.5", "\"rho\": 0.0", "rho is 0"),
        ("\"filter\": \"box\"", "\"filter\": \"gaussian\"", "`gaussian`"),
        ("\"depth\": 2", "\"depth\": 8", "depth is 8"),
        ("\"width\": 16", "\"width\": 17", "not those of the case's receiver"),
        ("\"schema_version\": 1", "\"schema_version\": 2", "schema_version is 2"),
        ("\"units\"", "\"unit\"", "unit"),
    ] {
        assert!(manifest.contains(from), "{from}");
        let path = dir.join("changed.json");
        std::fs::write(&path, manifest.replace(from, to)).unwrap();
        let (code, said) = verify("penumbra/eclipse", "right.npy", &["--manifest", path.to_str().unwrap()]);
        assert!(code == 2 && said.contains(expected), "{from}: {code} {said}");
    }
    // Reflectance wrong within its domain: no mistake of form, so the images tell.
    let path = dir.join("changed.json");
    std::fs::write(&path, manifest.replace("\"rho\": 0.5", "\"rho\": 1.0")).unwrap();
    let (code, said) = verify("penumbra/eclipse", "right.npy", &["--manifest", path.to_str().unwrap()]);
    assert!(code == 1 && said.contains("a factor 1/2"), "{code} {said}");

    std::fs::rename(dir.join("manifest.json"), dir.join("elsewhere.json")).unwrap();
    let (code, said) = verify("penumbra/eclipse", "right.npy", &[]);
    assert!(code == 2 && said.contains("--manifest"), "{code} {said}");
    let elsewhere = dir.join("elsewhere.json");
    let elsewhere = ["--manifest", elsewhere.to_str().unwrap()];
    std::fs::write(dir.join("cut.npy"), &std::fs::read(dir.join("right.npy")).unwrap()[..5000]).unwrap();
    let (code, said) = verify("penumbra/eclipse", "cut.npy", &elsewhere);
    assert!(code == 5 && said.contains("cut off"), "{code} {said}");
    npy(&dir.join("one.npy"), [1, 16, 16], &exact);
    let (code, said) = verify("penumbra/eclipse", "one.npy", &elsewhere);
    assert!(code == 3 && said.contains("no verdict"), "{code} {said}");
    etendue().args(["export", "caustic/cup", "--for", "mitsuba", "-o"]).arg(dir.join("cup")).assert().code(2);
}
