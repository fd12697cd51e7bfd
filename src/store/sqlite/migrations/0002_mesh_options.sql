-- The unit of a mesh's coordinates, where its sender named one, and what the coordinates in its file are
-- multiplied by.
ALTER TABLE meshes ADD COLUMN units TEXT;
ALTER TABLE meshes ADD COLUMN scale REAL NOT NULL DEFAULT 1.0;
