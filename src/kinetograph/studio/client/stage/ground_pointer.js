// The pointer on the ground: strokes of a mouse, a pen or a finger, with their own times, in place of orbiting.

/**
 * @typedef {{x: number, z: number}} Point metres on the ground
 *
 * @typedef {object} Stroke what a press begins
 * @property {(milliseconds: number, point: Point) => void} move
 * @property {(milliseconds: number) => void} done
 * @property {() => void} cancelled
 *
 * @typedef {object} Listener
 * @property {(event: PointerEvent, point: Point) => Stroke | null} press null leaves the press to the camera
 * @property {(event: PointerEvent, point: Point | null) => void} hover
 */

/**
 * Listens on a stage, before its camera does.
 *
 * @param {import("./stage.js").Stage} stage
 * @param {Listener} listener
 * @returns {{cancel: () => void, stop: () => void}} `cancel` ends a stroke, `stop` ends listening
 */
export function listenOnGround(stage, listener) {
  /** @type {{id: number, stroke: Stroke} | null} */
  let begun = null;

  const press = (/** @type {PointerEvent} */ event) => {
    if (event.button !== 0 || event.target !== stage.canvas) return;
    const point = stage.groundPoint(event);
    const stroke = !begun && point ? listener.press(event, point) : null;
    if (!stroke || !point) return;
    begun = { id: event.pointerId, stroke };
    if (event.isTrusted) stage.canvas.setPointerCapture(event.pointerId);
    stage.canvas.focus({ preventScroll: true });
    event.stopPropagation();
    event.preventDefault();
    stroke.move(event.timeStamp, point);
  };

  const move = (/** @type {PointerEvent} */ event) => {
    if (!begun) listener.hover(event, event.target === stage.canvas ? stage.groundPoint(event) : null);
    else if (event.pointerId === begun.id) {
      event.stopPropagation();
      const all = event.getCoalescedEvents?.() ?? [];
      for (const each of all.length ? all : [event]) {
        const point = stage.groundPoint(each);
        if (point) begun.stroke.move(each.timeStamp, point);
      }
    }
  };

  const end = (/** @type {PointerEvent} */ event) => {
    if (!begun || event.pointerId !== begun.id) return;
    const { stroke } = begun;
    begun = null;
    event.stopPropagation();
    if (event.type === "pointerup") stroke.done(event.timeStamp);
    else stroke.cancelled();
  };

  const cancel = () => {
    const stroke = begun?.stroke;
    begun = null;
    stroke?.cancelled();
  };

  const leave = (/** @type {PointerEvent} */ event) => listener.hover(event, null);
  const { parent } = stage;
  const options = { capture: true };
  parent.addEventListener("pointerdown", press, options);
  parent.addEventListener("pointermove", move, options);
  parent.addEventListener("pointerup", end, options);
  parent.addEventListener("pointercancel", end, options);
  parent.addEventListener("pointerleave", leave);
  return {
    cancel,
    stop() {
      cancel();
      parent.removeEventListener("pointerdown", press, options);
      parent.removeEventListener("pointermove", move, options);
      parent.removeEventListener("pointerup", end, options);
      parent.removeEventListener("pointercancel", end, options);
      parent.removeEventListener("pointerleave", leave);
    },
  };
}
