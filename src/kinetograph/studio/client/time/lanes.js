// The lanes of the timeline that show what was made.

/**
 * @typedef {import("../messages.js").MadeHeader} MadeHeader
 * @typedef {import("./timeline.js").Lane} Lane
 */

/** @type {Record<string, Lane["kind"]>} */
const KINDS = { keys: "keys", contacts: "contacts", handholds: "contacts", moves: "moves", error: "signal", edited: "signal", readings: "signal", uncertainty: "signal" };

/** @type {Record<string, string>} as the capsules of a body are coloured */
const SIDES = { left: "var(--left)", right: "var(--right)" };

/**
 * The lanes of what was made: its pieces, then those that came with it.
 *
 * @param {Pick<MadeHeader, "pieces" | "lanes">} made
 * @returns {Lane[]}
 */
export function lanesOf(made) {
  const others = (made.lanes ?? []).map(({ name, role, spans, values, unit }) => ({
    name: unit && role !== "readings" ? `${name}, ${unit}` : name,
    kind: KINDS[role] ?? "moves",
    spans: (spans ?? []).map(({ start, stop, label, title }) => ({ start, stop, label: label ?? "", title, colour: colourOf(role, label ?? "") })),
    values: values?.length ? values : undefined,
    draggable: false,
  }));
  const pieces = (made.pieces ?? []).map((piece) => ({
    start: piece.start,
    stop: piece.stop,
    label: piece.take,
    title: `${piece.take}${piece.mirrored ? ", mirrored" : ""}, ${piece.source_start.toFixed(2)} to ${piece.source_stop.toFixed(2)} s`,
    data: piece,
  }));
  return [...(pieces.length ? [{ name: "pieces", kind: /** @type {const} */ ("pieces"), spans: pieces }] : []), ...others];
}

/**
 * @param {string} role of a lane
 * @param {string} label of a span
 */
function colourOf(role, label) {
  if (role === "handholds") return label.startsWith("missed") ? "var(--bad)" : "var(--good)";
  return role === "contacts" ? SIDES[label.split(" ")[0]] : undefined;
}
