PRAGMA foreign_keys=OFF;
BEGIN TRANSACTION;
CREATE TABLE _sqlx_migrations (
    version BIGINT PRIMARY KEY,
    description TEXT NOT NULL,
    installed_on TIMESTAMP NOT NULL DEFAULT CURRENT_TIMESTAMP,
    success BOOLEAN NOT NULL,
    checksum BLOB NOT NULL,
    execution_time BIGINT NOT NULL
);
INSERT INTO _sqlx_migrations VALUES(1,'meshes and jobs','2026-11-30 21:55:35',1,X'aa47a69b52004c5e6af69e0915de6a4645c28f7d536f83fd7f1dd72d87eebed56abf46682eda53624d55da8cf6e628e6',3698789);
INSERT INTO _sqlx_migrations VALUES(2,'mesh options','2026-11-30 21:55:35',1,X'0a6190f52fe0d55a202d124201e21712e364da406bdcef0095c89d496e7bb97b5d7ab07226ebd53eb8a75dbebe3a93da',926343);
INSERT INTO _sqlx_migrations VALUES(3,'owners','2026-11-30 21:55:35',1,X'99dabc0b2955753a186bd58264a9c9ea3546336c2607b6f08ac0db9f265440385e9065644750a18ce2186af2eddda4e7',1989668);
INSERT INTO _sqlx_migrations VALUES(4,'webhooks','2026-11-30 21:55:35',1,X'4d095a9d00947690529a3c25cfaa81581d8d59a75a59c11f0c2dadfdc5a7378f5f62ed1f2fd7a1ff44ceaca407759095',630804);
INSERT INTO _sqlx_migrations VALUES(5,'stock','2026-11-30 21:55:35',1,X'3efa1eabb3cd7ab0df209d82f7d7a631679727374fb9a5a46c2de30d08aa599e1f474b7551ed9921f701a9b60ea92d58',624845);
INSERT INTO _sqlx_migrations VALUES(6,'batches','2026-11-30 21:55:35',1,X'1a0579fbabf30337f7030275f7054f60d2b8a6e55987abcb73099bc41b31187733de835f9de9edad421e3d8b615545fd',1249001);
CREATE TABLE jobs (
    id               TEXT    NOT NULL PRIMARY KEY, -- UUID version 7: sorts by time
    -- No foreign key: a mesh may be forgotten once all its jobs have ended.
    mesh_id          TEXT    NOT NULL,
    state            TEXT    NOT NULL
        CHECK (state IN ('queued', 'running', 'succeeded', 'failed', 'cancelled')),
    attempt          INTEGER NOT NULL DEFAULT 1,
    revision         INTEGER NOT NULL DEFAULT 1,
    cancel_requested INTEGER NOT NULL DEFAULT 0,
    lease            TEXT,
    created_at       INTEGER NOT NULL,
    started_at       INTEGER,
    finished_at      INTEGER,
    label            TEXT,
    request          TEXT    NOT NULL,
    progress         TEXT,
    problem          TEXT,
    -- Last, so that what reads only the other columns never touches its pages.
    result           TEXT, owner TEXT NOT NULL DEFAULT '', priority TEXT NOT NULL DEFAULT 'interactive'
    CHECK (priority IN ('interactive', 'batch')), batch_id TEXT, batch_index INTEGER
    CHECK ((batch_id IS NULL) = (batch_index IS NULL)),
    CHECK ((state = 'running') = (lease IS NOT NULL)),
    CHECK ((state IN ('queued', 'running')) = (finished_at IS NULL))
) STRICT;
INSERT INTO jobs VALUES('01a22e74-cc8b-75bf-ac76-eb2bf2596398','80a8d18f0ea3d8424bbb2254fb5efc15b2b4fb3272f9c0f2ae15c26672eadb54','succeeded',1,15,0,NULL,1796075736203940,1796075736205186,1796075736874810,'first','{"contacts":2,"contact_model":"hard","friction":0.5,"cone_edges":8,"edge_norm":"unit_edge","wrench_space":"l1","torque_scale":"max_radius","units":"mm","method":"memetic","population":10,"generations":2,"crossover_probability":0.7,"mutation_probability":0.2,"elitism":1,"initial":"weak","polish":true,"time_limit_s":3600.0,"trials":1,"top":1,"seed":1,"label":"first","priority":"interactive","callback_url":"http://localhost:1/hook"}','{"phase":"search","generation":0,"generations":2,"evaluations":0,"best_quality":null,"elapsed_s":0.657187839}',NULL,'{"force_closure":false,"quality":null,"margin":null,"exact":null,"bounds":null,"contacts":[],"weakest_wrench":null,"measures":null,"explanation":{"reason":"too_few_contacts","proven":true,"detail":"At least 3 contacts of this model are needed to hold any body against every force and torque; ask for 3 or more."},"initial":null,"frame":"mesh","units":"mm","torque_scale":{"kind":"max_radius","value":1.1547005383792517},"center_of_mass":[0.5,0.5,0.5],"contact_model":"hard","friction":0.5,"cone_edges":8,"edge_norm":"unit_edge","wrench_space":"l1","candidates":10000,"candidates_from":{"kind":"uniform","count":10000,"because":"there are fewer than 1000 triangles"},"method":"memetic","seed":1,"stopped_because":"impossible","single_exchange_optimal":false,"reproducible":true,"evaluations":0,"history":[],"elapsed_s":0.656761908,"version":"0.1.0"}','dad54f437771','interactive',NULL,NULL);
INSERT INTO jobs VALUES('01a22e74-d47f-7256-86ae-73ae8b9ea888','80a8d18f0ea3d8424bbb2254fb5efc15b2b4fb3272f9c0f2ae15c26672eadb54','succeeded',1,16,0,NULL,1796075738239345,1796075738241224,1796075738998914,NULL,'{"contacts":3,"contact_model":"hard","friction":0.5,"cone_edges":8,"edge_norm":"unit_edge","wrench_space":"l1","torque_scale":"max_radius","units":"mm","method":"memetic","population":10,"generations":2,"crossover_probability":0.7,"mutation_probability":0.2,"elitism":1,"initial":"weak","polish":true,"time_limit_s":3600.0,"trials":1,"top":1,"seed":1,"priority":"batch"}','{"phase":"search","generation":2,"generations":2,"evaluations":2338,"best_quality":0.16246707928536291,"elapsed_s":0.755111518}',NULL,'{"force_closure":true,"quality":0.16246707928536291,"margin":0.16246707928536291,"exact":true,"bounds":[0.16948852013091045,0.1694886896196001],"contacts":[{"position":[0.49939137868490874,0.0,0.4994191404015496],"normal":[-0.0,1.0,-0.0],"approach":[0.0,-1.0,0.0],"triangle":5,"barycentric":[0.5005808595984504,0.49939137868490874,0.00002776171664085833],"forces":[-0.4287684624186838,2.843244311060622,0.06648676015524799]},{"position":[0.998959976578074,1.0,1.8972082180618237e-17],"normal":[-0.0,-1.0,-0.0],"approach":[0.0,1.0,0.0],"triangle":8,"barycentric":[0.998959976578074,0.0010400234219260097,1.8972082180618237e-17],"forces":[0.19707294961699992,-1.1894315580912143,-0.5130697303653261]},{"position":[0.0,1.0,0.9990644366098792],"normal":[-0.0,-1.0,-0.0],"approach":[0.0,1.0,0.0],"triangle":8,"barycentric":[1.2967240624405885e-17,0.0009355633901208377,0.9990644366098792],"forces":[0.5201573357784003,-1.4726067698544771,0.5211324406437959]}],"weakest_wrench":{"force":[0.28846182297671635,0.18120598311493055,0.07454947043371803],"torque":[0.13007631094639413,0.7827859904132699,-0.49872115592748434],"description":"The grasp is weakest when it has to exert a torque about (0.14, 0.84, -0.53)."},"measures":{"epsilon_l1":0.16246707928536291,"epsilon_linf":0.309933236805784,"volume_l1":0.024726938634310757,"smallest_singular_value":0.9194012527506049,"isotropy":0.5036262351325422,"ellipsoid_volume":8.419418801173622,"centroid_distance":0.16666833918099114,"polygon_area":0.7064083139198774,"polygon_shape":0.08729501430660759},"initial":{"quality":0.019542060578769664,"contacts":[{"position":[0.4998600685036402,0.9931900566944836,0.0],"normal":[-0.0,-0.0,1.0],"approach":[0.0,0.0,-1.0],"triangle":1,"barycentric":[0.0068099433055164305,0.4933299881908434,0.4998600685036402]},{"position":[0.3591786865935481,0.0,0.4302892211135372],"normal":[-0.0,1.0,-0.0],"approach":[0.0,-1.0,0.0],"triangle":5,"barycentric":[0.5697107788864628,0.3591786865935481,0.07111053451998904]},{"position":[0.37340589857457673,1.0,0.670383968322565],"normal":[-0.0,-1.0,0.0],"approach":[0.0,1.0,-0.0],"triangle":9,"barycentric":[0.32961603167743503,0.6265941014254233,0.04378986689714166]}]},"frame":"mesh","units":"mm","torque_scale":{"kind":"max_radius","value":1.1547005383792517},"center_of_mass":[0.5,0.5,0.5],"contact_model":"hard","friction":0.5,"cone_edges":8,"edge_norm":"unit_edge","wrench_space":"l1","candidates":10000,"candidates_from":{"kind":"uniform","count":10000,"because":"there are fewer than 1000 triangles"},"method":"memetic","seed":1,"stopped_because":"generation_limit","polish":{"quality_before":0.1606794752646899,"gain":0.001787604020673017,"evaluations":161},"single_exchange_optimal":true,"reproducible":true,"evaluations":2338,"history":[{"generation":0,"best":0.13054568279207607,"mean":0.09881603968904215,"force_closures":10,"evaluations":121,"elapsed_s":0.478029724},{"generation":1,"best":0.16067947526468984,"mean":0.14246341417916875,"force_closures":9,"evaluations":1446,"elapsed_s":0.646532187},{"generation":2,"best":0.16067947526468984,"mean":0.1362613078551977,"force_closures":9,"evaluations":2177,"elapsed_s":0.721764381}],"elapsed_s":0.754858483,"version":"0.1.0"}','dad54f437771','batch','01a22e74-d47f-7256-86ae-73adac7f2f03',0);
INSERT INTO jobs VALUES('01a22e74-d47f-7256-86ae-73af2f0892cc','80a8d18f0ea3d8424bbb2254fb5efc15b2b4fb3272f9c0f2ae15c26672eadb54','succeeded',1,17,0,NULL,1796075738239345,1796075739005151,1796075739745630,NULL,'{"contacts":3,"contact_model":"hard","friction":0.5,"cone_edges":8,"edge_norm":"unit_edge","wrench_space":"l1","torque_scale":"max_radius","units":"mm","method":"memetic","population":10,"generations":2,"crossover_probability":0.7,"mutation_probability":0.2,"elitism":1,"initial":"weak","polish":true,"time_limit_s":3600.0,"trials":1,"top":1,"seed":1,"priority":"batch"}','{"phase":"search","generation":2,"generations":2,"evaluations":2338,"best_quality":0.16246707928536291,"elapsed_s":0.736100907}',NULL,'{"force_closure":true,"quality":0.16246707928536291,"margin":0.16246707928536291,"exact":true,"bounds":[0.16948852013091045,0.1694886896196001],"contacts":[{"position":[0.49939137868490874,0.0,0.4994191404015496],"normal":[-0.0,1.0,-0.0],"approach":[0.0,-1.0,0.0],"triangle":5,"barycentric":[0.5005808595984504,0.49939137868490874,0.00002776171664085833],"forces":[-0.4287684624186838,2.843244311060622,0.06648676015524799]},{"position":[0.998959976578074,1.0,1.8972082180618237e-17],"normal":[-0.0,-1.0,-0.0],"approach":[0.0,1.0,0.0],"triangle":8,"barycentric":[0.998959976578074,0.0010400234219260097,1.8972082180618237e-17],"forces":[0.19707294961699992,-1.1894315580912143,-0.5130697303653261]},{"position":[0.0,1.0,0.9990644366098792],"normal":[-0.0,-1.0,-0.0],"approach":[0.0,1.0,0.0],"triangle":8,"barycentric":[1.2967240624405885e-17,0.0009355633901208377,0.9990644366098792],"forces":[0.5201573357784003,-1.4726067698544771,0.5211324406437959]}],"weakest_wrench":{"force":[0.28846182297671635,0.18120598311493055,0.07454947043371803],"torque":[0.13007631094639413,0.7827859904132699,-0.49872115592748434],"description":"The grasp is weakest when it has to exert a torque about (0.14, 0.84, -0.53)."},"measures":{"epsilon_l1":0.16246707928536291,"epsilon_linf":0.309933236805784,"volume_l1":0.024726938634310757,"smallest_singular_value":0.9194012527506049,"isotropy":0.5036262351325422,"ellipsoid_volume":8.419418801173622,"centroid_distance":0.16666833918099114,"polygon_area":0.7064083139198774,"polygon_shape":0.08729501430660759},"initial":{"quality":0.019542060578769664,"contacts":[{"position":[0.4998600685036402,0.9931900566944836,0.0],"normal":[-0.0,-0.0,1.0],"approach":[0.0,0.0,-1.0],"triangle":1,"barycentric":[0.0068099433055164305,0.4933299881908434,0.4998600685036402]},{"position":[0.3591786865935481,0.0,0.4302892211135372],"normal":[-0.0,1.0,-0.0],"approach":[0.0,-1.0,0.0],"triangle":5,"barycentric":[0.5697107788864628,0.3591786865935481,0.07111053451998904]},{"position":[0.37340589857457673,1.0,0.670383968322565],"normal":[-0.0,-1.0,0.0],"approach":[0.0,1.0,-0.0],"triangle":9,"barycentric":[0.32961603167743503,0.6265941014254233,0.04378986689714166]}]},"frame":"mesh","units":"mm","torque_scale":{"kind":"max_radius","value":1.1547005383792517},"center_of_mass":[0.5,0.5,0.5],"contact_model":"hard","friction":0.5,"cone_edges":8,"edge_norm":"unit_edge","wrench_space":"l1","candidates":10000,"candidates_from":{"kind":"uniform","count":10000,"because":"there are fewer than 1000 triangles"},"method":"memetic","seed":1,"stopped_because":"generation_limit","polish":{"quality_before":0.1606794752646899,"gain":0.001787604020673017,"evaluations":161},"single_exchange_optimal":true,"reproducible":true,"evaluations":2338,"history":[{"generation":0,"best":0.13054568279207607,"mean":0.09881603968904215,"force_closures":10,"evaluations":121,"elapsed_s":0.450164834},{"generation":1,"best":0.16067947526468984,"mean":0.14246341417916875,"force_closures":9,"evaluations":1446,"elapsed_s":0.585291167},{"generation":2,"best":0.16067947526468984,"mean":0.1362613078551977,"force_closures":9,"evaluations":2177,"elapsed_s":0.699295146}],"elapsed_s":0.735782365,"version":"0.1.0"}','dad54f437771','batch','01a22e74-d47f-7256-86ae-73adac7f2f03',1);
INSERT INTO jobs VALUES('01a22e74-e0bb-7061-aa96-c05fe5c49273','80a8d18f0ea3d8424bbb2254fb5efc15b2b4fb3272f9c0f2ae15c26672eadb54','queued',1,41,0,NULL,1796075741371477,NULL,NULL,'long','{"contacts":3,"contact_model":"hard","friction":0.5,"cone_edges":8,"edge_norm":"unit_edge","wrench_space":"l1","torque_scale":"max_radius","units":"mm","method":"memetic","population":500,"generations":10000,"crossover_probability":0.7,"mutation_probability":0.2,"elitism":1,"initial":"weak","polish":true,"time_limit_s":3600.0,"trials":1,"top":1,"seed":2,"label":"long","priority":"interactive"}',NULL,NULL,NULL,'dad54f437771','interactive',NULL,NULL);
INSERT INTO jobs VALUES('01a22e74-e0f7-7721-afb1-451d6544af87','80a8d18f0ea3d8424bbb2254fb5efc15b2b4fb3272f9c0f2ae15c26672eadb54','cancelled',1,2,1,NULL,1796075741431238,NULL,1796075741586700,'cancelled','{"contacts":3,"contact_model":"hard","friction":0.5,"cone_edges":8,"edge_norm":"unit_edge","wrench_space":"l1","torque_scale":"max_radius","units":"mm","method":"memetic","population":500,"generations":10000,"crossover_probability":0.7,"mutation_probability":0.2,"elitism":1,"initial":"weak","polish":true,"time_limit_s":3600.0,"trials":1,"top":1,"seed":2,"label":"cancelled","priority":"interactive"}',NULL,NULL,NULL,'dad54f437771','interactive',NULL,NULL);
INSERT INTO jobs VALUES('01a22e74-e14f-751c-a17e-0904e5da15fd','80a8d18f0ea3d8424bbb2254fb5efc15b2b4fb3272f9c0f2ae15c26672eadb54','queued',1,1,0,NULL,1796075741519135,NULL,NULL,'waits','{"contacts":3,"contact_model":"hard","friction":0.5,"cone_edges":8,"edge_norm":"unit_edge","wrench_space":"l1","torque_scale":"max_radius","units":"mm","method":"memetic","population":500,"generations":10000,"crossover_probability":0.7,"mutation_probability":0.2,"elitism":1,"initial":"weak","polish":true,"time_limit_s":3600.0,"trials":1,"top":1,"seed":2,"label":"waits","priority":"interactive"}',NULL,NULL,NULL,'dad54f437771','interactive',NULL,NULL);
CREATE TABLE IF NOT EXISTS "meshes" (
    seq        INTEGER PRIMARY KEY AUTOINCREMENT,
    owner      TEXT    NOT NULL,
    id         TEXT    NOT NULL,
    format     TEXT    NOT NULL,
    bytes      INTEGER NOT NULL,
    candidates INTEGER NOT NULL,
    file_name  TEXT,
    created_at INTEGER NOT NULL,
    -- Last uploaded or asked for; what expiry counts from.
    used_at    INTEGER NOT NULL,
    report     TEXT    NOT NULL,
    units      TEXT,
    scale      REAL    NOT NULL DEFAULT 1.0,
    UNIQUE (owner, id)
) STRICT;
INSERT INTO meshes VALUES(1,'dad54f437771','80a8d18f0ea3d8424bbb2254fb5efc15b2b4fb3272f9c0f2ae15c26672eadb54','obj',160,12,'box.obj',1796075736104272,1796075741519135,'{"vertices_read":8,"triangles_read":12,"vertices":8,"triangles":12,"degenerate_triangles":0,"duplicate_triangles":0,"components":1,"flipped_triangles":0,"border_edges":0,"non_manifold_edges":0,"holes":0,"watertight":true,"mass_from":"solid","volume":1.0000000000000002,"volume_error":0.0,"area":6.0,"center_of_mass":[0.5,0.5,0.5],"bounds":[[0.0,0.0,0.0],[1.0,1.0,1.0]],"bounding_radius":0.8660254037844386,"candidates":12,"area_ratio":1.0,"warnings":[]}','mm',1.0);
CREATE TABLE keys (
    -- The owner of what is sent with the key.
    id         TEXT    NOT NULL PRIMARY KEY,
    name       TEXT    NOT NULL,
    -- SHA-256 of a secret of 256 random bits, which no guessing finds.
    hash       BLOB    NOT NULL,
    created_at INTEGER NOT NULL,
    expires_at INTEGER,
    revoked_at INTEGER
) STRICT;
INSERT INTO keys VALUES('dad54f437771','robot',X'b372cb07e786e797ef0188d3d0f926dfc3ef98e63f3676a6f60ff690a4f979f5',1796075735783302,NULL,NULL);
INSERT INTO keys VALUES('d5845d7b6184','gone',X'6e143ea91f100054f84c7a216c460c68d382e889cfedb6dbdd49ca01626618c4',1796075735807880,NULL,1796075735820095);
CREATE TABLE submissions (
    owner       TEXT    NOT NULL,
    key         TEXT    NOT NULL,
    fingerprint BLOB    NOT NULL,
    job         TEXT    NOT NULL,
    created_at  INTEGER NOT NULL,
    PRIMARY KEY (owner, key)
) STRICT, WITHOUT ROWID;
INSERT INTO submissions VALUES('dad54f437771','once',X'd48cfc96843a9c1fb931925a68464e16978c8efc17584b1c85b77caf07ad7f20','01a22e74-cc8b-75bf-ac76-eb2bf2596398',1796075736203940);
CREATE TABLE expired (
    id         TEXT    NOT NULL PRIMARY KEY,
    owner      TEXT    NOT NULL,
    expired_at INTEGER NOT NULL
) STRICT, WITHOUT ROWID;
CREATE TABLE webhooks (
    job_id          TEXT    NOT NULL PRIMARY KEY REFERENCES jobs (id) ON DELETE CASCADE,
    url             TEXT    NOT NULL,
    -- Host and, where it has one, port. URLs are kept in normal form: nothing else is in that place.
    host            TEXT    NOT NULL GENERATED ALWAYS AS (
        substr(url, instr(url, '//') + 2, instr(substr(url, instr(url, '//') + 2) || '/', '/') - 1)
    ) STORED,
    state           TEXT    NOT NULL DEFAULT 'pending'
        CHECK (state IN ('pending', 'delivered', 'failed')),
    attempts        INTEGER NOT NULL DEFAULT 0,
    last_error      TEXT,
    last_attempt_at INTEGER,
    due_at          INTEGER,
    -- Whose turn it is, and until when.
    lease           TEXT,
    leased_until    INTEGER,
    CHECK ((state = 'pending') = (due_at IS NOT NULL)),
    CHECK ((lease IS NULL) = (leased_until IS NULL))
) STRICT;
INSERT INTO webhooks VALUES('01a22e74-cc8b-75bf-ac76-eb2bf2596398','http://localhost:1/hook','pending',2,'the host cannot be reached',1796075741911413,1796075776027362,NULL,NULL);
CREATE TABLE stock (
    state TEXT    NOT NULL PRIMARY KEY,
    jobs  INTEGER NOT NULL DEFAULT 0
) STRICT, WITHOUT ROWID;
INSERT INTO stock VALUES('cancelled',1);
INSERT INTO stock VALUES('failed',0);
INSERT INTO stock VALUES('queued',2);
INSERT INTO stock VALUES('running',0);
INSERT INTO stock VALUES('succeeded',3);
CREATE TABLE batches (
    id         TEXT    NOT NULL PRIMARY KEY, -- UUID version 7: sorts by time
    owner      TEXT    NOT NULL,
    label      TEXT,
    -- As many as were submitted; each of them may be forgotten by itself.
    jobs       INTEGER NOT NULL,
    created_at INTEGER NOT NULL
) STRICT;
INSERT INTO batches VALUES('01a22e74-d47f-7256-86ae-73adac7f2f03','dad54f437771','pair',2,1796075738239345);
DELETE FROM sqlite_sequence;
INSERT INTO sqlite_sequence VALUES('meshes',1);
CREATE TRIGGER jobs_legal_transition
BEFORE UPDATE OF state ON jobs
WHEN OLD.state <> NEW.state AND NOT (
    (OLD.state = 'queued' AND NEW.state IN ('running', 'cancelled'))
    OR OLD.state = 'running'
)
BEGIN
    SELECT RAISE(ABORT, 'illegal state transition of a job');
END;
CREATE INDEX meshes_by_id ON meshes (id);
CREATE INDEX meshes_by_use ON meshes (used_at);
CREATE INDEX jobs_by_owner ON jobs (owner, id);
CREATE INDEX jobs_by_state ON jobs (owner, state, id);
CREATE INDEX jobs_by_mesh ON jobs (owner, mesh_id, id);
CREATE INDEX jobs_by_end ON jobs (finished_at) WHERE finished_at IS NOT NULL;
CREATE INDEX jobs_queued ON jobs (priority, owner, id) WHERE state = 'queued';
CREATE INDEX jobs_running ON jobs (owner) WHERE state = 'running';
CREATE INDEX jobs_by_start ON jobs (owner, started_at);
CREATE TRIGGER jobs_use_meshes AFTER INSERT ON jobs
BEGIN
    UPDATE meshes SET used_at = NEW.created_at WHERE owner = NEW.owner AND id = NEW.mesh_id;
END;
CREATE INDEX submissions_by_age ON submissions (created_at);
CREATE INDEX expired_by_age ON expired (expired_at);
CREATE INDEX webhooks_due ON webhooks (due_at, host) WHERE state = 'pending';
CREATE TRIGGER jobs_callback
AFTER UPDATE OF state ON jobs
WHEN OLD.state IN ('queued', 'running') AND NEW.state NOT IN ('queued', 'running')
    AND json_valid(NEW.request) AND json_extract(NEW.request, '$.callback_url') IS NOT NULL
BEGIN
    INSERT INTO webhooks (job_id, url, due_at)
    VALUES (NEW.id, json_extract(NEW.request, '$.callback_url'), NEW.finished_at);
END;
CREATE TRIGGER jobs_come AFTER INSERT ON jobs
BEGIN
    UPDATE stock SET jobs = jobs + 1 WHERE state = NEW.state;
END;
CREATE TRIGGER jobs_go AFTER DELETE ON jobs
BEGIN
    UPDATE stock SET jobs = jobs - 1 WHERE state = OLD.state;
END;
CREATE TRIGGER jobs_turn AFTER UPDATE OF state ON jobs WHEN OLD.state <> NEW.state
BEGIN
    UPDATE stock SET jobs = jobs - 1 WHERE state = OLD.state;
    UPDATE stock SET jobs = jobs + 1 WHERE state = NEW.state;
END;
CREATE INDEX meshes_by_owner ON meshes (owner, seq);
CREATE INDEX batches_by_owner ON batches (owner, id);
CREATE INDEX batches_by_age ON batches (created_at);
CREATE UNIQUE INDEX jobs_in_batch ON jobs (batch_id, batch_index) WHERE batch_id IS NOT NULL;
CREATE INDEX jobs_by_batch ON jobs (batch_id, state, id, started_at, finished_at)
    WHERE batch_id IS NOT NULL;
COMMIT;
