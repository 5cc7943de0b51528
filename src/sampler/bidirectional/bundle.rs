//! What can be shifted of a bidirectional sample: its camera subpath's first vertex moves, and all that goes on from there reconnects to it.
//!
//! A path must move alike whichever technique made it, and x_2 may be the last vertex of a light's subpath: so it is x_1 alone that moves,
//! never a longer run. Connections from x_1 itself are exits, all others share the link to the camera subpath's x_2.

use super::shiftable::{Asker, Joined};
use super::vertex::Kind;
use crate::math::Colour;
use crate::scene::{Queries, Stop};
use crate::shift::{self, Exit, MAX_WINGS, Onwards, Shiftable};

/// Most vertices of a light's subpath: each gives the camera subpath's x_2 a direction of its own to scatter in, beside that in which it
/// goes on.
pub const MOST_LIGHT_VERTICES: usize = MAX_WINGS - 1;

#[derive(Default)]
pub struct Bundle {
    /// Sum of the contributions that stay at the sample's pixel.
    pub plain: Colour,
    path: Option<Shiftable>,
    /// Whether x_1 may move; unknown before the first contribution.
    moves: Option<bool>,
    /// Which wing of the link to x_2 is that in which the camera's subpath goes on.
    camera_wing: Option<usize>,
}

impl Bundle {
    /// For the next sample. (What is large stays where it is.)
    pub fn clear(&mut self) {
        (self.plain, self.moves, self.camera_wing) = (Colour::ZERO, None, None);
        if let Some(path) = &mut self.path {
            path.clear();
        }
    }

    /// Adds what one technique made of the sample.
    pub fn add<Q: Queries>(&mut self, joined: &Joined, queries: &Q, options: &shift::Options) -> Result<(), Stop> {
        let asker = Asker { path: joined, queries, derivatives: options.mode.has_derivatives() };
        let moves = match self.moves {
            Some(moves) => moves,
            None => *self.moves.insert(joined.suits(options) && joined.first(&asker, &mut self.path)?),
        };
        if !(moves && (self.reconnect(joined, &asker)? || options.mode.has_queries() && self.follow(joined))) {
            self.plain += joined.connection.value * joined.connection.weight;
        }
        Ok(())
    }

    /// What can be shifted, if there is anything.
    pub fn finish(&mut self) -> Option<&Shiftable> {
        self.moves.filter(|moves| *moves)?;
        let path = self.path.as_mut()?;
        path.drop_what_carries_nothing().then_some(&*path)
    }

    /// A contribution that goes from x_1 to an x_2 that links may end at. False: it is none.
    fn reconnect<Q: Queries>(&mut self, joined: &Joined, asker: &Asker<Q>) -> Result<bool, Stop> {
        let Some(path) = self.path.as_mut().filter(|_| joined.connects(2)) else { return Ok(false) };
        let shared = joined.camera.len() > 2;
        let (link, phase) = match &path.onwards {
            Some(onwards) if shared => (onwards.link, onwards.phase),
            _ => joined.link(1, asker)?,
        };
        let scatters = joined.last() > 2 && matches!(joined.vertex(2).kind, Kind::Medium { .. });
        let wing = scatters.then(|| (phase, -joined.edge(2).back));
        let exit = Exit { from: 0, link, wing, rest: Colour::ONE };
        let Some(rest) = joined.rest_of(2, path.value_of(joined.scene, &exit)) else { return Ok(false) };
        if !shared {
            return Ok(path.leave(Exit { rest, ..exit }));
        }
        let onwards = path.onwards.get_or_insert(Onwards::new(link, 0, phase));
        match wing {
            None => onwards.plain += rest,
            Some((_, to_other)) if joined.camera.len() == 3 => onwards.add_wing(to_other, rest),
            Some((_, to_other)) => {
                let wing = *self.camera_wing.get_or_insert(onwards.wing_count);
                if wing == onwards.wing_count {
                    onwards.add_wing(to_other, Colour::ZERO);
                }
                if let Some((_, sum)) = onwards.wings.get_mut(wing) {
                    *sum += rest;
                }
            }
        }
        Ok(true)
    }

    /// A contribution that goes from x_1 to a light through specular surfaces alone. False: it is none.
    fn follow(&mut self, joined: &Joined) -> bool {
        let Some(path) = self.path.as_mut().filter(|path| joined.is_chain(2) && path.chain.is_none()) else { return false };
        let Some(mut chain) = joined.chain(1) else { return false };
        let Some(scale) = joined.scale(path.value_of_chain(joined.scene, &chain)) else { return false };
        chain.rest = Colour::splat(scale);
        path.chain = Some(chain);
        true
    }
}
