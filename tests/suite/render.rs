//! Pictures: the same bytes always, right on the average, wrong where the room is wrong, and complaints that help.

use etendue::case::{Case, shipped};
use etendue::configuration::{Configuration, Contents};
use etendue::eye::{Caustics, Direct, Eye, EyeError, Shading, View};
use etendue::geometry::DVec3;
use etendue::light::{Aim, First, Light, LightSettings, trace};
use etendue::sampling::Strategy;
use etendue::statistics::Verdict;
use etendue::statistics::budget::seed_of;
use etendue::trial::{
    Judged, PictureSettings, ReceiverPicture, camera_picture, receiver_picture, receiver_picture_with,
};

fn read(name: &str) -> Case {
    shipped().find(|case| case.name() == name).expect("a shipped case").read().expect("valid")
}

fn small(name: &str, strategy: Strategy, samples: u64) -> PictureSettings {
    PictureSettings { strategy, samples, seed: seed_of(name), pixels: Some([48, 48]) }
}

fn verdict(picture: &ReceiverPicture) -> Verdict {
    match &picture.judged {
        Judged::By(judged) => {
            assert_eq!(judged.property, "picture");
            judged.verdict
        }
        Judged::Not(why) => panic!("{} is judged: {why}", picture.case),
    }
}

#[test]
fn pictures_of_direct_light_pass() {
    for name in ["penumbra/eclipse", "texture/checker-panel", "direct/disk-receiver"] {
        let case = read(name);
        for strategy in Strategy::LECTURE {
            let picture = receiver_picture(&case, &small(name, strategy, 16)).unwrap();
            assert_ne!(verdict(&picture), Verdict::Fail, "{name}, {strategy}: {:?}", picture.judged);
            assert!(picture.light.is_none());
        }
    }
}

#[test]
fn pictures_with_caustics_pass() {
    for name in ["caustic/glass-ball", "caustic/paraboloid", "caustic/slab", "caustic/plane-mirror"] {
        let case = read(name);
        let picture = receiver_picture(&case, &small(name, Strategy::Stratified, 16)).unwrap();
        assert_ne!(verdict(&picture), Verdict::Fail, "{name}: {:?}", picture.judged);
        let light = picture.light.expect("light is bent here");
        let bent: f64 = picture.picture.pixels().iter().filter_map(|pixel| pixel.lit).map(|lit| lit.caustic).sum();
        assert!(bent > 0.0 && light.rays > 0, "{name}");
    }
}

/// The direct term of a room from which the glass (or the mirrors) have been taken out: light that the map brings as well.
fn as_if_clear(room: &Configuration) -> Direct {
    let contents = Contents { glass: vec![], mirrors: vec![], ..room.contents().clone() };
    Direct::new(&Configuration::of(contents).expect("a room without optics"))
}

#[test]
fn direct_light_through_glass_is_not_counted_twice() {
    for name in ["caustic/glass-ball", "caustic/plano-convex", "caustic/slab"] {
        let case = read(name);
        let settings = small(name, Strategy::Stratified, 16);
        let picture = receiver_picture_with(&case, &settings, as_if_clear(&case.configuration)).unwrap();
        assert_eq!(verdict(&picture), Verdict::Fail, "{name}: {:?}", picture.judged);
    }
}

#[test]
fn a_shadow_that_is_left_out_is_found() {
    let case = read("penumbra/eclipse");
    let contents = Contents { occluders: vec![], ..case.configuration.contents().clone() };
    let direct = Direct::new(&Configuration::of(contents).unwrap());
    let picture = receiver_picture_with(&case, &small("left_out", Strategy::Random, 16), direct).unwrap();
    assert_eq!(verdict(&picture), Verdict::Fail, "{:?}", picture.judged);
}

#[test]
fn errors_are_as_large_as_they_are_said_to_be() {
    let case = read("penumbra/eclipse");
    let picture = receiver_picture(&case, &small("as_large", Strategy::Random, 64)).unwrap();
    let mut squares = Vec::new();
    for y in 0..48 {
        for x in 0..48 {
            squares.extend(picture.z_around(x, y).map(|z| z * z));
        }
    }
    // By symmetry the mean of z² is that over all K pictures of one pixel, (K − 1)/K + (mean − due)²/s²: 1.00 for K = 32
    // and any distribution. Over so many pixels it is off by less than 0.1, skewed ones deep in the penumbra included.
    let mean = squares.iter().sum::<f64>() / squares.len() as f64;
    assert!(squares.len() > 2000 && (mean - 1.0).abs() < 0.25, "{} pixels, {mean}", squares.len());
}

#[test]
fn the_same_seed_gives_the_same_picture_on_any_number_of_threads() {
    let case = read("caustic/ball-on-a-globe");
    let light = LightSettings { rays: 100_000, ..case.light.clone() };
    let case = Case { light, ..case };
    for strategy in [Strategy::Stratified, Strategy::Correlated] {
        let settings = PictureSettings { pixels: Some([40, 30]), ..small("threads", strategy, 5) };
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                (camera_picture(&case, &settings).unwrap(), receiver_picture(&case, &settings).unwrap().picture)
            })
        };
        let one = on(1);
        assert_eq!(one, on(3), "{strategy}");
        let other = PictureSettings { seed: settings.seed + 1, ..settings.clone() };
        assert_ne!(one.0, camera_picture(&case, &other).unwrap(), "{strategy}");
    }
}

#[test]
fn a_camera_over_the_receiver_sees_what_the_receiver_has() {
    // Nothing stands between this camera and the floor: a source far to the side.
    let text = |camera: &str| {
        format!(
            r#"
            [source.sphere]
            center = [0.0, 0.0, 3.0]
            radius = 0.5
            exitance = 2.0
            [receiver]
            albedo = {{ checker = [4, 4], white = 0.8, black = 0.2 }}
            [receiver.rectangle]
            center = [4.0, 0.0, 0.0]
            edge_u = [2.0, 0.0, 0.0]
            edge_v = [0.0, 2.0, 0.0]
            [measure]
            grid = [1, 1]
            {camera}
            "#
        )
    };
    let camera = r#"
        [camera]
        kind = "orthographic"
        eye = [4.0, 0.0, 1.0]
        look_at = [4.0, 0.0, 0.0]
        up = [0.0, 1.0, 0.0]
        width = 2.0
        pixels = [32, 32]
    "#;
    let case = Case::from_toml("floor", &text(camera)).unwrap();
    let room = &case.configuration;
    let shading = Shading { strategy: Strategy::Random, samples: 8, seed: seed_of("camera_over") };
    let square_on = View::of_receiver(room, 32).unwrap();
    let seen = [View::Camera(case.camera.unwrap()), square_on]
        .map(|view| Eye::new(room, view, Direct::new(room)).unwrap().picture(&shading, &Caustics::none()));
    for (a, b) in seen[0].pixels().iter().zip(seen[1].pixels()) {
        let (a, b) = (a.lit.unwrap(), b.lit.unwrap());
        assert!((a.point.position() - b.point.position()).length() < 1e-14);
        assert_eq!(a.albedo, b.albedo);
        // The same streams, places that differ by a rounding.
        assert!((a.direct - b.direct).abs() <= 1e-12 * b.direct, "{} {}", a.direct, b.direct);
    }
    let albedos: Vec<f64> =
        [(4, 27), (12, 27), (12, 20)].map(|(x, y)| seen[0].pixel(x, y).lit.unwrap().albedo).into();
    assert_eq!(albedos, [0.8, 0.2, 0.8], "fields from the lower left");
}

#[test]
fn a_diffuse_surface_does_not_shade_itself() {
    // A ball under a disk source: straight below, R²/(R² + h²) of the exitance.
    let text = r#"
        [source.disk]
        center = [0.0, 0.0, 3.0]
        normal = [0.0, 0.0, -1.0]
        radius = 1.0
        exitance = 1.0
        [diffuse.sphere]
        center = [0.0, 0.0, 0.0]
        radius = 1.0
        albedo = 0.7
        [receiver]
        albedo = 0.5
        [receiver.rectangle]
        center = [0.0, 0.0, -1.5]
        edge_u = [4.0, 0.0, 0.0]
        edge_v = [0.0, 4.0, 0.0]
        [measure]
        grid = [1, 1]
        [camera]
        kind = "orthographic"
        eye = [0.0, 0.0, 2.5]
        look_at = [0.0, 0.0, 0.0]
        up = [0.0, 1.0, 0.0]
        width = 3.9
        pixels = [39, 39]
    "#;
    let case = Case::from_toml("ball", text).unwrap();
    let settings = PictureSettings { samples: 1024, seed: seed_of("itself"), ..PictureSettings::default() };
    let picture = camera_picture(&case, &settings).unwrap().unwrap();
    let top = picture.pixel(19, 19);
    let lit = top.lit.unwrap();
    assert_eq!((lit.surface, lit.albedo, top.first), (1, 0.7, First::Surface));
    assert!((lit.direct - 0.2).abs() < 2e-3, "{}", lit.direct);
    // The ball hides the source from the floor below it, and leaves light in its penumbra.
    let beside = picture.pixel(1, 19).lit.unwrap();
    assert_eq!(beside.surface, 0);
    assert!(beside.direct > 0.0);
}

#[test]
fn what_maps_bring_is_what_the_estimators_leave_out() {
    // Direct light by the map and by the estimators: the same floor under a mirror ring's lamp and beside it.
    let case = read("caustic/mirror-ring");
    let room = &case.configuration;
    let view = View::of_receiver(room, 16).unwrap();
    let eye = Eye::new(room, view, Direct::new(room)).unwrap();
    // Unaimed: rays that are aimed at the ring leave few for the table.
    let light = LightSettings { map: [16, 16], aim: Aim::Nowhere, rays: 4_000_000, ..case.light.clone() };
    let run = trace(room, &light, seed_of("leave_out"));
    let shading = Shading { strategy: Strategy::Random, samples: 1, seed: 1 };
    let picture = eye.picture(&shading, &Caustics::by_texel(&run.maps));
    let map = &run.maps[0];
    let (mut direct, mut from_map, mut variance) = (0.0, 0.0, 0.0);
    for pixel in picture.pixels() {
        let lit = pixel.lit.unwrap();
        let at = lit.point.position();
        // Away from the ring and its shadow, each pixel in the middle of a texel.
        if (at - DVec3::Z * at.z).length() > 0.6 && at.x < 0.0 {
            direct += lit.direct;
            let texel = map.grid().texel(map.parametrisation().to_map(at));
            let found = map.moments(texel, Light::Direct);
            from_map += found.watts() / map.area(texel);
            variance += found.variance(map.n_groups()).unwrap() / (map.area(texel) * map.area(texel));
        }
    }
    // The value in the middle is that of the texel's mean to a tenth of a per cent: 0.125 m wide, 4 m away.
    let error = variance.sqrt();
    assert!(error < 0.02 * direct, "{error} {direct}");
    assert!((direct - from_map).abs() < 5.0 * error + 1e-3 * direct, "{direct} {from_map} ± {error}");
}

#[test]
fn cameras_that_see_nothing_are_refused_with_their_place() {
    let case = |camera: &str| {
        let text = format!(
            "[source.sphere]\ncenter = [0.0, 0.0, 3.0]\nradius = 0.5\nexitance = 1.0\n\n[receiver.disk]\ncenter = [0.0, 0.0, \
             0.0]\nnormal = [0.0, 0.0, 1.0]\nradius = 1.0\n\n[measure]\ngrid = [1, 1]\n\n[camera]\n{camera}\n"
        );
        Case::from_toml("room", &text).map_err(|errors| errors.to_string())
    };
    let perspective = "kind = \"perspective\"\nlook_at = [0.0, 0.0, 0.0]\nup = [0.0, 1.0, 0.0]\n";
    assert!(case(&format!("{perspective}fov = 40\neye = [0.0, 0.0, 5.0]")).is_ok());
    for (camera, said) in [
        (format!("{perspective}fov = 40\neye = [0.0, 0.1, 3.0]"), "inside of source 0"),
        (format!("{perspective}fov = 180\neye = [0.0, 0.0, 5.0]"), "fov is 180°"),
        (format!("{perspective}eye = [0.0, 0.0, 5.0]"), "lacks the key `fov`"),
        (format!("{perspective}fov = 40\nwidth = 2\neye = [0.0, 0.0, 5.0]"), "an orthographic camera"),
        (format!("{perspective}fov = 40\neye = [0.0, 0.0, 0.0]"), "where it stands"),
        (format!("{perspective}fov = 40\neye = [0.0, 5.0, 0.0]"), "up points along"),
        (format!("{perspective}fov = 40\neye = [0.0, 0.0, 5.0]\npixels = [0, 5]"), "from 1 to"),
        (format!("{perspective}fov = 40\neye = [0.0, 0.0, 5.0]\npixels = [9999, 9999]"), "at most"),
        ("kind = \"fisheye\"\neye = [0.0, 0.0, 5.0]\nlook_at = [0.0, 0.0, 0.0]".into(), "perspective"),
        (
            "kind = \"orthographic\"\neye = [0.0, 0.0, 3.6]\nlook_at = [0.0, 0.0, 0.0]\nwidht = 1".into(),
            "did you mean `width`",
        ),
        (
            "kind = \"orthographic\"\neye = [0.8, 0.0, 3.0]\nlook_at = [0.8, 0.0, 0.0]\nwidth = 2.0\nup = [0.0, 1.0, 0.0]"
                .into(),
            "inside of source 0",
        ),
    ] {
        let told = case(&camera).expect_err(&camera);
        assert!(told.contains(said) && told.contains("room:"), "{camera}\n{told}");
    }
    // Without a receiver and a camera there is nothing to look at.
    let none = "[source.sphere]\ncenter = [0.0, 0.0, 3.0]\nradius = 0.5\nexitance = 1.0\n[[measure.point]]\nposition = [0.0, \
                0.0, 0.0]\nnormal = [0.0, 0.0, 1.0]\n";
    let none = Case::from_toml("none", none).unwrap();
    assert_eq!(receiver_picture(&none, &PictureSettings::default()).unwrap_err(), EyeError::NoReceiver);
    assert_eq!(camera_picture(&none, &PictureSettings::default()).unwrap(), None);
}

#[cfg(all(feature = "cli", feature = "plots"))]
mod command {
    use assert_cmd::Command;
    use std::path::Path;

    fn etendue() -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_etendue"));
        command.current_dir(env!("CARGO_TARGET_TMPDIR"));
        command
    }

    fn bytes(folder: &Path, name: &str) -> Vec<u8> {
        std::fs::read(folder.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    #[test]
    fn a_case_becomes_pictures() {
        let folders = [(); 2].map(|()| tempfile::tempdir().unwrap());
        for (folder, threads) in folders.iter().zip(["1", "2"]) {
            let out = folder.path().join("made/here");
            let run = etendue()
                .args([
                    "render",
                    "penumbra/eclipse",
                    "--size",
                    "64x48",
                    "--samples",
                    "16",
                    "--threads",
                    threads,
                    "-o",
                ])
                .arg(&out)
                .assert()
                .code(0);
            let said = String::from_utf8(run.get_output().stdout.clone()).unwrap();
            assert!(said.contains("PASS") && said.contains("sRGB curve") && said.contains("eclipse.png"), "{said}");
        }
        for name in ["eclipse.png", "eclipse.exr", "eclipse-receiver.png", "eclipse-receiver.exr"] {
            let name = format!("made/here/penumbra-{name}");
            assert_eq!(bytes(folders[0].path(), &name), bytes(folders[1].path(), &name), "{name}");
        }
        let png = bytes(folders[0].path(), "made/here/penumbra-eclipse.png");
        let reader = png::Decoder::new(png.as_slice()).read_info().unwrap();
        assert_eq!((reader.info().width, reader.info().height), (64, 48));
        let texts: Vec<String> = reader.info().utf8_text.iter().map(|t| t.get_text().unwrap()).collect();
        assert!(texts.iter().any(|text| text.contains("sRGB curve")), "{texts:?}");
    }

    #[test]
    fn wrong_words_are_usage() {
        for words in [&["render"][..], &["render", "--size", "5", "x"], &["render", "--lecture", "x"]] {
            etendue().args(words).assert().code(2);
        }
        etendue().args(["render", "no-such-case"]).assert().code(4);
    }
}
