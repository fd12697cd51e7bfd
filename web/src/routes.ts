/** The views of the page and their URL fragments. */

export type Route =
  { at: "start" } | { at: "mesh"; id: string } | { at: "job"; id: string } | { at: "unknown" };

export function parse(hash: string): Route {
  const [, kind, id, ...rest] = hash
    .replace(/^#/, "")
    .replace(/(.)\/$/, "$1")
    .split("/");
  if (kind === undefined || (kind === "" && id === undefined)) {
    return { at: "start" };
  }
  if (id !== undefined && /^[\w-]{1,64}$/.test(id) && rest.length === 0) {
    if (kind === "meshes") {
      return { at: "mesh", id };
    }
    if (kind === "jobs") {
      return { at: "job", id };
    }
  }
  return { at: "unknown" };
}

export const meshLink = (id: string): string => `#/meshes/${id}`;
export const jobLink = (id: string): string => `#/jobs/${id}`;
export const START = "#/";
