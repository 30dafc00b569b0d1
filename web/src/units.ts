/** From SI to what engineers write, and back. */

export const G = 9.80665;

interface Shown { unit: string; scale: number }

const SHOWN: Record<string, Shown> = {
  "m": { unit: "mm", scale: 1e3 },
  "m/s": { unit: "km/h", scale: 3.6 },
  "m/s2": { unit: "g", scale: 1 / G },
  "N": { unit: "kN", scale: 1e-3 },
  "N/m": { unit: "kN/m", scale: 1e-3 },
  "s": { unit: "ms", scale: 1e3 },
};

/** Units that may be typed, in SI. */
const TYPED: Record<string, [string, number]> = {
  "m": ["m", 1], "mm": ["m", 1e-3], "cm": ["m", 1e-2], "m/s": ["m/s", 1], "km/h": ["m/s", 1 / 3.6], "kN": ["N", 1e3], "N": ["N", 1],
  "kN/m": ["N/m", 1e3], "N/mm": ["N/m", 1e3], "N/m": ["N/m", 1], "ms": ["s", 1e-3], "s": ["s", 1], "kg": ["kg", 1], "t": ["kg", 1e3],
  "g": ["m/s2", G], "m/s2": ["m/s2", 1], "%": ["", 1e-2], "N s/m": ["N s/m", 1], "kg m2": ["kg m2", 1],
};

const PERCENT = /(^|\.)(overlap|damping_ratio|part)$/;

export function shownUnit(unit: string, path = ""): Shown {
  if (unit === "") return PERCENT.test(path) ? { unit: "%", scale: 100 } : { unit: "", scale: 1 };
  return SHOWN[unit] ?? { unit, scale: 1 };
}

/** A number to so many digits, with a true minus sign, and no more zeros than it needs. */
export function digits(value: number, count = 4): string {
  if (!Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const decimals = Math.max(0, Math.min(6, count - 1 - Math.floor(Math.log10(Math.abs(value)))));
  const text = value.toFixed(decimals);
  return (text.includes(".") ? text.replace(/\.?0+$/, "") : text).replace("-", "−").replace(/^−0$/, "0");
}

export function show(value: number, unit: string, path = "", count = 4): string {
  const shown = shownUnit(unit, path);
  return `${digits(value * shown.scale, count)} ${shown.unit}`.trim();
}

/** What was typed, in SI: a number in the shown unit, or with a unit of its own; null where it is neither. */
export function typed(text: string, unit: string, path: string): number | null {
  const found = /^\s*([+\-−]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*$/.exec(text.replace(",", "."));
  if (!found) return null;
  const value = Number(found[1]!.replace("−", "-"));
  if (!found[2]) return value / shownUnit(unit, path).scale;
  const own = TYPED[found[2]];
  return own && own[0] === unit ? value * own[1] : null;
}
