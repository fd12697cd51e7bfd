//! Grasp quality.
