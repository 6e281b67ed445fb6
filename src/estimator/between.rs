//! What stands between a source and its shading points.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

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
    /// By the point's coordinates, as bits: every strategy and every count of samples comes back to it.
    known: Mutex<HashMap<[u64; 3], Known>>,
}

/// What is known of a point.
#[derive(Default)]
struct Known {
    /// That have been sent from it, or are about to be.
    rays: u64,
    outlooks: Option<Outlooks>,
}

/// What is known of a source's blockers before any ray is sent from a point: nothing, or an entry for each.
pub(super) type Outlooks = Arc<[Option<Outlook>]>;

/// Points that are remembered; about 1.2 kB each, of those that a mesh stands before.
const REMEMBERED: usize = 4096;

impl Between {
    /// - `own`: which of the sources `source` is
    /// - `normal`: of a flat source
    pub(super) fn new(surroundings: &Surroundings, own: usize, source: &Source, normal: Option<DVec3>) -> Between {
        let blockers = surroundings.before(own);
        let has_meshes = blockers.iter().any(|blocker| blocker.is_mesh());
        Between { blockers, has_meshes, hull: source.shape().hull(), normal, known: Mutex::default() }
    }

    pub(super) fn has_meshes(&self) -> bool {
        self.has_meshes
    }

    /// What is known of the blockers before any ray is sent from a point: found when so many have been sent from it that
    /// finding it will have been worth its while.
    ///
    /// - `rays`: how many are to follow
    pub(super) fn outlooks(&self, machine: Machine, from: DVec3, rays: u64) -> Outlooks {
        if !self.has_meshes {
            return Outlooks::default();
        }
        let place = from.to_array().map(f64::to_bits);
        let rays = {
            let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
            if known.len() >= REMEMBERED && !known.contains_key(&place) {
                rays
            } else {
                let known = known.entry(place).or_default();
                if let Some(outlooks) = &known.outlooks {
                    return outlooks.clone();
                }
                known.rays += rays;
                known.rays
            }
        };
        let Some(target) = Target::new(&self.hull, self.normal, from) else { return Outlooks::default() };
        let outlook = |blocker: &Arc<Blocker>| blocker.outlook(machine, from, &target, rays);
        let outlooks: Outlooks = self.blockers.iter().map(outlook).collect();
        if outlooks.iter().any(Option::is_some) {
            let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
            if let Some(known) = known.get_mut(&place) {
                known.outlooks = Some(outlooks.clone());
            }
        }
        outlooks
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
        let between = Between::new(&Surroundings::new(&room), 0, &room.sources()[0], Some(-DVec3::Z));
        let looks = |x: f64, rays| between.outlooks(Machine::Any, DVec3::X * x, rays)[0].is_some();
        assert!(!looks(0.0, 1000) && !looks(0.0, 1000));
        assert!(!looks(0.1, 1000), "another point has sent nothing yet");
        assert!(looks(0.0, 1000), "3000 rays by now");
        assert!(looks(0.0, 1), "and it is known from there on");
        let first = between.outlooks(Machine::Any, DVec3::ZERO, 1);
        assert!(Arc::ptr_eq(&first, &between.outlooks(Machine::Any, DVec3::ZERO, 1)));
        // Beyond what is remembered, each call counts for itself.
        for k in 0..REMEMBERED {
            looks(1.0 + k as f64 * 1e-4, 1);
        }
        assert!(!looks(0.5, 2000) && !looks(0.5, 2000) && looks(0.5, 3000));
        assert!(between.known.lock().unwrap().len() <= REMEMBERED);
    }
}
