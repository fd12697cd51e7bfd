/** JSON in which no seed is rounded: a seed beyond the exact integers of JavaScript is a string on the page. */

export const parse = (text: string): unknown =>
  JSON.parse(text.replace(/"seed":(\d{16,})(?=[,}])/g, '"seed":"$1"'));

export const stringify = (value: unknown, indent?: number): string =>
  JSON.stringify(value, null, indent).replace(/"seed":( ?)"(\d{16,})"/g, '"seed":$1$2');
