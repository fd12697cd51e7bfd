//! The one table of all files that the service makes of a mesh or of the result of a job.
//!
//! From a row of [`EXPORTS`] come the route, its entry in the OpenAPI document and the line in the
//! list of endpoints. A new export is a function that writes it and a row here.

use super::pose::{GripperPose, PoseError};
use super::{csv, grasp, isaac, moveit};
use crate::picture::{self, Background, GraspOptions, PictureError, Viewpoint};
use crate::wire::{Chosen, ChosenGrasp, PlanResult, Units};
use graspd_core::mesh::Mesh;
use graspd_mesh_io::MeshFormat;

/// A file that the service can make.
pub struct Export {
    /// The last segment of its address, behind the job or the mesh.
    pub name: &'static str,
    /// The name of the operation in the OpenAPI document.
    pub operation: &'static str,
    pub summary: &'static str,
    pub description: &'static str,
    /// The Content-Type.
    pub media_type: &'static str,
    /// The name to save it under, with `{id}` for the job; without one it is shown.
    pub file_name: Option<&'static str>,
    /// What a client may choose.
    pub parameters: &'static [Parameter],
    /// What it needs, and the function that writes it.
    pub writer: Writer,
}

/// A choice that a client has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Parameter {
    Grasp,
    Units,
    View,
    Legend,
    Width,
    Theme,
}

/// The choices of a client.
#[derive(Debug, Clone, Copy, Default)]
pub struct Options {
    pub grasp: Chosen,
    /// The unit of the mesh, for a job that does not say.
    pub units: Option<Units>,
    pub view: Viewpoint,
    pub legend: Option<bool>,
    pub width: Option<u32>,
    /// The background; without one an SVG follows the reader, and a PNG is light.
    pub theme: Option<Background>,
}

/// The result of a job, as exports need it.
pub struct JobSource<'a> {
    pub result: &'a PlanResult,
    /// The label of the job, or a name made of its id.
    pub title: &'a str,
    pub options: &'a Options,
}

/// A mesh, as exports need it.
pub struct MeshSource<'a> {
    pub mesh: &'a Mesh,
    /// The format of the uploaded file.
    pub format: MeshFormat,
    pub units: Option<Units>,
    /// The name of its file, or its id.
    pub title: &'a str,
    pub options: &'a Options,
}

/// What an export is made of, and how. `pixels` is how many pixels are drawn, which is what a picture
/// costs.
pub enum Writer {
    /// From a mesh.
    Mesh {
        pixels: fn(&Options) -> u64,
        write: fn(&MeshSource<'_>) -> Written,
    },
    /// From a result, in no time.
    Result(fn(&JobSource<'_>) -> Written),
    /// From a result, drawn.
    Chart {
        pixels: fn(&Options) -> u64,
        write: fn(&JobSource<'_>) -> Written,
    },
    /// From one grasp of a result, in no time.
    Grasp(fn(&JobSource<'_>, &ChosenGrasp<'_>) -> Written),
    /// From one grasp of a result and the mesh.
    Scene {
        pixels: fn(&Options) -> u64,
        write: fn(&JobSource<'_>, &ChosenGrasp<'_>, &Mesh) -> Written,
    },
}

/// The bytes of a file.
pub type Written = Result<Vec<u8>, ExportError>;

/// Why there is no file.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The grasp cannot be expressed in this format.
    #[error(transparent)]
    Pose(#[from] PoseError),
    /// A bug, or no memory.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// A bug.
    #[error(transparent)]
    Json(#[from] serde_json::Error),
}

const DRAWING: &[Parameter] = &[
    Parameter::Grasp,
    Parameter::View,
    Parameter::Legend,
    Parameter::Width,
    Parameter::Theme,
];
const POSE: &[Parameter] = &[Parameter::Grasp, Parameter::Units];
const PICTURE: &[Parameter] = &[Parameter::Width, Parameter::Theme];

const CSV: &str = "text/csv; charset=utf-8; header=present";

/// All exports, in the order in which they are listed.
pub static EXPORTS: &[Export] = &[
    Export {
        name: "grasp.png",
        operation: "draw_grasp",
        summary: "Draw a grasp",
        description: "The shaded body. Each finger is an arrow that comes from outside along the inward normal and \
            ends in its contact, with the friction cone mirrored to the outside. Also the centre of mass and the \
            weakest wrench and, below, the numbers and a legend. What the body hides is faint.",
        media_type: "image/png",
        file_name: None,
        parameters: DRAWING,
        writer: Writer::Scene {
            pixels: |options| options.drawing().pixels(),
            write: |job, grasp, mesh| {
                let options = job.options.drawing();
                Ok(picture::grasp_png(
                    mesh, job.result, grasp, job.title, &options,
                )?)
            },
        },
    },
    Export {
        name: "grasp.svg",
        operation: "draw_grasp_svg",
        summary: "Draw a grasp as SVG",
        description: "As `grasp.png`. Marks and text are vectors; the shaded body is an image inside. Without a \
            theme the colours follow the reader's preference for light or dark.",
        media_type: "image/svg+xml",
        file_name: None,
        parameters: DRAWING,
        writer: Writer::Scene {
            pixels: |options| options.drawing().pixels(),
            write: |job, grasp, mesh| {
                let options = job.options.drawing();
                let svg = picture::grasp_svg(mesh, job.result, grasp, job.title, &options)?;
                Ok(svg.into_bytes())
            },
        },
    },
    Export {
        name: "convergence.png",
        operation: "draw_convergence",
        summary: "Draw how a search converged",
        description: "Best and mean quality ε over the generations, with the first grasp and what the final \
            refinement of the contacts gained.",
        media_type: "image/png",
        file_name: None,
        parameters: PICTURE,
        writer: Writer::Chart {
            pixels: |options| picture::convergence_pixels(options.picture_width()),
            write: |job| {
                let (background, width) = (job.options.background(), job.options.picture_width());
                let png = picture::convergence_png(job.result, job.title, background, width)?;
                Ok(png)
            },
        },
    },
    Export {
        name: "convergence.svg",
        operation: "draw_convergence_svg",
        summary: "Draw how a search converged, as SVG",
        description: "As `convergence.png`. Without a theme the colours follow the reader's preference for light or \
            dark.",
        media_type: "image/svg+xml",
        file_name: None,
        parameters: &[Parameter::Theme],
        writer: Writer::Chart {
            pixels: |_| 0,
            write: |job| {
                let svg = picture::convergence_svg(job.result, job.title, job.options.background());
                Ok(svg.into_bytes())
            },
        },
    },
    Export {
        name: "grasp.glb",
        operation: "export_grasp",
        summary: "Read a grasp as GLB",
        description: "The mesh; as named nodes, for each contact an arrow that ends in it along the inward normal, \
            and its friction cone, mirrored to the outside; the centre of mass and the weakest wrench. The numbers \
            are in the `extras` of the nodes. Coordinates are in the mesh's frame and unit; the root node scales \
            them to metres where the unit is known.",
        media_type: "model/gltf-binary",
        file_name: Some("grasp-{id}.glb"),
        parameters: &[Parameter::Grasp],
        writer: Writer::Scene {
            pixels: |_| 0,
            write: |job, grasp, mesh| Ok(grasp::grasp_glb(mesh, job.result, grasp)?),
        },
    },
    Export {
        name: "grasp.csv",
        operation: "export_contacts",
        summary: "Read a grasp as a table",
        description: "A line for each contact: number, position, inward normal, triangle and barycentric \
            coordinates, the force that answers the weakest wrench, torsion, and whether the contact was fixed. In \
            the mesh's frame and unit; RFC 4180, with a header.",
        media_type: CSV,
        file_name: Some("grasp-{id}.csv"),
        parameters: &[Parameter::Grasp],
        writer: Writer::Grasp(|_, grasp| Ok(csv::contacts_csv(grasp).into_bytes())),
    },
    Export {
        name: "grasp.isaac.yaml",
        operation: "export_isaac_grasp",
        summary: "Read a grasp of two contacts for Isaac Sim",
        description: "`isaac_grasp` 1.0: the pose of a gripper with two parallel jaws in the frame of the mesh, in \
            metres. The file says what it assumes. Answered with 409 unless the grasp has two opposed contacts and \
            the unit is known.",
        media_type: "application/yaml",
        file_name: Some("grasp.isaac.yaml"),
        parameters: POSE,
        writer: Writer::Grasp(|job, grasp| {
            let pose = GripperPose::of(job.result, grasp, job.options.units)?;
            Ok(isaac::yaml(&pose).into_bytes())
        }),
    },
    Export {
        name: "grasp.moveit.json",
        operation: "export_moveit_grasp",
        summary: "Read a grasp of two contacts for MoveIt",
        description: "The message `moveit_msgs/Grasp` as JSON: the pose of a gripper with two parallel jaws in the \
            frame of the mesh, in metres. Its `_comment` says what it assumes. Answered with 409 unless the grasp \
            has two opposed contacts and the unit is known.",
        media_type: "application/json",
        file_name: Some("grasp.moveit.json"),
        parameters: POSE,
        writer: Writer::Grasp(|job, grasp| {
            let pose = GripperPose::of(job.result, grasp, job.options.units)?;
            Ok(serde_json::to_vec_pretty(&moveit::message(&pose))?)
        }),
    },
    Export {
        name: "convergence.csv",
        operation: "export_history",
        summary: "Read how a search converged, as a table",
        description: "A line for each generation, evenly chosen ones of more than 1,000: best and mean quality ε, \
            how many of the population are force closure, evaluations and seconds so far. RFC 4180, with a header.",
        media_type: CSV,
        file_name: Some("convergence-{id}.csv"),
        parameters: &[],
        writer: Writer::Result(|job| Ok(csv::history_csv(job.result).into_bytes())),
    },
    Export {
        name: "preview.png",
        operation: "preview_mesh",
        summary: "Draw a mesh",
        description: "Two opposite views, side by side, half as high as wide: from the front (−y), right and above, \
            and from the back, left and below. Border edges are red, non-manifold ones magenta, the inside of the \
            surface is bluish, and the disc in black and white quarters is the centre of mass.",
        media_type: "image/png",
        file_name: None,
        parameters: PICTURE,
        writer: Writer::Mesh {
            pixels: Options::preview_pixels,
            write: |source| {
                let options = source.options.preview(Background::Light);
                Ok(picture::preview(source.mesh, &options)?)
            },
        },
    },
    Export {
        name: "preview.svg",
        operation: "preview_mesh_report",
        summary: "Draw a mesh with its report",
        description: "The picture of `preview.png` above the figures of the report, as SVG. Without a theme the \
            colours follow the reader's preference for light or dark.",
        media_type: "image/svg+xml",
        file_name: None,
        parameters: PICTURE,
        writer: Writer::Mesh {
            pixels: Options::preview_pixels,
            write: |source| {
                let options = source.options.preview(Background::Transparent);
                let MeshSource {
                    mesh,
                    format,
                    units,
                    title,
                    ..
                } = source;
                Ok(picture::sheet(mesh, *format, *units, title, &options)?.into_bytes())
            },
        },
    },
];

impl Export {
    /// Returns the address as a pattern of the router.
    pub fn path(&self) -> String {
        let resource = match self.writer {
            Writer::Mesh { .. } => "meshes",
            _ => "jobs",
        };
        format!("/{resource}/{{id}}/{}", self.name)
    }

    /// Returns the type and subtype of the Content-Type.
    pub fn essence(&self) -> &'static str {
        self.media_type.split(';').next().unwrap_or_default()
    }

    /// Returns what distinguishes the file under `options` from the same export under others, for an
    /// entity tag.
    pub fn variant(&self, options: &Options) -> String {
        let choice = |parameter: &Parameter| match parameter {
            Parameter::Grasp => options.grasp.name(),
            Parameter::Units => options.units.map_or("", Units::name).to_owned(),
            Parameter::View => format!("{:?}", options.view),
            Parameter::Legend => format!("{:?}", options.legend),
            Parameter::Width => options.picture_width().to_string(),
            Parameter::Theme => format!("{:?}", options.theme),
        };
        let choices = self
            .parameters
            .iter()
            .map(|parameter| format!("-{}", choice(parameter)));
        // A list of entity tags is separated by commas.
        let choices = choices.collect::<String>().replace([' ', ','], "");
        format!("{}{choices}", self.name)
    }
}

impl Options {
    /// How a picture of a grasp is to be.
    fn drawing(&self) -> GraspOptions {
        GraspOptions {
            width: self.picture_width(),
            background: self.background(),
            view: self.view,
            legend: self.legend.unwrap_or(true),
        }
    }

    /// How a picture of a mesh is to be.
    fn preview(&self, background: Background) -> picture::Options {
        picture::Options {
            width: self.picture_width(),
            background: self.theme.unwrap_or(background),
        }
    }

    fn preview_pixels(&self) -> u64 {
        let width = u64::from(self.picture_width());
        width * width / 2
    }

    fn picture_width(&self) -> u32 {
        self.width.unwrap_or(picture::DEFAULT_WIDTH)
    }

    fn background(&self) -> Background {
        self.theme.unwrap_or(Background::Transparent)
    }
}
