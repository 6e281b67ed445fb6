//! What stands between a source and its shading points.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use glam::DVec3;

use crate::configuration::Source;
use crate::number::Machine;
use crate::scene::{Blocker, Surroundings, Target, VisibilityMap};

/// What can come between a source and its shading points.
pub(super) struct Between {
    pub(super) blockers: Vec<Arc<Blocker>>,
    has_meshes: bool,
    target: Target,
    /// By the point's coordinates, as bits: every strategy and every count of samples comes back to it.
    known: Mutex<HashMap<[u64; 3], Known>>,
}

/// What is known of a point.
struct Known {
    /// That have been sent from it, or are about to be.
    rays: u64,
    maps: VisibilityMaps,
}

/// What is known of a source's blockers before any ray is sent from a point: nothing, or an entry for each.
pub(super) type VisibilityMaps = Vec<Option<Arc<VisibilityMap>>>;

/// Points that are remembered; each takes about 1.2 kB for each mesh that stands before the source.
const REMEMBERED: usize = 4096;

impl Between {
    /// - `own`: which of the sources `source` is
    pub(super) fn new(surroundings: &Surroundings, own: usize, source: &Source) -> Between {
        let blockers = surroundings.before(own);
        let has_meshes = blockers.iter().any(|blocker| blocker.is_mesh());
        Between { blockers, has_meshes, target: Target::new(source.shape()), known: Mutex::default() }
    }

    pub(super) fn has_meshes(&self) -> bool {
        self.has_meshes
    }

    /// What is known of the blockers before any ray is sent from a point: of each mesh, once so many have been sent from it
    /// that finding out will have been worth its while.
    ///
    /// - `rays`: how many are to follow
    pub(super) fn visibilities(&self, machine: Machine, from: DVec3, rays: u64) -> VisibilityMaps {
        if !self.has_meshes {
            return VisibilityMaps::new();
        }
        let place = from.to_array().map(f64::to_bits);
        let (rays, mut maps) = {
            let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
            let nothing = || vec![None; self.blockers.len()];
            if known.len() >= REMEMBERED && !known.contains_key(&place) {
                (rays, nothing())
            } else {
                let known = known.entry(place).or_insert_with(|| Known { rays: 0, maps: nothing() });
                known.rays = known.rays.saturating_add(rays);
                (known.rays, known.maps.clone())
            }
        };
        let mut finds = false;
        for (map, blocker) in maps.iter_mut().zip(&self.blockers).filter(|(map, _)| map.is_none()) {
            *map = blocker.visibility(machine, from, &self.target, rays).map(Arc::new);
            finds |= map.is_some();
        }
        if finds && let Some(known) = self.known.lock().unwrap_or_else(PoisonError::into_inner).get_mut(&place) {
            known.maps.clone_from(&maps);
        }
        maps
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::configuration::{Arrangement, Configuration, MeasurementPoint};
    use crate::geometry::{Disk, Mesh, Shape};
    use crate::radiometry::Exitance;

    #[test]
    fn a_point_looks_when_its_rays_add_up_and_remembers() {
        let disk = Shape::Disk(Disk::new(DVec3::Z * 2.0, -DVec3::Z, 0.5).unwrap());
        let source = Source::new(disk, Exitance::new(1.0)).unwrap();
        let corners = vec![DVec3::Z, DVec3::Z + DVec3::X, DVec3::Z + DVec3::Y];
        let mesh = Shape::Mesh(Mesh::new(corners, vec![[0, 1, 2]]).unwrap());
        let point = MeasurementPoint::new(DVec3::ZERO, DVec3::Z).unwrap();
        let room = Configuration::new(vec![source], vec![mesh], None, vec![point], Arrangement::Scattered).unwrap();
        let between = Between::new(&Surroundings::new(&room), 0, &room.sources()[0]);
        let looks = |x: f64, rays| between.visibilities(Machine::Any, DVec3::X * x, rays)[0].is_some();
        assert!(!looks(0.0, 1000) && !looks(0.0, 1000));
        assert!(!looks(0.1, 1000), "another point has sent nothing yet");
        assert!(looks(0.0, 1000), "3000 rays by now");
        assert!(looks(0.0, 1), "and it is known from there on");
        let found = || between.visibilities(Machine::Any, DVec3::ZERO, 1).remove(0).unwrap();
        assert!(Arc::ptr_eq(&found(), &found()));
        // Beyond what is remembered, each call counts for itself.
        for k in 0..REMEMBERED {
            looks(1.0 + k as f64 * 1e-4, 1);
        }
        assert!(!looks(0.5, 2000) && !looks(0.5, 2000) && looks(0.5, 3000));
        assert!(between.known.lock().unwrap().len() <= REMEMBERED);
    }
}
