//! The path that a technique makes of primary sample numbers.

use super::numbers::Change;
use crate::math::{DVec2, luminance};
use crate::sampler::bidirectional::{Connection, Connector, Limits, Subpath, Technique, from_camera, from_light};
use crate::sampler::path_tracer::Stats;
use crate::sampler::primary::{PrimarySample, Slot, pair};
use crate::scene::{Queries, Scene, Stop, View};

/// Room for a path.
#[derive(Default)]
pub struct Scratch<'a> {
    pub camera: Subpath<'a>,
    pub light: Subpath<'a>,
}

/// Makes the path. None: it carries nothing.
pub fn make<'a, Q: Queries>(
    scene: &'a Scene<'a>,
    queries: &Q,
    technique: Technique,
    numbers: &[f64],
    room: &mut Scratch<'a>,
    stats: &mut Stats,
) -> Result<Option<Connection>, Stop> {
    remake(scene, queries, technique, numbers, Change::BOTH, &mut room.camera, &mut room.light, stats)
}

/// Makes the path, of which a subpath whose numbers do not change is there already.
pub fn remake<'a, Q: Queries>(
    scene: &'a Scene<'a>,
    queries: &Q,
    technique: Technique,
    numbers: &[f64],
    change: Change,
    camera: &mut Subpath<'a>,
    light: &mut Subpath<'a>,
    stats: &mut Stats,
) -> Result<Option<Connection>, Stop> {
    let (mut for_camera, mut for_light) = technique.split(numbers);
    let limits = |vertices| Limits { vertices, rr_depth: usize::MAX };
    let first = for_camera.vertex(0);
    let [x0, y0, x1, y1] = scene.camera.crop.map(f64::from);
    let place = DVec2::new(x0, y0) + pair(&first, Slot::DirectionU, Slot::DirectionV) * DVec2::new(x1 - x0, y1 - y0);
    let lens = scene.camera.lens_point(pair(&first, Slot::LightU, Slot::LightV));
    if change.light && technique.light > 0 {
        from_light(scene, queries, limits(technique.light), &mut for_light, light, stats)?;
    } else if change.light {
        light.clear();
    }
    if light.vertices().len() != technique.light {
        return Ok(None);
    }
    if change.camera {
        let mut view = [View::through(scene, place, lens)];
        if technique.camera > 1 {
            View::trace(&mut view, scene, queries)?;
            stats.rays += 1;
        }
        from_camera(scene, queries, &mut view[0], limits(technique.camera), &mut for_camera, camera, stats)?;
    }
    if camera.vertices().len() != technique.camera {
        return Ok(None);
    }
    let connector = Connector::of_all_techniques(scene, queries, place, lens);
    connector.connect(camera.vertices(), light.vertices(), stats)
}

/// What a chain's density is proportional to: the luminance of w·f/p.
pub fn target(connection: &Connection) -> f64 {
    luminance(connection.value) * connection.weight
}
