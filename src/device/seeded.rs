//! Seeded random numbers. They are drawn on the host and loaded: burn-flex keeps one generator for
//! the whole process, so that two jobs at once would disturb each other.

use burn::tensor::TensorData;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// A generator for one purpose: the same numbers for the same seed and stream on every machine.
#[derive(Debug, Clone)]
pub struct Seeded(ChaCha8Rng);

impl Seeded {
    /// The generator of `stream` under `seed`. Streams are independent of each other.
    pub fn new(seed: u64, stream: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(stream);
        Self(rng)
    }

    /// Uniform in [0, 1), 24 bits.
    pub fn unit(&mut self) -> f32 {
        (self.0.next_u32() >> 8) as f32 / (1 << 24) as f32
    }

    /// Uniform in [0, 1), 53 bits.
    pub fn unit_f64(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Uniform in [−bound, bound).
    pub fn symmetric(&mut self, bound: f32) -> f32 {
        (2.0 * self.unit() - 1.0) * bound
    }
}

/// Values uniform in [−bound, bound), in order, as data for a tensor of that shape.
pub fn uniform<const D: usize>(rng: &mut Seeded, shape: [usize; D], bound: f32) -> TensorData {
    let values: Vec<f32> = (0..shape.iter().product()).map(|_| rng.symmetric(bound)).collect();
    TensorData::new(values, shape)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn same_seed_and_stream_same_numbers() {
        let draw = |seed, stream| {
            let mut rng = Seeded::new(seed, stream);
            (0..100).map(|_| rng.unit()).collect::<Vec<_>>()
        };
        assert_eq!(draw(1, 2), draw(1, 2));
        assert_ne!(draw(1, 2), draw(1, 3));
        assert_ne!(draw(1, 2), draw(2, 2));
        let mean = draw(7, 7).iter().sum::<f32>() / 100.0;
        assert!((mean - 0.5).abs() < 0.15, "{mean}");
    }

    #[test]
    fn uniform_values_stay_within_their_bound() {
        let data = uniform(&mut Seeded::new(3, 0), [5, 7], 0.25);
        let values = data.as_slice::<f32>().unwrap();
        assert_eq!(values.len(), 35);
        assert!(values.iter().all(|v| v.abs() <= 0.25));
        assert!(values.iter().any(|v| v.abs() > 0.1));
    }
}
