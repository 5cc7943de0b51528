//! A guide's warp and density: the same distribution, told by what each cell of the square carried.

use super::reference::random::{generator, uniform};
use super::unit_square;
use proptest::prelude::*;
use volgrad::math::DVec2;
use volgrad::scene::{GUIDE_SIDE, Guide};

/// Sums of 4096 cells.
const TOLERANCE: f64 = 1e-11;

const CELLS: usize = GUIDE_SIDE * GUIDE_SIDE;

fn learned(carried: &[f64]) -> Guide {
    Guide::learned(|i, j| carried[j * GUIDE_SIDE + i])
}

/// A third nothing, a third little, a third much.
fn carried() -> impl Strategy<Value = Vec<f64>> {
    any::<u64>().prop_map(|seed| {
        let rng = &mut generator(seed);
        (0..CELLS).map(|cell| uniform(rng, 0.0, [0.0, 1.0, 1000.0][cell % 3])).collect()
    })
}

fn cell(u: DVec2) -> usize {
    let [i, j] = (u * GUIDE_SIDE as f64).to_array().map(|x| x as usize);
    j * GUIDE_SIDE + i
}

fn centre(cell: usize) -> DVec2 {
    (DVec2::new((cell % GUIDE_SIDE) as f64, (cell / GUIDE_SIDE) as f64) + 0.5) / GUIDE_SIDE as f64
}

/// A fifth all alike, the rest in proportion.
fn expected(carried: &[f64], cell: usize) -> f64 {
    0.2 + 0.8 * carried[cell] / (carried.iter().sum::<f64>() / CELLS as f64)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]

    #[test]
    fn a_guide_is_what_was_carried(carried in carried()) {
        let guide = learned(&carried);
        let mut sum = 0.0;
        for cell in 0..CELLS {
            let density = guide.density(centre(cell));
            sum += density / CELLS as f64;
            prop_assert!((density - expected(&carried, cell)).abs() < TOLERANCE * CELLS as f64, "{cell}: {density}");
        }
        prop_assert!((sum - 1.0).abs() < TOLERANCE);
    }

    /// It is continuous along each axis of a cell, and stretches areas by one over the density.
    #[test]
    fn a_guide_warps_to_its_density(carried in carried(), us in prop::collection::vec(unit_square(), 64)) {
        let guide = learned(&carried);
        let step = 1e-7;
        for u in us {
            let (warped, density) = guide.warp(u).expect("u < 1");
            prop_assert!(warped.min_element() >= 0.0 && warped.max_element() <= 1.0);
            let beside = |d: DVec2| guide.warp(u + d).filter(|(w, _)| cell(*w) == cell(warped)).map(|(w, _)| (w - warped) / step);
            let (Some(x), Some(y)) = (beside(DVec2::new(step, 0.0)), beside(DVec2::new(0.0, step))) else { continue };
            prop_assert!(density == guide.density(warped));
            prop_assert!((density - expected(&carried, cell(warped))).abs() < TOLERANCE * CELLS as f64);
            prop_assert!(x.y == 0.0 && y.x == 0.0 && (x.x * y.y * density - 1.0).abs() < 1e-4, "{x} {y} {density}");
        }
    }

    /// And back, in the open square.
    #[test]
    fn a_guide_unwarps_what_it_warped(carried in carried(), us in prop::collection::vec(unit_square(), 64)) {
        let guide = learned(&carried);
        for u in us {
            let (warped, density) = guide.warp(u).expect("u < 1");
            let back = guide.unwarp(warped).expect("it made them");
            // Where cells are thin rounding of what they were warped to counts for more.
            prop_assert!((back - u).length() < TOLERANCE * density.max(1.0), "{u} {warped} {back}");
        }
    }

    /// What carried nothing at all, not a number or less than nothing teaches nothing.
    #[test]
    fn a_guide_that_learned_nothing_leaves_all_alike(u in unit_square(), nothing in prop_oneof![Just(0.0), Just(f64::NAN), Just(-1.0)]) {
        let guide = Guide::learned(|_, _| nothing);
        let (warped, density) = guide.warp(u).expect("u < 1");
        prop_assert!((warped - u).length() < TOLERANCE && (density - 1.0).abs() < TOLERANCE);
        prop_assert!((guide.density(u) - 1.0).abs() < TOLERANCE);
    }

    #[test]
    fn one_cell_gets_four_fifths(hot in 0..CELLS) {
        let mut carried = vec![0.0; CELLS];
        carried[hot] = 1e-30;
        let guide = learned(&carried);
        prop_assert!((guide.density(centre(hot)) - (0.2 + 0.8 * CELLS as f64)).abs() < 1e-8);
        let steps = 100;
        let square = (0..steps * steps).map(|k| DVec2::new((k % steps) as f64 + 0.5, (k / steps) as f64 + 0.5) / steps as f64);
        let found = square.filter(|u| cell(guide.warp(*u).expect("u < 1").0) == hot).count();
        // To a grid line of the u on each side.
        prop_assert!((found as f64 / (steps * steps) as f64 - 0.8).abs() < 0.04, "{found}");
    }
}

/// Numbers at the upper borders belong to the last cells.
#[test]
fn a_guide_ends_at_one() {
    let guide = learned(&vec![1.0; CELLS]);
    assert!((guide.density(DVec2::ONE) - 1.0).abs() < 1e-10);
    let (warped, _) = guide.warp(DVec2::splat(1.0_f64.next_down())).expect("u < 1");
    assert!(warped.max_element() <= 1.0);
}
