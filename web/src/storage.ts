/** A value that the browser stores for the page. If storage is blocked, the value lives until the page is left. */

export class StoredValue {
  private readonly storage: () => Storage;
  private readonly name: string;
  private inMemory: string | null = null;

  /** `storage` is a function because some browsers throw on mere access to a storage that is blocked. */
  constructor(storage: () => Storage, name: string) {
    this.storage = storage;
    this.name = name;
  }

  get(): string | null {
    try {
      return this.storage().getItem(this.name) ?? this.inMemory;
    } catch {
      return this.inMemory;
    }
  }

  set(value: string): void {
    this.inMemory = value;
    try {
      this.storage().setItem(this.name, value);
    } catch {
      this.forget();
    }
  }

  /** Removes an old value that could not be replaced, so that `get` returns the value in memory. */
  private forget(): void {
    try {
      this.storage().removeItem(this.name);
    } catch {
      // There is no storage.
    }
  }
}
