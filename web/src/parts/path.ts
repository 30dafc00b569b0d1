/** A line through many points, drawn through the few that leave it where it is: what a wide line costs goes by its points. */
import uPlot from "uplot";

const AWAY = 0.25; // pixels of the canvas that the line may pass a point by, upwards or downwards
const JUMP = 1e-6; // pixels: points no farther apart than that are the two sides of a jump
const CROWDED = 4; // points a pixel, from which on uPlot's own way, by the extremes in each pixel, is the better one

const byExtremes = uPlot.paths.linear!();

/** For `paths` of a series. Where a value is missing (NaN), the line has a gap. */
export const fewestPoints: uPlot.Series.PathBuilder = (plot, series, first, last) => {
  const xs = plot.data[0], ys = plot.data[series]!;
  if (last - first >= CROWDED * plot.bbox.width) return byExtremes(plot, series, first, last);
  const [x0, perX] = pixels(plot, "x"), [y0, perY] = pixels(plot, plot.series[series]!.scale!);
  const stroke = new Path2D();
  let started = false, some = false; // whether the line has begun, and whether points wait since the last one it was drawn to
  let fromX = 0, fromY = 0, beforeX = 0, beforeY = 0;
  let low = -Infinity, high = Infinity; // slopes from the last point drawn that pass all that wait
  const draw = (x: number, y: number) => {
    stroke.lineTo(x, y);
    fromX = x, fromY = y, low = -Infinity, high = Infinity, some = false;
  };
  for (let i = first; i <= last; i++) {
    const x = x0 + perX * xs[i]!, y = y0 + perY * ys[i]!;
    if (Number.isNaN(y)) {
      if (some) draw(beforeX, beforeY);
      started = false;
      continue;
    }
    if (!started) {
      stroke.moveTo(x, y);
      draw(x, y);
      started = true;
      continue;
    }
    const slope = (y - fromY) / (x - fromX);
    if (some && (x - beforeX <= JUMP || slope < low || slope > high)) draw(beforeX, beforeY);
    const along = x - fromX;
    if (along <= JUMP) {
      draw(x, y);
      continue;
    }
    low = Math.max(low, (y - AWAY - fromY) / along);
    high = Math.min(high, (y + AWAY - fromY) / along);
    beforeX = x, beforeY = y, some = true;
  }
  if (some) draw(beforeX, beforeY);
  return { stroke };
};

/** Where zero of a scale lies on the canvas, and how many pixels there are to its unit. */
function pixels(plot: uPlot, scale: string): [number, number] {
  const { min, max } = plot.scales[scale]!;
  const from = plot.valToPos(min!, scale, true), per = (plot.valToPos(max!, scale, true) - from) / (max! - min! || 1);
  return [from - per * min!, per];
}
