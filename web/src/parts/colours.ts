/** Okabe and Ito's colours, told apart with any common colour blindness; dashes go with them. */

const LIGHT = ["#0072b2", "#d55e00", "#009e73", "#c2578f", "#b87800", "#3b9fd4", "#1b1f24"];
const DARK = ["#5db4ee", "#ff8b4a", "#35c99a", "#ef9fd0", "#f0b429", "#9bd8fa", "#e8edf3"];
const DASHES: number[][] = [[], [6, 3], [2, 2], [8, 3, 2, 3]];

const system = matchMedia("(prefers-color-scheme: dark)");

export function isDark(): boolean {
  const chosen = document.documentElement.dataset.theme;
  return chosen ? chosen === "dark" : system.matches;
}

export function colour(index: number): string {
  const palette = isDark() ? DARK : LIGHT;
  return palette[index % palette.length]!;
}

/** Colours come round after seven lines, dashes after four: no two of 28 lines look the same. */
export function dash(index: number): number[] {
  return DASHES[index % DASHES.length]!;
}

export function variable(name: string): string {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}
