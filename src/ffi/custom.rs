//! What the host computes: tables of its functions, and how many of their values were left out.

use super::callbacks::{volgrad_custom_bsdf, volgrad_custom_density, volgrad_custom_light, volgrad_custom_phase};
use super::pointer::output;
use super::scenes::{object, volgrad_scene};
use super::status::{finish, volgrad_status};
use core::fmt;
use core::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// A copy of a host's table, whose functions may be called by several threads at a time, with the same `user`.
pub(super) struct Host<T> {
    pub table: T,
    dropped: AtomicUsize,
}

// What shows numbers can panic, so that it is left out of libvolgrad_core.
impl<T> fmt::Debug for Host<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Host")
    }
}

// SAFETY: the header's contract of every table: what it points to may be used by all threads at a time.
unsafe impl<T> Sync for Host<T> {}

impl<T> Host<T> {
    pub fn new(table: T) -> Self {
        Self { table, dropped: AtomicUsize::new(0) }
    }

    /// Counts a value that is none; the core takes 0 for it.
    pub fn checked<V>(&self, value: V, ok: bool) -> V {
        if !ok {
            self.dropped.fetch_add(1, Relaxed);
        }
        value
    }

    fn dropped(hosts: &[Self]) -> u64 {
        hosts.iter().map(|host| host.dropped.load(Relaxed) as u64).sum()
    }
}

/// A scene's tables.
#[derive(Clone, Copy)]
pub(super) struct Hosts {
    pub densities: &'static [Host<volgrad_custom_density>],
    pub bsdfs: &'static [Host<volgrad_custom_bsdf>],
    pub phases: &'static [Host<volgrad_custom_phase>],
    pub lights: &'static [Host<volgrad_custom_light>],
}

/// How many values of the scene's custom densities were NaN, infinite or negative, and how many of their gradients were not finite, since
/// `volgrad_scene_init`: all of them count as 0. A scene's guided scenes count with it. While other threads use the scene this is what they
/// have counted by now.
/// Costs a look at each custom density's counter.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_scene_dropped_densities(scene: *const volgrad_scene, dropped: *mut u64) -> volgrad_status {
    finish((|| {
        // SAFETY: the header's contract.
        let (scene, write) = unsafe { (object(scene)?, output(dropped)?) };
        write(Host::dropped(scene.hosts.densities));
        Ok(())
    })())
}

/// The same of the scene's custom materials, phase functions and lights: values and densities that were NaN, infinite or negative, sampled
/// directions that were no unit vectors, cosines beyond 1, and derivatives that were not finite.
/// Costs a look at each one's counter.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn volgrad_scene_dropped_values(scene: *const volgrad_scene, dropped: *mut u64) -> volgrad_status {
    finish((|| {
        // SAFETY: the header's contract.
        let (scene, write) = unsafe { (object(scene)?, output(dropped)?) };
        let Hosts { bsdfs, phases, lights, .. } = &scene.hosts;
        write(Host::dropped(bsdfs) + Host::dropped(phases) + Host::dropped(lights));
        Ok(())
    })())
}
