//! The film's sums are exact: whatever the order and the distribution over films, the same bits. What cannot be summed is counted.

mod reference;

use proptest::prelude::*;
use rand_core::Rng;
use rand_pcg::Pcg64;
use reference::random::*;
use std::sync::Barrier;
use volgrad::film::{Cell, Count, Film, LARGEST, LEAST};
use volgrad::math::{Colour, DVec2};

const WIDTH: u32 = 5;
const HEIGHT: u32 = 3;

/// A film and the memory that it is over.
#[derive(Clone, Debug, PartialEq)]
struct Owned {
    cells: Vec<Cell>,
    dropped: Count,
    is_shared: bool,
}

impl Owned {
    fn new() -> Self {
        Self { cells: vec![Cell::default(); (WIDTH * HEIGHT) as usize], dropped: Count::default(), is_shared: false }
    }

    fn of(splats: &[Splat]) -> Self {
        let film = Self::new();
        splats.iter().for_each(|splat| film.add(*splat));
        film
    }

    fn film(&self) -> Film<'_> {
        Film { width: WIDTH, height: HEIGHT, cells: &self.cells, dropped: &self.dropped, is_shared: self.is_shared }
    }

    fn add(&self, (pixel, value): Splat) {
        self.film().add(pixel, value);
    }

    fn merge(&self, other: &Self) {
        self.film().merge(&other.cells, other.dropped.get());
    }

    fn value(&self, x: u32, y: u32) -> Colour {
        self.cells[(y * WIDTH + x) as usize].value()
    }
}

type Splat = (DVec2, Colour);

/// Of either sign, over thirty orders of magnitude, some off the image, some not finite.
fn random_splats(rng: &mut Pcg64, count: usize) -> Vec<Splat> {
    let splat = || {
        let pixel = DVec2::new(uniform(rng, -0.5, 5.5), uniform(rng, -0.5, 3.5));
        let channel = [0; 3].map(|_| uniform(rng, -1.0, 1.0) * 10_f64.powf(uniform(rng, -21.0, 9.0)));
        let broken = uniform(rng, 0.0, 1.0) < 0.05;
        (pixel, if broken { Colour::new(f64::NAN, 0.0, f64::INFINITY) } else { Colour::from_array(channel) })
    };
    std::iter::repeat_with(splat).take(count).collect()
}

fn shuffle(rng: &mut Pcg64, splats: &mut [Splat]) {
    for i in (1..splats.len()).rev() {
        splats.swap(i, (rng.next_u64() % (i as u64 + 1)) as usize);
    }
}

proptest! {
    #[test]
    fn order_does_not_matter(seed in any::<u64>(), count in 0..300_usize) {
        let mut rng = generator(seed);
        let mut splats = random_splats(&mut rng, count);
        let in_order = Owned::of(&splats);
        shuffle(&mut rng, &mut splats);
        prop_assert_eq!(in_order, Owned::of(&splats));
    }

    /// Splats dealt to several films, which are then merged in any order.
    #[test]
    fn distribution_over_films_does_not_matter(seed in any::<u64>(), count in 0..300_usize, films in 1..8_usize) {
        let mut rng = generator(seed);
        let splats = random_splats(&mut rng, count);
        let mut parts = vec![Owned::new(); films];
        for splat in &splats {
            parts[(rng.next_u64() % films as u64) as usize].add(*splat);
        }
        parts.rotate_left((rng.next_u64() % films as u64) as usize);
        let merged = Owned::new();
        parts.iter().for_each(|part| merged.merge(part));
        prop_assert_eq!(merged, Owned::of(&splats));
    }

    /// What was splatted can be taken back.
    #[test]
    fn negative_splats_cancel(seed in any::<u64>(), count in 0..300_usize) {
        let splats = random_splats(&mut generator(seed), count);
        let film = Owned::of(&splats);
        splats.iter().for_each(|(pixel, value)| film.add((*pixel, -*value)));
        prop_assert_eq!(film.cells, Owned::new().cells);
    }

    /// Within a rounding of the largest sum and the least unit per splat.
    #[test]
    fn sums_are_right(values in prop::collection::vec(-1e6..1e6_f64, 1..100)) {
        let film = Owned::new();
        values.iter().for_each(|value| film.add((DVec2::new(2.5, 1.5), Colour::new(*value, -value, 0.0))));
        // A sum of at most 100 doubles of at most 1e6.
        let sum: f64 = values.iter().sum();
        let tolerance = 100.0 * 100.0 * 1e6 * f64::EPSILON;
        prop_assert!((film.value(2, 1) - Colour::new(sum, -sum, 0.0)).abs().max_element() <= tolerance);
    }
}

#[test]
fn splats_land_in_the_pixel_that_contains_them() {
    for (x, y) in [(0, 0), (4, 0), (0, 2), (4, 2), (3, 1)] {
        for (dx, dy) in [(0.0, 0.0), (0.5, 0.5), (1.0 - 1e-12, 0.0), (0.0, 1.0 - 1e-12)] {
            let film = Owned::new();
            film.add((DVec2::new(f64::from(x) + dx, f64::from(y) + dy), Colour::ONE));
            assert_eq!(film.value(x, y), Colour::ONE, "({x} + {dx}, {y} + {dy})");
            assert_eq!(film.cells.iter().filter(|cell| **cell != Cell::default()).count(), 1);
        }
    }
}

#[test]
fn values_of_a_double_come_back() {
    for value in [
        1.0,
        -1.0,
        0.1,
        1.0 / 3.0,
        -123.456,
        987_654_321.0,
        LEAST,
        -LEAST,
        3.0 * LEAST,
        0.6 * LEAST,
        1.4 * LEAST,
        0.75 * LARGEST,
    ] {
        let film = Owned::new();
        film.add((DVec2::ZERO, Colour::new(value, 0.0, -value)));
        let expected = (value / LEAST).round() * LEAST;
        assert_eq!(film.value(0, 0), Colour::new(expected, 0.0, -expected), "{value:e}");
        assert!((expected - value).abs() <= 0.5 * LEAST);
    }
}

/// The least unit is not lost beside the largest splat, as it would be in a double.
#[test]
fn small_values_add_up_beside_large_ones() {
    let film = Owned::new();
    let large = 2_f64.powi(29);
    film.add((DVec2::ZERO, Colour::splat(large)));
    for _ in 0..1000 {
        film.add((DVec2::ZERO, Colour::splat(LEAST)));
    }
    film.add((DVec2::ZERO, Colour::splat(-large)));
    assert_eq!(film.value(0, 0), Colour::splat(1000.0 * LEAST));

    let film = Owned::new();
    film.add((DVec2::ZERO, Colour::splat(0.5 * LEAST)));
    film.add((DVec2::ZERO, Colour::splat(f64::MIN_POSITIVE)));
    assert_eq!(film, Owned::new(), "below the least unit nothing is kept, and nothing dropped");
}

#[test]
fn what_cannot_be_summed_is_dropped_and_counted() {
    let bad = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, LARGEST, -LARGEST, f64::MAX];
    let film = Owned::new();
    for value in bad {
        film.add((DVec2::ONE, Colour::new(value, 1.0, 1.0)));
        film.add((DVec2::ONE, Colour::new(1.0, 1.0, value)));
    }
    assert_eq!(film.dropped.get(), 2 * bad.len() as u64);
    assert_eq!(film.cells, Owned::new().cells);
}

#[test]
fn splats_off_the_image_are_dropped_and_counted() {
    let (width, height) = (f64::from(WIDTH), f64::from(HEIGHT));
    let off = [-1e-300, -1.0, -1e30, 1e30, f64::MAX, f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
    let film = Owned::new();
    for coordinate in off {
        film.add((DVec2::new(coordinate, 1.0), Colour::ONE));
        film.add((DVec2::new(1.0, coordinate), Colour::ONE));
        film.add((DVec2::splat(coordinate), Colour::ONE));
    }
    film.add((DVec2::new(width, 0.0), Colour::ONE));
    film.add((DVec2::new(0.0, height), Colour::ONE));
    assert_eq!(film.dropped.get(), 3 * off.len() as u64 + 2);
    assert_eq!(film.cells, Owned::new().cells);
}

/// Threads add to one film what one thread adds to another: values of both signs, whose sums pass 0 and so carry through both halves of a
/// cell all the time.
#[test]
fn threads_may_share_a_film() {
    const THREADS: u64 = 4;
    const ROUNDS: u64 = 1000;
    let splats: Vec<_> = (0..THREADS).map(|thread| random_splats(&mut generator(thread), 5000)).collect();
    let shared = Owned { is_shared: true, ..Owned::new() };
    let alone = Owned::new();
    let add = |film: &Owned, splats: &[Splat]| (0..ROUNDS).for_each(|_| splats.iter().for_each(|splat| film.add(*splat)));
    let start = Barrier::new(THREADS as usize);
    std::thread::scope(|scope| {
        for splats in &splats {
            scope.spawn(|| {
                start.wait();
                add(&shared, splats);
            });
        }
    });
    splats.iter().for_each(|splats| add(&alone, splats));
    assert_eq!(shared.cells, alone.cells);
    assert_eq!(shared.dropped, alone.dropped);
    // Merging adds, too.
    shared.merge(&alone);
    alone.merge(&alone.clone());
    assert_eq!(shared.cells, alone.cells);
}

/// A sum that leaves the range of a cell stays at its end.
#[test]
fn sums_beyond_the_range_saturate() {
    let mut film = Owned::new();
    film.cells[0] = Cell::from([i128::MAX, i128::MIN, 0]);
    film.add((DVec2::ZERO, Colour::new(1.0, -1.0, 1.0)));
    assert_eq!(film.cells[0].sums()[..2], [i128::MAX, i128::MIN]);
    let full = film.clone();
    film.merge(&full);
    assert_eq!(film.cells[0].sums()[..2], [i128::MAX, i128::MIN]);
}
