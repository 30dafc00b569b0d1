/** A figure that the server drew, as a picture in the page's own colours. */
import { memo } from "preact/compat";
import { useMemo } from "preact/hooks";
import { isDark } from "./colours";

export interface Drawn { name: string; title: string; description: string; svg: string }

/** The report's colours (src/ridedown/report/style.py) to those that stand out on a dark card. */
const ON_DARK: Record<string, string> = {
  "#ffffff": "#181f29", "#222222": "#e8edf3", "#000000": "#e8edf3", "#e3e3e3": "#303b49", "#8a8a8a": "#8c9bad",
  "#0072b2": "#5db4ee", "#d55e00": "#ff8b4a", "#009e73": "#35c99a", "#cc79a7": "#ef9fd0", "#e69f00": "#f0b429", "#56b4e9": "#9bd8fa",
};

/** Text that says no colour is black: it gets one, which what a text says of its own goes before. */
function onDark(svg: string): string {
  const coloured = svg.replace(/#[0-9a-f]{6}\b/gi, (colour) => ON_DARK[colour.toLowerCase()] ?? colour);
  return coloured.replace("<defs>", `<style>text { fill: ${ON_DARK["#000000"]} }</style><defs>`);
}

export const Drawing = memo(function Drawing({ drawn, theme }: { drawn: Drawn; theme: string }) {
  const source = useMemo(() => {
    const svg = isDark() ? onDark(drawn.svg) : drawn.svg;
    return `data:image/svg+xml;charset=utf-8,${encodeURIComponent(svg)}`;
  }, [drawn, theme]);
  return (
    <figure class="card drawn">
      <div class="scroll" tabIndex={0} role="region" aria-label={drawn.title}>
        <img src={source} alt={`${drawn.title}. ${drawn.description}`} width={691} height={374} />
      </div>
      <figcaption class="quiet">{drawn.description}</figcaption>
    </figure>
  );
});
