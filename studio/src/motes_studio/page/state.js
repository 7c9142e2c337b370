// All that the page knows. What the server knows is in `session`, `rows` and what follows it.

const LAYERS = ["ellipse", "labels", "particles", "trails", "places"];
const LANES = ["confidence", "size", "speed", "particles", "cues"];

/** Return the state of a page that has just been opened. */
export const initialState = () => ({
  // the first page
  films: null,
  sessions: null,
  presets: null,
  // how the page looks
  theme: "system",
  looks: 0,
  sized: 0,
  tab: "layers",
  shown: new Set(LAYERS),
  lanes: new Set(LANES),
  speed: 1,
  tracker: { preset: "default", config: null, seed: 0 },
  ...freshSession(),
});

/** Return the state of a session about which nothing is known yet. */
export const freshSession = () => ({
  // from the server
  session: null,
  film: null,
  times: [], // of the frames of a film whose rate varies
  connected: true,
  jobs: new Map(),
  rows: new Map(),
  overlays: new Map(), // by object and frame: the last ones
  newest: null, // the frame that a run has reached: object, frame and when
  doubts: new Map(),
  looked: null,
  scene: [],
  events: [],
  counts: null,
  // what the person looks at
  frame: 0,
  pictured: null, // the frame whose picture is on the stage
  awaited: new Set(), // frames whose pictures are on their way to the stage
  picture: 0,
  playing: false,
  following: false,
  view: null, // null shows the whole film
  range: null, // null shows all frames on the timeline
  selected: null,
  hidden: new Set(),
  // what the person is doing
  tool: "select",
  redrawing: false,
  draft: null,
  corners: [],
  doubtful: null,
  asked: null, // the particles that were asked for last
});
