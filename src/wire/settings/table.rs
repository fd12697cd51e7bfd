//! The settings of a planning request, each defined once.
//!
//! To add one: define it here, give the type it is read into ([`PlanRequest`](crate::wire::PlanRequest), or the
//! type of the object that it is a member of) a field of its name, and use that. Then run
//! `cargo run -- reference`, which writes the reference and what the page knows.

use graspd_core::plan::{ContactKind, Method};
use graspd_core::search::InitialMode;
use graspd_core::wrench::{EdgeNorm, WrenchSpace};
use graspd_mesh_io::MeshFormat;

use super::definition::{
    DIRECTION, Kind, List, MAX_CONTACTS, MAX_COORDINATE, MESH_UNIT, POINT, Scope, Setting, WRENCH,
    above, choice, from, name_or, whole,
};
use super::objects::{CANDIDATE_KINDS, CANDIDATES, CONSTRAINTS, INDEPENDENT_REGIONS, ROBUSTNESS};
use super::rules::{by_method, contact_model_default, contacts_default, with_friction};
use crate::wire::{CandidateKind, MAX_URL_BYTES, Priority, TorqueScaleSchema, Units};

/// Every setting of a planning request, in the order of the help and the reference.
pub const SETTINGS: &[Setting] = &[
    Setting::new(
        "contacts",
        whole(1, MAX_CONTACTS as u64),
        "Number of contacts, fixed ones included.",
    )
    .default_from("4 with friction, 7 without", contacts_default)
    .example("4")
    .scope(Scope::Search),
    Setting::new(
        "contact_model",
        choice::<ContactKind>(&[
            ("hard", "Hard fingertip with friction"),
            ("soft", "Soft fingertip: also resists turning about its normal"),
            ("frictionless", "No friction, as a locator of a fixture"),
        ]),
        "How a finger touches the body.",
    )
    .default_from("hard, or frictionless when friction is 0", contact_model_default)
    .scope(Scope::Quality),
    Setting::new(
        "friction",
        from(0.0, graspd_core::contact::Friction::MAX),
        "Coulomb's coefficient of friction. The same for all contacts; 0 asks for frictionless contacts, and an \
         effective request without friction does not have it.",
    )
    .default_if("0.5", |read| with_friction(read, 0.5))
    .example("0.5")
    .scope(Scope::Quality),
    Setting::new(
        "cone_edges",
        Kind::Whole { min: 3, max: 32, or_zero: true },
        "Edges of the pyramid that replaces the friction cone. 0 keeps the round cone itself; absent when \
         frictionless.",
    )
    .default_if("8", |read| with_friction(read, 8))
    .example("8")
    .scope(Scope::Quality),
    Setting::new(
        "torsional_friction",
        above(0.0, MAX_COORDINATE),
        "Torsional friction of a soft finger, the greatest torque about the normal over the normal force. Only \
         soft contacts have it.",
    )
    .unit(MESH_UNIT)
    .absent("a twentieth of the greatest distance of a vertex from the centre of mass")
    .example("0.01")
    .scope(Scope::Quality),
    Setting::new(
        "edge_norm",
        choice::<EdgeNorm>(&[
            ("unit_edge", "The edge itself is a unit vector, as in the paper"),
            ("unit_normal", "Its component along the normal is one, as in GraspIt! and Dex-Net"),
        ]),
        "How long the edges of the friction cone are. It only changes the scale of the quality.",
    )
    .default("\"unit_edge\"")
    .scope(Scope::Quality),
    Setting::new(
        "wrench_space",
        choice::<WrenchSpace>(&[
            ("l1", "The forces of all fingers sum to one"),
            ("linf", "The force of each finger is at most one"),
        ]),
        "How the wrenches of the contacts add up.",
    )
    .default("\"l1\"")
    .scope(Scope::Quality),
    Setting::new(
        "torque_scale",
        name_or::<TorqueScaleSchema>(
            &[
                ("max_radius", "One over the greatest distance of a vertex from the centre of mass"),
                ("none", "Torques as they are"),
            ],
            &from(1e-9, 1e9),
        ),
        "The factor (1/length) that makes torques comparable with forces.",
    )
    .default("\"max_radius\"")
    .scope(Scope::Quality),
    Setting::new(
        "center_of_mass",
        POINT,
        "The point that torques are taken about, in the mesh's frame.",
    )
    .unit(MESH_UNIT)
    .absent("the mesh's own centre of mass")
    .example("[0.0, 0.0, 0.0]")
    .scope(Scope::Quality),
    Setting::new(
        "units",
        choice::<Units>(UNITS),
        "The unit of the mesh's coordinates. It is echoed and used to doubt sizes, never to rescale.",
    )
    .absent("that of the mesh, where its upload named one")
    .scope(Scope::Quality),
    Setting::new(
        "component",
        Kind::Component,
        "Which of the bodies in the mesh is grasped. The report of the mesh lists them. The others are left out: the \
         centre of mass, radius and candidates are its own. `all` takes them all as one rigid body.",
    )
    .absent("the body, of which there must be one")
    .example("0")
    .scope(Scope::Quality),
    Setting::new(
        "enclosed",
        Kind::Boolean,
        "Whether contacts may be where no finger gets: in sealed cavities, and on walls that are buried between \
         solids.",
    )
    .absent("false")
    .example("true")
    .scope(Scope::Quality),
    Setting::new(
        "candidates",
        name_or::<CandidateKind>(CANDIDATE_KINDS, &Kind::Object(CANDIDATES)),
        "The places that are searched. The result says which in `candidates_from`.",
    )
    .absent(
        "triangles, but uniform for memetic where the triangles are fewer than 1000 or their areas vary by more \
         than a factor of 4 (95th over 5th percentile)",
    )
    .scope(Scope::Search),
    Setting::new(
        "constraints",
        Kind::Object(CONSTRAINTS),
        "Where contacts may be, how far apart they are, how fingers approach, and contacts that are given.",
    )
    .absent("contacts anywhere")
    .scope(Scope::Search),
    Setting::new(
        "method",
        choice::<Method>(&[
            ("memetic", "Memetic: the best known, with a proof that no single finger does better"),
            ("modified_ga", "Genetic algorithm of the paper"),
            ("local", "Local search: one finger after the other"),
            ("random", "Random grasps, to compare with"),
        ]),
        "Which search looks for the best grasp.",
    )
    .default("\"memetic\"")
    .scope(Scope::Search),
    Setting::new(
        "population",
        whole(2, 100_000),
        "Individuals per generation. For `memetic`, grasps that climb side by side.",
    )
    .default_from("8 for memetic, else 200", |read| by_method(read, 8, 200))
    .example("200")
    .scope(Scope::Search),
    Setting::new(
        "generations",
        whole(0, 100_000),
        "Generations after the first population. With `memetic`, each individual reaches an optimum once a \
         generation. The population times (generations + 1) may be at most 1,000,000,000.",
    )
    .default_from("25 for memetic, else 100", |read| by_method(read, 25, 100))
    .example("100")
    .scope(Scope::Search),
    Setting::new(
        "crossover_probability",
        from(0.0, 1.0),
        "Probability that two parents are crossed.",
    )
    .default_from("0.7 for memetic, else 0.9", |read| by_method(read, 0.7, 0.9))
    .example("0.9")
    .scope(Scope::Search),
    Setting::new(
        "mutation_probability",
        from(0.0, 1.0),
        "Probability that a child is mutated.",
    )
    .default("0.2")
    .example("0.2")
    .scope(Scope::Search),
    Setting::new(
        "elitism",
        whole(0, 99_999),
        "Best individuals carried over unchanged, fewer than the population. Only `modified_ga` uses it.",
    )
    .default("1")
    .example("1")
    .scope(Scope::Search),
    Setting::new(
        "initial",
        choice::<InitialMode>(&[
            ("strict", "All primitive wrenches of the new finger must lie in the region"),
            ("weak", "One primitive wrench of the new finger in the region suffices"),
        ]),
        "Which candidates may complete the first force-closure grasp. `random` starts from no grasp.",
    )
    .default_from("weak for memetic, else strict, as in the paper", |read| {
        by_method(read, "weak", "strict")
    })
    .scope(Scope::Search),
    Setting::new(
        "polish",
        Kind::Boolean,
        "Whether the contacts of the best grasp slide over the surface to where the quality is greater still. \
         They slide within triangles and across edges; otherwise contacts are centroids, as in the paper.",
    )
    .default_from("true for memetic, else false", |read| by_method(read, true, false))
    .scope(Scope::Search),
    Setting::new(
        "time_limit_s",
        above(0.0, 3600.0),
        "Stop searching after this time. The analyses of the grasp may take as long again.",
    )
    .unit("seconds")
    .absent("only the server's own limit")
    .example("60.0")
    .scope(Scope::Search),
    Setting::new(
        "evaluation_limit",
        whole(1, 1_000_000_000),
        "Stop after this many quality evaluations.",
    )
    .absent("no limit")
    .example("1000000")
    .scope(Scope::Search),
    Setting::new(
        "target_quality",
        above(0.0, f64::INFINITY),
        "Stop once this quality is reached.",
    )
    .absent("never")
    .example("0.2")
    .scope(Scope::Search),
    Setting::new(
        "robustness",
        Kind::Object(ROBUSTNESS),
        "Compute how robust the grasp is against fingers that miss their places.",
    )
    .absent("not computed")
    .scope(Scope::Analysis),
    Setting::new(
        "independent_regions",
        Kind::Object(INDEPENDENT_REGIONS),
        "Compute where each finger may be while the others stay.",
    )
    .absent("not computed")
    .scope(Scope::Analysis),
    Setting::new(
        "task_wrenches",
        Kind::List(List { of: &WRENCH, min: 1, max: 256, what: "wrenches" }),
        "Compute the quality against these disturbances. Each is a force and a torque about the centre of mass, \
         in the mesh's frame, in any unit of force and that times the mesh's unit of length. Only their \
         directions matter, once torques are scaled.",
    )
    .absent("none")
    .example("[[0.0, 0.0, -1.0, 0.0, 0.0, 0.0]]")
    .scope(Scope::Analysis),
    Setting::new(
        "gravity",
        DIRECTION,
        "Compute the quality against a force in this direction at the centre of mass.",
    )
    .absent("not computed")
    .example("[0.0, 0.0, -1.0]")
    .scope(Scope::Analysis),
    Setting::new(
        "seed",
        whole(0, u64::MAX),
        "Fixes every random choice. The same mesh, request and seed give the same result.",
    )
    .default_from("a random number below 2^53", |_| None)
    .example("7")
    .scope(Scope::Search),
    Setting::new(
        "trials",
        whole(1, 1000),
        "Repeat the run with the seeds seed, seed + 1, ... and add statistics over them to the best result.",
    )
    .default("1")
    .example("1")
    .scope(Scope::Search),
    Setting::new(
        "top",
        whole(1, 100),
        "How many distinct grasps to return, the best included. There may be fewer.",
    )
    .default("1")
    .example("1")
    .scope(Scope::Search),
    LABEL,
    Setting::new(
        "priority",
        choice::<Priority>(&[
            ("interactive", "Someone waits for it"),
            ("batch", "One of many that nobody waits for"),
        ]),
        "Whether the job goes before others in the queue.",
    )
    .default("\"interactive\"")
    .scope(Scope::Job),
    Setting::new(
        "callback_url",
        Kind::Url { max_bytes: MAX_URL_BYTES },
        "Where the server posts a signed message once the job has ended. It is an https URL on a host that the \
         operator of the server allows.",
    )
    .absent("nowhere")
    .example("\"https://hooks.example.com/grasps\"")
    .scope(Scope::Job),
];

/// The label of a job or a batch.
pub const LABEL: Setting = Setting::new(
    "label",
    Kind::Text { max_chars: 200 },
    "A name by which people recognise the job, up to 200 characters.",
)
.example("\"duck, four fingers\"")
.scope(Scope::Search);

/// How a mesh file is read; sent beside the settings, and no part of them.
pub const FILE_SETTINGS: &[Setting] = &[
    Setting::new(
        "format",
        choice::<MeshFormat>(&[
            ("stl", "STL"),
            ("obj", "Wavefront OBJ"),
            ("ply", "PLY"),
            ("off", "OFF"),
            ("glb", "glTF, binary"),
            ("gltf", "glTF"),
            ("3mf", "3MF"),
            ("dae", "COLLADA"),
        ]),
        "Format of the file.",
    )
    .absent("recognised by its content"),
    Setting::new(
        "scale",
        from(1e-9, 1e9),
        "The factor that the coordinates of the file are multiplied by.",
    )
    .default("1"),
];

const UNITS: &[(&str, &str)] = &[
    ("m", "Metres"),
    ("cm", "Centimetres"),
    ("mm", "Millimetres"),
    ("um", "Micrometres"),
    ("in", "Inches"),
    ("ft", "Feet"),
];
