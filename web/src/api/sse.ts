/** Parses Server-Sent Events from a response: unlike with EventSource, the request can carry an API key. */

export interface ServerEvent {
  event: string;
  data: string;
  id: string;
}

/** Accepts text in chunks of any size and returns the events that are complete. */
export class EventParser {
  private rest = "";
  private event = "";
  private data: string[] = [];
  private id = "";

  push(text: string): ServerEvent[] {
    const lines = (this.rest + text).split(/\r\n|\n|\r(?!$)/);
    this.rest = lines.pop() ?? "";
    const events: ServerEvent[] = [];
    for (const line of lines) {
      const event = this.line(line);
      if (event !== null) {
        events.push(event);
      }
    }
    return events;
  }

  private line(line: string): ServerEvent | null {
    if (line === "") {
      const { event, data, id } = this;
      this.event = "";
      this.data = [];
      return data.length === 0 ? null : { event: event || "message", data: data.join("\n"), id };
    }
    const colon = line.indexOf(":");
    const name = colon < 0 ? line : line.slice(0, colon);
    const value = colon < 0 ? "" : line.slice(colon + 1).replace(/^ /, "");
    if (name === "event") {
      this.event = value;
    } else if (name === "data") {
      this.data.push(value);
    } else if (name === "id") {
      this.id = value;
    }
    return null;
  }
}
