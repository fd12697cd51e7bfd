/** Formats numbers for display. */

/** Formats a number with four significant digits; tiny and huge ones get an exponent. */
export function number(value: number | null | undefined): string {
  if (value === null || value === undefined || !Number.isFinite(value)) {
    return "–";
  }
  if (value === 0) {
    return "0";
  }
  const size = Math.abs(value);
  if (size >= 1e6 || size < 1e-4) {
    return value.toExponential(3);
  }
  return String(Number(value.toPrecision(4)));
}

/** Formats equally spaced numbers with just enough digits to distinguish neighbours. */
export function steps(values: readonly number[]): string[] {
  const [first = 0, second = first] = values;
  const step = Math.abs(second - first);
  const size = Math.max(...values.map(Math.abs));
  if (!(step > 0)) {
    return values.map((value) => number(value));
  }
  const exponential = size >= 1e6 || size < 1e-3;
  const unit = exponential ? 10 ** Math.floor(Math.log10(size)) : 1;
  // A step such as 0.25 needs one digit more than its magnitude suggests.
  const isWhole = (places: number): boolean => {
    const scaled = (step / unit) * 10 ** places;
    return scaled > 0.5 && Math.abs(scaled - Math.round(scaled)) < 0.01 * scaled;
  };
  let places = 0;
  while (places < 12 && !isWhole(places)) {
    places += 1;
  }
  return values.map((value) =>
    value === 0
      ? "0"
      : exponential
        ? `${(value / unit).toFixed(places)}e${Math.round(Math.log10(unit))}`
        : value.toFixed(places),
  );
}

export function count(value: number): string {
  return Number.isFinite(value) ? value.toLocaleString("en") : "–";
}

export function seconds(value: number): string {
  if (value < 10) {
    return `${value.toFixed(2)} s`;
  }
  if (value < 90) {
    return `${value.toFixed(0)} s`;
  }
  const whole = Math.round(value);
  return `${Math.floor(whole / 60)} min ${whole % 60} s`;
}

export function vector(value: readonly number[]): string {
  return value.map((part) => number(part)).join(", ");
}

/** The diagonal of a box. */
export const extent = ([low, high]: readonly [readonly number[], readonly number[]]): number =>
  Math.hypot(...low.map((value, axis) => (high[axis] ?? value) - value));

/** Decimal places that resolve a ten-thousandth of a body of this size. */
export const decimals = (size: number): number =>
  size > 0 ? Math.min(Math.max(4 - Math.floor(Math.log10(size)), 0), 20) : 6;

/** Formats a position on a body of the given size, however far from the origin it is. */
export function place(position: readonly number[], size: number): string {
  return position.map((part) => String(Number(part.toFixed(decimals(size))))).join(", ");
}

/** Says how long ago a moment was. */
export function ago(moment: string, now: number = Date.now()): string {
  const passed = (now - Date.parse(moment)) / 1000;
  if (!(passed >= 60)) {
    return "just now";
  }
  const units: [number, string][] = [
    [86400, "day"],
    [3600, "hour"],
    [60, "minute"],
  ];
  for (const [length, name] of units) {
    const whole = Math.floor(passed / length);
    if (whole >= 1) {
      return `${whole} ${name}${whole === 1 ? "" : "s"} ago`;
    }
  }
  return "just now";
}
