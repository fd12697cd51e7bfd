/** What the browser keeps for the page. Where its reader forbids that, it is kept until the page is left. */

export class Kept {
  private readonly storage: () => Storage;
  private readonly name: string;
  private here: string | null = null;

  /** The storage is asked for when it is used: a browser that forbids it throws at the mention of it. */
  constructor(storage: () => Storage, name: string) {
    this.storage = storage;
    this.name = name;
  }

  get(): string | null {
    try {
      return this.storage().getItem(this.name) ?? this.here;
    } catch {
      return this.here;
    }
  }

  set(value: string): void {
    this.here = value;
    try {
      this.storage().setItem(this.name, value);
    } catch {
      this.forget();
    }
  }

  /** Of what could not be replaced, nothing old is left: what is here counts. */
  private forget(): void {
    try {
      this.storage().removeItem(this.name);
    } catch {
      // There is no storage.
    }
  }
}
