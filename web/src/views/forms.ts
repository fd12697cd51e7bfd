/** The initial values of a mesh's form: its last state, or the request of a job that is planned again. */

import { StoredValue } from "../storage";

/** A partial planning request. */
export type Form = Record<string, unknown>;

/** Number of meshes whose forms are stored, newest first. */
const MAX_FORMS = 20;

const stored = new StoredValue(() => sessionStorage, "graspd-forms");

function all(): Map<string, Form> {
  try {
    return new Map(JSON.parse(stored.get() ?? "[]") as [string, Form][]);
  } catch {
    return new Map();
  }
}

export const formOf = (meshId: string): Form => all().get(meshId) ?? {};

export function keepForm(meshId: string, form: Form): void {
  const forms = all();
  forms.delete(meshId);
  forms.set(meshId, form);
  stored.set(JSON.stringify([...forms].slice(-MAX_FORMS)));
}
