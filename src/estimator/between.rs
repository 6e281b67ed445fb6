//! What stands between a source and its shading points.

use std::sync::Arc;

use glam::DVec3;

use crate::configuration::Source;
use crate::number::Machine;
use crate::scene::{Blocker, Outlook, Surroundings, Target};

/// What can come between a source and its shading points.
pub(super) struct Between {
    pub(super) blockers: Vec<Arc<Blocker>>,
    has_meshes: bool,
    /// Points whose hull holds the source, metres.
    hull: Vec<DVec3>,
    /// Of a flat source.
    normal: Option<DVec3>,
}

/// What is known of a source's blockers before any ray is sent from a point: nothing, or an entry for each.
pub(super) type Outlooks = Vec<Option<Outlook>>;

impl Between {
    /// - `own`: which of the sources `source` is
    /// - `normal`: of a flat source
    pub(super) fn new(surroundings: &Surroundings, own: usize, source: &Source, normal: Option<DVec3>) -> Between {
        let blockers = surroundings.before(own);
        let has_meshes = blockers.iter().any(|blocker| blocker.is_mesh());
        Between { blockers, has_meshes, hull: source.shape().hull(), normal }
    }

    pub(super) fn has_meshes(&self) -> bool {
        self.has_meshes
    }

    /// What is known of the blockers before any ray is sent from a point.
    ///
    /// - `rays`: how many are to follow
    pub(super) fn outlooks(&self, machine: Machine, from: DVec3, rays: u64) -> Outlooks {
        if !self.has_meshes {
            return Outlooks::new();
        }
        let Some(target) = Target::new(&self.hull, self.normal, from) else { return Outlooks::new() };
        self.blockers.iter().map(|blocker| blocker.outlook(machine, from, &target, rays)).collect()
    }
}
