//! The boundary between matter and outside, where closed parts cross, touch or nest.
//!
//! Each closed part winds about the points that it encloses. The sum of all winding numbers says what a point is: 0 is
//! outside, 1 and more is matter, 2 and more is matter of two parts that overlap. The surface that counts is where the
//! sum changes from 0. The rest is buried in matter and can be touched by nothing.
//!
//! ```text
//! the parts, with trees over their triangles                              shells.rs
//! pairs of parts whose boxes meet                                         neighbours.rs
//! where triangles of such a pair meet                                     meeting.rs
//! triangles cut along that, and regions of the surface                    cut.rs, regions.rs
//! how often every part winds about both sides of every region             regions.rs, the mesh's tree.rs
//! which parts lie in others, as matter or as voids                        nesting.rs
//! of each region: the winding number on both sides, so whether it is boundary       compare.rs
//! which of the boundary is sealed off                                     reach.rs
//! ```
//!
//! **Why the volume is right:** the regions that are boundary close the surface of the union, since the winding number
//! changes nowhere else. Their flux is the volume of the union exactly, but for regions too narrow to have a point of
//! their own, and the tolerance with which triangles are cut; both are summed up to a bound.
//!
//! **Cost:** nothing when there is one part or no two boxes meet. Else a tree for each part that is involved, O(n log n),
//! and a winding number for every region and part around it. Parts so many that this takes seconds are not examined at
//! all ([`Outcome::TooMany`]).

mod compare;
mod cut;
mod meeting;
mod neighbours;
mod nesting;
mod reach;
mod regions;
mod shells;

pub(super) use compare::{Moments, Outcome, Overlap, compare};
pub(super) use neighbours::pairs;
pub(super) use nesting::Said;
pub(super) use regions::{find, join};
