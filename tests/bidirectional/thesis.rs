//! The thesis' estimator, path by path, against f and the p of all techniques from `path`, written down for the moved path: the gradient of
//! each case is that of log(f/p) by finite differences, the MIS weight of y is p/Σp, and a batch has W = w(y)/w(x) · (1 + ⟨∇log(f/p), d⟩).

use crate::path::Path;
use crate::toy::scenes::World;
use crate::{each_technique, options, pixels, worlds};
use std::collections::BTreeMap;
use volgrad::math::{DVec3, luminance};
use volgrad::medium::NONE;
use volgrad::sampler::bidirectional::thesis::{EMPTY, Moving, Options};
use volgrad::sampler::bidirectional::{Bidirectional, Heuristic, Joined, Kind, Sample};
use volgrad::sampler::{Stats, line_numbers};
use volgrad::scene::{HIT_NONE, Hit, Queries, Ray, Scene};

const LONGEST: u32 = 5;

/// World units: rays and segments are in single precision, so that differences of less are noise.
const STEP: f64 = 2e-3;
/// Of a gradient, relative, or 1/world unit where that is less than 1.
const OF_DIFFERENCES: f64 = 2e-3;
/// Single precision, as in `weights`; and of f/p.
const OF_WEIGHTS: f64 = 1e-5;
/// Nearer to each other than this, single precision knows little of what is between two vertices, and differences little of 1/d².
const NEAR: f64 = 0.1;
/// What is left out otherwise: within a step or rounding of an edge of a medium, of a surface, or of a grid's cell.
const MOST_AT_EDGES: f64 = 0.02;

/// A path of one technique, and a direction in which its first vertex may move.
struct Subject<'s, 'a> {
    world: &'a World,
    scene: &'a Scene<'a>,
    sample: &'s Sample<'s, 'a>,
    /// A unit vector.
    along: DVec3,
}

impl<'s, 'a> Subject<'s, 'a> {
    fn s(&self) -> usize {
        self.sample.light.len()
    }

    /// The case of [Lu20 fig. 13].
    fn case(&self) -> u32 {
        match (self.s(), self.sample.camera.len()) {
            (1.., t @ 1..=3) => t as u32 + 2,
            _ => 6,
        }
    }

    /// The whole path with x_1 elsewhere, as the reference has it.
    fn path(&self, offset: DVec3) -> Path<'a> {
        let mut path = Path::new(self.world, self.sample);
        path.vertices[1].position += offset;
        path
    }

    /// 1/p as far as the thesis does not have it.
    fn chance(&self, path: &Path) -> f64 {
        match (self.s(), self.sample.camera.len()) {
            (2, 1) => 1.0 / path.aim(),
            (_, 1) => 1.0,
            _ => path.collisions(),
        }
    }

    /// f/p, its luminance, without that.
    fn value(&self, offset: DVec3) -> f64 {
        let path = self.path(offset);
        luminance(path.contribution()) / (path.densities()[self.s()] * self.chance(&path))
    }

    /// p/Σp.
    fn weight(&self, path: &Path) -> f64 {
        let densities = path.densities();
        densities[self.s()] / densities.iter().sum::<f64>()
    }

    fn medium(&self) -> u32 {
        match self.path(DVec3::ZERO).vertices[1].kind {
            Kind::Medium { index, .. } => index,
            _ => NONE,
        }
    }

    /// Whether the camera sees y in x_1's medium, and y sees x_2.
    fn is_seen(&self, path: &Path) -> bool {
        let [x0, y] = [0, 1].map(|i| path.vertices[i].position);
        let lens = self.scene.camera.on_lens(x0);
        let next = &path.vertices[2];
        let far = matches!(next.kind, Kind::Far { .. });
        let to_next = if far { f64::INFINITY } else { next.position.distance(y) - 1e-4 };
        self.scene.camera.project(y, lens).is_some()
            && self.world.geometry.medium_at(y) == self.medium()
            && self.is_free(x0, path.to(0, 1), y.distance(x0) - 1e-4)
            && self.is_free(y, path.to(1, 2), to_next)
    }

    fn is_free(&self, from: DVec3, direction: DVec3, distance: f64) -> bool {
        let mut hits = [Hit::EMPTY];
        let ray = Ray { t_min: 1e-4, ..Ray::free(from, direction, distance, self.world.geometry.medium_at(from)) };
        self.world.geometry.occluded(&[ray], &mut hits).expect("never stops");
        hits[0].kind == HIT_NONE
    }

    /// Whether vertices next to x_1 are near.
    fn is_crowded(&self, path: &Path) -> bool {
        path.distance(1) < NEAR || path.distance(2) < NEAR || path.is_between_cells()
    }

    /// Tells the estimator for this path.
    fn moving<T>(&self, tell: impl FnOnce(&mut Moving<'_, 'a, crate::Geometry>) -> T) -> T {
        let Sample { camera, light, connection } = self.sample;
        let path = Joined { scene: self.scene, camera, light, connection };
        tell(&mut Moving::new(&path, &self.world.geometry).expect("never stops"))
    }
}

/// All paths of some samples to which the estimator applies.
fn each(world: &World, passes: u64, mut tell: impl FnMut(&Subject)) {
    let scene = world.scene();
    let options = volgrad::sampler::bidirectional::Options { rr_depth: 99, ..options(LONGEST, Heuristic::Balance) };
    let sampler = Bidirectional { scene: &scene, queries: &world.geometry, options };
    let mut random = line_numbers(3, 0);
    for pass in 0..passes {
        for pixel in 0..pixels(world) {
            let tell = |sample: &Sample| {
                let Sample { camera, light, connection } = sample;
                let path = Joined { scene: &scene, camera, light, connection };
                if !path.is_available() {
                    return;
                }
                let any = DVec3::from_array([0; 3].map(|_| 2.0 * random() - 1.0)).normalize();
                let along = if path.vertex(2).is_specular() { path.directions(1).1 } else { any };
                tell(&Subject { world, scene: &scene, sample, along });
            };
            each_technique(&sampler, pass, pixel, tell);
        }
    }
}

fn all_worlds() -> Vec<(&'static str, World)> {
    let smooth = worlds::media().into_iter().filter(|(name, _)| *name != "custom");
    let all = worlds::lights().into_iter().chain(worlds::cameras()).chain(worlds::materials()).chain(worlds::glass());
    all.chain(worlds::guided()).chain(smooth).collect()
}

/// Both with the factors of the case alone; beside a specular vertex along the edge to it.
#[test]
fn gradients_are_those_of_finite_differences() {
    let mut cases = BTreeMap::<(u32, bool), u32>::new();
    let mut largest = BTreeMap::<u32, f64>::new();
    for (name, world) in all_worlds() {
        let (mut count, mut at_edges) = (0, 0);
        each(&world, 20, |subject| {
            let paths = [STEP, -STEP].map(|step| subject.path(step * subject.along));
            if paths.iter().any(|path| subject.is_crowded(path)) {
                return;
            }
            count += 1;
            let [ahead, behind] = [STEP, -STEP].map(|step| subject.value(step * subject.along).ln());
            let found = subject.moving(|moving| moving.gradient()).dot(subject.along);
            let expected = (ahead - behind) / (2.0 * STEP);
            if !((found - expected).abs() < OF_DIFFERENCES * expected.abs().max(1.0)) {
                at_edges += 1;
                return;
            }
            let specular = subject.path(DVec3::ZERO).is_specular(2);
            *cases.entry((subject.case(), specular)).or_default() += 1;
            let largest = largest.entry(subject.case()).or_default();
            *largest = largest.max(expected.abs());
        });
        println!("{name}: {at_edges} of {count} not compared");
        assert!(count > 100 && f64::from(at_edges) <= MOST_AT_EDGES * f64::from(count), "{name}: {at_edges} of {count}");
    }
    println!("compared {cases:?}; largest gradients {largest:?}");
    let seen: Vec<(u32, bool)> = cases.into_iter().filter(|(_, count)| *count > 20).map(|(case, _)| case).collect();
    assert_eq!(seen, [(3, false), (3, true), (4, false), (5, false), (6, false), (6, true)]);
    // Case 6 has none, but for what is left in chromatic media.
    assert!((3..=5).all(|case| largest[&case] > 1.0));
}

/// At offsets as large as the scene's own structure.
#[test]
fn weights_are_those_of_the_moved_path() {
    let mut cases = BTreeMap::<(u32, bool), u32>::new();
    for (name, world) in all_worlds() {
        let (mut dark, mut worst) = (0, 0.0_f64);
        each(&world, 20, |subject| {
            let offset = 0.3 * subject.along;
            let path = subject.path(offset);
            // Beyond a specular vertex: another path.
            let beyond = path.is_specular(2) && 0.3 > subject.path(DVec3::ZERO).distance(2);
            if subject.is_crowded(&path) || beyond {
                return;
            }
            let (found, own) = subject.moving(|moving| {
                let stats = &mut Stats::default();
                [offset, DVec3::ZERO].map(|offset| moving.moved(offset, stats).expect("never stops")).into()
            });
            let Some(own) = own else { panic!("x is seen") };
            let weight = if subject.is_seen(&path) { subject.weight(&path) } else { 0.0 };
            let Some(found) = found else {
                dark += 1;
                assert!(!(weight > 0.0), "{name}, case {}: {weight}", subject.case());
                return;
            };
            let lens = subject.scene.camera.on_lens(path.vertices[0].position);
            let image = subject.scene.camera.project(path.vertices[1].position, lens).expect("it is seen");
            let chance = subject.chance(&path) / subject.chance(&subject.path(DVec3::ZERO));
            let errors = [found.weight / weight - 1.0, found.chance / own.chance / chance - 1.0];
            let error =
                errors.into_iter().fold((found.pixel - image.pixel).length(), |a, b| if b.abs() > a { b.abs() } else { a });
            assert!(error < OF_WEIGHTS, "{name}, case {}: {error} {errors:?}", subject.case());
            worst = worst.max(error);
            *cases.entry((subject.case(), path.is_specular(2))).or_default() += 1;
        });
        println!("{name}: errors up to {worst:.1e}; {dark} carry nothing");
    }
    println!("compared {cases:?}");
    let seen: Vec<(u32, bool)> = cases.into_iter().filter(|(_, count)| *count > 20).map(|(case, _)| case).collect();
    assert_eq!(seen, [(3, false), (3, true), (4, false), (5, false), (6, false), (6, true)]);
}

/// Numbers, three for each member, and the points of the unit ball or, from the first of each, of (−1, 1) that they are made into.
const NUMBERS: [f64; 9] = [0.75, 0.6, 0.2, 0.1, 0.4, 0.5, 0.3, 0.7, 0.9];
const POINTS: [DVec3; 3] = [DVec3::new(0.5, 0.2, -0.6), DVec3::new(-0.8, -0.2, 0.0), DVec3::new(-0.4, 0.4, 0.8)];

const RADIUS: f64 = 0.02;
const SAMPLES: f64 = 1e4;
const ALPHA: f64 = 0.25;

/// Of W, whose W − 1 is first order, beside its square.
const ROUNDING: f64 = 1e-3;

/// The radius falls over the samples of the image, or as the thesis prints it over the members of each batch.
#[test]
fn batches_are_worth_w_f_over_p() {
    let mut largest = 0.0_f64;
    for (name, world) in all_worlds() {
        let (mut count, mut apart) = (0, 0);
        each(&world, 4, |subject| {
            let own = subject.path(DVec3::ZERO);
            if subject.is_crowded(&own) {
                return;
            }
            for as_printed in [false, true] {
                let options = Options { radius: RADIUS, count: 3, alpha: ALPHA, clamp: f64::INFINITY, as_printed };
                let radii = if as_printed {
                    [1.0_f64, 2.0, 3.0].map(|i| RADIUS * i.powf((ALPHA - 1.0) / 3.0))
                } else {
                    [RADIUS * SAMPLES.powf((ALPHA - 1.0) / 3.0); 3]
                };
                let mut members = EMPTY;
                let mut numbers = NUMBERS.iter().step_by(if own.is_specular(2) { 3 } else { 1 });
                let mut random = || *numbers.next().expect("three for each");
                let stats = &mut Stats::default();
                let made = subject.moving(|moving| moving.batch(&options, SAMPLES, &mut random, &mut members, stats));
                if made.expect("never stops").expect("x is seen") < 3 {
                    continue;
                }
                for ((pixel, w), (point, radius)) in members.into_iter().zip(POINTS.into_iter().zip(radii)) {
                    let offset = radius * if own.is_specular(2) { point.x * subject.along } else { point };
                    let path = subject.path(offset);
                    let lens = subject.scene.camera.on_lens(path.vertices[0].position);
                    let image = subject.scene.camera.project(path.vertices[1].position, lens).expect("it is seen");
                    assert!((pixel - image.pixel).length() < 1e-6, "{name}: {pixel}, not {}", image.pixel);
                    let value =
                        |path: &Path| subject.weight(path) * luminance(path.contribution()) / path.densities()[subject.s()];
                    count += 1;
                    apart += u32::from((w - value(&path) / value(&own)).abs() > ROUNDING + (w - 1.0) * (w - 1.0));
                    largest = largest.max((w - 1.0).abs());
                }
            }
        });
        println!("{name}: {apart} of {count} differ");
        assert!(count > 100 && f64::from(apart) <= 2.0 * MOST_AT_EDGES * f64::from(count), "{name}: {apart} of {count}");
    }
    assert!(largest > 0.1);
}

#[test]
fn clamps_are_kept() {
    let options = Options { radius: 0.3, count: 3, alpha: 1.0, clamp: 1.25, as_printed: false };
    let mut reached = 0;
    each(&worlds::lamp(worlds::room(worlds::pinhole(), worlds::fog())), 4, |subject| {
        let (mut members, mut random) = (EMPTY, line_numbers(4, 0));
        let made = subject.moving(|moving| moving.batch(&options, 1.0, &mut random, &mut members, &mut Stats::default()));
        for (_, w) in &members[..made.expect("never stops").expect("x is seen")] {
            assert!(w.abs() <= 1.25);
            reached += u32::from(w.abs() == 1.25);
        }
    });
    assert!(reached > 20);
}
