import type { ViewProps } from "../app";

export function StudyView(_: ViewProps) {
  return <p class="note">Design studies run from the command line: <code>ridedown study</code>.</p>;
}
