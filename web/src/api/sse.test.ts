import { expect, test } from "vitest";

import { EventParser } from "./sse";

const STREAM =
  ': a comment\n\nevent: snapshot\nid: 3\ndata: {"a":\ndata: 1}\n\nretry: 5\ndata:x\r\n\r\nid: 7\nevent: end\ndata: é\n\n';
const EVENTS = [
  { event: "snapshot", data: '{"a":\n1}', id: "3" },
  { event: "message", data: "x", id: "3" },
  { event: "end", data: "é", id: "7" },
];

test("a stream parses alike in chunks of any size", () => {
  for (let size = 1; size <= STREAM.length; size += 1) {
    const parser = new EventParser();
    const events = [];
    for (let start = 0; start < STREAM.length; start += size) {
      events.push(...parser.push(STREAM.slice(start, start + size)));
    }
    expect(events).toEqual(EVENTS);
  }
});

test("an unfinished event is not returned", () => {
  expect(new EventParser().push("data: 1\n")).toEqual([]);
});
