/** Contour lines by marching squares, and round numbers to draw them at. */

/** Pieces [x1, y1, x2, y2] in grid indices, of values (ny rows of nx) at a level; cells with a missing corner have none. */
export function contours(values: ArrayLike<number>, nx: number, ny: number, level: number): [number, number, number, number][] {
  const found: [number, number, number, number][] = [];
  for (let j = 0; j < ny - 1; j++) {
    for (let i = 0; i < nx - 1; i++) {
      const a = values[j * nx + i]! - level, b = values[j * nx + i + 1]! - level;
      const c = values[(j + 1) * nx + i + 1]! - level, d = values[(j + 1) * nx + i]! - level;
      if (Number.isNaN(a + b + c + d)) continue;
      const crossings: [number, number][] = [];
      if (a > 0 !== b > 0) crossings.push([i + a / (a - b), j]);
      if (b > 0 !== c > 0) crossings.push([i + 1, j + b / (b - c)]);
      if (d > 0 !== c > 0) crossings.push([i + d / (d - c), j + 1]);
      if (a > 0 !== d > 0) crossings.push([i, j + a / (a - d)]);
      // four crossings are a saddle: bottom with right and top with left, or the other way, by the middle
      if (crossings.length === 4 && a + b + c + d > 0 === a > 0) crossings.push(crossings.shift()!);
      for (let k = 0; k + 1 < crossings.length; k += 2) found.push([...crossings[k]!, ...crossings[k + 1]!]);
    }
  }
  return found;
}

/** The same pieces joined into lines, each a list of points: what dashes need. */
export function joined(pieces: [number, number, number, number][]): [number, number][][] {
  const key = (x: number, y: number) => `${x.toFixed(6)},${y.toFixed(6)}`;
  const at = new Map<string, number[]>();
  pieces.forEach(([x1, y1, x2, y2], i) => {
    for (const end of [key(x1, y1), key(x2, y2)]) at.set(end, [...(at.get(end) ?? []), i]);
  });
  const used = new Set<number>();
  const walk = (x: number, y: number): [number, number][] => {
    const line: [number, number][] = [];
    for (;;) {
      const next = at.get(key(x, y))?.find((i) => !used.has(i));
      if (next === undefined) return line;
      used.add(next);
      const [x1, y1, x2, y2] = pieces[next]!;
      [x, y] = key(x1, y1) === key(x, y) ? [x2, y2] : [x1, y1];
      line.push([x, y]);
    }
  };
  return pieces.flatMap(([x1, y1], i) => (used.has(i) ? [] : [[...walk(x1, y1).reverse(), [x1, y1] as [number, number], ...walk(x1, y1)]]));
}

/** Round numbers from low to high, about so many. */
export function niceSteps(low: number, high: number, about: number): number[] {
  const rough = (high - low) / about;
  if (!(rough > 0) || !Number.isFinite(rough)) return [];
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * ([1, 2, 2.5, 5, 10].find((one) => one * power >= rough) ?? 10);
  const first = Math.ceil(low / step - 1e-9);
  return Array.from({ length: Math.floor(high / step + 1e-9) - first + 1 }, (_, i) => Number(((first + i) * step).toPrecision(12)));
}
