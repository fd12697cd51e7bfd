//! What a planning request means where it says nothing.

use super::request::{InitialMode, Method};

/// What a method does unless it is told otherwise.
pub(super) struct SearchDefaults {
    pub population: u64,
    pub generations: u64,
    pub crossover: f64,
    pub mutation: f64,
    pub initial: InitialMode,
    pub polish: bool,
}

impl SearchDefaults {
    pub fn of(method: Method) -> Self {
        match method {
            Method::Memetic => Self {
                population: 8,
                generations: 25,
                crossover: 0.7,
                mutation: 0.2,
                initial: InitialMode::Weak,
                polish: true,
            },
            Method::ModifiedGa | Method::Local | Method::Random => Self {
                population: 200,
                generations: 100,
                crossover: 0.9,
                mutation: 0.2,
                initial: InitialMode::Strict,
                polish: false,
            },
        }
    }
}
