//! Code that several test programs and benchmarks share.
//!
//! | module | what is there |
//! |---|---|
//! | `stl` | mesh files of simple solids |
//! | `cases`, `grasps` | grasps on the example meshes, to measure and to check with |
//! | `process`, `events` | the program `graspd`, and its stream of events as a client reads it |
//! | `postgres`, `proxy` | a private PostgreSQL server, and a proxy that fails on demand |
//! | `load` | many clients at once, and checks of what a service promised them |
//! | `environment`, `install` | settings of the tests, and programs that they need |

pub mod cases;
pub mod environment;
pub mod events;
pub mod grasps;
pub mod install;
pub mod load;
pub mod postgres;
pub mod process;
pub mod proxy;
pub mod stl;
