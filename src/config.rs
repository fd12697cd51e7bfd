//! Every setting once: flag, environment variable, default and unit.
