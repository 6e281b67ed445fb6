//! A key's numbers for everything that `rand` can draw.

use std::convert::Infallible;

use rand::TryRng;

use super::lanes::{Lanes, step};
use super::seed::StreamKey;

/// The first lane of a key, as a generator for everything that `rand` can draw.
#[derive(Clone, Debug)]
pub struct Stream([u64; 4]);

impl Stream {
    pub fn new(key: StreamKey) -> Stream {
        Stream(Lanes::first(key))
    }
}

impl TryRng for Stream {
    type Error = Infallible;

    fn try_next_u32(&mut self) -> Result<u32, Infallible> {
        self.try_next_u64().map(|word| (word >> 32) as u32)
    }

    fn try_next_u64(&mut self) -> Result<u64, Infallible> {
        let (word, next) = step(self.0);
        self.0 = next;
        Ok(word)
    }

    fn try_fill_bytes(&mut self, bytes: &mut [u8]) -> Result<(), Infallible> {
        for chunk in bytes.chunks_mut(8) {
            chunk.copy_from_slice(&self.try_next_u64()?.to_le_bytes()[..chunk.len()]);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::LANES;
    use rand::Rng;

    #[test]
    fn the_stream_is_the_first_lane() {
        let key = StreamKey::root(1).with(2);
        let (mut stream, mut lanes) = (Stream::new(key), Lanes::new(key, LANES));
        for _ in 0..100 {
            assert_eq!(stream.next_u64(), lanes.next_words()[0]);
        }
    }
}
