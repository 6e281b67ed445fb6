//! Second routes: bins against quadrature of the point value, focal lengths, energy.

use std::f64::consts::PI;

use approx::{assert_abs_diff_eq, assert_relative_eq};
use proptest::prelude::*;

use super::caustic::{Optic, with_fan};
use super::fan::{self, Fan};
use super::*;
use crate::oracle::quadrature::rule::{self, Demand, Ends};

fn value(caustic: &Caustic, radius: f64) -> f64 {
    caustic.at(radius).unwrap().value().expect("no caustic there")
}

/// Layouts with folds, with a focus and with neither.
fn layouts() -> Vec<(&'static str, Caustic)> {
    let loss = Loss::PerPolarisation;
    vec![
        ("paraboloid below the focus", Caustic::paraboloid(1.0, 0.5, 0.9).unwrap()),
        ("paraboloid above", Caustic::paraboloid(0.7, 1.9, 0.5).unwrap()),
        ("sphere", Caustic::spherical_mirror(1.0, 0.4375, 0.5).unwrap()),
        ("sphere, far plane", Caustic::spherical_mirror(1.3, 1.1, 0.8).unwrap()),
        ("ball", Caustic::glass_ball(1.0, 1.5, 1.25, 0.875, loss).unwrap()),
        ("ball, whole", Caustic::glass_ball(1.0, 1.3, 1.5, 1.0, loss).unwrap()),
        ("lens", Caustic::plano_convex(2.0, 1.5, 3.5, 1.0, loss).unwrap()),
        ("lens, whole", Caustic::plano_convex(2.0, 1.5, 1.0, 2.0, loss).unwrap()),
        ("slab", Caustic::slab_under_point_source(1.0, 0.5, 1.5, 0, loss).unwrap()),
        ("slab, once to and fro", Caustic::slab_under_point_source(1.0, 0.5, 1.5, 1, loss).unwrap()),
    ]
}

/// ∫ E 2πρ dρ over a ring, with square-root ends.
fn ring_by_quadrature(caustic: &Caustic, breaks: &[f64]) -> f64 {
    let integrand = |radius: f64| [caustic.at(radius).unwrap().value().map_or(0.0, |e| 2.0 * PI * radius * e)];
    let demand = |sum: &[f64; 1]| Demand { goal: [1e-12 * sum[0].abs()], floor: |_| [1e-16] };
    // Ends like 1/√: the square of the way takes them away.
    rule::integrate(breaks, Ends::Roots, 1e-13, 4000, integrand, demand).value[0]
}

/// Flux in a ring is what the point value adds up to. (Of what lies within 10⁻⁶ of a caustic the flux is told by the map alone:
/// there quadrature of an inverse root has no digits to spare.)
#[test]
fn rings_hold_what_the_irradiance_adds_up_to() {
    for (name, caustic) in layouts() {
        for [from, to] in [[0.01, 0.05], [0.05, 0.3], [0.1, 0.9]] {
            // Where the beam's rim lands the irradiance jumps.
            let last = caustic.knots[caustic.knots.len() - 1].landing.narrow().abs();
            let mut breaks = vec![from, to, last];
            breaks.extend(caustic.rings().iter().flat_map(|ring| [ring - 1e-6, ring + 1e-6]));
            breaks.retain(|radius| *radius >= from && *radius <= to);
            breaks.sort_by(f64::total_cmp);
            for pair in breaks.windows(2) {
                if caustic.rings().iter().any(|ring| (ring - 0.5 * (pair[0] + pair[1])).abs() < 1e-9) {
                    continue;
                }
                let found = caustic.power_in_ring(pair[0], pair[1]).unwrap();
                let wanted = ring_by_quadrature(&caustic, pair);
                assert!(
                    (found.value - wanted).abs() <= 1e-10 * wanted.abs() + found.bound + 1e-15,
                    "{name} {pair:?}: {} against {wanted}",
                    found.value
                );
            }
        }
    }
}

#[test]
fn rings_and_rectangles_add_up_to_the_total() {
    for (name, caustic) in layouts() {
        let total = caustic.total();
        let radii = [0.0, 0.003, 0.02, 0.1, 0.5, 2.0, f64::INFINITY];
        let rings: f64 = radii.windows(2).map(|pair| caustic.power_in_ring(pair[0], pair[1]).unwrap().value).sum();
        assert_relative_eq!(rings, total.value, max_relative = 1e-14);
        assert!(total.value <= caustic.incident() * (1.0 + 1e-15), "{name}");
        // A checkerboard of uneven fields against one rectangle.
        let cuts = [-0.37, -0.11, 0.0, 0.02, 0.25];
        let whole = caustic.power_in_rectangle([cuts[0], cuts[4]], [cuts[0], cuts[4]]).unwrap();
        let mut sum = 0.0;
        for x in cuts.windows(2) {
            for y in cuts.windows(2) {
                sum += caustic.power_in_rectangle([x[0], x[1]], [y[0], y[1]]).unwrap().value;
            }
        }
        assert_relative_eq!(sum, whole.value, max_relative = 1e-12);
        assert!(whole.bound <= 1e-12 * whole.value, "{name}: {whole:?}");
        // Between the circles in it and around it.
        let inner = caustic.power_in_ring(0.0, 0.25).unwrap().value;
        let outer = caustic.power_in_ring(0.0, 0.37 * 2.0_f64.sqrt()).unwrap().value;
        let slack = 1e-12 * whole.value;
        assert!(whole.value >= inner - slack && whole.value <= outer + slack, "{name}");
    }
}

/// A rectangle between the axis' circles, by quadrature of the point value over x and y: no caustic in it.
#[test]
fn a_rectangle_holds_what_the_irradiance_adds_up_to() {
    let caustic = Caustic::glass_ball(1.0, 1.5, 1.25, 0.875, Loss::PerPolarisation).unwrap();
    let ([x0, x1], [y0, y1]) = ([0.062, 0.095], [-0.03, 0.04]);
    // Neither a caustic nor the beam's rim lands in it.
    let mut edges = caustic.rings();
    edges.push(caustic.knots[caustic.knots.len() - 1].landing.narrow().abs());
    assert!(edges.iter().all(|r| *r > 0.104 || *r < 0.06), "{edges:?}");
    let inner = |x: f64| crate::number::gauss_10(0.5 * (y0 + y1), 0.5 * (y1 - y0), |y| value(&caustic, x.hypot(y)));
    let wanted = crate::number::gauss_10(0.5 * (x0 + x1), 0.5 * (x1 - x0), inner);
    let found = caustic.power_in_rectangle([x0, x1], [y0, y1]).unwrap();
    assert_relative_eq!(found.value, wanted, max_relative = 1e-9);
}

#[test]
fn without_losses_all_power_lands() {
    let loss = Loss::None;
    for caustic in [
        Caustic::paraboloid(1.0, 1.0, 1.0).unwrap(),
        Caustic::paraboloid(1.0, 2.0, 1.0).unwrap(),
        Caustic::spherical_mirror(1.0, 0.5, 0.6).unwrap(),
        Caustic::glass_ball(1.0, 1.4, 2.0, 1.0, loss).unwrap(),
        Caustic::plano_convex(1.0, 1.5, 2.0, 0.6, loss).unwrap(),
        Caustic::slab_under_point_source(1.0, 2.0, 1.5, 0, loss).unwrap(),
    ] {
        assert_relative_eq!(caustic.total().value, caustic.incident(), max_relative = 1e-14);
        assert_relative_eq!(
            caustic.power_in_ring(0.0, f64::INFINITY).unwrap().value,
            caustic.incident(),
            max_relative = 1e-14
        );
    }
}

/// Through a slab under a lamp, order by order: what the two faces leave of it.
#[test]
fn the_orders_of_a_slab_are_its_transmittance() {
    let order = |echoes: u32| {
        Caustic::slab_under_point_source(1.0, 0.5, 1.5, echoes, Loss::PerPolarisation).unwrap().total().value
    };
    const ORDERS: u32 = 4;
    let sum: f64 = (0..ORDERS).map(order).sum();
    // By what each face does, over the cosine.
    let shares = |c: f64| (0..ORDERS).map(|k| faces::slab_order(1.5, c, k).unwrap()[0].mean()).sum::<f64>();
    let panels = 100;
    let closed: f64 = (0..panels)
        .map(|i| {
            let half = 0.5 / f64::from(panels);
            let middle = half * f64::from(2 * i + 1);
            crate::number::gauss_10(middle, half, shares)
        })
        .sum();
    assert_relative_eq!(sum, 2.0 * PI * closed, max_relative = 1e-13);
}

/// Straight below: the source's image is nearer by d (1 − 1/n).
#[test]
fn a_slab_lifts_the_source() {
    let slab = Caustic::slab_under_point_source(1.0, 0.5, 1.5, 0, Loss::PerPolarisation).unwrap();
    let expected = 0.96_f64.powi(2) / (1.0 + 0.5 / 1.5_f64).powi(2);
    assert_relative_eq!(value(&slab, 0.0), expected, max_relative = 1e-14);
    assert_relative_eq!(value(&slab, 1e-7), expected, max_relative = 1e-12);
    assert!(slab.rings().is_empty() && !slab.is_focused());
    // Far out: E ρ³ tends to nothing, and nothing is infinite.
    assert!(value(&slab, 1e12) < 1e-36);
}

/// At the paraxial focus the map's slope on the axis vanishes; next to it the beam is narrower by (1 − z/f).
#[test]
fn focal_lengths_are_the_textbooks() {
    let loss = Loss::None;
    let on_axis = |caustic: Caustic| value(&caustic, 0.0);
    // Sphere: R/2. Ball: n R/(2(n − 1)) from the middle. Lens: R/(n − 1).
    assert!(Caustic::spherical_mirror(2.0, 1.0, 0.5).unwrap().is_focused());
    assert!(Caustic::glass_ball(1.0, 1.5, 1.5, 0.5, loss).unwrap().is_focused());
    assert!(Caustic::plano_convex(1.0, 1.5, 2.0, 0.25, loss).unwrap().is_focused());
    assert_relative_eq!(on_axis(Caustic::spherical_mirror(2.0, 1.25, 0.125).unwrap()), 16.0, max_relative = 1e-12);
    assert_relative_eq!(
        on_axis(Caustic::glass_ball(1.0, 1.5, 2.25, 0.125, loss).unwrap()),
        4.0,
        max_relative = 1e-12
    );
    assert_relative_eq!(
        on_axis(Caustic::plano_convex(1.0, 1.5, 3.0, 0.125, loss).unwrap()),
        4.0,
        max_relative = 1e-12
    );
}

#[test]
fn a_paraboloid_is_its_closed_form() {
    for (f, plane, b) in [(1.0, 0.5, 1.2), (0.6, 1.7, 0.9), (2.0, 1.999, 3.0), (1.0, 0.01, 1.5)] {
        let caustic = Caustic::paraboloid(f, plane, b).unwrap();
        let kappa = (1.0 - plane / f).abs();
        for i in 0..50 {
            let radius = 0.037 * f64::from(i) * f * kappa;
            let s = radius / (f * kappa + (f * kappa).hypot(radius));
            let is_lit = 2.0 * f * s <= b && f * s * s <= plane;
            let closed = if is_lit { (1.0 - s * s).powi(3) / (kappa * kappa * (1.0 + s * s)) } else { 0.0 };
            assert_relative_eq!(value(&caustic, radius), closed, max_relative = 1e-11);
        }
    }
    // The part of the mirror that stands above the plane sends nothing down to it.
    let shallow = Caustic::paraboloid(1.0, 0.25, 1.5).unwrap();
    assert_relative_eq!(shallow.total().value, PI, max_relative = 1e-15);
}

#[test]
fn what_is_singular_says_so() {
    let point = Caustic::paraboloid(1.0, 1.0, 1.0).unwrap();
    assert_eq!(point.at(0.0).unwrap(), Arrival::OnCaustic);
    assert_eq!(point.at(0.1).unwrap(), Arrival::Finite { value: 0.0, bound: 0.0, n_rays: 0 });
    assert_relative_eq!(point.power_in_ring(0.0, 1e-9).unwrap().value, PI, max_relative = 1e-15);
    assert_relative_eq!(
        point.power_in_rectangle([-0.1, 0.1], [0.0, 0.1]).unwrap().value,
        PI / 2.0,
        max_relative = 1e-14
    );
    for (name, caustic) in layouts() {
        for ring in caustic.rings() {
            assert_eq!(caustic.at(ring).unwrap(), Arrival::OnCaustic, "{name}");
            for step in [1e-9, 1e-6, 1e-3] {
                for near in [ring * (1.0 - step), ring * (1.0 + step)] {
                    let Arrival::Finite { value, bound, .. } = caustic.at(near).unwrap() else { panic!("{name}") };
                    assert!(value.is_finite() && bound <= 1e-11 * value, "{name}: {value:e} ± {bound:e}");
                }
            }
        }
        if caustic.is_focused() {
            assert_eq!(caustic.at(0.0).unwrap(), Arrival::OnCaustic, "{name}");
        } else {
            assert!(value(&caustic, 0.0) > 0.0, "{name}");
        }
    }
}

/// The folds are those that a scan of 20,000 rays finds, whatever the layout.
#[test]
fn no_fold_goes_unseen() {
    let mut all: Vec<Caustic> = layouts().into_iter().map(|(_, caustic)| caustic).collect();
    for i in 0..40 {
        let x = 0.025 * f64::from(i);
        all.push(Caustic::spherical_mirror(1.0, 0.05 + 1.2 * x, 0.7).unwrap());
        all.push(Caustic::glass_ball(1.0, 1.05 + 2.0 * x, 1.0 + 2.0 * x * x, 1.0, Loss::None).unwrap());
        all.push(Caustic::glass_ball(1.0, 1.5, 1.0 + 2.0 * x, 1.0, Loss::None).unwrap());
        all.push(Caustic::plano_convex(1.0, 1.2 + x, 0.1 + 4.0 * x, 1.0, Loss::None).unwrap());
    }
    let mut most = 0;
    for caustic in all {
        let slope = |u: f64| with_fan!(&caustic.optic, fan => fan::jet(|u| fan.landing(u), u).1);
        let last = caustic.knots[caustic.knots.len() - 1].u.narrow() * (1.0 - 1e-12);
        let n = 20_000;
        let slopes: Vec<f64> = (1..=n).map(|i| slope(last * f64::from(i) / f64::from(n))).collect();
        let scanned = slopes.windows(2).filter(|pair| pair[0] * pair[1] < 0.0).count();
        let (found, first) = (caustic.rings().len(), caustic.rings().first().copied());
        // A fold so near to the axis that the scan's first ray lies beyond it is found all the same.
        let is_small = first.is_some_and(|ring| ring < 1e-9);
        assert!(
            found == scanned || (is_small && found == scanned + 1),
            "{found} folds, {scanned} scanned: {caustic:?}"
        );
        most = most.max(found);
    }
    assert!(most >= 1);
}

/// A ring caustic is the end of light on one side: E ~ |ρ − ρ_c|^{−1/2} on the other.
#[test]
fn next_to_a_ring_light_grows_like_an_inverse_root() {
    let caustic = Caustic::spherical_mirror(1.0, 0.4375, 0.5).unwrap();
    let [ring] = caustic.rings()[..] else { panic!("one ring") };
    let more = |d: f64| value(&caustic, ring - d) - value(&caustic, ring + d);
    assert_relative_eq!(more(1e-9) / more(4e-9), 2.0, max_relative = 1e-3);
}

proptest! {
    #[test]
    fn no_question_gets_a_number_that_is_none(
        radius in 0.1..3.0, index in 1.0..4.0, plane in 0.01..6.0, share in 0.01..=1.0, at in 0.0..3.0,
    ) {
        let loss = Loss::PerPolarisation;
        let layouts = [
            Caustic::paraboloid(radius, plane, 1.99 * radius * share),
            Caustic::spherical_mirror(radius, plane, 0.707 * radius * share),
            Caustic::glass_ball(radius, index, radius + plane, radius * share, loss),
            Caustic::plano_convex(radius, index, plane, radius * share, loss),
            Caustic::slab_under_point_source(radius, plane, index, 0, loss),
        ];
        for caustic in layouts {
            let caustic = caustic.unwrap();
            if let Arrival::Finite { value, bound, .. } = caustic.at(at).unwrap() {
                prop_assert!(value.is_finite() && value >= 0.0 && bound <= 1e-9 * value, "{caustic:?}");
            }
            let ring = caustic.power_in_ring(0.5 * at, at).unwrap();
            let box_around = caustic.power_in_rectangle([-at, at], [-at, at]).unwrap();
            let disk = caustic.power_in_ring(0.0, at).unwrap();
            prop_assert!(ring.value >= 0.0 && ring.value <= disk.value * (1.0 + 1e-13));
            prop_assert!(box_around.value >= disk.value * (1.0 - 1e-11), "{box_around:?} {disk:?} {caustic:?}");
            prop_assert!(box_around.value <= caustic.total().value * (1.0 + 1e-11));
        }
    }
}

#[test]
fn what_is_no_layout_is_refused() {
    let loss = Loss::None;
    assert!(matches!(Caustic::paraboloid(0.0, 1.0, 1.0), Err(OpticsError::Length { .. })));
    assert!(matches!(Caustic::paraboloid(1.0, 1.0, 2.0), Err(OpticsError::Beam { .. })));
    assert!(matches!(Caustic::spherical_mirror(1.0, 0.5, 0.75), Err(OpticsError::Beam { .. })));
    assert!(matches!(Caustic::glass_ball(1.0, 0.9, 2.0, 0.5, loss), Err(OpticsError::Index { .. })));
    assert!(matches!(Caustic::glass_ball(1.0, 1.5, 0.5, 0.5, loss), Err(OpticsError::InsideGlass { .. })));
    assert!(Caustic::glass_ball(1.0, 1.5, 1.0, 1.0, loss).is_ok());
    assert!(Caustic::plano_convex(1.0, f64::NAN, 0.5, 0.5, loss).is_err());
    assert!(Caustic::slab_under_point_source(f64::INFINITY, 0.5, 1.5, 0, loss).is_err());
    let ball = Caustic::glass_ball(1.0, 1.5, 1.0, 1.0, loss).unwrap();
    for radius in [-0.1, f64::NAN, f64::INFINITY] {
        assert!(matches!(ball.at(radius), Err(OpticsError::Place { .. })));
    }
    assert!(matches!(ball.power_in_ring(0.2, 0.1), Err(OpticsError::Stretch { .. })));
    assert!(ball.power_in_ring(-0.2, 0.1).is_err() && ball.power_in_ring(0.1, f64::NAN).is_err());
    assert!(ball.power_in_rectangle([0.0, f64::INFINITY], [0.0, 1.0]).is_err());
    assert_abs_diff_eq!(ball.power_in_ring(0.1, 0.1).unwrap().value, 0.0);
}
