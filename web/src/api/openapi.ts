/** Written by `npm run types`: do not edit. */

export type paths = Record<string, never>;
export type webhooks = Record<string, never>;
export interface components {
  schemas: {
    /** @description One page of batches, newest first. */
    BatchPage: {
      batches: components["schemas"]["BatchRecord"][];
      /** @description Where the next page starts; absent on the last one. */
      next_cursor?: string;
    };
    /** @description A batch, as clients see it. */
    BatchRecord: {
      /** Format: date-time */
      created_at: string;
      /**
       * Format: date-time
       * @description When the last of its jobs ended; present once the batch has ended.
       */
      finished_at?: string;
      /** Format: uuid */
      id: string;
      jobs: components["schemas"]["JobCounts"];
      /** @description The name that the client gave it. */
      label?: string;
      /**
       * Format: date-time
       * @description When the first of its remaining jobs started.
       */
      started_at?: string;
      state: components["schemas"]["BatchState"];
    };
    BatchRequest:
      | {
          /** @description A name by which people recognise the batch, without control characters. */
          label?: string;
          /** @description Ids of the meshes, as their uploads returned them; an id may be repeated. */
          meshes: string[];
          request?: components["schemas"]["PlanRequestInput"];
        }
      | {
          /** @description A name by which people recognise the batch, without control characters. */
          label?: string;
          /** @description The jobs, each with its mesh. */
          requests: components["schemas"]["JobRequest"][];
        };
    /** @description The outcome of one job of a batch: a line of its results. */
    BatchResult: {
      /**
       * Format: int32
       * @description The position of the job in the batch, counted from 0.
       */
      index: number;
      /** Format: uuid */
      job_id: string;
      /** @description The name that the client gave the job. */
      label?: string;
      mesh_id: string;
      /** @description Why the job failed. */
      problem?: components["schemas"]["Problem"];
      /** @description The result, byte for byte as the planner wrote it. */
      result?: components["schemas"]["PlanResult"];
      state: components["schemas"]["JobState"];
    };
    /**
     * @description The state of a batch.
     * @enum {string}
     */
    BatchState: "running" | "ended";
    /** Format: binary */
    Binary: string;
    /** @description One of several bodies in a mesh that do not touch each other. */
    Body: {
      /** @description Lowest and highest corner of its axis-aligned bounding box. */
      bounds: number[][];
      /** @description The names that its triangles have in the file; the first ten where there are more. */
      names?: string[];
      triangles: number;
    };
    /** @description What became of the callback of a job. */
    CallbackRecord: {
      /**
       * Format: int32
       * @description How often it was tried.
       */
      attempts: number;
      /** Format: date-time */
      last_attempt_at?: string;
      /** @description Why the last attempt failed. */
      last_error?: string;
      /**
       * Format: date-time
       * @description While pending, once the job has ended.
       */
      next_attempt_at?: string;
      state: components["schemas"]["CallbackState"];
      /**
       * Format: uri
       * @description Where the server posts the end of the job.
       */
      url: string;
    };
    /**
     * @description Where a callback is: `pending → delivered | failed`.
     * @enum {string}
     */
    CallbackState: "pending" | "delivered" | "failed";
    /**
     * @description Which places on the surface are candidates.
     * @enum {string}
     */
    CandidateKind: "triangles" | "uniform";
    /** @description Where fingers may be put. In a form or as a flag also the kind alone. */
    CandidateSettings: {
      /**
       * Format: int32
       * @description How many are spread over the surface. Only for `uniform`. Default: 10000 for uniform.
       * @example 10000
       */
      count?: number;
      /** @description Which places on the surface are candidates. */
      kind: components["schemas"]["CandidateKind"];
    };
    /** @description Which candidates a run searched, and why. */
    CandidateSource: {
      /** @description Why these, in words. */
      because: string;
      /**
       * Format: int64
       * @description How many there were before the constraints.
       */
      count: number;
      kind: components["schemas"]["CandidateKind"];
    };
    /** @description The number of a body, counted from 0 in the order of the report, or the name of parts of the file. `all` takes all bodies as one rigid body. */
    Component: number | string;
    /** @description What every grasp has to satisfy. A place on the surface may be a contact if it is in some region of `include`, when that names any, and in none of `exclude`. Places are judged by their position, the centroid of a triangle, and borders belong to their region. */
    Constraints: {
      /** @description Directions in which a finger moves towards the body. They may have any length but zero. Default: any. */
      approach_directions?: number[][];
      /** @description Regions not to be in. Both lists together have at most 64 regions. Default: none. */
      exclude?: components["schemas"]["Region"][];
      /** @description Contacts that are part of every grasp, fewer than `contacts`. The rest are planned; the fixed ones are not checked against each other. Default: none. */
      fixed_contacts?: components["schemas"]["ContactSpec"][];
      /** @description Regions to be in. Default: the whole surface. */
      include?: components["schemas"]["Region"][];
      /**
       * Format: double
       * @description Greatest distance between any two contacts, the span of the hand. In the mesh's unit. Default: none.
       */
      max_contact_distance?: number;
      /**
       * Format: double
       * @description Greatest angle between the inward normal of a contact and the nearest approach direction. In degrees. Default: none.
       * @example 60
       */
      max_normal_angle?: number;
      /**
       * Format: double
       * @description Least distance between any two contacts. In the mesh's unit. Default: none.
       */
      min_contact_distance?: number;
    };
    /**
     * @description How a finger touches the body.
     * @enum {string}
     */
    ContactModel: "frictionless" | "hard" | "soft";
    /** @description A contact of a grasp. */
    ContactPoint: {
      /** @description Unit normal pointing out of the body: the side a finger comes from. */
      approach: number[];
      /** @description Barycentric coordinates of the position in that triangle. */
      barycentric?: number[] | null;
      /** @description Whether the contact was given by the constraints; present only if it was. */
      fixed?: boolean;
      /**
       * @description The force this finger exerts in the least-effort answer to the disturbance that the grasp
       *     resists worst: the opposite of `weakest_wrench`, at unit size. Present in the best grasp only, and
       *     only with force closure.
       */
      forces?: number[] | null;
      /** @description Unit normal pointing into the body: the direction a finger pushes in. */
      normal: number[];
      /** @description Position in the mesh's frame and unit. */
      position: number[];
      /**
       * Format: double
       * @description The torque about the inward normal that goes with the force, for soft contacts.
       */
      torsion?: number | null;
      /**
       * Format: int32
       * @description The triangle it touches, counted from 0 in the order of the uploaded file; absent for a fixed contact
       *     that was given with its normal.
       */
      triangle?: number | null;
    };
    /** @description `triangle` alone, counted from 0 in the order of the file: its centroid. `point` alone: the nearest place on the surface. `point` with `normal`, into the body and of any length but zero: as it is. */
    ContactSpec: {
      normal?: number[];
      point?: number[];
      triangle?: number;
    };
    /** @description An axis-aligned box. */
    Corners: {
      /** @description Highest corner. */
      max: number[];
      /** @description Lowest corner. */
      min: number[];
    };
    /**
     * @description How long the edges of a linearised friction cone are.
     *
     *     With one friction coefficient μ for all contacts, every wrench and so ε under `UnitNormal` is
     *     √(1+μ²) times that under `UnitEdge`.
     * @enum {string}
     */
    EdgeNorm: "unit_edge" | "unit_normal";
    /** @description A contact as it was evaluated. */
    EvaluatedContact: {
      /** @description Unit normal pointing out of the body: the side a finger comes from. */
      approach: number[];
      /** @description Barycentric coordinates of the position in that triangle. */
      barycentric?: number[] | null;
      /**
       * Format: double
       * @description Distance by which projection moved the point.
       */
      distance?: number | null;
      /**
       * @description The force this finger exerts in the least-effort answer to the disturbance that the grasp
       *     resists worst: the opposite of `weakest_wrench`, at unit size. Absent without force closure.
       */
      forces?: number[] | null;
      /** @description Unit normal pointing into the body: the direction a finger pushes in. */
      normal: number[];
      /** @description Position in the mesh's frame and unit. */
      position: number[];
      /**
       * Format: double
       * @description The torque about the inward normal that goes with the force, for soft contacts.
       */
      torsion?: number | null;
      /**
       * Format: int32
       * @description The triangle it touches, counted from 0 in the order of the file; absent for free points.
       */
      triangle?: number | null;
    };
    EvaluationForm: {
      /**
       * @description The point that torques are taken about, in the mesh's frame. In the mesh's unit. Default: the mesh's own centre of mass.
       * @example [
       *       0,
       *       0,
       *       0
       *     ]
       */
      center_of_mass?: number[];
      /** @description Which of the bodies in the mesh is grasped. The report of the mesh lists them. The others are left out: the centre of mass, radius and candidates are its own. `all` takes them all as one rigid body. Default: the body, of which there must be one. */
      component?: components["schemas"]["Component"];
      /**
       * Format: int32
       * @description Edges of the pyramid that replaces the friction cone. 0 keeps the round cone itself; absent when frictionless. Default: 8.
       * @example 8
       */
      cone_edges?: number;
      /** @description How a finger touches the body. Default: hard, or frictionless when friction is 0. */
      contact_model?: components["schemas"]["ContactModel"];
      /** @description How long the edges of the friction cone are. It only changes the scale of the quality. Default: unit_edge. */
      edge_norm?: components["schemas"]["EdgeNorm"];
      /**
       * @description Whether contacts may be where no finger gets: in sealed cavities, and on walls that are buried between solids. Default: false.
       * @example true
       */
      enclosed?: boolean;
      external_wrench?: components["schemas"]["ExternalWrench"];
      external_wrenches?: components["schemas"]["ExternalWrench"][];
      /**
       * Format: double
       * @description Coulomb's coefficient of friction. The same for all contacts; 0 asks for frictionless contacts, and an effective request without friction does not have it. Default: 0.5.
       * @example 0.5
       */
      friction?: number;
      /** @description The grasps, each a list of contacts. */
      grasps?: components["schemas"]["ContactSpec"][][];
      /**
       * @description Compute the quality against a force in this direction at the centre of mass. Default: not computed.
       * @example [
       *       0,
       *       0,
       *       -1
       *     ]
       */
      gravity?: number[];
      /** @description Compute where each finger may be while the others stay. Default: not computed. */
      independent_regions?: components["schemas"]["RegionSettings"];
      mesh: components["schemas"]["Binary"];
      /** @description Everything but the mesh as one JSON document, instead of the other fields. */
      request?: Record<string, never>;
      /** @description Compute how robust the grasp is against fingers that miss their places. Default: not computed. */
      robustness?: components["schemas"]["RobustnessSettings"];
      /**
       * @description Compute the quality against these disturbances. Each is a force and a torque about the centre of mass, in the mesh's frame, in any unit of force and that times the mesh's unit of length. Only their directions matter, once torques are scaled. Default: none.
       * @example [
       *       [
       *         0,
       *         0,
       *         -1,
       *         0,
       *         0,
       *         0
       *       ]
       *     ]
       */
      task_wrenches?: number[][];
      /** @description The factor (1/length) that makes torques comparable with forces. Default: max_radius. */
      torque_scale?: components["schemas"]["TorqueScale"];
      /**
       * Format: double
       * @description Torsional friction of a soft finger, the greatest torque about the normal over the normal force. Only soft contacts have it. In the mesh's unit. Default: a twentieth of the greatest distance of a vertex from the centre of mass.
       * @example 0.01
       */
      torsional_friction?: number;
      /** @description The unit of the mesh's coordinates. It is echoed and used to doubt sizes, never to rescale. Default: that of the mesh, where its upload named one. */
      units?: components["schemas"]["Units"];
      /** @description How the wrenches of the contacts add up. Default: l1. */
      wrench_space?: components["schemas"]["WrenchSpace"];
    };
    EvaluationRequest: {
      /**
       * @description The point that torques are taken about, in the mesh's frame. In the mesh's unit. Default: the mesh's own centre of mass.
       * @example [
       *       0,
       *       0,
       *       0
       *     ]
       */
      center_of_mass?: number[];
      /** @description Which of the bodies in the mesh is grasped. The report of the mesh lists them. The others are left out: the centre of mass, radius and candidates are its own. `all` takes them all as one rigid body. Default: the body, of which there must be one. */
      component?: components["schemas"]["Component"];
      /**
       * Format: int32
       * @description Edges of the pyramid that replaces the friction cone. 0 keeps the round cone itself; absent when frictionless. Default: 8.
       * @example 8
       */
      cone_edges?: number;
      /** @description How a finger touches the body. Default: hard, or frictionless when friction is 0. */
      contact_model?: components["schemas"]["ContactModel"];
      /** @description How long the edges of the friction cone are. It only changes the scale of the quality. Default: unit_edge. */
      edge_norm?: components["schemas"]["EdgeNorm"];
      /**
       * @description Whether contacts may be where no finger gets: in sealed cavities, and on walls that are buried between solids. Default: false.
       * @example true
       */
      enclosed?: boolean;
      external_wrench?: components["schemas"]["ExternalWrench"];
      external_wrenches?: components["schemas"]["ExternalWrench"][];
      /**
       * Format: double
       * @description Coulomb's coefficient of friction. The same for all contacts; 0 asks for frictionless contacts, and an effective request without friction does not have it. Default: 0.5.
       * @example 0.5
       */
      friction?: number;
      /** @description The grasps, each a list of contacts. */
      grasps: components["schemas"]["ContactSpec"][][];
      /**
       * @description Compute the quality against a force in this direction at the centre of mass. Default: not computed.
       * @example [
       *       0,
       *       0,
       *       -1
       *     ]
       */
      gravity?: number[];
      /** @description Compute where each finger may be while the others stay. Default: not computed. */
      independent_regions?: components["schemas"]["RegionSettings"];
      /** @description Id of the mesh, as its upload returned it. */
      mesh_id: string;
      /** @description Compute how robust the grasp is against fingers that miss their places. Default: not computed. */
      robustness?: components["schemas"]["RobustnessSettings"];
      /**
       * @description Compute the quality against these disturbances. Each is a force and a torque about the centre of mass, in the mesh's frame, in any unit of force and that times the mesh's unit of length. Only their directions matter, once torques are scaled. Default: none.
       * @example [
       *       [
       *         0,
       *         0,
       *         -1,
       *         0,
       *         0,
       *         0
       *       ]
       *     ]
       */
      task_wrenches?: number[][];
      /** @description The factor (1/length) that makes torques comparable with forces. Default: max_radius. */
      torque_scale?: components["schemas"]["TorqueScale"];
      /**
       * Format: double
       * @description Torsional friction of a soft finger, the greatest torque about the normal over the normal force. Only soft contacts have it. In the mesh's unit. Default: a twentieth of the greatest distance of a vertex from the centre of mass.
       * @example 0.01
       */
      torsional_friction?: number;
      /** @description The unit of the mesh's coordinates. It is echoed and used to doubt sizes, never to rescale. Default: that of the mesh, where its upload named one. */
      units?: components["schemas"]["Units"];
      /** @description How the wrenches of the contacts add up. Default: l1. */
      wrench_space?: components["schemas"]["WrenchSpace"];
    };
    /**
     * @description The evaluations of grasps, in the order of the request, with every number that they depend on. The same
     *     mesh and request give the same bytes.
     */
    Evaluations: {
      /** @description The point torques are taken about. */
      center_of_mass: number[];
      /**
       * Format: int32
       * @description Edges of the pyramid that replaces the friction cone; 0 is the round cone.
       */
      cone_edges?: number | null;
      contact_model: components["schemas"]["ContactModel"];
      edge_norm: components["schemas"]["EdgeNorm"];
      evaluations: components["schemas"]["GraspEvaluation"][];
      /**
       * @description The frame of positions, normals and torques: `mesh`, that of the uploaded file.
       * @example mesh
       */
      frame: string;
      /**
       * Format: double
       * @description Coefficient of friction μ.
       */
      friction?: number | null;
      /** @description Warnings about the mesh without which the answer should not be believed. */
      mesh_warnings?: components["schemas"]["MeshWarning"][];
      /** @description The factor that made torques comparable with forces. */
      torque_scale: components["schemas"]["TorqueScaleValue"];
      /**
       * Format: double
       * @description Torsional friction μ_t of soft contacts, a length in the mesh's unit.
       */
      torsional_friction?: number | null;
      units?: components["schemas"]["Units"] | null;
      /**
       * @description Version of graspd that made this answer.
       * @example 0.1.0
       */
      version: string;
      wrench_space: components["schemas"]["WrenchSpace"];
    };
    /** @description Why there is no force closure. */
    Explanation: {
      detail: string;
      /**
       * @description Whether it is proven that no choice of contacts on this mesh is force closure and keeps the
       *     constraints.
       */
      proven: boolean;
      reason: components["schemas"]["Reason"];
    };
    /**
     * @description A force and a torque about the centre of mass that act on the body from outside, in the mesh's
     *     frame: any unit of force, torques in that times the mesh's unit of length.
     */
    ExternalWrench: {
      force?: number[];
      torque?: number[];
    };
    /** @description One field at fault. */
    FieldError: {
      /** @description The fault of the field and what is accepted. */
      detail: string;
      /** @description JSON pointer (RFC 6901) to the field in the request; for a form, `/field-name`. */
      pointer: string;
    };
    /**
     * @description A motion of the body that no contact hinders, in the mesh's frame, at unspecified speed.
     *
     *     If the fingers stay where they are, the motion separates the body from them or slides it along them; no
     *     force that they can exert has negative power along it.
     */
    FreeMotion: {
      /** @description Unit direction of a translation, or the axis of a right-handed rotation or screw. */
      axis: number[];
      kind: components["schemas"]["MotionKind"];
      /**
       * Format: double
       * @description Advance of a screw, in the mesh's unit per radian; negative for a left-handed screw.
       */
      pitch?: number | null;
      /** @description The point of the axis that is nearest to the centre of mass; absent for a translation. */
      point?: number[] | null;
    };
    /** @description The evaluation of one given grasp. */
    GraspEvaluation: {
      /**
       * @description [lower, upper]: a certified interval on the ε that the same contacts have with the round
       *     friction cone itself. Absent without force closure.
       */
      bounds?: number[] | null;
      /**
       * @description Whether `bounds` differ by at most 1e-6 of the upper one. `false` when the facet limit ended the interval earlier; it
       *     is certified all the same. Absent without force closure.
       */
      bounds_exact?: boolean | null;
      contacts: components["schemas"]["EvaluatedContact"][];
      /**
       * @description Whether `margin`, and with it `quality`, is exact to rounding or, where the wrench space is no
       *     polytope, to 1e-6 of itself. If not, `quality` is a lower bound, and `weakest_wrench` and the forces are those of
       *     the weakest direction found.
       */
      exact?: boolean | null;
      explanation?: components["schemas"]["Obstacle"] | null;
      /** @description Whether the contacts hold the body against every small force and torque. */
      force_closure: boolean;
      /**
       * Format: double
       * @description Quality against a force along the gravity of the request, at the centre of mass: the largest such
       *     force that is resisted, in the unit of ε.
       */
      gravity_quality?: number | null;
      /**
       * @description Where each finger may be while the others stay, in the order of the contacts, if it was requested.
       *     Absent without force closure.
       */
      independent_regions?: components["schemas"]["IndependentRegion"][] | null;
      /**
       * Format: double
       * @description Signed distance from the origin to the plane of the nearest facet of the wrench space, as in a planning
       *     result.
       */
      margin?: number | null;
      measures: components["schemas"]["Measures"];
      /**
       * Format: double
       * @description The quality ε, as in a planning result; where the wrench space is no polytope, the certified
       *     lower end of an interval. Absent without force closure.
       */
      quality?: number | null;
      /** @description For each external wrench of the request, in order, whether and how it is resisted. */
      resisted: components["schemas"]["Resistance"][];
      robustness?: components["schemas"]["Robustness"] | null;
      task_quality?: components["schemas"]["TaskQuality"] | null;
      weakest_wrench?: components["schemas"]["WeakestWrench"] | null;
    };
    /** @description All on one side of a plane. */
    HalfSpace: {
      /** @description Into the half-space, of any length but zero. */
      normal: number[];
      /** @description Somewhere on the plane. */
      point: number[];
    };
    /** @description The state of the service in a word. */
    Health: {
      /** @description `ok`. */
      status: string;
    };
    /** @description State of the population after a generation. */
    HistoryEntry: {
      /**
       * Format: double
       * @description Best quality ε so far.
       */
      best?: number | null;
      /**
       * Format: double
       * @description Seconds since planning began.
       */
      elapsed_s: number;
      /**
       * Format: int64
       * @description Quality evaluations so far.
       */
      evaluations: number;
      /**
       * Format: int64
       * @description Number of individuals that are force closure.
       */
      force_closures: number;
      /** Format: int64 */
      generation: number;
      /**
       * Format: double
       * @description Mean ε of the individuals that are force closure.
       */
      mean?: number | null;
    };
    /**
     * @description Where one finger may be while the others stay (independent contact region, Nguyen 1988, Roa & Suárez
     *     2009): the triangles at whose centroids the grasp keeps force closure and the requested fraction of its
     *     quality. Every triangle was decided, none estimated.
     */
    IndependentRegion: {
      /**
       * Format: double
       * @description Their area, in the mesh's unit squared.
       */
      area: number;
      /**
       * Format: int64
       * @description How many of them can be reached from the contact's own triangle over edges that they share; zero
       *     when that is not among them. Absent for a free contact.
       */
      connected?: number | null;
      /**
       * Format: double
       * @description The area of those.
       */
      connected_area?: number | null;
      /**
       * Format: int64
       * @description Triangles of the whole region.
       */
      count: number;
      /** @description The triangles, ascending, counted from 0 in the order of the file. */
      triangles: number[];
      /**
       * @description Whether `triangles` was cut short: one answer lists 100,000 in all, the same number for every
       *     contact. `count` and the areas are of the whole region.
       */
      truncated: boolean;
    };
    /** @description The first force-closure grasp. */
    InitialGrasp: {
      contacts: components["schemas"]["ContactPoint"][];
      /**
       * Format: double
       * @description Its quality ε.
       */
      quality: number;
    };
    /**
     * @description Which candidates may replace a contact.
     * @enum {string}
     */
    InitialMode: "weak" | "strict";
    /** @description The number of jobs of a batch in each state. */
    JobCounts: {
      /** Format: int32 */
      cancelled: number;
      /** Format: int32 */
      failed: number;
      /**
       * Format: int32
       * @description Jobs that were deleted or have expired.
       */
      forgotten: number;
      /** Format: int32 */
      queued: number;
      /** Format: int32 */
      running: number;
      /** Format: int32 */
      succeeded: number;
      /**
       * Format: int32
       * @description Jobs that were submitted.
       */
      total: number;
    };
    /** @description One event. */
    JobEvent: {
      /** @description A `JobRecord` or a `JobProgress` as one line of JSON. */
      data: string;
      /** @description `snapshot`, `progress` or `end`. */
      event: string;
      /** @description Revision of the job. */
      id?: string;
      /**
       * Format: int64
       * @description Milliseconds to wait before the stream is opened again.
       */
      retry?: number;
    };
    JobForm: {
      /**
       * Format: uri
       * @description Where the server posts a signed message once the job has ended. It is an https URL on a host that the operator of the server allows. Default: nowhere.
       * @example https://hooks.example.com/grasps
       */
      callback_url?: string;
      /** @description The places that are searched. The result says which in `candidates_from`. Default: triangles, but uniform for memetic where the triangles are fewer than 1000 or their areas vary by more than a factor of 4 (95th over 5th percentile). */
      candidates?: components["schemas"]["CandidateSettings"];
      /**
       * @description The point that torques are taken about, in the mesh's frame. In the mesh's unit. Default: the mesh's own centre of mass.
       * @example [
       *       0,
       *       0,
       *       0
       *     ]
       */
      center_of_mass?: number[];
      /** @description Which of the bodies in the mesh is grasped. The report of the mesh lists them. The others are left out: the centre of mass, radius and candidates are its own. `all` takes them all as one rigid body. Default: the body, of which there must be one. */
      component?: components["schemas"]["Component"];
      /**
       * Format: int32
       * @description Edges of the pyramid that replaces the friction cone. 0 keeps the round cone itself; absent when frictionless. Default: 8.
       * @example 8
       */
      cone_edges?: number;
      /** @description Where contacts may be, how far apart they are, how fingers approach, and contacts that are given. Default: contacts anywhere. */
      constraints?: components["schemas"]["Constraints"];
      /** @description How a finger touches the body. Default: hard, or frictionless when friction is 0. */
      contact_model?: components["schemas"]["ContactModel"];
      /**
       * Format: int32
       * @description Number of contacts, fixed ones included. Default: 4 with friction, 7 without.
       * @example 4
       */
      contacts?: number;
      /**
       * Format: double
       * @description Probability that two parents are crossed. Default: 0.7 for memetic, else 0.9.
       * @example 0.9
       */
      crossover_probability?: number;
      /** @description How long the edges of the friction cone are. It only changes the scale of the quality. Default: unit_edge. */
      edge_norm?: components["schemas"]["EdgeNorm"];
      /**
       * Format: int32
       * @description Best individuals carried over unchanged, fewer than the population. Only `modified_ga` uses it. Default: 1.
       * @example 1
       */
      elitism?: number;
      /**
       * @description Whether contacts may be where no finger gets: in sealed cavities, and on walls that are buried between solids. Default: false.
       * @example true
       */
      enclosed?: boolean;
      /**
       * Format: int64
       * @description Stop after this many quality evaluations. Default: no limit.
       * @example 1000000
       */
      evaluation_limit?: number;
      /**
       * Format: double
       * @description Coulomb's coefficient of friction. The same for all contacts; 0 asks for frictionless contacts, and an effective request without friction does not have it. Default: 0.5.
       * @example 0.5
       */
      friction?: number;
      /**
       * Format: int32
       * @description Generations after the first population. With `memetic`, each individual reaches an optimum once a generation. The population times (generations + 1) may be at most 1,000,000,000. Default: 25 for memetic, else 100.
       * @example 100
       */
      generations?: number;
      /**
       * @description Compute the quality against a force in this direction at the centre of mass. Default: not computed.
       * @example [
       *       0,
       *       0,
       *       -1
       *     ]
       */
      gravity?: number[];
      /** @description Compute where each finger may be while the others stay. Default: not computed. */
      independent_regions?: components["schemas"]["RegionSettings"];
      /** @description Which candidates may complete the first force-closure grasp. `random` starts from no grasp. Default: weak for memetic, else strict, as in the paper. */
      initial?: components["schemas"]["InitialMode"];
      /**
       * @description A name by which people recognise the job, up to 200 characters. Default: none.
       * @example duck, four fingers
       */
      label?: string;
      mesh: components["schemas"]["Binary"];
      /** @description Which search looks for the best grasp. Default: memetic. */
      method?: components["schemas"]["Method"];
      /**
       * Format: double
       * @description Probability that a child is mutated. Default: 0.2.
       * @example 0.2
       */
      mutation_probability?: number;
      /** @description Whether the contacts of the best grasp slide over the surface to where the quality is greater still. They slide within triangles and across edges; otherwise contacts are centroids, as in the paper. Default: true for memetic, else false. */
      polish?: boolean;
      /**
       * Format: int32
       * @description Individuals per generation. For `memetic`, grasps that climb side by side. Default: 8 for memetic, else 200.
       * @example 200
       */
      population?: number;
      /** @description Whether the job goes before others in the queue. Default: interactive. */
      priority?: components["schemas"]["Priority"];
      request?: components["schemas"]["PlanRequestInput"];
      /** @description Compute how robust the grasp is against fingers that miss their places. Default: not computed. */
      robustness?: components["schemas"]["RobustnessSettings"];
      /**
       * Format: int64
       * @description Fixes every random choice. The same mesh, request and seed give the same result. Default: a random number below 2^53.
       * @example 7
       */
      seed?: number;
      /**
       * Format: double
       * @description Stop once this quality is reached. Default: never.
       * @example 0.2
       */
      target_quality?: number;
      /**
       * @description Compute the quality against these disturbances. Each is a force and a torque about the centre of mass, in the mesh's frame, in any unit of force and that times the mesh's unit of length. Only their directions matter, once torques are scaled. Default: none.
       * @example [
       *       [
       *         0,
       *         0,
       *         -1,
       *         0,
       *         0,
       *         0
       *       ]
       *     ]
       */
      task_wrenches?: number[][];
      /**
       * Format: double
       * @description Stop searching after this time. The analyses of the grasp may take as long again. In seconds. Default: only the server's own limit.
       * @example 60
       */
      time_limit_s?: number;
      /**
       * Format: int32
       * @description How many distinct grasps to return, the best included. There may be fewer. Default: 1.
       * @example 1
       */
      top?: number;
      /** @description The factor (1/length) that makes torques comparable with forces. Default: max_radius. */
      torque_scale?: components["schemas"]["TorqueScale"];
      /**
       * Format: double
       * @description Torsional friction of a soft finger, the greatest torque about the normal over the normal force. Only soft contacts have it. In the mesh's unit. Default: a twentieth of the greatest distance of a vertex from the centre of mass.
       * @example 0.01
       */
      torsional_friction?: number;
      /**
       * Format: int32
       * @description Repeat the run with the seeds seed, seed + 1, ... and add statistics over them to the best result. Default: 1.
       * @example 1
       */
      trials?: number;
      /** @description The unit of the mesh's coordinates. It is echoed and used to doubt sizes, never to rescale. Default: that of the mesh, where its upload named one. */
      units?: components["schemas"]["Units"];
      /** @description How the wrenches of the contacts add up. Default: l1. */
      wrench_space?: components["schemas"]["WrenchSpace"];
    };
    /** @description One page of jobs, newest first, without their results. */
    JobPage: {
      jobs: components["schemas"]["JobRecord"][];
      /** @description Where the next page starts; absent on the last one. */
      next_cursor?: string;
    };
    /** @description The data of an event `progress` of a job. */
    JobProgress: {
      /** @description The progress of the run; absent while the job is queued. */
      progress?: components["schemas"]["Progress"];
      /**
       * Format: int64
       * @description The revision of the job.
       */
      revision: number;
      state: components["schemas"]["JobState"];
    };
    /** @description A job, as clients see it. */
    JobRecord: {
      /**
       * Format: int32
       * @description 1, plus one for each time that the server stopped unexpectedly while the job ran.
       */
      attempt: number;
      /**
       * Format: uuid
       * @description The batch that the job belongs to.
       */
      batch_id?: string;
      /**
       * Format: int32
       * @description Its position in the batch, counted from 0.
       */
      batch_index?: number;
      /** @description The delivery of the callback, if the job has one. Lists omit it. */
      callback?: components["schemas"]["CallbackRecord"];
      /** Format: date-time */
      created_at: string;
      /** Format: date-time */
      finished_at?: string;
      /** Format: uuid */
      id: string;
      /** @description The name that the client gave it. */
      label?: string;
      /** @description The mesh to plan on; it may have been deleted once the job has ended. */
      mesh_id: string;
      /** @description The report on the mesh. Lists omit it, and it is deleted with the mesh. */
      mesh_report?: components["schemas"]["MeshReport"];
      priority: components["schemas"]["Priority"];
      /** @description Why the job failed. */
      problem?: components["schemas"]["Problem"];
      /** @description The progress of the run; once the job has ended, the progress at its end. */
      progress?: components["schemas"]["Progress"];
      /** @description The effective settings, with every default filled in and the seed fixed. */
      request: components["schemas"]["PlanRequest"];
      /** @description The result, byte for byte as the planner wrote it. Lists omit it. */
      result?: components["schemas"]["PlanResult"];
      /**
       * Format: int64
       * @description Grows with every change of this record, except changes of `callback`.
       */
      revision: number;
      /**
       * Format: date-time
       * @description When the last attempt started.
       */
      started_at?: string;
      state: components["schemas"]["JobState"];
    };
    JobRequest: {
      /**
       * Format: uri
       * @description Where the server posts a signed message once the job has ended. It is an https URL on a host that the operator of the server allows. Default: nowhere.
       * @example https://hooks.example.com/grasps
       */
      callback_url?: string;
      /** @description The places that are searched. The result says which in `candidates_from`. Default: triangles, but uniform for memetic where the triangles are fewer than 1000 or their areas vary by more than a factor of 4 (95th over 5th percentile). */
      candidates?: components["schemas"]["CandidateSettings"];
      /**
       * @description The point that torques are taken about, in the mesh's frame. In the mesh's unit. Default: the mesh's own centre of mass.
       * @example [
       *       0,
       *       0,
       *       0
       *     ]
       */
      center_of_mass?: number[];
      /** @description Which of the bodies in the mesh is grasped. The report of the mesh lists them. The others are left out: the centre of mass, radius and candidates are its own. `all` takes them all as one rigid body. Default: the body, of which there must be one. */
      component?: components["schemas"]["Component"];
      /**
       * Format: int32
       * @description Edges of the pyramid that replaces the friction cone. 0 keeps the round cone itself; absent when frictionless. Default: 8.
       * @example 8
       */
      cone_edges?: number;
      /** @description Where contacts may be, how far apart they are, how fingers approach, and contacts that are given. Default: contacts anywhere. */
      constraints?: components["schemas"]["Constraints"];
      /** @description How a finger touches the body. Default: hard, or frictionless when friction is 0. */
      contact_model?: components["schemas"]["ContactModel"];
      /**
       * Format: int32
       * @description Number of contacts, fixed ones included. Default: 4 with friction, 7 without.
       * @example 4
       */
      contacts?: number;
      /**
       * Format: double
       * @description Probability that two parents are crossed. Default: 0.7 for memetic, else 0.9.
       * @example 0.9
       */
      crossover_probability?: number;
      /** @description How long the edges of the friction cone are. It only changes the scale of the quality. Default: unit_edge. */
      edge_norm?: components["schemas"]["EdgeNorm"];
      /**
       * Format: int32
       * @description Best individuals carried over unchanged, fewer than the population. Only `modified_ga` uses it. Default: 1.
       * @example 1
       */
      elitism?: number;
      /**
       * @description Whether contacts may be where no finger gets: in sealed cavities, and on walls that are buried between solids. Default: false.
       * @example true
       */
      enclosed?: boolean;
      /**
       * Format: int64
       * @description Stop after this many quality evaluations. Default: no limit.
       * @example 1000000
       */
      evaluation_limit?: number;
      /**
       * Format: double
       * @description Coulomb's coefficient of friction. The same for all contacts; 0 asks for frictionless contacts, and an effective request without friction does not have it. Default: 0.5.
       * @example 0.5
       */
      friction?: number;
      /**
       * Format: int32
       * @description Generations after the first population. With `memetic`, each individual reaches an optimum once a generation. The population times (generations + 1) may be at most 1,000,000,000. Default: 25 for memetic, else 100.
       * @example 100
       */
      generations?: number;
      /**
       * @description Compute the quality against a force in this direction at the centre of mass. Default: not computed.
       * @example [
       *       0,
       *       0,
       *       -1
       *     ]
       */
      gravity?: number[];
      /** @description Compute where each finger may be while the others stay. Default: not computed. */
      independent_regions?: components["schemas"]["RegionSettings"];
      /** @description Which candidates may complete the first force-closure grasp. `random` starts from no grasp. Default: weak for memetic, else strict, as in the paper. */
      initial?: components["schemas"]["InitialMode"];
      /**
       * @description A name by which people recognise the job, up to 200 characters. Default: none.
       * @example duck, four fingers
       */
      label?: string;
      /** @description Id of the mesh, as its upload returned it. */
      mesh_id: string;
      /** @description Which search looks for the best grasp. Default: memetic. */
      method?: components["schemas"]["Method"];
      /**
       * Format: double
       * @description Probability that a child is mutated. Default: 0.2.
       * @example 0.2
       */
      mutation_probability?: number;
      /** @description Whether the contacts of the best grasp slide over the surface to where the quality is greater still. They slide within triangles and across edges; otherwise contacts are centroids, as in the paper. Default: true for memetic, else false. */
      polish?: boolean;
      /**
       * Format: int32
       * @description Individuals per generation. For `memetic`, grasps that climb side by side. Default: 8 for memetic, else 200.
       * @example 200
       */
      population?: number;
      /** @description Whether the job goes before others in the queue. Default: interactive. */
      priority?: components["schemas"]["Priority"];
      /** @description Compute how robust the grasp is against fingers that miss their places. Default: not computed. */
      robustness?: components["schemas"]["RobustnessSettings"];
      /**
       * Format: int64
       * @description Fixes every random choice. The same mesh, request and seed give the same result. Default: a random number below 2^53.
       * @example 7
       */
      seed?: number;
      /**
       * Format: double
       * @description Stop once this quality is reached. Default: never.
       * @example 0.2
       */
      target_quality?: number;
      /**
       * @description Compute the quality against these disturbances. Each is a force and a torque about the centre of mass, in the mesh's frame, in any unit of force and that times the mesh's unit of length. Only their directions matter, once torques are scaled. Default: none.
       * @example [
       *       [
       *         0,
       *         0,
       *         -1,
       *         0,
       *         0,
       *         0
       *       ]
       *     ]
       */
      task_wrenches?: number[][];
      /**
       * Format: double
       * @description Stop searching after this time. The analyses of the grasp may take as long again. In seconds. Default: only the server's own limit.
       * @example 60
       */
      time_limit_s?: number;
      /**
       * Format: int32
       * @description How many distinct grasps to return, the best included. There may be fewer. Default: 1.
       * @example 1
       */
      top?: number;
      /** @description The factor (1/length) that makes torques comparable with forces. Default: max_radius. */
      torque_scale?: components["schemas"]["TorqueScale"];
      /**
       * Format: double
       * @description Torsional friction of a soft finger, the greatest torque about the normal over the normal force. Only soft contacts have it. In the mesh's unit. Default: a twentieth of the greatest distance of a vertex from the centre of mass.
       * @example 0.01
       */
      torsional_friction?: number;
      /**
       * Format: int32
       * @description Repeat the run with the seeds seed, seed + 1, ... and add statistics over them to the best result. Default: 1.
       * @example 1
       */
      trials?: number;
      /** @description The unit of the mesh's coordinates. It is echoed and used to doubt sizes, never to rescale. Default: that of the mesh, where its upload named one. */
      units?: components["schemas"]["Units"];
      /** @description How the wrenches of the contacts add up. Default: l1. */
      wrench_space?: components["schemas"]["WrenchSpace"];
    };
    /**
     * @description The state of a job: `queued → running → succeeded | failed | cancelled`, also
     *     `queued → cancelled`, and `running → queued` when the server stops before the job ends.
     * @enum {string}
     */
    JobState: "queued" | "running" | "succeeded" | "failed" | "cancelled";
    /** @description What the service is and where to go on. */
    Landing: {
      /** @description All routes, each with its method. */
      endpoints: string[];
      /** @description `graspd`. */
      name: string;
      /** @description Version of the service. */
      version: string;
    };
    /**
     * @description The source of volume and centre of mass.
     * @enum {string}
     */
    MassSource: "solid" | "capped" | "union" | "surface";
    /**
     * @description The standard quality measures besides ε, after Roa & Suárez, "Grasp quality measures: review and
     *     performance" (Autonomous Robots 38, 2015). Torques are scaled by the torque scale λ.
     *
     *     No measure changes when the body is moved or turned together with its contacts, or when the contacts are
     *     renumbered. When the body is scaled and λ = 1/radius, only lengths and areas change.
     */
    Measures: {
      /**
       * Format: double
       * @description Distance from the mean of the contacts' positions to the centre of mass, in the mesh's unit, from 0;
       *     less is better, because gravity and inertia then load the fingers less. Ponce et al. 1997.
       */
      centroid_distance: number;
      /**
       * Format: double
       * @description √det(G·Gᵀ), the product of the singular values of G: proportional to the volume of the ellipsoid of
       *     wrenches that contact forces of unit length, taken together, exert. No unit, from 0; greater is
       *     better. Li & Sastry 1988.
       */
      ellipsoid_volume: number;
      /**
       * @description Whether `epsilon_l1` and `epsilon_linf` are exact to 1e-6 of themselves. `false` when one of them is only a lower
       *     bound, because the facet limit ended its hull: for many contacts, above all with round cones and in L∞. Absent
       *     without force closure.
       */
      epsilon_exact?: boolean | null;
      /**
       * Format: double
       * @description ε in the L1 space: radius of the largest origin-centred ball in the convex hull of the contacts'
       *     wrenches, min over unit u of max over contacts i of h_i(u). In the unit of the cone's edges, from 0
       *     to √(1+(λr)²) for contacts within r of the centre of mass and unit edges; greater is better. A lower
       *     bound where the cone is round. Absent without force closure. Ferrari & Canny 1992.
       */
      epsilon_l1?: number | null;
      /**
       * Format: double
       * @description ε in the L∞ space: the same of the Minkowski sum, min over unit u of the sum of max(0, h_i(u)).
       *     At least the L1 value, at most that times the number of contacts. Ferrari & Canny 1992.
       */
      epsilon_linf?: number | null;
      /**
       * Format: double
       * @description Grasp isotropy index σ_min/σ_max of G. No unit, 0 (singular) to 1 (contact forces count the same in
       *     every direction). Kim et al. 2001.
       */
      isotropy: number;
      /**
       * Format: double
       * @description Area of the polygon of the contacts, projected on the plane that fits them best, in the mesh's
       *     unit squared; greater is better. Absent where there is no polygon. Mirtich & Canny 1994.
       */
      polygon_area?: number | null;
      /**
       * Format: double
       * @description Sum of the deviations of that polygon's m inner angles from the regular polygon's, θ̄ = π(m−2)/m, over
       *     the greatest that is possible, (m−2)(π−θ̄) + 2θ̄: 0 (regular) to 1 (squeezed to a line); less is
       *     better. Absent where there is no polygon. Park & Starr 1992, Kim et al. 2001.
       */
      polygon_shape?: number | null;
      /**
       * Format: double
       * @description σ_min of the grasp matrix G (6 rows; a column for each force and torque component that a
       *     contact transmits): the length of the shortest wrench that contact forces of unit length, taken
       *     together, exert. No unit, from 0, where some wrench cannot be exerted even by fingers that pull;
       *     greater is better. Li & Sastry 1988.
       */
      smallest_singular_value: number;
      /**
       * Format: double
       * @description Volume of the convex hull of the contacts' wrenches (L1), in the sixth power of their unit, from 0;
       *     greater is better. Zero when they span fewer than 6 dimensions; positive also without force closure.
       *     For a round cone, the volume with an inscribed pyramid of 16 edges. Absent when the hull is too large
       *     to finish. Miller & Allen 1999.
       */
      volume_l1?: number | null;
    };
    MeshForm: {
      mesh: components["schemas"]["Binary"];
    };
    /**
     * @description A supported file format.
     * @enum {string}
     */
    MeshFormat: "stl" | "obj" | "ply" | "off" | "glb" | "gltf" | "3mf" | "dae";
    /** @description One page of meshes, newest first. */
    MeshPage: {
      meshes: components["schemas"]["MeshRecord"][];
      /** @description Where the next page starts; absent on the last one. */
      next_cursor?: string;
    };
    /** @description A mesh that the service keeps. */
    MeshRecord: {
      /**
       * Format: int64
       * @description Size of the file in bytes.
       */
      bytes: number;
      /**
       * Format: date-time
       * @description When it was first uploaded.
       */
      created_at: string;
      /** @description The file name that the client sent. */
      file_name?: string;
      format: components["schemas"]["MeshFormat"];
      /** @description Derived from the bytes, the format, the unit and the scale; the same file has the same id. */
      id: string;
      /** @description The report on the mesh, as it was written when the mesh was uploaded. */
      report: components["schemas"]["MeshReport"];
      /**
       * Format: double
       * @description Factor by which the coordinates of the file were multiplied.
       */
      scale: number;
      /** @description The unit of the coordinates, if the upload named it. */
      units?: components["schemas"]["Units"];
    };
    /**
     * @description The findings of the preparation of a mesh and the repairs that it made. Lengths are in the mesh's own
     *     unit.
     */
    MeshReport: {
      /**
       * Format: double
       * @description Area of the whole surface, with walls of cavities and with what is buried in matter.
       */
      area: number;
      /**
       * Format: double
       * @description 95th over 5th percentile of the candidates' triangle areas; 1 is perfectly even.
       */
      area_ratio: number;
      /**
       * @description These bodies, in the order in which the file begins them; the first
       *     100 where there are more. Empty when the mesh is one body.
       */
      bodies?: components["schemas"]["Body"][];
      /** @description Number of bodies that do not touch each other. */
      body_count?: number;
      /** @description Edges with a triangle on one side only. */
      border_edges: number;
      /**
       * Format: double
       * @description Greatest distance of a vertex from the centre of mass.
       */
      bounding_radius: number;
      /** @description Lowest and highest corner of the axis-aligned bounding box. */
      bounds: number[][];
      /**
       * @description Triangles that are no candidates because their centroids lie in matter, such as the walls between solids that
       *     touch or overlap.
       */
      buried_triangles?: number;
      /** @description Triangles that are not degenerate, buried or enclosed: the places where a finger may be put. */
      candidates: number;
      /**
       * Format: double
       * @description The same for the distance of the centre of mass from the right one, in the mesh's unit.
       */
      center_bound?: number;
      /** @description Centre of mass of the solid or of the shell (see `mass_from`), in the mesh's frame. */
      center_of_mass: number[];
      /**
       * @description Separate pieces of the surface, connected over edges; the wall of a cavity is a piece, and so is each of two
       *     solids that touch.
       */
      components: number;
      /** @description Triangles that were dropped or cannot be used because their area is zero. */
      degenerate_triangles: number;
      /** @description Triangles that were dropped because the same triangle is there already. */
      duplicate_triangles?: number;
      /** @description Triangles that are no candidates because they lie in a sealed cavity, which no finger can reach. */
      enclosed_triangles?: number;
      /** @description Triangles whose winding was reversed so that all normals point the same way, outward. */
      flipped_triangles: number;
      /** @description Closed lines along which the surface is open. */
      holes?: number;
      /** @description What centre of mass and volume were computed from. */
      mass_from: components["schemas"]["MassSource"];
      /** @description Edges with more than two triangles, or with two that no winding can make consistent. */
      non_manifold_edges: number;
      /** @description Closed pieces that have matter in common with another. */
      overlapping_parts?: number;
      /** @description Triangles that are used: those that welding did not collapse. */
      triangles: number;
      /** @description Triangles in the file, after polygons were cut. */
      triangles_read: number;
      /** @description Whether there are too many pieces to look for those that overlap; then none is taken to do so. */
      unexamined?: boolean;
      /** @description Those of the non-manifold edges at which triangles could not be paired into closed pieces. */
      unresolved_edges?: number;
      /** @description Triangles of open pieces for which nothing confirms which side is outside; their normals are taken on trust. */
      unverified_normals?: number;
      /** @description Vertices after welding, without unused ones. */
      vertices: number;
      /** @description Vertices in the file; three per triangle in STL. */
      vertices_read: number;
      /**
       * Format: double
       * @description Enclosed volume, with holes capped where `mass_from` says so; absent for a shell.
       */
      volume?: number;
      /**
       * Format: double
       * @description Greatest error of the volume, relative to it, that cutting out the union of solids may have caused; absent
       *     unless `mass_from` is `union`.
       */
      volume_bound?: number;
      /**
       * Format: double
       * @description Greatest difference between the volumes by the flux through the surface along x, y and z and the
       *     volume, relative to the volume: about 1e-15 when the surface is closed and consistently wound.
       */
      volume_error?: number;
      /** @description Reasons not to trust a grasp of this mesh as it is. */
      warnings?: components["schemas"]["MeshWarning"][];
      /**
       * @description Whether the surface is closed: every edge has exactly two triangles, consistently wound.
       *
       *     A mesh that is not watertight may still have the mass of a solid, such as two boxes that share an edge.
       */
      watertight: boolean;
    };
    /** @description A property of a mesh that may make a grasp of it worth less than it seems. */
    MeshWarning: {
      /** @description What was found and what to do. */
      detail: string;
      kind: components["schemas"]["WarningKind"];
    };
    /**
     * @description Which search improves the first grasp.
     * @enum {string}
     */
    Method: "memetic" | "modified_ga" | "local" | "random";
    /**
     * @description The kind of a motion.
     * @enum {string}
     */
    MotionKind: "translation" | "rotation" | "screw";
    /** @description Why a grasp is not force closure. */
    Obstacle: {
      /** @description The obstacle in plain words. */
      detail: string;
      /**
       * Format: double
       * @description Distance of the origin from the wrench space, in the unit of `margin`, to 1e-6 of itself. It is at least minus
       *     the `margin`, which is the offset of one facet.
       */
      distance?: number | null;
      motion?: components["schemas"]["FreeMotion"] | null;
      /**
       * Format: int32
       * @description Number of dimensions that the wrenches span, if fewer than 6.
       */
      rank?: number | null;
      reason: components["schemas"]["ObstacleReason"];
    };
    /**
     * @description The kind of the obstacle to force closure.
     * @enum {string}
     */
    ObstacleReason: "rank_deficient" | "origin_outside";
    /**
     * @description What a run is doing.
     * @enum {string}
     */
    Phase: "preparing" | "initial" | "search" | "analysis";
    /** @description A planning request with every default filled in and the seed fixed: the effective settings that are stored with the job and enough to repeat the run. */
    PlanRequest: {
      /**
       * Format: uri
       * @description Where the server posts a signed message once the job has ended. It is an https URL on a host that the operator of the server allows. Default: nowhere.
       * @example https://hooks.example.com/grasps
       */
      callback_url?: string;
      /** @description The places that are searched. The result says which in `candidates_from`. Default: triangles, but uniform for memetic where the triangles are fewer than 1000 or their areas vary by more than a factor of 4 (95th over 5th percentile). */
      candidates?: components["schemas"]["CandidateSettings"];
      /**
       * @description The point that torques are taken about, in the mesh's frame. In the mesh's unit. Default: the mesh's own centre of mass.
       * @example [
       *       0,
       *       0,
       *       0
       *     ]
       */
      center_of_mass?: number[];
      /** @description Which of the bodies in the mesh is grasped. The report of the mesh lists them. The others are left out: the centre of mass, radius and candidates are its own. `all` takes them all as one rigid body. Default: the body, of which there must be one. */
      component?: components["schemas"]["Component"];
      /**
       * Format: int32
       * @description Edges of the pyramid that replaces the friction cone. 0 keeps the round cone itself; absent when frictionless. Default: 8.
       * @example 8
       */
      cone_edges?: number;
      /** @description Where contacts may be, how far apart they are, how fingers approach, and contacts that are given. Default: contacts anywhere. */
      constraints?: components["schemas"]["Constraints"];
      /** @description How a finger touches the body. Default: hard, or frictionless when friction is 0. */
      contact_model: components["schemas"]["ContactModel"];
      /**
       * Format: int32
       * @description Number of contacts, fixed ones included. Default: 4 with friction, 7 without.
       * @example 4
       */
      contacts: number;
      /**
       * Format: double
       * @description Probability that two parents are crossed. Default: 0.7 for memetic, else 0.9.
       * @example 0.9
       */
      crossover_probability: number;
      /** @description How long the edges of the friction cone are. It only changes the scale of the quality. Default: unit_edge. */
      edge_norm: components["schemas"]["EdgeNorm"];
      /**
       * Format: int32
       * @description Best individuals carried over unchanged, fewer than the population. Only `modified_ga` uses it. Default: 1.
       * @example 1
       */
      elitism: number;
      /**
       * @description Whether contacts may be where no finger gets: in sealed cavities, and on walls that are buried between solids. Default: false.
       * @example true
       */
      enclosed?: boolean;
      /**
       * Format: int64
       * @description Stop after this many quality evaluations. Default: no limit.
       * @example 1000000
       */
      evaluation_limit?: number;
      /**
       * Format: double
       * @description Coulomb's coefficient of friction. The same for all contacts; 0 asks for frictionless contacts, and an effective request without friction does not have it. Default: 0.5.
       * @example 0.5
       */
      friction?: number;
      /**
       * Format: int32
       * @description Generations after the first population. With `memetic`, each individual reaches an optimum once a generation. The population times (generations + 1) may be at most 1,000,000,000. Default: 25 for memetic, else 100.
       * @example 100
       */
      generations: number;
      /**
       * @description Compute the quality against a force in this direction at the centre of mass. Default: not computed.
       * @example [
       *       0,
       *       0,
       *       -1
       *     ]
       */
      gravity?: number[];
      /** @description Compute where each finger may be while the others stay. Default: not computed. */
      independent_regions?: components["schemas"]["RegionSettings"];
      /** @description Which candidates may complete the first force-closure grasp. `random` starts from no grasp. Default: weak for memetic, else strict, as in the paper. */
      initial: components["schemas"]["InitialMode"];
      /**
       * @description A name by which people recognise the job, up to 200 characters. Default: none.
       * @example duck, four fingers
       */
      label?: string;
      /** @description Which search looks for the best grasp. Default: memetic. */
      method: components["schemas"]["Method"];
      /**
       * Format: double
       * @description Probability that a child is mutated. Default: 0.2.
       * @example 0.2
       */
      mutation_probability: number;
      /** @description Whether the contacts of the best grasp slide over the surface to where the quality is greater still. They slide within triangles and across edges; otherwise contacts are centroids, as in the paper. Default: true for memetic, else false. */
      polish: boolean;
      /**
       * Format: int32
       * @description Individuals per generation. For `memetic`, grasps that climb side by side. Default: 8 for memetic, else 200.
       * @example 200
       */
      population: number;
      /** @description Whether the job goes before others in the queue. Default: interactive. */
      priority: components["schemas"]["Priority"];
      /** @description Compute how robust the grasp is against fingers that miss their places. Default: not computed. */
      robustness?: components["schemas"]["RobustnessSettings"];
      /**
       * Format: int64
       * @description Fixes every random choice. The same mesh, request and seed give the same result. Default: a random number below 2^53.
       * @example 7
       */
      seed: number;
      /**
       * Format: double
       * @description Stop once this quality is reached. Default: never.
       * @example 0.2
       */
      target_quality?: number;
      /**
       * @description Compute the quality against these disturbances. Each is a force and a torque about the centre of mass, in the mesh's frame, in any unit of force and that times the mesh's unit of length. Only their directions matter, once torques are scaled. Default: none.
       * @example [
       *       [
       *         0,
       *         0,
       *         -1,
       *         0,
       *         0,
       *         0
       *       ]
       *     ]
       */
      task_wrenches?: number[][];
      /**
       * Format: double
       * @description Stop searching after this time. The analyses of the grasp may take as long again. In seconds. Default: only the server's own limit.
       * @example 60
       */
      time_limit_s?: number;
      /**
       * Format: int32
       * @description How many distinct grasps to return, the best included. There may be fewer. Default: 1.
       * @example 1
       */
      top: number;
      /** @description The factor (1/length) that makes torques comparable with forces. Default: max_radius. */
      torque_scale: components["schemas"]["TorqueScale"];
      /**
       * Format: double
       * @description Torsional friction of a soft finger, the greatest torque about the normal over the normal force. Only soft contacts have it. In the mesh's unit. Default: a twentieth of the greatest distance of a vertex from the centre of mass.
       * @example 0.01
       */
      torsional_friction?: number;
      /**
       * Format: int32
       * @description Repeat the run with the seeds seed, seed + 1, ... and add statistics over them to the best result. Default: 1.
       * @example 1
       */
      trials: number;
      /** @description The unit of the mesh's coordinates. It is echoed and used to doubt sizes, never to rescale. Default: that of the mesh, where its upload named one. */
      units?: components["schemas"]["Units"];
      /** @description How the wrenches of the contacts add up. Default: l1. */
      wrench_space: components["schemas"]["WrenchSpace"];
    };
    /** @description What to plan. Every field is optional. */
    PlanRequestInput: {
      /**
       * Format: uri
       * @description Where the server posts a signed message once the job has ended. It is an https URL on a host that the operator of the server allows. Default: nowhere.
       * @example https://hooks.example.com/grasps
       */
      callback_url?: string;
      /** @description The places that are searched. The result says which in `candidates_from`. Default: triangles, but uniform for memetic where the triangles are fewer than 1000 or their areas vary by more than a factor of 4 (95th over 5th percentile). */
      candidates?: components["schemas"]["CandidateSettings"];
      /**
       * @description The point that torques are taken about, in the mesh's frame. In the mesh's unit. Default: the mesh's own centre of mass.
       * @example [
       *       0,
       *       0,
       *       0
       *     ]
       */
      center_of_mass?: number[];
      /** @description Which of the bodies in the mesh is grasped. The report of the mesh lists them. The others are left out: the centre of mass, radius and candidates are its own. `all` takes them all as one rigid body. Default: the body, of which there must be one. */
      component?: components["schemas"]["Component"];
      /**
       * Format: int32
       * @description Edges of the pyramid that replaces the friction cone. 0 keeps the round cone itself; absent when frictionless. Default: 8.
       * @example 8
       */
      cone_edges?: number;
      /** @description Where contacts may be, how far apart they are, how fingers approach, and contacts that are given. Default: contacts anywhere. */
      constraints?: components["schemas"]["Constraints"];
      /** @description How a finger touches the body. Default: hard, or frictionless when friction is 0. */
      contact_model?: components["schemas"]["ContactModel"];
      /**
       * Format: int32
       * @description Number of contacts, fixed ones included. Default: 4 with friction, 7 without.
       * @example 4
       */
      contacts?: number;
      /**
       * Format: double
       * @description Probability that two parents are crossed. Default: 0.7 for memetic, else 0.9.
       * @example 0.9
       */
      crossover_probability?: number;
      /** @description How long the edges of the friction cone are. It only changes the scale of the quality. Default: unit_edge. */
      edge_norm?: components["schemas"]["EdgeNorm"];
      /**
       * Format: int32
       * @description Best individuals carried over unchanged, fewer than the population. Only `modified_ga` uses it. Default: 1.
       * @example 1
       */
      elitism?: number;
      /**
       * @description Whether contacts may be where no finger gets: in sealed cavities, and on walls that are buried between solids. Default: false.
       * @example true
       */
      enclosed?: boolean;
      /**
       * Format: int64
       * @description Stop after this many quality evaluations. Default: no limit.
       * @example 1000000
       */
      evaluation_limit?: number;
      /**
       * Format: double
       * @description Coulomb's coefficient of friction. The same for all contacts; 0 asks for frictionless contacts, and an effective request without friction does not have it. Default: 0.5.
       * @example 0.5
       */
      friction?: number;
      /**
       * Format: int32
       * @description Generations after the first population. With `memetic`, each individual reaches an optimum once a generation. The population times (generations + 1) may be at most 1,000,000,000. Default: 25 for memetic, else 100.
       * @example 100
       */
      generations?: number;
      /**
       * @description Compute the quality against a force in this direction at the centre of mass. Default: not computed.
       * @example [
       *       0,
       *       0,
       *       -1
       *     ]
       */
      gravity?: number[];
      /** @description Compute where each finger may be while the others stay. Default: not computed. */
      independent_regions?: components["schemas"]["RegionSettings"];
      /** @description Which candidates may complete the first force-closure grasp. `random` starts from no grasp. Default: weak for memetic, else strict, as in the paper. */
      initial?: components["schemas"]["InitialMode"];
      /**
       * @description A name by which people recognise the job, up to 200 characters. Default: none.
       * @example duck, four fingers
       */
      label?: string;
      /** @description Which search looks for the best grasp. Default: memetic. */
      method?: components["schemas"]["Method"];
      /**
       * Format: double
       * @description Probability that a child is mutated. Default: 0.2.
       * @example 0.2
       */
      mutation_probability?: number;
      /** @description Whether the contacts of the best grasp slide over the surface to where the quality is greater still. They slide within triangles and across edges; otherwise contacts are centroids, as in the paper. Default: true for memetic, else false. */
      polish?: boolean;
      /**
       * Format: int32
       * @description Individuals per generation. For `memetic`, grasps that climb side by side. Default: 8 for memetic, else 200.
       * @example 200
       */
      population?: number;
      /** @description Whether the job goes before others in the queue. Default: interactive. */
      priority?: components["schemas"]["Priority"];
      /** @description Compute how robust the grasp is against fingers that miss their places. Default: not computed. */
      robustness?: components["schemas"]["RobustnessSettings"];
      /**
       * Format: int64
       * @description Fixes every random choice. The same mesh, request and seed give the same result. Default: a random number below 2^53.
       * @example 7
       */
      seed?: number;
      /**
       * Format: double
       * @description Stop once this quality is reached. Default: never.
       * @example 0.2
       */
      target_quality?: number;
      /**
       * @description Compute the quality against these disturbances. Each is a force and a torque about the centre of mass, in the mesh's frame, in any unit of force and that times the mesh's unit of length. Only their directions matter, once torques are scaled. Default: none.
       * @example [
       *       [
       *         0,
       *         0,
       *         -1,
       *         0,
       *         0,
       *         0
       *       ]
       *     ]
       */
      task_wrenches?: number[][];
      /**
       * Format: double
       * @description Stop searching after this time. The analyses of the grasp may take as long again. In seconds. Default: only the server's own limit.
       * @example 60
       */
      time_limit_s?: number;
      /**
       * Format: int32
       * @description How many distinct grasps to return, the best included. There may be fewer. Default: 1.
       * @example 1
       */
      top?: number;
      /** @description The factor (1/length) that makes torques comparable with forces. Default: max_radius. */
      torque_scale?: components["schemas"]["TorqueScale"];
      /**
       * Format: double
       * @description Torsional friction of a soft finger, the greatest torque about the normal over the normal force. Only soft contacts have it. In the mesh's unit. Default: a twentieth of the greatest distance of a vertex from the centre of mass.
       * @example 0.01
       */
      torsional_friction?: number;
      /**
       * Format: int32
       * @description Repeat the run with the seeds seed, seed + 1, ... and add statistics over them to the best result. Default: 1.
       * @example 1
       */
      trials?: number;
      /** @description The unit of the mesh's coordinates. It is echoed and used to doubt sizes, never to rescale. Default: that of the mesh, where its upload named one. */
      units?: components["schemas"]["Units"];
      /** @description How the wrenches of the contacts add up. Default: l1. */
      wrench_space?: components["schemas"]["WrenchSpace"];
    };
    /**
     * @description The result of a planning run, with every number that the quality depends on.
     *
     *     The same mesh, request and seed give the same bytes, except for the elapsed times.
     */
    PlanResult: {
      /**
       * @description [lower, upper]: a certified interval on the ε that the same contacts have with the round
       *     friction cone itself. Absent without force closure and, like `measures` and the forces of contacts,
       *     when a run of many wrenches was cancelled.
       */
      bounds?: number[] | null;
      /**
       * @description Whether `bounds` differ by at most 1e-6 of the upper one. `false` when the facet limit ended the interval earlier; it
       *     is certified all the same.
       */
      bounds_exact?: boolean | null;
      /**
       * Format: int64
       * @description Number n of places on the surface that were searched: those that the constraints leave.
       */
      candidates: number;
      candidates_from?: components["schemas"]["CandidateSource"] | null;
      /** @description The point torques are taken about. */
      center_of_mass: number[];
      /**
       * Format: int32
       * @description Edges of the pyramid that replaces the friction cone; 0 is the round cone.
       */
      cone_edges?: number | null;
      /**
       * @description The number of candidates that each rule of the constraints removed, of those that the rules before it
       *     left: one entry for each rule that decides about single places, in the order of application. Absent
       *     without constraints.
       */
      constraints?: components["schemas"]["RuleReport"][] | null;
      contact_model: components["schemas"]["ContactModel"];
      /**
       * @description The contacts of the best grasp, fixed ones first; without force closure, those of the best of the
       *     random grasps that were tried first. Empty when the run was stopped before these, or when all of them
       *     are degenerate.
       */
      contacts: components["schemas"]["ContactPoint"][];
      edge_norm: components["schemas"]["EdgeNorm"];
      /**
       * Format: double
       * @description Seconds that planning took, without reading the mesh.
       */
      elapsed_s: number;
      /**
       * Format: int64
       * @description Quality evaluations made.
       */
      evaluations: number;
      /**
       * @description Whether `margin`, and with it `quality`, is exact to rounding or, where the wrench space is no
       *     polytope (round cones, L∞), to 1e-6 of itself; `quality` is then the certified lower end. False for
       *     grasps with so many wrenches that their hull could not be finished; `quality` is then a lower
       *     bound.
       */
      exact?: boolean | null;
      explanation?: components["schemas"]["Explanation"] | null;
      /** @description Whether `contacts` hold the body against every small force and torque. */
      force_closure: boolean;
      /**
       * @description The frame of positions, normals and torques: `mesh`, that of the uploaded file.
       * @example mesh
       */
      frame: string;
      /**
       * Format: double
       * @description Coefficient of friction μ.
       */
      friction?: number | null;
      /**
       * Format: double
       * @description Quality against a force along the gravity of the request, at the centre of mass: the largest such
       *     force that is resisted, in the unit of ε.
       */
      gravity_quality?: number | null;
      /**
       * @description State of the population after each generation. Entry 0 is the initial population; the last may be a
       *     generation in which the search was stopped. Of more than 1,000 generations, 1,000 are listed, evenly
       *     spread.
       */
      history: components["schemas"]["HistoryEntry"][];
      /**
       * @description Where each finger may be while the others stay, in the order of the contacts, if it was requested.
       *     Absent without force closure.
       */
      independent_regions?: components["schemas"]["IndependentRegion"][] | null;
      initial?: components["schemas"]["InitialGrasp"] | null;
      /**
       * Format: double
       * @description Signed distance from the origin to the nearest facet of that hull: ε when positive; zero or
       *     negative when the origin is outside. Absent when the wrenches span fewer than 6 dimensions.
       */
      margin?: number | null;
      measures?: components["schemas"]["Measures"] | null;
      /** @description Warnings about the mesh without which the result should not be believed. */
      mesh_warnings?: components["schemas"]["MeshWarning"][];
      method: components["schemas"]["Method"];
      polish?: components["schemas"]["Polish"] | null;
      /**
       * Format: double
       * @description The quality ε: radius of the largest origin-centred ball in the convex hull of the
       *     contacts' wrenches (Ferrari & Canny 1992). Absent without force closure.
       * @example 0.069
       */
      quality?: number | null;
      /**
       * @description Whether the same request gives the same result again. False when a time limit or a cancellation ended
       *     the run; a request with `evaluations` as its `evaluation_limit` then comes closest.
       */
      reproducible?: boolean;
      robustness?: components["schemas"]["Robustness"] | null;
      /** Format: int64 */
      seed: number;
      /**
       * @description Whether it is proven that moving one finger to any other candidate of the mesh does not improve the
       *     quality (before any polish) by more than one part in a million, or one in a thousand where cones are
       *     round or the space is L∞. Only `memetic` proves that.
       */
      single_exchange_optimal?: boolean;
      stopped_because: components["schemas"]["StoppedBecause"];
      task_quality?: components["schemas"]["TaskQuality"] | null;
      /** @description Distinct grasps, the best first, if more than one was requested. */
      top?: components["schemas"]["TopGrasp"][] | null;
      /** @description The factor that made torques comparable with forces. */
      torque_scale: components["schemas"]["TorqueScaleValue"];
      /**
       * Format: double
       * @description Torsional friction μ_t of soft contacts, a length in the mesh's unit.
       */
      torsional_friction?: number | null;
      trials?: components["schemas"]["Trials"] | null;
      units?: components["schemas"]["Units"] | null;
      /**
       * @description Version of graspd that made this result.
       * @example 0.1.0
       */
      version: string;
      weakest_wrench?: components["schemas"]["WeakestWrench"] | null;
      wrench_space?: components["schemas"]["WrenchSpace"];
    };
    /** @description How the contacts of the best grasp slid over the surface to where it is better. */
    Polish: {
      /** Format: int64 */
      evaluations: number;
      /**
       * Format: double
       * @description The increase of ε by the sliding; never negative.
       */
      gain: number;
      /**
       * Format: double
       * @description ε with every contact at the centroid of its triangle.
       */
      quality_before: number;
    };
    /**
     * @description The class of a job in the queue. `interactive` jobs go first, but while both wait every fourth turn is a
     *     `batch` job's, so that neither class waits for ever.
     * @enum {string}
     */
    Priority: "interactive" | "batch";
    /** @description Why a request or a job failed, and what to do about it (`application/problem+json`). */
    Problem: {
      /** @description The fault in this case and what to do about it. */
      detail: string;
      /** @description The first 20 fields at fault, when fields are. */
      errors?: components["schemas"]["FieldError"][];
      /**
       * Format: int32
       * @description HTTP status code.
       */
      status: number;
      /** @description The kind in a few words. */
      title: string;
      /** @description Stable name of the kind of problem, a URI reference such as `/problems/invalid-request`. */
      type: string;
    };
    /** @description The progress of a run. */
    Progress: {
      /**
       * @description The contacts of the best grasp while the job runs: the fixed ones first, the others in an order that
       *     may change. Once the job has ended, the result has the contacts.
       */
      best_contacts?: components["schemas"]["ProgressContact"][];
      /**
       * Format: double
       * @description Best quality ε so far; null until a force-closure grasp is known.
       */
      best_quality?: number | null;
      /**
       * Format: double
       * @description Seconds since the run started.
       */
      elapsed_s: number;
      /**
       * Format: int64
       * @description Quality evaluations so far.
       */
      evaluations: number;
      /**
       * Format: int64
       * @description Generations completed, in all trials together.
       */
      generation: number;
      /**
       * Format: int64
       * @description Generations requested, in all trials together.
       */
      generations: number;
      phase: components["schemas"]["Phase"];
    };
    /** @description A finger tip on the surface. */
    ProgressContact: {
      /** @description Unit normal pointing into the body. */
      normal: number[];
      /** @description Position in the mesh's frame and unit. */
      position: number[];
    };
    /**
     * @description The kind of the obstacle to force closure.
     * @enum {string}
     */
    Reason:
      | "too_few_contacts"
      | "rank_deficient"
      | "one_sided"
      | "constraints"
      | "exhausted"
      | "none_found"
      | "stopped";
    Region:
      | {
          /** @description Inside an axis-aligned box. */
          box: components["schemas"]["Corners"];
        }
      | {
          /** @description On the side of the plane through `point` that `normal` points to. */
          half_space: components["schemas"]["HalfSpace"];
        }
      | {
          /** @description Inside a sphere. */
          sphere: components["schemas"]["Sphere"];
        }
      | {
          /** @description On these triangles, counted from 0 in the order of the uploaded file; all regions together may name 100,000. */
          triangles: number[];
        };
    /** @description What a grasp has to keep within its independent regions. */
    RegionSettings: {
      /**
       * Format: double
       * @description Share of the quality ε that has to be kept. Default: 0.5.
       * @example 0.5
       */
      fraction: number;
    };
    /** @description Contact forces against one external wrench. */
    Resistance: {
      /**
       * Format: double
       * @description The least sum of normal forces that resists it, in the unit of the external force.
       */
      effort?: number | null;
      /** @description The force of each finger, in the order of the contacts. */
      forces?: number[][] | null;
      /**
       * @description Whether the grasp can resist it, with forces of at most 10^7 times its size, torques measured over the longest lever
       *     arm. A grasp that is force closure resists everything.
       */
      resisted: boolean;
      /** @description The torque of each finger about its inward normal, for soft contacts. */
      torsions?: number[] | null;
    };
    /**
     * @description The quality of a grasp to expect when its fingers miss their places (Weisz & Allen 2012).
     *
     *     Each contact is displaced by a normal distribution in its tangent plane and put back on the surface, with
     *     the normal there, on an edge that of the face which leans least from the contact's own; a free contact stays in the plane and keeps its normal. The same seed gives the same
     *     numbers.
     */
    Robustness: {
      /**
       * Format: double
       * @description Mean quality ε of the scattered grasps, zero for those that are not force closure.
       */
      expected: number;
      /**
       * Format: double
       * @description Share of the scattered grasps that are force closure.
       */
      force_closure_probability: number;
      /**
       * Format: double
       * @description The ε that 5 of 100 scattered grasps fall short of, interpolated between the two nearest.
       */
      percentile_5: number;
      /**
       * Format: int32
       * @description Number of scattered grasps.
       */
      samples: number;
      /**
       * Format: int64
       * @description The seed of the displacements.
       */
      seed: number;
      /**
       * Format: double
       * @description Standard deviation of either component of a displacement, in the mesh's unit.
       */
      sigma: number;
    };
    /** @description How the contacts of a grasp are scattered to see how robust it is. */
    RobustnessSettings: {
      /**
       * Format: int32
       * @description How many scattered grasps are evaluated. Default: 200.
       * @example 200
       */
      samples: number;
      /**
       * Format: int64
       * @description Fixes the displacements. Default: 0.
       * @example 0
       */
      seed: number;
      /**
       * Format: double
       * @description Standard deviation of either component of a displacement in the tangent plane. At most the size of the mesh. In the mesh's unit.
       * @example 0.5
       */
      sigma: number;
    };
    /** @description The number of candidates that a rule of the constraints removed, of those that the rules before it left. */
    RuleReport: {
      /**
       * Format: int64
       * @description Candidates it removed.
       */
      removed: number;
      /**
       * @description The member of the constraints that sets the rule, one region of `exclude` by its index. Distances
       *     remove places too near to a fixed contact or too far from one; `fixed_contacts` those that a fixed
       *     contact takes.
       * @example exclude[0]
       */
      rule: string;
    };
    /** @description A solid sphere. */
    Sphere: {
      /** @description Its centre. */
      center: number[];
      /**
       * Format: double
       * @description Its radius.
       */
      radius: number;
    };
    /** @description Statistics of at least one number. */
    Statistics: {
      /** Format: double */
      max: number;
      /** Format: double */
      mean: number;
      /** Format: double */
      min: number;
      /**
       * Format: double
       * @description Standard deviation of the sample (n − 1); zero for a single number.
       */
      sd: number;
    };
    /**
     * @description Why a search ended.
     * @enum {string}
     */
    StoppedBecause:
      | "generation_limit"
      | "local_optimum"
      | "evaluation_limit"
      | "target_quality"
      | "time_limit"
      | "cancelled"
      | "impossible"
      | "infeasible";
    /** @description Quality for a task (Li & Sastry 1988; Roa & Suárez 2015): how much of each disturbance the grasp resists. */
    TaskQuality: {
      /**
       * Format: double
       * @description The least of them.
       */
      least: number;
      /**
       * @description For each task wrench t, torque scaled, the largest s with −s·t/‖t‖ in the grasp wrench space: in the
       *     unit of ε, never below it; zero when t is not resisted at all.
       */
      per_wrench: number[];
      /**
       * Format: int32
       * @description Which task wrench that is, counted from 0; the first of equals.
       */
      weakest: number;
    };
    /**
     * @description One of several distinct grasps. The Hausdorff distance of any two of them, the greatest distance of a
     *     contact of one, fixed ones included, from the nearest contact of the other, is at least a twentieth of the mesh's bounding radius.
     */
    TopGrasp: {
      contacts: components["schemas"]["ContactPoint"][];
      /**
       * Format: double
       * @description Hausdorff distance from the best grasp, in the mesh's unit.
       */
      distance_to_best: number;
      /**
       * Format: double
       * @description The quality ε. Only the first grasp is polished.
       */
      quality: number;
    };
    /** @description The factor (1/length) that makes torques comparable with forces. `max_radius`: one over the greatest distance of a vertex from the point torques are taken about. `none`: 1. A number: itself. */
    TorqueScale: ("max_radius" | "none") | number;
    /** @description The torque scale λ. */
    TorqueScaleValue: {
      /**
       * @description How it was chosen: `max_radius`, `none` or `custom`.
       * @example max_radius
       */
      kind: string;
      /**
       * Format: double
       * @description Its value, 1/length.
       */
      value: number;
    };
    /** @description The outcome of one trial. */
    Trial: {
      /** Format: double */
      elapsed_s: number;
      /** Format: int64 */
      evaluations: number;
      /**
       * Format: double
       * @description Quality ε of the first grasp.
       */
      initial?: number | null;
      /**
       * Format: double
       * @description Quality ε of the best grasp.
       */
      last?: number | null;
      /** Format: int64 */
      seed: number;
      stopped_because: components["schemas"]["StoppedBecause"];
    };
    /** @description The trials of a run, which differ in their seeds only, with statistics over them. */
    Trials: {
      /**
       * Format: int32
       * @description Trials that were run; fewer than requested when time ran out or the job was cancelled.
       */
      count: number;
      elapsed_s?: components["schemas"]["Statistics"] | null;
      evaluations?: components["schemas"]["Statistics"] | null;
      /**
       * Format: int32
       * @description How many of them found a force-closure grasp.
       */
      force_closures: number;
      initial?: components["schemas"]["Statistics"] | null;
      last?: components["schemas"]["Statistics"] | null;
      ratio?: components["schemas"]["Statistics"] | null;
      runs: components["schemas"]["Trial"][];
    };
    /**
     * @description The unit of a mesh's coordinates.
     * @enum {string}
     */
    Units: "m" | "cm" | "mm" | "um" | "in" | "ft";
    /**
     * @description The subject of a warning.
     * @enum {string}
     */
    WarningKind:
      | "open"
      | "non_manifold"
      | "mass"
      | "uneven_triangles"
      | "duplicates"
      | "degenerate"
      | "file"
      | "precision"
      | "overlap"
      | "enclosed"
      | "several_bodies"
      | "unverified_normals"
      | "size";
    /**
     * @description The unit wrench (force; scaled torque) along which a grasp can exert less than along any other.
     *
     *     The grasp exerts at most `margin` along it with contact forces that sum to one, so a disturbance
     *     in the opposite direction is the hardest to resist.
     */
    WeakestWrench: {
      /** @description The same in plain words. */
      description: string;
      force: number[];
      /** @description Torque about the centre of mass times the torque scale. */
      torque: number[];
    };
    /** @description A job without its result, and where that is. */
    WebhookData: components["schemas"]["JobRecord"] & {
      /** @description Path of the result on the server, if there is one. */
      result_url?: string;
    };
    /**
     * @description What is posted to a callback URL (Standard Webhooks) when the job has ended. The same job always
     *     has the same message, under the same `webhook-id`.
     */
    WebhookEvent: {
      data: components["schemas"]["WebhookData"];
      /**
       * Format: date-time
       * @description When the job ended.
       */
      timestamp: string;
      /** @description `job.succeeded`, `job.failed` or `job.cancelled`. */
      type: string;
    };
    /**
     * @description How the wrenches of all contacts add up to the grasp wrench space (Ferrari & Canny 1992).
     * @enum {string}
     */
    WrenchSpace: "l1" | "linf";
  };
  responses: never;
  parameters: never;
  requestBodies: never;
  headers: never;
  pathItems: never;
}
export type $defs = Record<string, never>;
export type operations = Record<string, never>;
