/** A field for one number: shown in the unit that engineers write, typed in that or with a unit of its own. */
import { useState } from "preact/hooks";
import { digits, shownUnit, typed } from "../units";

interface Props { label: string; value: number; unit: string; path?: string; onChange: (value: number) => void }

export function NumberField({ label, value, unit, path = "", onChange }: Props) {
  const [text, setText] = useState<string | null>(null);
  const wrong = text !== null && typed(text, unit, path) === null;
  const take = () => {
    const found = text === null ? null : typed(text, unit, path);
    if (found !== null && found !== value) onChange(found);
    setText(null);
  };
  return (
    <input type="text" class="number-field" inputMode="decimal" aria-label={label} aria-invalid={wrong} value={text ?? digits(value * shownUnit(unit, path).scale)}
      onInput={(event) => setText(event.currentTarget.value)} onBlur={take} onKeyDown={(event) => event.key === "Enter" && take()} />
  );
}
