//! Is my low-discrepancy set unbiased behind an occluder, and how noisy is it?
//!
//! `cargo run --example own_low_discrepancy`

use etendue::{Case, Draws, PointSampler, judge};

/// The additive recurrence of the plastic number (Roberts 2018), shifted as a whole by a random vector (Cranley & Patterson
/// 1976). Without the shift it would be the same set each time, and its error all bias.
struct Plastic;

impl PointSampler for Plastic {
    fn points(&self, draws: &mut Draws, points: &mut [[f64; 2]]) {
        const STEP: [f64; 2] = [0.754_877_666_246_692_8, 0.569_840_290_998_053_2];
        let shift = [draws.unit(), draws.unit()];
        for (k, point) in points.iter_mut().enumerate() {
            *point = [0, 1].map(|axis| (shift[axis] + k as f64 * STEP[axis]).fract());
        }
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let case = Case::shipped("penumbra/eclipse")?;
    let judgement = judge(&case).quick().samples(&[4, 64]).points("plastic", &Plastic);
    println!("{judgement}");
    judgement.assert_passes();

    // What it gains: the variance of one estimate beside that of as many independent points.
    let independent = |draws: &mut Draws, points: &mut [[f64; 2]]| {
        points.fill_with(|| [draws.unit(), draws.unit()]);
    };
    let independent = judge(&case).quick().samples(&[4, 64]).points("independent", &independent);
    for (mine, other) in
        judgement.outcome()?.strategies[0].cells.iter().zip(&independent.outcome()?.strategies[0].cells)
    {
        let total = |cell: &etendue::trial::Cell| cell.points.iter().map(|point| point.variance).sum::<f64>();
        let share = total(mine) / total(other);
        println!("N = {}: {share:.3} of the variance of independent points", mine.samples);
        assert!(share < 1.0);
    }
    Ok(())
}

#[test]
fn my_low_discrepancy_set_is_unbiased_and_gains() {
    main().unwrap();
}
