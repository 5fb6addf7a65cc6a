// Listening to sensors: what is heard, under which names, and the link for phones.
import { button, element, field } from "../../dom.js";

/** Kinds of sources: what a person reads, the text before the address, and what the address is like. */
const KINDS = {
  phone: { name: "Phones nearby", address: "phone://0.0.0.0", hint: null },
  here: { name: "A browser here", address: "phone", hint: null },
  slimevr: { name: "SlimeVR trackers", address: "slimevr://", hint: "0.0.0.0:6969" },
  sensorserver: { name: "SensorServer (Android)", address: "sensorserver://", hint: "192.168.0.5/right_forearm" },
  mvn: { name: "Xsens MVN", address: "mvn://", hint: "0.0.0.0:9763" },
  replay: { name: "Replay of a file", address: "replay:", hint: null },
};

/** @typedef {keyof typeof KINDS} Kind */

export class Listening {
  #running = false;
  /** @type {string[]} */
  #sensors = [];

  /**
   * @param {import("../../studio.js").App} app
   * @param {(fields: Partial<import("../../messages.js").Sensors>, label: string) => void} edit changes the section, without making it anew
   * @param {() => void} stopped a person has stopped listening
   */
  constructor(app, edit, stopped) {
    this.app = app;
    this.edit = edit;
    this.stopped = stopped;
    this.kind = element(
      "select",
      { onchange: () => this.#chosen() },
      Object.entries(KINDS).map(([value, { name }]) => element("option", { value }, name)),
    );
    this.address = element("input", { type: "text", spellcheck: "false", onchange: () => this.#chosen() });
    this.file = element("select", { onchange: () => this.#chosen() });
    this.addressField = field("Address", this.address);
    this.fileField = field("File", this.file);
    this.button = button("Start listening", () => (this.#running ? this.stop() : this.start()), { class: "primary" });
    this.link = element("div", { class: "phone-link", hidden: true });
    this.table = element("div", { class: "heard", role: "group", "aria-label": "Who is heard" });
    this.element = element(
      "section",
      { "aria-label": "Live" },
      element("h2", {}, "Live"),
      field("From", this.kind),
      this.addressField,
      this.fileField,
      element("div", { class: "buttons" }, this.button),
      this.link,
      this.table,
    );
    app.connection.on("heard", (message) => this.#heard(message));
    app.connection.on("phone_link", (message) => this.#phone(message));
    this.#write();
  }

  /** What is listened to, as the section has it. */
  get source() {
    const kind = /** @type {Kind} */ (this.kind.value);
    if (kind === "replay") return this.file.value && `replay:${this.file.value}`;
    return KINDS[kind].hint === null ? KINDS[kind].address : KINDS[kind].address + this.address.value.trim();
  }

  /** Shows the section as it is in the project. */
  show() {
    const source = this.app.store.project.sensors?.source ?? "";
    const kind = /** @type {Kind[]} */ (Object.keys(KINDS)).find((each) => (KINDS[each].hint === null && each !== "replay" ? source === KINDS[each].address : source.startsWith(KINDS[each].address)));
    const files = (this.app.store.welcome?.files ?? []).filter((name) => /\.(csv|tsv|txt)$/i.test(name));
    const chosen = source.startsWith("replay:") ? source.slice(7) : this.file.value;
    this.file.replaceChildren(...files.map((name) => element("option", { value: name, selected: name === chosen.replace(/@[\d.]+$/, "") }, name)));
    if (source && kind) {
      this.kind.value = kind;
      this.address.value = KINDS[kind].hint === null ? "" : source.slice(KINDS[kind].address.length);
    }
    this.#write();
  }

  start() {
    if (!this.source) return this.app.say("drop a file of readings onto the page to replay it", "error");
    this.#chosen();
    this.app.connection.send({ kind: "listen" });
    this.clear();
    this.#running = true;
    this.button.textContent = "Stop listening";
    this.app.say("the sensors' model is made ready");
  }

  stop() {
    if (!this.#running) return;
    this.app.connection.send({ kind: "stop_run" });
    this.ended();
    this.stopped();
  }

  /** Nothing of an earlier run is shown. */
  clear() {
    this.table.replaceChildren();
    this.link.hidden = true;
  }

  ended() {
    this.#running = false;
    this.button.textContent = "Start listening";
    this.link.hidden = true;
  }

  #chosen() {
    this.#write();
    if (this.source !== (this.app.store.project.sensors?.source ?? "")) this.edit({ source: this.source }, "listen to another source");
  }

  #write() {
    const kind = /** @type {Kind} */ (this.kind.value);
    this.addressField.hidden = KINDS[kind].hint === null;
    this.address.placeholder = KINDS[kind].hint ?? "";
    this.fileField.hidden = kind !== "replay";
  }

  /** @param {import("../../messages.js").PhoneLink} message */
  #phone({ link, code }) {
    this.link.hidden = false;
    this.link.replaceChildren(
      ...(code?.length ? [squares(code)] : []),
      element("p", { class: "note" }, "Open on the phone: ", element("a", { href: link, target: "_blank", rel: "noreferrer" }, link)),
    );
  }

  /** @param {import("../../messages.js").Heard} message */
  #heard({ rows, sensors }) {
    this.#sensors = sensors;
    const typing = this.table.contains(document.activeElement);
    if (typing) return; // a person is choosing a name
    const names = this.app.store.project.sensors?.names ?? {};
    const unheard = sensors.filter((name) => !rows.some((row) => (names[row.sensor] ?? row.sensor) === name));
    this.table.replaceChildren(
      rows.length
        ? element(
            "table",
            {},
            element("thead", {}, element("tr", {}, ["Sensor", "Hz", "Lost", "m/s²"].map((name) => element("th", { scope: "col" }, name)))),
            element("tbody", {}, rows.flatMap((row) => this.#row(row, names))),
          )
        : element("p", { class: "note" }, "nothing is heard yet"),
      ...(rows.length && unheard.length ? [element("p", { class: "note" }, `Not heard: ${unheard.map(plain).join(", ")}`)] : []),
    );
  }

  /**
   * @param {import("../../messages.js").HeardRow} row
   * @param {Record<string, string>} names
   */
  #row(row, names) {
    const called = names[row.sensor] ?? row.sensor;
    const same = called === row.sensor && row.known;
    const choice = element(
      "select",
      { "aria-label": `Which sensor is ${row.sensor}`, onchange: () => this.#call(row.sensor, choice.value) },
      element("option", { value: "" }, "not used"),
      this.#sensors.map((name) => element("option", { value: name, selected: name === called }, plain(name))),
    );
    const cells = [row.rate.toFixed(0), row.lost, row.force.toFixed(1)].map((value) => element("td", {}, value));
    const first = element("tr", {}, element("th", { scope: "row", title: row.sensor }, same ? plain(row.sensor) : row.sensor), cells);
    return same ? [first] : [first, element("tr", { class: "mapping" }, element("td", { colspan: "4" }, "is ", choice))];
  }

  /**
   * @param {string} heard
   * @param {string} name
   */
  #call(heard, name) {
    const others = Object.entries(this.app.store.project.sensors?.names ?? {}).filter(([key, value]) => key !== heard && value !== name);
    const names = Object.fromEntries(name ? [...others, [heard, name]] : others);
    this.edit({ names }, `call ${heard} ${plain(name)}`);
    this.app.connection.send({ kind: "call_sensors", names });
    /** @type {HTMLElement | null} */ (document.activeElement)?.blur();
  }
}

/** @param {string} name */
export function plain(name) {
  return name.replaceAll("_", " ");
}

/**
 * A QR code, dark on light in both themes, as readers expect.
 *
 * @param {string[]} rows
 */
function squares(rows) {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  const size = rows.length + 8;
  for (const [key, value] of Object.entries({ viewBox: `-4 -4 ${size} ${size}`, class: "code", role: "img", "aria-label": "QR code of the link" })) svg.setAttribute(key, value);
  const path = document.createElementNS("http://www.w3.org/2000/svg", "path");
  path.setAttribute("d", rows.flatMap((row, y) => [...row].map((module, x) => (module === "1" ? `M${x} ${y}h1v1h-1z` : ""))).join(""));
  svg.append(path);
  return svg;
}
