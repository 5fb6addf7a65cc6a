// Cubic splines through the frames of a motion: what `kinetograph.motion.sample` gives between frames.

/**
 * Rows of numbers on the cubic spline through all frames, straight at both ends and held beyond them.
 */
export class Spline {
  /**
   * @param {Float32Array} values rows of frames
   * @param {number} width numbers a row
   */
  constructor(values, width) {
    this.width = width;
    this.frames = values.length / width;
    this.weights = splineWeights(values, width);
  }

  /**
   * Writes the row of a fractional frame.
   *
   * @param {number} position frames from the first
   * @param {Float32Array | Float64Array} out
   */
  at(position, out) {
    const last = this.frames - 1;
    const held = Math.min(Math.max(position, 0), last);
    const first = Math.min(Math.floor(held), Math.max(last - 1, 0));
    const u = held - first;
    const v = 1 - u;
    const [a, b] = [(v * v * v) / 6, (4 - 6 * u * u + 3 * u * u * u) / 6];
    const [c, d] = [(1 + 3 * u + 3 * u * u - 3 * u * u * u) / 6, (u * u * u) / 6];
    const { width, weights } = this;
    let row = first * width; // the weights begin a row before the frames
    for (let k = 0; k < width; k++, row++)
      out[k] = a * weights[row] + b * weights[row + width] + c * weights[row + 2 * width] + d * weights[row + 3 * width];
  }
}

/**
 * Weights of the spline's basis, for a row before the first frame to two after the last.
 *
 * The weights of inner frames solve w[i - 1] + 4 w[i] + w[i + 1] = 6 values[i]; those of the ends are the values.
 *
 * @param {Float32Array} values
 * @param {number} width
 * @returns {Float32Array}
 */
function splineWeights(values, width) {
  const frames = values.length / width;
  const out = new Float32Array((frames + 3) * width);
  const ratios = new Float64Array(frames);
  out.set(values, width);
  for (let frame = 1; frame < frames - 1; frame++) {
    ratios[frame] = 1 / (4 - ratios[frame - 1]);
    const row = (frame + 1) * width;
    for (let k = row; k < row + width; k++) out[k] = (6 * out[k] - out[k - width]) * ratios[frame];
  }
  for (let frame = frames - 2; frame > 0; frame--) {
    const row = (frame + 1) * width;
    for (let k = row; k < row + width; k++) out[k] -= ratios[frame] * out[k + width];
  }
  const end = frames * width; // the row of the last frame
  for (let k = 0; k < width; k++) {
    out[k] = frames > 1 ? 2 * out[k + width] - out[k + 2 * width] : out[k + width];
    out[end + width + k] = frames > 1 ? 2 * out[end + k] - out[end - width + k] : out[end + k];
    out[end + 2 * width + k] = out[end + width + k]; // is weighted by zero
  }
  return out;
}
