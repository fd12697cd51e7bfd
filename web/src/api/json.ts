/** JSON in which no seed is rounded: one beyond what a number of a browser keeps is text on the page. */

export const parse = (text: string): unknown =>
  JSON.parse(text.replace(/"seed":(\d{16,})(?=[,}])/g, '"seed":"$1"'));

export const stringify = (value: unknown, indent?: number): string =>
  JSON.stringify(value, null, indent).replace(/"seed":( ?)"(\d{16,})"/g, '"seed":$1$2');
