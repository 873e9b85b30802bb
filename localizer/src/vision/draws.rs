//! Pseudo-random numbers that are the same in each run, for RANSAC samples and descriptor patterns: Marsaglia's 64-bit xorshift.

pub(super) struct Draws(u64);

impl Draws {
    pub(super) fn new() -> Draws {
        Draws(0x9E37_79B9_7F4A_7C15)
    }

    /// A random whole number from 0 up to, but without, `bound`.
    pub(super) fn below(&mut self, bound: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % bound as u64) as usize
    }
}
