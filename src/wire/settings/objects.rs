//! The settings that are objects: their members, defined as settings are.

use graspd_core::mesh::MAX_UNIFORM;

use super::definition::{
    DIRECTION, Kind, List, MAX_CONTACTS, MAX_COORDINATE, MESH_UNIT, NORMAL, Object, POINT, Setting,
    above, choice, from, whole,
};
use super::rules::{self, MAX_REGIONS, MAX_TRIANGLES};
use crate::wire::CandidateKind;

pub const CANDIDATE_KINDS: &[(&str, &str)] = &[
    (
        "triangles",
        "The centroid of every triangle, as in the paper",
    ),
    (
        "uniform",
        "Places spread evenly over the surface, whatever the triangles",
    ),
];

pub const CANDIDATES: Object = Object {
    name: "CandidateSettings",
    help: "Where fingers may be put. In a form or as a flag also the kind alone.",
    members: &[
        Setting::new(
            "kind",
            choice::<CandidateKind>(CANDIDATE_KINDS),
            "Which places on the surface are candidates.",
        )
        .required(),
        Setting::new(
            "count",
            whole(1, MAX_UNIFORM as u64),
            "How many are spread over the surface. Only for `uniform`.",
        )
        .default_if("10000 for uniform", rules::uniform_count)
        .example("10000"),
    ],
    rules: rules::candidates,
    is_closed: false,
};

pub const ROBUSTNESS: Object = Object {
    name: "RobustnessSettings",
    help: "How the contacts of a grasp are scattered to see how robust it is.",
    members: &[
        Setting::new(
            "sigma",
            above(0.0, MAX_COORDINATE),
            "Standard deviation of either component of a displacement in the tangent plane. At most the size of \
             the mesh.",
        )
        .unit(MESH_UNIT)
        .required()
        .example("0.5"),
        Setting::new("samples", whole(1, 10_000), "How many scattered grasps are evaluated.")
            .default("200")
            .example("200"),
        Setting::new("seed", whole(0, u64::MAX), "Fixes the displacements.")
            .default("0")
            .example("0"),
    ],
    rules: rules::none,
    is_closed: false,
};

pub const INDEPENDENT_REGIONS: Object = Object {
    name: "RegionSettings",
    help: "What a grasp has to keep within its independent regions.",
    members: &[Setting::new(
        "fraction",
        above(0.0, 1.0),
        "Share of the quality ε that has to be kept.",
    )
    .default("0.5")
    .example("0.5")],
    rules: rules::none,
    is_closed: false,
};

pub const CONSTRAINTS: Object = Object {
    name: "Constraints",
    help: "What every grasp has to satisfy. A place on the surface may be a contact if it is in some region of \
           `include`, when that names any, and in none of `exclude`. Places are judged by their position, the \
           centroid of a triangle, and borders belong to their region.",
    members: &[
        Setting::new("include", REGIONS, "Regions to be in.").absent("the whole surface"),
        Setting::new(
            "exclude",
            REGIONS,
            "Regions not to be in. Both lists together have at most 64 regions.",
        ),
        Setting::new(
            "min_contact_distance",
            from(0.0, MAX_COORDINATE),
            "Least distance between any two contacts.",
        )
        .unit(MESH_UNIT),
        Setting::new(
            "max_contact_distance",
            above(0.0, MAX_COORDINATE),
            "Greatest distance between any two contacts, the span of the hand.",
        )
        .unit(MESH_UNIT),
        Setting::new(
            "approach_directions",
            Kind::List(List { of: &DIRECTION, min: 1, max: 64, what: "directions" }),
            "Directions in which a finger moves towards the body. They may have any length but zero.",
        )
        .absent("any"),
        Setting::new(
            "max_normal_angle",
            from(0.0, 180.0),
            "Greatest angle between the inward normal of a contact and the nearest approach direction.",
        )
        .unit("degrees")
        .example("60.0"),
        Setting::new(
            "fixed_contacts",
            Kind::List(List { of: &Kind::Contact, min: 0, max: MAX_CONTACTS - 1, what: "contacts" }),
            "Contacts that are part of every grasp, fewer than `contacts`. The rest are planned; the fixed ones \
             are not checked against each other.",
        ),
    ],
    rules: rules::constraints,
    is_closed: true,
};

const REGIONS: Kind = Kind::List(List {
    of: &REGION,
    min: 0,
    max: MAX_REGIONS,
    what: "regions",
});

const REGION: Kind = Kind::OneOf {
    name: "Region",
    members: &[
        Setting::new(
            "box",
            Kind::Object(Object {
                name: "Corners",
                help: "An axis-aligned box.",
                members: &[
                    Setting::new("min", POINT, "Lowest corner.").required(),
                    Setting::new("max", POINT, "Highest corner.").required(),
                ],
                rules: rules::corners,
                is_closed: true,
            }),
            "Inside an axis-aligned box.",
        )
        .required(),
        Setting::new(
            "half_space",
            Kind::Object(Object {
                name: "HalfSpace",
                help: "All on one side of a plane.",
                members: &[
                    Setting::new("point", POINT, "Somewhere on the plane.").required(),
                    Setting::new(
                        "normal",
                        NORMAL,
                        "Into the half-space, of any length but zero.",
                    )
                    .required(),
                ],
                rules: rules::none,
                is_closed: true,
            }),
            "On the side of the plane through `point` that `normal` points to.",
        )
        .required(),
        Setting::new(
            "sphere",
            Kind::Object(Object {
                name: "Sphere",
                help: "A solid sphere.",
                members: &[
                    Setting::new("center", POINT, "Its centre.").required(),
                    Setting::new("radius", above(0.0, MAX_COORDINATE), "Its radius.").required(),
                ],
                rules: rules::none,
                is_closed: true,
            }),
            "Inside a sphere.",
        )
        .required(),
        Setting::new(
            "triangles",
            Kind::Triangles { max: MAX_TRIANGLES },
            "On these triangles, counted from 0 in the order of the uploaded file; all regions together may name \
             100,000.",
        )
        .required(),
    ],
};
