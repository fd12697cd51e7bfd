//! Search for good grasps.

/// Which candidates Algorithm 1 accepts as a replacement (paper, §3.2 and §4.2.1).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InitialMode {
    /// One primitive wrench of the new finger in the region χ suffices.
    Weak,
    /// All primitive wrenches of the new finger must lie in χ, as the paper asks.
    Strict,
}

/// Parameters of the modified genetic algorithm (paper, §3.3.2).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GeneticSettings {
    /// Individuals, 2 to 100,000.
    pub population: usize,
    /// Generations after the initial population, 0 to 100,000.
    pub generations: usize,
    /// Probability that a pair of parents is crossed, 0 to 1.
    pub crossover_probability: f64,
    /// Probability that a child is mutated, 0 to 1.
    pub mutation_probability: f64,
    /// Best individuals carried over unchanged, less than the population.
    pub elitism: usize,
}
