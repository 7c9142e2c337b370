// The page's side of the protocol; a test compares these tables with the server's schema.

/** The fields of each command, next to `type` and `id`. */
export const COMMANDS = {
  add_object: ["name", "color", "frame", "region", "preset", "config", "seed"],
  change_object: ["object", "name", "color", "preset", "config", "seed"],
  remove_object: ["object"],
  set_keyframe: ["object", "frame", "region"],
  remove_keyframe: ["object", "frame"],
  set_absent: ["object", "first", "last"],
  split: ["object", "frame"],
  join: ["object", "other"],
  track: ["objects"],
  stop: ["job"],
  undo: [],
  redo: [],
  watch: ["detector", "preset", "config", "seed"],
  set_places: ["places"],
  acknowledge: ["number"],
};

/** The parts of a row, in their order. */
export const ROW = [
  "frame", "time", "x", "y", "a", "b", "theta", "confidence", "status", "distance",
  "effective_sample_size", "belief", "deviations", "cue_weights", "final", "milliseconds",
  "supporting",
];

/** The parts of an object of the many-object mode, in their order. */
export const SCENE_OBJECT = [
  "id", "x", "y", "width", "height", "confidence", "status", "occluded_by", "label",
];

/** Return the text of a command. */
export function encode(type, id, fields) {
  const known = COMMANDS[type];
  const unknown = known ? Object.keys(fields).find((name) => !known.includes(name)) : type;
  if (unknown !== undefined) throw new Error(`The protocol has no ${unknown}.`);
  return JSON.stringify({ type, id, ...fields });
}

/** Return an array of the wire as an object with these names. */
export const named = (names, values) =>
  Object.fromEntries(names.map((name, place) => [name, values[place]]));
