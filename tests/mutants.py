#!/usr/bin/env python3
"""Do the statistical tests notice? Each mutant is a mistake that one could make in src/; the named test has to fail on it.

Copies the repository to a temporary directory, checks that all named tests pass there, then makes one change at a time and runs its
test. Needs git, cargo and Python's standard library. Exits with 1 if a mutant survives, is not found in the source, or does not
compile. Usage: tests/mutants.py [part of a mutant's name ...]
"""

import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass


@dataclass
class Mutant:
    name: str
    file: str
    old: str  # must occur exactly once
    new: str
    test: str  # "file test" of cargo test


MUTANTS = [
    # How chains are shared out.
    Mutant(
        "a length that shares chains counts as if it had them for itself",
        "src/sampler/metropolis/bootstrap.rs",
        "/ (chains * sum / of)",
        "/ chains",
        "metropolis each_length_counts_right",
    ),
    # Distances from milestones.
    Mutant(
        "what lies before a milestone counts again after it",
        "src/medium/milestones.rs",
        "target - before)",
        "target)",
        "tracking distances_are_found_from_milestones",
    ),
    Mutant(
        "milestones are those of any stretch",
        "src/medium/milestones.rs",
        "known == 0 || stretch.start != self.start",
        "known == 0",
        "tracking distances_are_found_from_milestones",
    ),
    Mutant(
        "a flight knows the extinction of density 1",
        "src/medium/tracking.rs",
        "extinction: medium.sigma_t * density, pdf",
        "extinction: medium.sigma_t, pdf",
        "tracking pdf_is_the_derivative_of_the_cdf",
    ),
    Mutant(
        "a path whose own ray is not known is shared out as if nothing were on it",
        "src/shift/place.rs",
        "        let probability = view.known_collisions()?.probability;\n        let pdf = collision_pdf",
        "        let probability = view.known_collisions().map_or(0.0, |collisions| collisions.probability);\n        let pdf = collision_pdf",
        "tiles what_is_seen_through_too_many_media_stays_where_it_is",
    ),
    # What hosts say about points of surfaces.
    Mutant(
        "surfaces that a batch's members see forget what their hits said",
        "src/shift/run.rs",
        "Some(Self::Surface { material: hit.material, normal, medium, user: hit.user })",
        "Some(Self::Surface { material: hit.material, normal, medium, user: 0 })",
        "custom points_are_on_their_surfaces",
    ),
    Mutant(
        "vertices of subpaths forget what their hits said",
        "src/sampler/bidirectional/subpath.rs",
        "(hit.unit_normal(), hit.user)",
        "(hit.unit_normal(), 0)",
        "custom points_are_on_their_surfaces",
    ),
    Mutant(
        "a batch's members all see the texture where the path's own vertex is",
        "src/shift/run.rs",
        "self.a * self.place.scattering(scene, self.vertex(path, i), ",
        "self.a * self.place.scattering(scene, path.first().x, ",
        "custom a_texture_renders_as_pieces_do",
    ),
    Mutant(
        "grids: cells on the far side of a box's low faces",
        "src/medium/walk.rs",
        "sample.min(self.size[axis] - 1).max(0) as usize",
        "sample.min(self.size[axis] - 1) as usize",
        "tracking_edge_cases walks_end_in_boxes_of_no_volume",
    ),
    # Films.
    Mutant(
        "shared films: what one half of a sum carries over is lost",
        "src/film.rs",
        "carry = full || (part != 0 && limb.fetch_add(part, Relaxed).overflowing_add(part).1);",
        "carry = full || (part != 0 && limb.fetch_add(part, Relaxed) == 0 && false);",
        "film threads_may_share_a_film",
    ),
    Mutant(
        "shared films are added to as if by one thread",
        "src/film.rs",
        "if self.is_shared { sum.add_shared(v) } else { sum.add(v) }",
        "sum.add(v)",
        "film threads_may_share_a_film",
    ),
    # Layers.
    Mutant(
        "paths that begin on a mirror are in the layer of surfaces that scatter",
        "src/sampler/path_tracer.rs",
        "if bsdf.is_specular() => first.specular",
        "if bsdf.is_specular() => first.surface",
        "determinism layers_add_up",
    ),
    Mutant(
        "light that the camera sees directly is in every layer",
        "src/sampler/path_tracer.rs",
        "|_| self.options.first.none && ",
        "|_| ",
        "determinism layers_add_up",
    ),
    # Paths handed over together.
    Mutant(
        "contributions that share a link and a wing: only the first counts",
        "src/shift/paths.rs",
        "*sum += *rest;",
        "let _ = (sum, rest);",
        "host_sampler paths_that_begin_alike",
    ),
    Mutant(
        "a tile's rays serve paths at other places of its pixels",
        "src/shift/paths.rs",
        "const SAME_PLACE: f64 = 1e-3;",
        "const SAME_PLACE: f64 = 1.0;",
        "host_sampler paths_that_begin_alike",
    ),
    Mutant(
        "paths that begin elsewhere join a batch",
        "src/shift/paths.rs",
        "same_place && a.x == b.x",
        "same_place",
        "host_sampler paths_that_begin_alike",
    ),
    # What is looked at to find mistakes.
    Mutant(
        "a path's report leaves out the gradient of the importance",
        "src/path/report.rs",
        '("importance", g.importance)',
        '("importance", g.scattering)',
        "path_report a_report_has_the_factors",
    ),
    Mutant(
        "numbers in text that single precision cannot hold are 0",
        "src/text.rs",
        "if single.is_normal() || x == 0.0 {",
        "if single.is_finite() {",
        "path_report numbers_read_as_they_are",
    ),
    # The shifts: what makes the unbiased modes unbiased.
    Mutant(
        "no stay rule: rejected offsets are lost",
        "src/shift/weight.rs",
        "split.stays += self.carried[g];",
        "",
        "unbiased exact_disk_under_a_point_light",
    ),
    Mutant(
        "exact bounds W above only",
        "src/shift/weight.rs",
        "ratio * MAX_RATIO >= 1.0 && ratio <= MAX_RATIO",
        "ratio > 0.0 && ratio <= MAX_RATIO",
        "unbiased exact_ball_under_a_point_light",
    ),
    Mutant(
        "exact bounds W below only",
        "src/shift/weight.rs",
        "ratio * MAX_RATIO >= 1.0 && ratio <= MAX_RATIO",
        "ratio * MAX_RATIO >= 1.0",
        "unbiased exact_ball_under_a_point_light",
    ),
    Mutant(
        "two_level: the exact members correct only themselves",
        "src/shift/weight.rs",
        "let there = c.there + (e.there - c.there) * share;",
        "let there = e.there + 0.0 * share;",
        "unbiased two_level_disk_under_a_point_light",
    ),
    Mutant(
        "two_level corrects what moves but not what stays",
        "src/shift/weight.rs",
        "let stays = c.stays + (e.stays - c.stays) * share;",
        "let stays = c.stays;",
        "unbiased two_level_tile_beside_specular_surfaces",
    ),
    Mutant(
        "exchangeable without a common centre",
        "src/shift/spots.rs",
        "let drawn = if options.mode == Mode::Exchangeable { 0 } else { 1 };",
        "let drawn = 1;",
        "unbiased exchangeable_disk_under_a_point_light",
    ),
    Mutant(
        "exchangeable, thesis' choice: the sum leaves the path itself out",
        "src/shift/weight.rs",
        "let share = own / (own + others.sum::<f64>());",
        "let share = (own / others.sum::<f64>()).min(1.0);",
        "kernels energy",
    ),
    Mutant(
        "the camera edge is never occluded",
        "src/shift/evaluate.rs",
        "if hit.kind == wanted {",
        "let start = self.scene.camera.position + self.scene.camera.near_clip * self.scene.camera.forward;\n"
        "            if hit.kind == wanted || wanted == HIT_NONE && (rays[0].origin.wide() - start).length() < 0.2 {",
        "unbiased exact_disk_under_a_point_light",
    ),
    Mutant(
        "other edges are never occluded",
        "src/shift/evaluate.rs",
        "if hit.kind == wanted {",
        "let start = self.scene.camera.position + self.scene.camera.near_clip * self.scene.camera.forward;\n"
        "            if hit.kind == wanted || wanted == HIT_NONE && (rays[0].origin.wide() - start).length() > 0.2 {",
        "unbiased exact_disk_under_a_point_light",
    ),
    Mutant(
        "a disk across the camera ray",
        "src/shift/spots.rs",
        "let (right, down) = (side * camera.right, -side * camera.up);",
        "let (s, t) = crate::math::orthonormal_basis((x - camera.position).normalize());\n"
        "    let (right, down) = (side * s, side * t);",
        "unbiased exact_disk_under_a_point_light",
    ),
    Mutant(
        "a shifted surface without its cosine",
        "src/shift/run.rs",
        "bsdf.eval(&at, to_previous, to_next) * normal.dot(to_next).abs())",
        "bsdf.eval(&at, to_previous, to_next))",
        "unbiased exact_disk_beside_specular_surfaces",
    ),
    Mutant(
        "a surface's path forgets the probability of passing the media before it",
        "src/sampler/path_tracer.rs",
        "self.record.first(image, probability, &arrival);",
        "self.record.first(image, 1.0, &arrival);",
        "unbiased exchangeable_disk_beside_specular_surfaces",
    ),
    Mutant(
        "a disk that is not uniform by area",
        "src/shift/spots.rs",
        "radius * DVec2::from_array(step)",
        "{ let d = DVec2::from_array(step); radius * d.length() * d }",
        "kernels the_disk_is_symmetric",
    ),
    Mutant(
        "a ball that is not uniform by volume",
        "src/shift/spots.rs",
        "radius * DVec3::from_array(offset)",
        "{ let d = DVec3::from_array(offset); radius * d.length() * d }",
        "kernels the_ball_is_symmetric",
    ),
    Mutant(
        "the radius shrinks with the square root",
        "src/shift/kernel.rs",
        "(self.alpha - 1.0) / 3.0",
        "(self.alpha - 1.0) / 2.0",
        "kernels the_radius_follows_its_schedule",
    ),
    Mutant(
        "a member's value leaves the density out",
        "src/shift/run.rs",
        "|medium| medium.sigma_s(x)),",
        "|medium| medium.sigma_t),",
        "unbiased exchangeable_ball_under_a_point_light",
    ),
    Mutant(
        "the phase function at the next vertex stays as it was",
        "src/shift/run.rs",
        "onwards.phase.eval(-aim.direction.dot(*to_other))",
        "onwards.phase.eval(0.0 * aim.direction.dot(*to_other))",
        "host_sampler a_shifted_splat",
    ),
    Mutant(
        "the light's cosine is left out",
        "src/shift/link.rs",
        "let cosine = normal.map_or(1.0, |n| -n.dot(direction));",
        "let cosine = normal.map_or(1.0, |n| f64::from(n.dot(direction) < 0.0));",
        "single_scattering shifted_paths_under_an_area_light",
    ),
    Mutant(
        "from_path takes the weight for the whole contribution",
        "src/shift/from_path.rs",
        "let scale = luminance(weight) / luminance(shiftable.carried(scene));",
        "let scale = luminance(weight);",
        "host_sampler exchangeable_single_scattering",
    ),
    Mutant(
        "a spot light shines everywhere as at x_1",
        "src/sampler/record.rs",
        "Stage::Run if !event.profile => {",
        "Stage::Run => {",
        "unbiased exact_disk_under_a_spot_light",
    ),
    # Runs.
    Mutant(
        "runs: a step without sigma_s",
        "src/shift/run.rs",
        "self.a *= scattering * sigma_s * transmittance(optical_depth);",
        "self.a *= scattering * sigma_s.signum() * transmittance(optical_depth);",
        "kernels a_record_is_the_whole_path",
    ),
    Mutant(
        "runs: a step without transmittance",
        "src/shift/run.rs",
        "self.a *= scattering * sigma_s * transmittance(optical_depth);",
        "self.a *= scattering * sigma_s * transmittance(0.0 * optical_depth);",
        "kernels a_record_is_the_whole_path",
    ),
    Mutant(
        "runs: the transmittance inside stays as it was",
        "src/shift/evaluate.rs",
        "value.step(scene, path, i, Place::Medium(last.medium), optical_depth_or_dark(&line));",
        "value.step(scene, path, i, Place::Medium(last.medium), vertex.depth.at_x + 0.0 * optical_depth_or_dark(&line));",
        "host_sampler a_shifted_splat",
    ),
    Mutant(
        "runs: members keep the medium of each vertex",
        "src/shift/evaluate.rs",
        "let (Some(value), Some(last)) = (&mut member.value, hit.media().last()) else { return };\n"
        "                let line = Line::new(scene.media, value.vertex(path, i - 1), direction, distance, hit.media());\n"
        "                value.step(scene, path, i, Place::Medium(last.medium), optical_depth_or_dark(&line));",
        "let Some(value) = &mut member.value else { return };\n"
        "                let line = Line::new(scene.media, value.vertex(path, i - 1), direction, distance, hit.media());\n"
        "                value.step(scene, path, i, vertex.place, optical_depth_or_dark(&line));",
        "unbiased exchangeable_disk_under_a_point_light",
    ),
    Mutant(
        "runs: those that end before their last vertex forget its sigma_s",
        "src/sampler/record.rs",
        "self.rest *= sigma_s * (last.distance * last.distance / pdf);",
        "self.rest *= sigma_s.signum() * (last.distance * last.distance / pdf);",
        "kernels a_record_is_the_whole_path",
    ),
    Mutant(
        "runs: those that end before their last vertex forget its phase function",
        "src/sampler/record.rs",
        "self.stage = Stage::Beyond { onwards: arrival.line.direction, wing: true };",
        "self.stage = Stage::Beyond { onwards: arrival.line.direction, wing: false };",
        "kernels a_record_is_the_whole_path",
    ),
    Mutant(
        "runs: the gradient of the edge from the camera moves as a whole",
        "src/shift/from_path.rs",
        "Depth::far(&moments(&edge), edge.direction, edge.length)",
        "Depth::whole(&moments(&edge))",
        "gradients batches_use_the_gradient",
    ),
    Mutant(
        "runs: the gradient of the first phase function is left out beyond it",
        "src/shift/gradient.rs",
        "if let Some(next) = path.run().get(1) {",
        "if let Some(next) = path.run().get(super::kernel::MAX_RUN) {",
        "gradients batches_use_the_gradient",
    ),
    # Chains.
    Mutant(
        "chains: reflectances and refractions stay those of x",
        "src/shift/chain.rs",
        "value: value * bounce.value }",
        "value }",
        "kernels a_shift_by_nothing_changes_nothing",
    ),
    Mutant(
        "chains: the light is as at x, whatever y finds",
        "src/shift/chain.rs",
        "Found::Light(value * self.emission(scene, hit))",
        "Found::Light(value)",
        "unbiased exact_disk_beside_specular_surfaces",
    ),
    Mutant(
        "chains: no media behind the first surface",
        "src/shift/chain.rs",
        "let medium = hit.medium_beyond(bounce.direction.dot(at.normal) > 0.0);",
        "let medium = NONE;",
        "unbiased exact_disk_beside_specular_surfaces",
    ),
    Mutant(
        "chains: rough surfaces go on with them",
        "src/sampler/path_tracer.rs",
        "_ => self.record.end_chain(),",
        "_ => {}",
        "kernels a_record_is_the_whole_path",
    ),
    # Weights from gradients.
    Mutant(
        "linear weights: those whose spot is left out are lost",
        "src/shift/weight.rs",
        "let mut stay_counts = [spots.members - spots.len(); GROUPS];",
        "let mut stay_counts = [0 * (spots.members - spots.len()); GROUPS];",
        "kernels what_leaves_stays",
    ),
    Mutant(
        "a box is positive if its bricks are empty",
        "src/medium/walk.rs",
        "is_some_and(|brick| brick.min > 0.0)",
        "is_some_and(|brick| brick.min >= 0.0)",
        "grid where_a_density_is_surely_positive",
    ),
    Mutant(
        "a sparse grid's cell is one further in its block",
        "src/medium/walk.rs",
        "map(|c| (c % side) as usize)",
        "map(|c| ((c + 1) % side) as usize)",
        "grid sparse_grids_are_the_same",
    ),
    Mutant(
        "a block's bounds are those of the block before",
        "src/medium/blocks.rs",
        "if number == block => known",
        "if number + 1 == block => known",
        "grid sparse_grids_are_the_same",
    ),
    # Tiles.
    Mutant(
        "tiles: no Jacobian",
        "src/shift/place.rs",
        "Some(value.scaled(spread / own_spread))",
        "Some(value.scaled(if spread * own_spread > 0.0 { 1.0 } else { 0.0 }))",
        "unbiased exchangeable_tile_under_a_point_light",
    ),
    Mutant(
        "tiles: the same distance instead of the same share of collisions",
        "src/shift/place.rs",
        "view.sample_distance(scene, share * probability)",
        "view.sample_distance(scene, share)",
        "tiles the_map_of_a_tile",
    ),
    Mutant(
        "tiles: rays go through the middles of pixels",
        "src/shift/tile.rs",
        "let place = DVec2::new(pixel.x - floor(pixel.x), pixel.y - floor(pixel.y));",
        "let place = DVec2::splat(0.5);",
        "unbiased exchangeable_tile_under_a_point_light",
    ),
    Mutant(
        "tiles: the lens point is that of the first path sampled",
        "src/sampler/camera_samples.rs",
        "RandomNumbers::for_path(self.seed, self.pass, number(left, top))",
        "RandomNumbers::for_path(self.seed, self.pass, pixel + 0 * number(left, top))",
        "determinism any_split_and_order",
    ),
    Mutant(
        "tiles at the border end a pixel too early",
        "src/shift/tile.rs",
        "(p - inside.min(p - first), (p + self.side.get() - inside).min(end))",
        "(p - inside.min(p - first), (p + self.side.get() - inside).min(end - 1).max(p + 1))",
        "tiles tiles_are_a_partition",
    ),
    # The path sampler.
    Mutant(
        "next-event estimation is weighted 1",
        "src/sampler/next_event.rs",
        "emission / (aim.pdf + going_on)",
        "emission / (aim.pdf + 0.0 * going_on)",
        "energy how_often",
    ),
    Mutant(
        "transmittance is missing in next-event estimation's MIS weight only",
        "src/sampler/next_event.rs",
        "survival * vertex.pdf(direction) * mean(transmittance) * geometry",
        "survival * vertex.pdf(direction) * geometry",
        "energy furnace_with_a_grid",
    ),
    Mutant(
        "transmittance is missing in emission's MIS weight only",
        "src/sampler/path_tracer.rs",
        "let going_on = sampled.pdf * probability * geometry;",
        "let going_on = sampled.pdf * geometry;",
        "energy furnace_with_a_grid",
    ),
    Mutant(
        "emission's MIS weight takes an environment map for a constant one",
        "src/sampler/path_tracer.rs",
        "Light::EnvironmentMap(_) | Light::CustomSky(_) => light.direction_pdf(-self.direction),",
        "Light::EnvironmentMap(_) | Light::CustomSky(_) => sampled.direction_pdf,",
        "energy furnace_under_an_environment_map",
    ),
    Mutant(
        "next-event estimation under a constant sky only reflects on rough glass",
        "src/sampler/next_event.rs",
        "vertex.sample(u, rest)",
        "vertex.sample(u, 0.0 * rest)",
        "energy how_often_a_light_is_picked_changes_nothing_on_rough_surfaces",
    ),
    Mutant(
        "roulette's survival is missing in next-event estimation's MIS weight",
        "src/sampler/next_event.rs",
        "survival * vertex.pdf(direction) * mean(transmittance) * geometry",
        "vertex.pdf(direction) * mean(transmittance) * geometry",
        "energy roulette",
    ),
    Mutant(
        "the phase function is turned around",
        "src/phase.rs",
        "let d = 1.0 + g * g + 2.0 * g * c;",
        "let d = 1.0 + g * g - 2.0 * g * c;",
        "single_scattering point_light_in_an_unbounded_medium",
    ),
    Mutant(
        "shifts share the path's numbers",
        "src/sampler/primary.rs",
        "const SHIFT: u64 = 1;",
        "const SHIFT: u64 = 0;",
        "unbiased exact_ball_under_a_point_light",
    ),
    # Gradients.
    Mutant(
        "runs: the transmittance inside is that of an edge with one end that moves",
        "src/path/gradient/run.rs",
        "let gradient = moments(&path.edge(scene, i)?).gradient;",
        "let line = path.edge(scene, i)?;\n"
        "            let gradient = moments(&line).far_gradient(line.direction, line.length);",
        "gradients runs",
    ),
    Mutant(
        "runs: sigma_s counts at the first vertex only",
        "src/path/gradient/run.rs",
        "for i in self.first..=self.last {",
        "for i in self.first..=self.first {",
        "gradients runs",
    ),
    Mutant(
        "gradients: the apex has the sign of the wings, as printed",
        "src/path/gradient/end.rs",
        "sum.phase_apex -= self.phase",
        "sum.phase_apex += self.phase",
        "gradients vertex",
    ),
    Mutant(
        "specular neighbours: the edge keeps its length",
        "src/path/gradient/run.rs",
        "sigma_t[c] * outwards)",
        "0.0 * sigma_t[c] * outwards)",
        "gradients specular",
    ),
    Mutant(
        "profiles: the direction's length counts",
        "src/path/gradient/neighbour.rs",
        "(by_direction - by_direction.dot(self.towards) * self.towards) / self.distance",
        "by_direction / self.distance",
        "gradients profile",
    ),
    Mutant(
        "profiles: a BSDF's gradients by its two directions are swapped",
        "src/path/gradient/end.rs",
        ".map(|(by_camera, _)| by_camera)",
        ".map(|(_, by_light)| by_light)",
        "gradients profile",
    ),
    # Estimators of transmittance, densities through callbacks.
    Mutant(
        "ratio tracking's gradient leaves no collision out",
        "src/medium/estimators/ratio_tracking.rs",
        "let before = self.transmittance;\n        self.multiply(weight);",
        "self.multiply(weight);\n        let before = self.transmittance;",
        "estimators ratio_tracking_is_unbiased",
    ),
    Mutant(
        "ratio tracking's gradient knows no faces",
        "src/medium/estimators/ratio_tracking.rs",
        "t * across(direction, self.faces.first_moment[c])",
        "0.0 * across(direction, self.faces.first_moment[c])",
        "estimators ratio_tracking_is_unbiased",
    ),
    Mutant(
        "the control density counts twice",
        "src/medium/estimators/ratio_tracking.rs",
        "(medium.density.at(x) - majorant.control)",
        "medium.density.at(x)",
        "estimators residual_ratio_tracking_is_unbiased",
    ),
    Mutant(
        "a custom density's distances have the pdf of the true density",
        "src/medium/mod.rs",
        "Self::Custom(custom) => custom.along(stretch, t),",
        "Self::Custom(custom) => custom.at(stretch.origin + t * stretch.direction),",
        "custom_medium distances_are_sampled_exactly",
    ),
    Mutant(
        "a custom density's panels depend on where the edge ends",
        "src/medium/custom.rs",
        "(f64::NEG_INFINITY, f64::INFINITY, 0, 0);",
        "(stretch.start, stretch.end, 0, 0);",
        "custom_medium tau_belongs_to_the_line",
    ),
    Mutant(
        "an exact density forgets its box's faces",
        "src/medium/exact.rs",
        "        chord.add_faces(stretch, [at(start), at(end)], &mut sum);\n",
        "        let _ = (&chord, &at);\n",
        "custom density::a_copy_has",
    ),
    Mutant(
        "an exact density's distances stop at the first guess",
        "src/medium/exact.rs",
        "(next - t).abs() <= f64::EPSILON * t.abs()",
        "(next - t).abs() <= t.abs()",
        "custom density::a_copy_has",
    ),
    # What the host computes.
    Mutant(
        "a custom BSDF's weight forgets the cosine",
        "src/scene/bsdf/custom.rs",
        "(l.z.abs() / pdf)",
        "(1.0 / pdf)",
        "custom bsdf::a_copy_renders",
    ),
    Mutant(
        "a custom BSDF's gradients stay in its own frame",
        "src/scene/bsdf/custom.rs",
        "if g.is_finite() { at.axes * g }",
        "if g.is_finite() { g }",
        "custom bsdf::gradients_need",
    ),
    Mutant(
        "a custom phase function is turned around",
        "src/phase.rs",
        "custom.eval((-c)",
        "custom.eval(c",
        "custom phase::a_copy_renders",
    ),
    Mutant(
        "a custom phase function's derivative has the sign of the other cosine",
        "src/phase.rs",
        "if slope.is_finite() { -slope }",
        "if slope.is_finite() { slope }",
        "custom phase::gradients_need",
    ),
    Mutant(
        "unknown derivatives count as 0 in batches",
        "src/shift/kernel.rs",
        "if self.mode.evaluates() { Ok(()) }",
        "if true { Ok(()) }",
        "custom phase::modes_that_need",
    ),
    Mutant(
        "unknown derivatives count as 0 in the thesis' batches",
        "src/sampler/metropolis/chain.rs",
        "Some(Batches::Thesis(_)) => self.scene.check_phase_derivatives()?,",
        "Some(Batches::Thesis(_)) => {}",
        "custom phase::chains_that_need",
    ),
    Mutant(
        "a custom sky is looked for with another density than is told",
        "src/scene/light/emission.rs",
        "Self::CustomSky(sky) => sky.pdf(to_light),",
        "Self::CustomSky(_) => 1.0 / (4.0 * PI),",
        "custom light::a_copy_of_a_map",
    ),
    Mutant(
        "a custom profile sends subpaths off alike bright",
        "src/scene/light/mod.rs",
        "profile.intensity(direction)",
        "profile.intensity(-DVec3::Y)",
        "custom light::guided_subpaths",
    ),
    # Exactness.
    Mutant(
        "numbers depend on the pixel only",
        "src/sampler/primary.rs",
        "mix(mix(seed) ^ pass)",
        "mix(mix(seed) ^ 0 * pass)",
        "energy furnace_with_a_grid",
    ),
    Mutant(
        "a shift's occlusion answer is not checked",
        "src/shift/evaluate.rs",
        "                hit.check(self.scene)?;\n",
        "",
        "determinism a_shift_checks",
    ),
    Mutant(
        "next-event estimation's occlusion answer is not checked",
        "src/sampler/next_event.rs",
        "HIT_NONE => hit.check(scene)?,",
        "HIT_NONE => {}",
        "determinism answers_that_break_the_contract",
    ),
    # The bidirectional sampler: every factor of every technique.
    Mutant(
        "bidirectional: light through glass is compressed both ways",
        "src/sampler/bidirectional/subpath.rs",
        "let weight = if self.adjoint { sample.weight * sample.eta_squared } else { sample.weight };",
        "let weight = sample.weight;",
        "bidirectional the_sun_through_glass",
    ),
    Mutant(
        "bidirectional: the reverse density is that of the walk's own direction",
        "src/sampler/bidirectional/subpath.rs",
        "vertex.scattering_density(sample.direction, back) * before",
        "vertex.scattering_density(back, sample.direction) * before",
        "bidirectional weights_through_glass",
    ),
    Mutant(
        "bidirectional: no cosine where an edge arrives",
        "src/sampler/bidirectional/vertex.rs",
        "_ => self.cosine(edge.back) * edge.spread() * mean",
        "_ => edge.spread() * mean",
        "bidirectional densities_from_each_light",
    ),
    Mutant(
        "bidirectional: no cosine where an area light emits",
        "src/sampler/bidirectional/vertex.rs",
        "normal.map_or(1.0, |n| n.dot(direction).max(0.0))",
        "normal.map_or(1.0, |_| 1.0)",
        "bidirectional techniques_under_each_light",
    ),
    Mutant(
        "bidirectional: sampled as if all distances made a collision, but not so weighted",
        "src/sampler/bidirectional/subpath.rs",
        "self.pdf * vertex.arrival(&vertex.edge) / share",
        "self.pdf * vertex.arrival(&vertex.edge)",
        "bidirectional densities_from_the_camera",
    ),
    Mutant(
        "bidirectional: paths seen from the light weighted as if the camera's first edge were left to chance",
        "src/sampler/bidirectional/connect.rs",
        "forward /= view.collision_share(scene);",
        "let _ = view.collision_share(scene);",
        "bidirectional weights_through_each_camera",
    ),
    Mutant(
        "bidirectional: the disk before the sky has the area of the sphere",
        "src/sampler/bidirectional/vertex.rs",
        "1.0 / (PI * bounds.radius * bounds.radius)",
        "0.25 / (PI * bounds.radius * bounds.radius)",
        "bidirectional under_each_light",
    ),
    Mutant(
        "bidirectional: a light that is found was picked for certain",
        "src/sampler/bidirectional/connect.rs",
        "camera: [pick * point, towards]",
        "camera: [point + 0.0 * pick, towards]",
        "bidirectional weights_under_each_light",
    ),
    Mutant(
        "bidirectional: light seen through glass is found twice",
        "src/sampler/bidirectional/connect.rs",
        "between.last().filter(|_| !between.iter().all(Vertex::is_specular))?;",
        "between.last()?;",
        "bidirectional on_each_material",
    ),
    Mutant(
        "bidirectional: the sun can be found",
        "src/sampler/bidirectional/mis.rs",
        "None => vertex.can_be_found(),",
        "None => true,",
        "bidirectional weights_under_each_light",
    ),
    Mutant(
        "bidirectional: connections to specular vertices count among the camera's",
        "src/sampler/bidirectional/mis.rs",
        "if connects(camera, i) && connects(camera, i - 1) && has(i) {",
        "if connects(camera, i) && has(i) {",
        "bidirectional weights_on_each_material",
    ),
    Mutant(
        "bidirectional: the power heuristic is the balance heuristic",
        "src/sampler/bidirectional/mis.rs",
        "Self::Power => ratio * ratio,",
        "Self::Power => ratio,",
        "bidirectional weights_in_each_medium",
    ),
    Mutant(
        "bidirectional: importance without the camera's cosine",
        "src/sampler/bidirectional/connect.rs",
        "(scene.camera.direction_density(image.ray.cosine) / (image.distance",
        "(scene.camera.direction_density(1.0) / (image.distance",
        "bidirectional weights_through_each_camera",
    ),
    Mutant(
        "bidirectional: roulette that is not made up for",
        "src/sampler/bidirectional/subpath.rs",
        "self.throughput *= weight / survival;",
        "self.throughput *= weight;",
        "bidirectional a_furnace_of_glowing_walls",
    ),
    Mutant(
        "bidirectional: at glass, probabilities in solid angle",
        "src/scene/bsdf/mod.rs",
        "probability * cosine.abs() * if cosine > 0.0 { 1.0 } else { eta * eta }",
        "probability * cosine.abs()",
        "bidirectional weights_through_glass",
    ),
    # Metropolis light transport: what of the chain, the bootstrap and the batches makes images right.
    Mutant(
        "metropolis: a flush forgets what is due",
        "src/sampler/metropolis/chain.rs",
        "self.splat(state, Change::NONE, state.pending, &mut room, film, stats)",
        "self.splat(state, Change::NONE, 0.0, &mut room, film, stats)",
        "metropolis three_mutations_without_burn_in",
    ),
    Mutant(
        "metropolis: what is due is forgotten where the chain stays",
        "src/sampler/metropolis/chain.rs",
        "state.pending = if decision.accepted { come } else { stay };",
        "state.pending = come;",
        "metropolis three_mutations_without_burn_in",
    ),
    Mutant(
        "metropolis: no share of a length among all chains",
        "src/sampler/metropolis/chain.rs",
        "path.weight * share /",
        "path.weight /",
        "metropolis three_mutations_without_burn_in",
    ),
    Mutant(
        "metropolis: the ratio of targets is upside down",
        "src/sampler/metropolis/chain.rs",
        "(target / current).min(1.0)",
        "(current / target).min(1.0)",
        "metropolis under_a_point_light",
    ),
    Mutant(
        "metropolis: all is accepted",
        "src/sampler/metropolis/chain.rs",
        "let accepted = random.next() < acceptance;",
        "let accepted = target > 0.0 && random.next() < 1.0;",
        "metropolis under_a_point_light",
    ),
    Mutant(
        "metropolis: large steps do not count as samples",
        "src/sampler/metropolis/chain.rs",
        "+ if decision.large { proposal.large } else { 0.0 }",
        "+ 0.0",
        "metropolis a_chain_that_hardly_leaves_its_start",
    ),
    Mutant(
        "metropolis: large steps have no part in a sample's density",
        "src/sampler/metropolis/chain.rs",
        "target / brightness + self.options.large_step * b / brightness",
        "target / brightness + 0.0 * b",
        "metropolis three_mutations_without_burn_in",
    ),
    Mutant(
        "metropolis: the balance heuristic takes b with the start's own value",
        "src/sampler/metropolis/chain.rs",
        "let density = |b: f64| target / brightness + self.options.large_step * b / brightness;",
        "let density = |_: f64| target / brightness + self.options.large_step;",
        "metropolis three_mutations_without_burn_in",
    ),
    Mutant(
        "metropolis: a chain's density without the technique's probability",
        "src/sampler/metropolis/chain.rs",
        "let target = target(&path) / probability;",
        "let target = target(&path);",
        "metropolis three_mutations_without_burn_in",
    ),
    Mutant(
        "metropolis: a value without the technique's probability",
        "src/sampler/metropolis/chain.rs",
        "(path.weight * share / (probability * density",
        "(path.weight * share / (density",
        "metropolis three_mutations_without_burn_in",
    ),
    Mutant(
        "metropolis: a batch every T mutations counts once",
        "src/sampler/metropolis/chain.rs",
        "== phase { every as f64 }",
        "== phase { 1.0 }",
        "metropolis any_number_of_mutations_counts_right",
    ),
    Mutant(
        "metropolis: the first mutation counts T times",
        "src/sampler/metropolis/chain.rs",
        "% every == phase",
        "% every == 0",
        "metropolis any_number_of_mutations_counts_right",
    ),
    Mutant(
        "metropolis: a stopped mutation has been counted",
        "src/sampler/metropolis/chain.rs",
        "self.splat(state, left, due, &mut room, film, stats)?;",
        "state.mutations += 1; self.splat(state, left, due, &mut room, film, stats)?; state.mutations -= 1;",
        "metropolis at_any_call",
    ),
    Mutant(
        "metropolis: the subpath that an accepted mutation made is not kept",
        "src/sampler/metropolis/room.rs",
        "self.light.traded ^= change.light;",
        "",
        "metropolis any_division_into_calls",
    ),
    Mutant(
        "metropolis: a number of the subpath that is kept changes",
        "src/sampler/metropolis/numbers.rs",
        "let middle = technique.camera_numbers();",
        "let middle = technique.camera_numbers() + 1;",
        "metropolis paths_are_those_of_their_numbers",
    ),
    Mutant(
        "metropolis: a batch of the wrong one of two paths",
        "src/sampler/metropolis/chain.rs",
        "(camera.get(change.camera).vertices(), light.get(change.light).vertices())",
        "(camera.get(false).vertices(), light.get(false).vertices())",
        "metropolis under_area_lights",
    ),
    Mutant(
        "metropolis: a direction's numbers are swapped in the inverse",
        "src/sampler/metropolis/inverse.rs",
        "writer.push(&[distance, direction.x, direction.y, lobe]);",
        "writer.push(&[distance, direction.y, direction.x, lobe]);",
        "metropolis numbers_come_back",
    ),
    Mutant(
        "metropolis: the first edge's number as if all distances made a collision",
        "src/sampler/metropolis/inverse.rs",
        "/ if i == 1 { share } else { 1.0 };",
        "/ if i == 0 { share } else { 1.0 };",
        "metropolis other_techniques_make_the_same_path",
    ),
    Mutant(
        "metropolis: the inverse forgets a light's guide",
        "src/sampler/metropolis/inverse.rs",
        "scene.lights.unguide(index, direction?)",
        "direction?",
        "metropolis numbers_come_back",
    ),
    Mutant(
        "metropolis: the inverse gives 0 and 1",
        "src/sampler/metropolis/inverse.rs",
        "number.clamp(LEAST, 1.0 - LEAST)",
        "*number",
        "metropolis numbers_stay_between_0_and_1",
    ),
    Mutant(
        "metropolis: paths without a value are not counted",
        "src/sampler/metropolis/chain.rs",
        "self.dropped += u64::from(decision.dropped);",
        "",
        "metropolis paths_without_a_value_are_counted",
    ),
    Mutant(
        "metropolis: samples without a value are not counted",
        "src/sampler/metropolis/bootstrap.rs",
        "chain_stats.dropped += u64::from(!value.is_finite());",
        "",
        "metropolis samples_and_burn_in_without_a_value_are_counted",
    ),
    Mutant(
        "metropolis: chains take any scene",
        "src/sampler/metropolis/chain.rs",
        "if same { Ok(()) }",
        "if same || true { Ok(()) }",
        "metropolis strangers",
    ),
    Mutant(
        "metropolis: brightness of all lengths instead of one",
        "src/sampler/metropolis/bootstrap.rs",
        "brightness: sum / self.samples as f64,",
        "brightness: self.brightness(),",
        "metropolis three_mutations_without_burn_in",
    ),
    Mutant(
        "metropolis: a value without the techniques' probability",
        "src/sampler/metropolis/bootstrap.rs",
        "target(&path) / techniques.probability(length, technique)",
        "target(&path)",
        "metropolis learning_does_not_bias",
    ),
    Mutant(
        "metropolis: starts evenly among the samples that are not dark",
        "src/sampler/metropolis/bootstrap.rs",
        "passed[place] += chains * f64::from(*weight) / of;",
        "passed[place] += chains * 4.0 / self.samples as f64;",
        "metropolis a_chain_that_hardly_leaves_its_start",
    ),
    Mutant(
        "metropolis: starts evenly spread from a fixed place on",
        "src/sampler/metropolis/bootstrap.rs",
        "passed.iter_mut().for_each(|passed| *passed = random());",
        "passed.iter_mut().for_each(|passed| *passed = 0.999 + 0.0 * random());",
        "metropolis a_chain_that_hardly_leaves_its_start",
    ),
    Mutant(
        "metropolis: techniques are learned from the samples that they serve",
        "src/sampler/metropolis/techniques.rs",
        "rows.flat_map(|shares| shares.0).fold(seed, |seed, share| mix(seed ^ u64::from(share.to_bits())))",
        "rows.flat_map(|shares| shares.0).fold(seed, |seed, share| mix(seed ^ u64::from(share.to_bits())) & 0 | seed)",
        "metropolis samples_are_not_those_that_were_learned_from",
    ),
    Mutant(
        "metropolis: shares follow mean squares, not their roots",
        "src/sampler/metropolis/techniques.rs",
        "sqrt(squares(length, i).max(0.0))",
        "squares(length, i).max(0.0)",
        "metropolis shares_follow_root_mean_squares",
    ),
    Mutant(
        "metropolis: no floor under a technique's share",
        "src/sampler/metropolis/techniques.rs",
        "ALL_ALIKE / count as f64 + (1.0 - ALL_ALIKE) * own",
        "own",
        "metropolis probabilities_sum_to_one_and_none_is_too_small",
    ),
    Mutant(
        "metropolis: joined: the path carries its value without its weight",
        "src/sampler/bidirectional/shiftable.rs",
        "luminance(self.connection.value) * self.connection.weight / luminance",
        "luminance(self.connection.value) / luminance",
        "metropolis it_carries_the_weight_handed_in",
    ),
    Mutant(
        "metropolis: joined: the colours of what stays are left out",
        "src/sampler/bidirectional/shiftable.rs",
        "let product = rest * self.colour(i) * edge;",
        "let product = rest * edge;",
        "metropolis it_carries_the_weight_handed_in",
    ),
    Mutant(
        "metropolis: joined: the edge of the other side",
        "src/sampler/bidirectional/shiftable.rs",
        "self.vertex(i).edge.reversed()",
        "self.vertex(i).edge",
        "metropolis it_carries_the_weight_handed_in",
    ),
    Mutant(
        "metropolis: surfaces that the kernel cannot move count every T-th time",
        "src/sampler/bidirectional/shiftable.rs",
        "self.suits(options) && self.run(options).is_some()",
        "self.run(options).is_some()",
        "metropolis surfaces_under_a_ball",
    ),
    Mutant(
        "bidirectional: bundles: surfaces that the kernel cannot move are left to chance",
        "src/sampler/bidirectional/bundle.rs",
        "joined.suits(options) && joined.first(",
        "joined.first(",
        "bidirectional a_contribution_alone",
    ),
    Mutant(
        "metropolis: joined: a run ends where the camera's subpath does",
        "src/sampler/bidirectional/shiftable.rs",
        "while in_medium(1) && length < options.run && length + 1 < last",
        "while in_medium(1) && length < options.run && length + 1 < self.camera.len()",
        "metropolis what_moves_depends_on_the_path_alone",
    ),
    Mutant(
        "metropolis: joined: runs do not end before specular surfaces",
        "src/sampler/bidirectional/shiftable.rs",
        "bsdf.is_lambertian(),\n            _ => true,",
        "!bsdf.is_specular() || bsdf.is_lambertian(),\n            _ => true,",
        "metropolis batches_are_those_of_the_path_handed_in",
    ),
    Mutant(
        "guides: directions are guided but not so weighted",
        "src/sampler/bidirectional/subpath.rs",
        "(vertex.position, direction, aim * pdf)",
        "(vertex.position, direction, pdf + 0.0 * aim)",
        "bidirectional with_guides",
    ),
    Mutant(
        "guides: places on the disk are guided but not so weighted",
        "src/sampler/bidirectional/subpath.rs",
        "(origin, -vertex.position, aim * disk_density(&scene.bounds))",
        "(origin, -vertex.position, 0.0 * aim + disk_density(&scene.bounds))",
        "bidirectional weights_of_guided_subpaths",
    ),
    Mutant(
        "guides: not in the density of a light's next vertex",
        "src/sampler/bidirectional/vertex.rs",
        "light.direction_density(normal, direction) * aim * next",
        "(light.direction_density(normal, direction) + 0.0 * aim) * next",
        "bidirectional weights_of_guided_subpaths",
    ),
    Mutant(
        "guides: learned by the numbers before the warp",
        "src/sampler/bidirectional/mod.rs",
        "let (u, _) = self.scene.lights.guide(index, pair(&first, Slot::DirectionU, Slot::DirectionV));",
        "let u = pair(&first, Slot::DirectionU, Slot::DirectionV);",
        "bidirectional only_what_leads_through_the_window",
    ),
    # The thesis' estimator: what changes in each case, and the weight of what has been moved.
    Mutant(
        "thesis: case 3 without the camera's importance",
        "src/sampler/bidirectional/thesis.rs",
        "before.geometry_gradient() + before.importance_gradient(camera) + apex_gradient",
        "before.geometry_gradient() + apex_gradient",
        "bidirectional gradients_are_those_of_finite_differences",
    ),
    Mutant(
        "thesis: case 4 without the phase function at x_1",
        "src/sampler/bidirectional/thesis.rs",
        "2 => after.geometry_gradient() + apex_gradient(x, &before, &after) + self",
        "2 => after.geometry_gradient() + self",
        "bidirectional gradients_are_those_of_finite_differences",
    ),
    Mutant(
        "thesis: case 5 is case 6",
        "src/sampler/bidirectional/thesis.rs",
        "3 => self.wing_gradient(&after),",
        "",
        "bidirectional gradients_are_those_of_finite_differences",
    ),
    Mutant(
        "thesis: transmittance of sampled edges does not cancel",
        "src/sampler/bidirectional/thesis.rs",
        "sampled - mean(self.connection.value * LUMINANCE)",
        "0.0 * sampled - mean(self.connection.value * LUMINANCE)",
        "bidirectional gradients_are_those_of_finite_differences",
    ),
    Mutant(
        "thesis: the density of x_2 is that of x",
        "src/sampler/bidirectional/thesis.rs",
        "second.density = y.density_of(scene, from_camera.back, second, onwards);",
        "",
        "bidirectional weights_are_those_of_the_moved_path",
    ),
    Mutant(
        "thesis: the density of x_3 is that of x",
        "src/sampler/bidirectional/thesis.rs",
        "third.density = second.density_of(scene, onwards.back, third, &third.edge);",
        "",
        "bidirectional weights_are_those_of_the_moved_path",
    ),
    Mutant(
        "thesis: the reverse density of x_1 is that of x",
        "src/sampler/bidirectional/thesis.rs",
        "y.reverse = second.density_of(scene, -third.edge.back, y, &onwards.reversed());",
        "",
        "bidirectional weights_are_those_of_the_moved_path",
    ),
    Mutant(
        "thesis: the reverse density of x_3 is that of x",
        "src/sampler/bidirectional/thesis.rs",
        "third.reverse = next.density_of(scene, onwards.back, third, &next.edge.reversed());",
        "",
        "bidirectional weights_are_those_of_the_moved_path",
    ),
    Mutant(
        "thesis: as if no guide had been there",
        "src/sampler/bidirectional/thesis.rs",
        "1.0 / next.guided(scene, y, onwards.back)",
        "1.0 + 0.0 * next.guided(scene, y, onwards.back)",
        "bidirectional weights_are_those_of_the_moved_path",
    ),
    Mutant(
        "thesis: y in another medium",
        "src/sampler/bidirectional/thesis.rs",
        "|| medium_at(&view, image.distance) != index",
        "",
        "bidirectional weights_are_those_of_the_moved_path",
    ),
    Mutant(
        "thesis: the MIS weight of x",
        "src/sampler/bidirectional/thesis.rs",
        "let ratio = moved.weight * moved.chance / (own.weight * own.chance);",
        "let ratio = moved.chance / own.chance;",
        "bidirectional batches_are_worth_w_f_over_p",
    ),
    Mutant(
        "thesis: the radius of a batch alone",
        "src/sampler/bidirectional/thesis.rs",
        "if self.as_printed { (index + 1) as f64 }",
        "if index < MAX_SHIFTS { (index + 1) as f64 }",
        "bidirectional batches_are_worth_w_f_over_p",
    ),
    Mutant(
        "thesis: a batch is worth its sum",
        "src/sampler/metropolis/thesis.rs",
        "value * (w / options.count as f64)",
        "value * w",
        "metropolis the_thesis_is_biased_at_a_large_radius",
    ),
    # Shifted bidirectional samples, fewer techniques, what is left to chance.
    Mutant(
        "bundle: of what goes on from x_2 only the last contribution counts",
        "src/sampler/bidirectional/bundle.rs",
        "*sum += rest;",
        "*sum = rest;",
        "bidirectional a_bundle_and_what_stays_are_the_sample",
    ),
    Mutant(
        "bundle: shifted contributions are weighted twice",
        "src/sampler/bidirectional/shiftable.rs",
        "self.scale(value * rest).map(|scale| rest * scale)",
        "self.scale(value * rest).map(|scale| rest * scale * self.connection.weight)",
        "bidirectional a_bundle_and_what_stays_are_the_sample",
    ),
    Mutant(
        "an exit's phase function is that of the path itself",
        "src/shift/run.rs",
        "*group = exit.wing.map_or(value, |(phase, to_other)| value * phase.eval(-aim.direction.dot(to_other)));",
        "*group = value;",
        "bidirectional a_contribution_alone_moves_like_its_path",
    ),
    Mutant(
        "weights count techniques with more vertices from a light than are made",
        "src/sampler/bidirectional/mis.rs",
        "if connects(camera, i) && connects(camera, i - 1) && has(i) {",
        "if connects(camera, i) && connects(camera, i - 1) {",
        "bidirectional weights_of_few_techniques",
    ),
    Mutant(
        "weights count what the camera would see of a light's subpath",
        "src/sampler/bidirectional/mis.rs",
        "technique.camera >= self.camera && technique.light <= self.light",
        "technique.light <= self.light",
        "bidirectional weights_of_few_techniques",
    ),
    Mutant(
        "connections by chance count as if they were sure",
        "src/sampler/bidirectional/connect.rs",
        "(self.number < probability).then_some(probability)",
        "(self.number < probability).then_some(1.0)",
        "bidirectional with_roulette",
    ),
    Mutant(
        "batches by chance count as if they were sure",
        "src/sampler/bidirectional/mod.rs",
        "film.add(place, colour / survival);",
        "film.add(place, colour);",
        "bidirectional shifted_in_toys",
    ),
    Mutant(
        "what stays of a sample is added before its batch, which may stop",
        "src/sampler/bidirectional/mod.rs",
        "let plain = bundle.plain;",
        "film.add(place, bundle.plain);\n            let plain = Colour::ZERO;",
        "bidirectional a_stop_leaves_whole_samples",
    ),
    Mutant(
        "a tile's point of the lens is that of the first pixel sampled here",
        "src/sampler/camera_samples.rs",
        "number(left, top)).vertex(0)",
        "number(x, y).max(number(left, top))).vertex(0)",
        "bidirectional any_division_of_a_shifted_pass_gives_the_same_bits",
    ),
    Mutant(
        "walks beyond what is left out are rarer, but do not count for more",
        "src/sampler/path_tracer.rs",
        "let weight = sample.weight / survival;",
        "let weight = sample.weight / self.survival(depth);",
        "bidirectional paths_longer_than_those_left_out",
    ),
]


def copy_repository(to: pathlib.Path) -> None:
    """What git tracks or would track."""
    root = pathlib.Path(__file__).resolve().parent.parent
    listed = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"], cwd=root, check=True, capture_output=True
    )
    for name in filter(None, listed.stdout.decode().split("\0")):
        source = root / name
        if source.is_file():
            (to / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(source, to / name)


def run(copy: pathlib.Path, test: str, build_only: bool = False) -> subprocess.CompletedProcess:
    file, name = test.split()
    command = ["cargo", "test", "--quiet", "--test", file] + (["--no-run"] if build_only else ["--", name])
    return subprocess.run(command, cwd=copy, capture_output=True, text=True)


def reason(output: str) -> str:
    """What the first failed assertion says."""
    lines = output.splitlines()
    panics = [i for i, line in enumerate(lines) if "panicked at" in line]
    return lines[panics[0] + 1] if panics and panics[0] + 1 < len(lines) else ""


def verdict(copy: pathlib.Path, mutant: Mutant) -> tuple[str, str]:
    path = copy / mutant.file
    original = path.read_text()
    if original.count(mutant.old) != 1:
        return "NOT FOUND", ""
    path.write_text(original.replace(mutant.old, mutant.new))
    try:
        build = run(copy, mutant.test, build_only=True)
        if build.returncode != 0:
            return "NO BUILD", build.stderr
        result = run(copy, mutant.test)
        return ("SURVIVES", "") if result.returncode == 0 else ("killed", reason(result.stdout))
    finally:
        path.write_text(original)


def main(wanted: list[str]) -> int:
    mutants = [m for m in MUTANTS if not wanted or any(part in m.name for part in wanted)]
    with tempfile.TemporaryDirectory(prefix="volgrad-mutants-") as directory:
        copy = pathlib.Path(directory)
        # Builds of the dependencies may be shared through CARGO_TARGET_DIR.
        os.environ.setdefault("CARGO_TARGET_DIR", str(copy / "target"))
        copy_repository(copy)
        bad = 0
        for test in sorted({m.test for m in mutants}):
            result = run(copy, test)
            if result.returncode != 0 or " 0 passed" in result.stdout:
                print(f"{test}: does not pass, or is no test\n{result.stdout}{result.stderr}")
                bad += 1
        if bad:
            return 1
        print(f"{'verdict':10} {'s':>5}  mutant (test)")
        for mutant in mutants:
            begin = time.monotonic()
            result, why = verdict(copy, mutant)
            bad += result != "killed"
            print(f"{result:10} {time.monotonic() - begin:5.1f}  {mutant.name} ({mutant.test})\n{'':18}{why}", flush=True)
        print(f"{len(mutants) - bad} of {len(mutants)} mutants killed")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
