// Colors of objects. People with color blindness tell them apart (Okabe and Ito, 2008); dashes and
// labels differ as well.

export const COLORS = [
  { name: "orange", value: "#e69f00" },
  { name: "sky blue", value: "#56b4e9" },
  { name: "green", value: "#009e73" },
  { name: "yellow", value: "#f0e442" },
  { name: "vermilion", value: "#d55e00" },
  { name: "purple", value: "#cc79a7" },
  { name: "blue", value: "#0072b2" },
];

const DASHES = [[], [9, 4], [3, 3], [12, 3, 3, 3], [6, 3, 2, 3, 2, 3]];

/** Return the color of the next object of a list: the first that is not used. */
export function nextColor(objects) {
  const used = new Set(objects.map((object) => object.color));
  const free = COLORS.find(({ value }) => !used.has(value));
  return (free ?? COLORS[objects.length % COLORS.length]).value;
}

/** Return the dashes of the object at a place of the list. */
export const dashes = (place) => DASHES[place % DASHES.length];

/** Return the color of a many-object track. */
export const trackColor = (id) => COLORS[Math.abs(id) % COLORS.length].value;

/** Return red, green, blue of a share from 0 to 1: viridis, whose lightness is even. */
export function viridis(share) {
  const at = Math.min(0.9999, Math.max(0, share)) * (VIRIDIS.length - 1);
  const [low, high, part] = [VIRIDIS[Math.floor(at)], VIRIDIS[Math.floor(at) + 1], at % 1];
  return low.map((value, place) => Math.round(value + (high[place] - value) * part));
}

const VIRIDIS = [
  [68, 1, 84], [71, 44, 122], [59, 81, 139], [44, 113, 142], [33, 144, 141],
  [39, 173, 129], [92, 200, 99], [170, 220, 50], [253, 231, 37],
];
