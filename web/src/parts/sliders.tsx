/** The numbers of a scenario: a slider, and a field to type into, for each. */
import { memo } from "preact/compat";
import { useState } from "preact/hooks";
import type { SliderInfo } from "../types";
import { digits, show, shownUnit, typed } from "../units";

interface Props {
  sliders: SliderInfo[];
  values: Record<string, number>;
  all: boolean;
  refused: { field: string; message: string } | null;
  onChange: (path: string, value: number, at: number) => void;
  onReset: (path: string) => void;
}

export function Sliders({ sliders, values, all, refused, onChange, onReset }: Props) {
  const shown = sliders.filter((one) => all || one.first || one.path in values);
  const groups = [...new Set(shown.map((one) => one.group))];
  return (
    <>
      {groups.map((group) => (
        <details key={group} open={group !== "scenario"} class="group">
          <summary>{group}</summary>
          {shown.filter((one) => one.group === group).map((one) => (
            <Slider key={one.path} info={one} value={values[one.path] ?? one.value} changed={one.path in values}
              refused={refused?.field === one.path ? refused.message : ""} onChange={onChange} onReset={onReset} />
          ))}
        </details>
      ))}
    </>
  );
}

interface One {
  info: SliderInfo; value: number; changed: boolean; refused: string; onChange: Props["onChange"]; onReset: Props["onReset"];
}

const Slider = memo(function Slider({ info, value, changed, refused, onChange, onReset }: One) {
  const { path, label, unit } = info;
  const shown = shownUnit(unit, path);
  const [text, setText] = useState<string | null>(null);
  const wrong = text !== null && typed(text, unit, path) === null;
  const name = `${info.group}, ${label}`;
  const take = () => {
    const value = text === null ? null : typed(text, unit, path);
    if (value !== null) onChange(path, value, performance.now());
    setText(null);
  };
  const low = Math.min(info.low, value), high = Math.max(info.high, value);
  return (
    <div class={`slider${changed ? " changed" : ""}`}>
      <label for={`s-${path}`}>{label}</label>
      <input id={`s-${path}`} type="range" min={low} max={high} step="any" value={value} aria-label={name}
        aria-valuetext={show(value, unit, path)}
        onInput={(event) => onChange(path, fine(Number(event.currentTarget.value)), event.timeStamp)} />
      <span class="typed">
        <input type="text" inputMode="decimal" aria-label={`${name}, typed, ${shown.unit || "a plain number"}`} aria-invalid={wrong || !!refused}
          value={text ?? digits(value * shown.scale)} onInput={(event) => setText(event.currentTarget.value)}
          onBlur={take} onKeyDown={(event) => event.key === "Enter" && take()} />
        <span class="unit">{shown.unit}</span>
        <button type="button" class="reset" disabled={!changed} onClick={() => onReset(path)} aria-label={`${name}: as in the scenario`} title="as in the scenario">↺</button>
      </span>
      {refused && <p class="refused">{refused}</p>}
    </div>
  );
});

/** What a slider gives, without the noise of its last digits: addresses stay short. */
function fine(value: number): number {
  return Number(value.toPrecision(4));
}
