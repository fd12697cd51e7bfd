/** What the form of a mesh begins with: its last state, or a job that is to be planned again. */

import { Kept } from "../storage";

/** A planning request, as far as it is given. */
export type Form = Record<string, unknown>;

/** Of the newest meshes. */
const MOST = 20;

const kept = new Kept(() => sessionStorage, "graspd-forms");

function all(): Map<string, Form> {
  try {
    return new Map(JSON.parse(kept.get() ?? "[]") as [string, Form][]);
  } catch {
    return new Map();
  }
}

export const formOf = (meshId: string): Form => all().get(meshId) ?? {};

export function keepForm(meshId: string, form: Form): void {
  const forms = all();
  forms.delete(meshId);
  forms.set(meshId, form);
  kept.set(JSON.stringify([...forms].slice(-MOST)));
}
