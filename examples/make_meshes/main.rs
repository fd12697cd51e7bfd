//! Makes the meshes in `examples/meshes`, the same bytes on every run:
//!
//! ```text
//! cargo run --release --example make_meshes -- examples/meshes
//! ```
//!
//! A body is a signed distance field ([`sdf`], [`shapes`]); surface nets turn it into triangles
//! ([`surface`]), remeshing makes these alike ([`remesh`], [`fabric`]), and nothing is written ([`write`]) that
//! is not closed, connected and oriented outward ([`mesh`]).

mod fabric;
mod mesh;
mod remesh;
mod sdf;
mod shapes;
mod surface;
mod write;

use mesh::Mesh;
use shapes::{cuboid, duck, knight, rabbit};
use std::{error::Error, fs, path::PathBuf, time::Instant};

/// Largest 95th over 5th percentile of the triangles' areas that counts as homogeneous.
const EVEN: f64 = 2.0;

/// A file to make: its name, its mesh, and how it is written.
type Recipe = (
    &'static str,
    fn() -> Result<Mesh, String>,
    fn(&Mesh) -> Vec<u8>,
);

const RECIPES: [Recipe; 4] = [
    (
        "box.stl",
        || Ok(cuboid::mesh()),
        |mesh| write::stl(mesh, "graspd example: box, 1 x 0.6 x 0.4"),
    ),
    (
        "knight.stl",
        || knight::body().mesh(),
        |mesh| write::stl(mesh, "graspd example: chess knight, mm"),
    ),
    (
        "duck.obj",
        || duck::body().mesh(),
        |mesh| write::obj(mesh, "graspd example: rubber duck, mm", 3),
    ),
    (
        "rabbit.ply",
        || rabbit::body().mesh(),
        |mesh| write::ply(mesh, "graspd example: sitting rabbit, mm"),
    ),
];

fn main() -> Result<(), Box<dyn Error>> {
    let folder = PathBuf::from(
        std::env::args_os()
            .nth(1)
            .ok_or("usage: make_meshes FOLDER")?,
    );
    fs::create_dir_all(&folder)?;
    println!(
        "| file | triangles | vertices | holes | size | volume | area ratio | smallest angle |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    for (name, make, write) in RECIPES {
        let start = Instant::now();
        eprintln!("{name}: ...");
        let mesh = make().map_err(|problem| format!("{name}: {problem}"))?;
        let report = mesh
            .check()
            .map_err(|problem| format!("{name}: {problem}"))?;
        let size = report.max - report.min;
        println!(
            "| {name} | {} | {} | {} | {:.4} x {:.4} x {:.4} | {:.4} | {:.2} | {:.1}° |",
            report.triangles,
            report.vertices,
            report.genus,
            size.x,
            size.y,
            size.z,
            report.volume,
            report.area_ratio,
            report.min_angle,
        );
        if report.area_ratio > EVEN {
            return Err(format!("{name}: areas are uneven, ratio {:.2}", report.area_ratio).into());
        }
        fs::write(folder.join(name), write(&mesh))?;
        eprintln!("{name}: {:.1} s", start.elapsed().as_secs_f64());
    }
    Ok(())
}
