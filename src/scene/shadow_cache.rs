//! The occluder that blocked last is tried first.

use crate::sampling::BLOCK;

/// Which part of a mesh blocked each ray of a block last: the rays of the next block ask it first.
///
/// Worth its while where the next block's rays end where these did (shading points share their points on the source, or have
/// one in each stratum) and the mesh is coarse beside the distance from point to point. It counts how often it helps, and
/// while it helps too seldom it is asked only now and then. It is a hint and no more: what it names is tested like everything
/// else, so that it changes no answer, of whatever block, mesh or run it is left over.
///
/// - source: E. Haines, D. Greenberg, *The light buffer: a shadow-testing accelerator*, IEEE Computer Graphics and
///   Applications 6(9), 1986
#[derive(Clone, Debug)]
#[cfg_attr(all(not(feature = "fast"), not(test)), expect(dead_code, reason = "meshes that are halved ask none"))]
pub struct ShadowCache {
    pub(super) parts: [u32; BLOCK],
    asked: u32,
    helped: u32,
    /// Blocks since it was found to help too seldom.
    passed_by: u32,
}

#[cfg_attr(all(not(feature = "fast"), not(test)), expect(dead_code, reason = "meshes that are halved ask none"))]
impl ShadowCache {
    /// No part of any mesh.
    pub(super) const NOTHING: u32 = u32::MAX;
    /// Rays before which nothing is said of how often it helps, and beyond which the past counts half.
    const FEW: u32 = 1024;
    const MANY: u32 = 16 * ShadowCache::FEW;
    /// Asking a part costs about a seventh of a ray's way through the hierarchy.
    const WORTH: u32 = 7;
    /// Blocks after which it is given another chance.
    const PATIENCE: u32 = 255;

    /// Whether the next block is to ask it.
    pub(super) fn is_asked(&mut self) -> bool {
        if self.asked < ShadowCache::FEW || self.helped * ShadowCache::WORTH >= self.asked {
            return true;
        }
        self.passed_by += 1;
        if self.passed_by > ShadowCache::PATIENCE {
            (self.asked, self.helped, self.passed_by) = (0, 0, 0);
        }
        false
    }

    pub(super) fn count(&mut self, asked: u32, helped: u32) {
        (self.asked, self.helped) = (self.asked + asked, self.helped + helped);
        if self.asked > ShadowCache::MANY {
            (self.asked, self.helped) = (self.asked / 2, self.helped / 2);
        }
    }
}

impl Default for ShadowCache {
    fn default() -> ShadowCache {
        ShadowCache { parts: [ShadowCache::NOTHING; BLOCK], asked: 0, helped: 0, passed_by: 0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    impl ShadowCache {
        /// Left over from elsewhere.
        pub fn holding(parts: [u32; BLOCK]) -> ShadowCache {
            ShadowCache { parts, ..ShadowCache::default() }
        }
    }

    /// How many of many blocks ask a cache that helps with so many rays of each.
    fn asked(helped: u32) -> u32 {
        let mut cache = ShadowCache::default();
        let mut asked = 0;
        for _ in 0..10_000 {
            if cache.is_asked() {
                cache.count(BLOCK as u32, helped);
                asked += 1;
            }
        }
        asked
    }

    #[test]
    fn what_helps_is_asked_always_and_what_does_not_now_and_then() {
        assert_eq!(asked(BLOCK as u32), 10_000);
        assert_eq!(asked(BLOCK as u32 / 7 + 1), 10_000);
        let seldom = asked(BLOCK as u32 / 7 - 1);
        assert!((100..1000).contains(&seldom), "{seldom}");
        assert_eq!(asked(0), seldom);
    }

    #[test]
    fn what_comes_to_help_is_asked_again() {
        let mut cache = ShadowCache::default();
        let mut since = 0;
        for block in 0..4_000 {
            if cache.is_asked() {
                cache.count(BLOCK as u32, if block < 2_000 { 0 } else { BLOCK as u32 });
                since += u32::from(block >= 2_000);
            }
        }
        assert!(since > 1_500, "{since}");
    }
}
