//! Which parts lie wholly in others, and whether they bound matter or a void there.
//!
//! Every part comes wound outward. One that lies in no other is matter. For a part within others the file decides: if it
//! is wound there as the outermost part around it is, it is matter within matter, such as a core that was modelled as a
//! solid of its own; if it is wound the other way, it is the wall of a cavity. A part whose triangles disagree among
//! each other says nothing. Then depth decides, as for a surface whose winding is unknown: within an odd number of
//! parts it is the wall of a cavity, within an even number a body in the cavity.

use super::regions::Region;

/// Share of the area of a part that must be inside another for the part to lie wholly in it. What is missing is
/// rounding where surfaces touch.
const WHOLLY: f64 = 0.999;

/// What the file says about a closed part.
#[derive(Debug, Clone, Copy)]
pub(in crate::mesh) struct Said {
    /// Whether the file has most of its triangles wound outward.
    pub(in crate::mesh) outward: bool,
    /// Whether its triangles agree.
    pub(in crate::mesh) agreed: bool,
    pub(in crate::mesh) volume: f64,
}

/// For each part the parts that it lies wholly in, in ascending order.
pub(super) fn containers(regions: &[Region], said: &[Said]) -> Vec<Vec<u32>> {
    let mut areas = vec![0.0; said.len()];
    let mut inside: Vec<Vec<(u32, f64)>> = vec![Vec::new(); said.len()];
    for region in regions {
        areas[region.part as usize] += region.area;
        let inner = &mut inside[region.part as usize];
        for around in region.around.iter().filter(|around| around.below >= 1) {
            match inner.iter_mut().find(|(part, _)| *part == around.part) {
                Some((_, area)) => *area += region.area,
                None => inner.push((around.part, region.area)),
            }
        }
    }
    let contained = inside.into_iter().enumerate().map(|(n, inner)| {
        // Of two parts that fill the same space neither lies in the other.
        let larger = |part: u32| said[part as usize].volume > said[n].volume;
        let wholly = |area: f64| area >= WHOLLY * areas[n];
        let found = inner
            .into_iter()
            .filter(|&(part, area)| wholly(area) && larger(part));
        let mut found: Vec<u32> = found.map(|(part, _)| part).collect();
        found.sort_unstable();
        found
    });
    contained.collect()
}

/// For each part whether it bounds a void.
pub(super) fn voids(containers: &[Vec<u32>], said: &[Said]) -> Vec<bool> {
    let of = |part: u32| &said[part as usize];
    let is_void = |n: usize| {
        let volume = |part: &&u32| of(**part).volume;
        let outermost = containers[n]
            .iter()
            .max_by(|a, b| volume(a).total_cmp(&volume(b)).then(b.cmp(a)));
        outermost.is_some_and(|&outermost| match of(outermost).agreed && said[n].agreed {
            true => of(outermost).outward != said[n].outward,
            false => containers[n].len() % 2 == 1,
        })
    };
    (0..said.len()).map(is_void).collect()
}
