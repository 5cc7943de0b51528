//! Text without `core::fmt`, and a path's report: it says what the functions that it asks say, and names what is wrong.

mod toy;

use toy::scenes::{World, camera, homogeneous};
use volgrad::math::{Colour, DVec3, Vec3};
use volgrad::medium::Segment;
use volgrad::path::{
    Path, VERTEX_CAMERA, VERTEX_LIGHT, VERTEX_MEDIUM, Vertex, contribution, factors, path_log_gradient, report,
};
use volgrad::scene::Light;
use volgrad::text::Text;

fn number(x: f64) -> String {
    let mut buffer = [0; 32];
    let mut text = Text::new(&mut buffer);
    text.number(x);
    let length = text.length;
    String::from_utf8(buffer[..length].to_vec()).unwrap()
}

#[test]
fn numbers_read_as_they_are() {
    let cases =
        [(0.0, "0.0"), (1.0, "1.0"), (-2.5, "-2.5"), (f64::from(0.1_f32), "0.1"), (1e20, "1e20"), (0.001234, "0.001234")];
    let beyond_single = [(1.5e-300, "1.5e-300"), (5e-324, "5e-324"), (f64::MAX, "1.7976931348623157e308")];
    let odd = [(f64::NAN, "NaN"), (f64::INFINITY, "inf"), (f64::NEG_INFINITY, "-inf")];
    for (x, expected) in cases.into_iter().chain(beyond_single).chain(odd) {
        assert_eq!(number(x), expected);
    }
    for i in 0..4000 {
        let x = libm::pow(10.0, f64::from(i) / 7.0 - 280.0);
        let read: f64 = number(x).parse().unwrap();
        assert!((read / x - 1.0).abs() < 1.2e-7, "{x} is written as {}", number(x));
    }
    let mut four = [b'#'; 4];
    let mut text = Text::new(&mut four);
    text.whole(u64::MAX).put(" ").whole(0);
    assert_eq!((text.length, &four), (22, b"1844"));
}

const LIGHT: [f32; 3] = [0.0, 2.0, 0.0];

fn world() -> World {
    World::new(camera([0.0, 0.0, -3.0], 0.8, 8))
        .medium([-1.0; 3], [1.0; 3], homogeneous([0.5, 1.0, 1.5], [0.9; 3], 0.5))
        .light(Light::Point { position: DVec3::new(0.0, 2.0, 0.0), intensity: Colour::splat(8.0) }, 1.0)
}

fn vertices() -> [Vertex; 3] {
    let at = |kind, position: [f32; 3]| Vertex {
        kind,
        index: 0,
        position: Vec3::from(DVec3::from(position.map(f64::from))),
        ..Vertex::default()
    };
    [at(VERTEX_CAMERA, [0.0; 3]), at(VERTEX_MEDIUM, [0.1, 0.2, 0.3]), at(VERTEX_LIGHT, LIGHT)]
}

fn words(world: &World, path: &Path) -> String {
    let mut buffer = [0; 4096];
    let mut text = Text::new(&mut buffer);
    report(&world.scene(), path, &mut text);
    let length = text.length;
    String::from_utf8(buffer[..length].to_vec()).unwrap()
}

/// The three numbers after `name`.
fn vector(words: &str, name: &str) -> DVec3 {
    let rest = words.split_once(name).unwrap_or_else(|| panic!("no {name} in {words}")).1;
    let mut numbers = rest.split([' ', ',', '\n']).filter(|word| !word.is_empty()).map(|word| word.parse().expect(name));
    DVec3::new(numbers.next().unwrap(), numbers.next().unwrap(), numbers.next().unwrap())
}

#[test]
fn a_report_has_the_factors_and_the_gradients() {
    let world = world();
    let (vertices, scene) = (vertices(), world.scene());
    let from = DVec3::new(0.0, 0.0, -3.0);
    let x = vertices[1].position.wide();
    let mut segments = world.geometry.segments(from, (x - from).normalize(), (x - from).length()).unwrap();
    let mut edge_ends = vec![segments.len() as u32];
    let to = DVec3::from(LIGHT.map(f64::from)) - x;
    segments.extend(world.geometry.segments(x, to.normalize(), to.length()).unwrap());
    edge_ends.push(segments.len() as u32);
    let path = Path { vertices: &vertices, segments: &segments, edge_ends: &edge_ends };
    let words = words(&world, &path);
    println!("{words}");
    let same = |name: &str, expected: DVec3| {
        let found = vector(&words, name);
        assert!((found - expected).length() <= 1e-6 * expected.length(), "{name} {found}, not {expected}");
    };
    let gradient = path_log_gradient(&scene, &path, 1).unwrap();
    same(", f =", contribution(&scene, &path).unwrap());
    same("sigma_s * phase =", factors(&scene, &path, 1).unwrap().vertex);
    same("emission =", factors(&scene, &path, 2).unwrap().vertex);
    same("grad log luminance =", gradient.luminance);
    same("geometry_next =", gradient.factors.geometry_next);
    same("phase_apex =", gradient.factors.phase_apex);
    same("        importance =", gradient.factors.importance);
    same("transmittance_previous green =", gradient.factors.transmittance_previous[1]);
    assert!(words.contains("vertex 1: medium 0 at 0.1 0.2 0.3") && !words.contains("not valid"));
}

#[test]
fn a_report_names_what_is_wrong() {
    let world = world();
    let segments = [Segment { end: 9.0, medium: 0, normal: Vec3::default() }; 2];
    let said = |vertices: &[Vertex], edge_ends: &[u32]| words(&world, &Path { vertices, segments: &segments, edge_ends });
    let mut wrong = vertices();
    wrong[1].index = 7;
    let report = said(&wrong, &[1, 2]);
    assert!(report.contains("not valid: an index past its array (vertex or edge 1)"));
    // Where it is, and the edges on both sides of it, help to find it.
    assert!(report.contains("unknown 7 at ") && report.matches("edge of ").count() == 2, "{report}");
    wrong = vertices();
    wrong[2].position.x = 0.5;
    assert!(said(&wrong, &[1, 2]).contains("not valid: off the lens, or not where the light is (vertex or edge 2)"));
    assert!(said(&vertices(), &[2, 1]).contains("segments missing"));
}
