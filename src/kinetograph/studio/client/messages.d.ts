// Generated from the Python classes by: python -m kinetograph.studio.typescript

// Fields with a question mark have a default there, and may be left out.

/** The sections of a project. */
export type Mode = "walk" | "keys" | "duet" | "sensors";

/** A part of a key that is to be elsewhere than in the pose; see this module for the fields. */
export interface RequestPartRow {
  role: string;
  in: "root" | "world";
  position?: [number, number, number] | null;
  orientation?: [number, number, number, number] | null;
}

/** A foot that stays where it is for a span. */
export interface RequestContactRow {
  part: "left_foot" | "left_toe" | "right_foot" | "right_toe";
  start: number;
  stop: number;
}

/** A move that is asked for, or ruled out, in a span. */
export interface RequestMoveRow {
  start: number;
  stop: number;
  name?: string;
  forbid?: boolean;
  weight?: number | null;
  first?: "" | "left" | "right";
  last?: "" | "left" | "right";
  like?: string;
  within?: number | null;
}

/** A key of a request. */
export interface RequestOnPathRow {
  pose: string;
  time?: number | [number, number] | null;
  position?: [number, number] | null;
  heading?: number | null;
  roles?: string[] | null;
  parts?: RequestPartRow[];
  track?: string | null;
  units?: string | null;
  up?: string | null;
  fps?: number | null;
  name?: string | null;
  along?: number | null;
  near?: [number, number] | null;
  weight?: number;
}

/** What is pinned or forbidden in a span of a control; see `kinetograph.methods.performance.Rule`. */
export interface RuleRow {
  start: number;
  stop: number;
  take?: string | null;
  source?: number | [number, number] | null;
  forbid?: boolean;
}

/** A part of a walk's body that something else drives. */
export interface LayerRow {
  parts: string[];
  source: string;
  library?: string;
  start?: number;
  second?: number;
  seconds?: number | null;
  ease?: number;
  hold?: boolean;
}

/** A drawn path, and how it is walked. */
export interface Walk {
  library?: string;
  path?: [number, number, number][];
  smooth_time?: number;
  smooth_space?: number;
  mirror?: boolean;
  keep_time?: boolean;
  facing?: number | null;
  rules?: RuleRow[];
  layers?: LayerRow[];
  keys?: RequestOnPathRow[];
  moves?: RequestMoveRow[];
  contacts?: RequestContactRow[];
  fill?: boolean | null;
}

/** Where a part of a key's body is to be, as `kinetograph.keys.PartFromRoot` and `PartInWorld` have it. */
export interface PartRow {
  role: string;
  in: "root" | "world";
  position?: [number, number, number] | null;
  orientation?: [number, number, number, number] | null;
}

/** A key, with the fields of `kinetograph.formats.keys_json`. */
export interface KeyRow {
  pose: string;
  time?: number | [number, number] | null;
  position?: [number, number] | null;
  heading?: number | null;
  roles?: string[] | null;
  moved?: Record<string, [number, number, number]>;
  name?: string | null;
  parts?: PartRow[];
}

/** A span of an earlier result that is kept, and what that result was made of. */
export interface Lock {
  span: [number, number];
  of: Keys;
}

/** Poses to go through. */
export interface Keys {
  library?: string;
  rows?: KeyRow[];
  moves?: string[];
  without?: string[];
  filler?: boolean;
  mirror?: boolean;
  alternatives?: number;
  chosen?: number;
  lock?: Lock | null;
  force?: boolean;
}

/** A leader, who is answered. */
export interface Duet {
  library?: string;
  leader?: string;
  target?: string;
  mirror?: boolean;
  person?: string;
  units?: string;
  up?: string;
  rules?: RuleRow[];
}

/** Readings of worn sensors. */
export interface Sensors {
  library?: string;
  readings?: string;
  layout?: string;
  use?: string[];
  synthesis?: "continuity" | "guided" | "interpolation" | "optimisation" | "ridge";
  track?: string;
  source?: string;
  names?: Record<string, string>;
}

/** What a person has asked for. */
export interface Project {
  version?: 1;
  mode?: "duet" | "keys" | "sensors" | "walk";
  libraries?: Record<string, string>;
  character?: string;
  walk?: Walk;
  keys?: Keys;
  duet?: Duet;
  sensors?: Sensors;
}

/** Stop what is being made. */
export interface Cancel {
  kind: "cancel";
}

/** The header of a blob whose payload is a GLB that answers a question: a ghost, an alternative, a take. */
export interface ClipHeader {
  kind: "clip";
  id: number;
  name?: string;
  floor?: number;
  start?: number;
}

/** A section, or a field, of the project in a new state. */
export interface Edit {
  kind: "edit";
  part: string;
  value: any;
  label?: string;
  merge?: boolean;
  solve?: boolean;
  number?: number;
}

/** Something could not be done, in one line. */
export interface Failed {
  kind: "failed";
  message: string;
  id?: number | null;
  section?: "duet" | "keys" | "sensors" | "walk" | null;
}

/** A file was taken into the project, under this name; the project's files. */
export interface Kept {
  kind: "kept";
  id: number;
  name: string;
  files: string[];
}

/** A library of the project: its takes, and what can be done with it. */
export interface LibraryRow {
  name: string;
  takes: number;
  seconds: number;
  tracks: string[];
  partners: boolean;
}

/** The header of a blob whose payload is a body as GLB, which the pose frames after it move. */
export interface LiveHeader {
  kind: "live";
  section: "duet" | "keys" | "sensors" | "walk";
  floor?: number;
  characters?: string[];
}

/** A section asks for nothing that could be made yet. */
export interface Nothing {
  kind: "nothing";
  section: "duet" | "keys" | "sensors" | "walk";
}

/** Make the edit that was taken back again; its number is answered as that of an edit. */
export interface Redo {
  kind: "redo";
  number?: number;
}

/** Something a person should know, in one line. */
export interface Said {
  kind: "said";
  message: string;
}

/** Make the section that is shown. */
export interface Solve {
  kind: "solve";
}

/** The project, whenever it changes. */
export interface State {
  kind: "state";
  project: Project;
  revision: number;
  undo?: string | null;
  redo?: string | null;
  number?: number;
}

/** End what runs live. */
export interface StopRun {
  kind: "stop_run";
}

/** Take the last edit back; its number is answered as that of an edit. */
export interface Undo {
  kind: "undo";
  number?: number;
}

/** The first message to a page, sent again when what it says changes. */
export interface Welcome {
  kind: "welcome";
  version: string;
  formats: string[];
  films: string[];
  libraries: LibraryRow[];
  files: string[];
}

/** Something is being made or fetched: how far it is; ``done`` is ``total`` at its end. */
export interface Working {
  kind: "working";
  label: string;
  done: number;
  total: number;
  section?: "duet" | "keys" | "sensors" | "walk" | null;
}

/** Ask which hands of the follower that was made last hold which of the leader's. */
export interface AskHands {
  kind: "ask_hands";
  id: number;
}

/** Ask who the leader of the project is. */
export interface AskLeader {
  kind: "ask_leader";
  id: number;
}

/** Ask for the takes that can lead a duet: of a library, the project's unless given. */
export interface AskLeaders {
  kind: "ask_leaders";
  id: number;
  library?: string | null;
}

/** The handholds of the follower and the leader. */
export interface Hands {
  kind: "hands";
  id: number;
  holds?: HandsRow[];
}

/** Hands that hold each other: the joints, as the bodies that are shown call them. */
export interface HandsRow {
  start: number;
  stop: number;
  own: string;
  theirs: string;
  met?: boolean;
}

/** The leader of the project. */
export interface LeaderFacts {
  kind: "leader_facts";
  id: number;
  name: string;
  seconds: number;
  person: string;
  persons?: string[];
  truth?: boolean;
  notes?: string[];
}

/** A take that can lead, and the people in it who can. */
export interface LeaderRow {
  take: string;
  seconds: number;
  persons: string[];
}

/** The takes of a library that can lead. */
export interface LeaderTakes {
  kind: "leader_takes";
  id: number;
  library: string;
  takes?: LeaderRow[];
  target?: string;
  targets?: string[];
  advice?: string;
}

/** A move of a transcript. */
export interface MoveRow {
  move: string;
  start: number;
  stop: number;
  margin?: number | null;
  notation?: string;
}

/** Let the leader of the project dance now, and the follower answer live. */
export interface Rehearse {
  kind: "rehearse";
  lag?: number;
}

/** How a rehearsal goes. */
export interface Rehearsed {
  kind: "rehearsed";
  second: number;
  seconds: number;
  lag: number;
  load?: number;
  running?: boolean;
  error?: number | null;
}

/** Ask for the leader of the project as a clip. */
export interface ShowLeader {
  kind: "show_leader";
  id: number;
}

/** Ask for the moves of the follower that was made last. */
export interface Transcribe {
  kind: "transcribe";
  id: number;
}

/** The moves of the follower in order, or what to do to have them. */
export interface Transcribed {
  kind: "transcribed";
  id: number;
  moves?: MoveRow[];
  advice?: string;
}

/** The header of a blob from the page: a file that was dropped onto it. */
export interface FileHeader {
  kind: "file";
  id: number;
  name: string;
  role: "character" | "layout" | "leader" | "readings" | "recording";
}

/** Asks for one of the motions through the keys as a clip; the first is number 0. */
export interface Alternative {
  kind: "alternative";
  id: number;
  number: number;
}

/** Where the hands and feet of a key are. */
export interface EndPlaces {
  kind: "end_places";
  id: number;
  ends: Record<string, [number, number, number]>;
  roles: string[];
  position: [number, number];
  heading: number;
  said?: string[];
  positions?: Record<string, [number, number, number]>;
  orientations?: Record<string, [number, number, number, number]>;
}

/** Asks where the hands and feet of a key are (`EndPlaces`). */
export interface KeyEnds {
  kind: "key_ends";
  id: number;
  row: KeyRow;
}

/** Asks for the pose of a key as a clip of one frame: the root above the origin, with the heading 0. */
export interface KeyPose {
  kind: "key_pose";
  id: number;
  row: KeyRow;
}

/** Asks when and where the project's keys are met in what is shown (`Met`). */
export interface KeysMet {
  kind: "keys_met";
  id: number;
}

/** Asks which of the project's keys cannot be met (`Trouble`). */
export interface KeyTrouble {
  kind: "key_trouble";
  id: number;
}

/** When and where the keys are met, one row per key. */
export interface Met {
  kind: "met";
  id: number;
  rows: MetRow[];
}

/** When and where a key is met: seconds, metres x and z of the root, and its heading in degrees. */
export interface MetRow {
  time: number;
  position: [number, number];
  heading: number;
}

/** Why keys cannot be met. */
export interface Trouble {
  kind: "trouble";
  id: number;
  message?: string;
  row?: number | null;
  seconds?: number | null;
  force?: boolean;
}

/** Parts of takes that are like an example, the nearest first, one of each track. */
export interface Alike {
  kind: "alike";
  id: number;
  rows: FoundRow[];
}

/** Where a library has something like a part of a take. */
export interface AskAlike {
  kind: "ask_alike";
  id: number;
  take: string;
  start: number;
  stop: number;
  library?: string;
  count?: number;
}

/** A take of a library as it was recorded; answered by a clip. */
export interface AskClip {
  kind: "ask_clip";
  id: number;
  take: string;
  library?: string;
}

/** Which takes a library has. */
export interface AskTakes {
  kind: "ask_takes";
  id: number;
  library?: string;
  words?: string;
  tags?: string[];
  first?: number;
  count?: number;
}

/** Thumbnails of takes of a library. */
export interface AskThumbnails {
  kind: "ask_thumbnails";
  id: number;
  takes: string[];
  library?: string;
}

/** Write what is shown into files. */
export interface Export {
  kind: "export";
  id: number;
  formats: string[];
  name: string;
  together?: boolean;
}

/** Files that were written: their names, and where the page can fetch them from. */
export interface Exported {
  kind: "exported";
  id: number;
  files: [string, string][];
}

/** A part of a take that is like an example, and how far it is from it in metres. */
export interface FoundRow {
  take: string;
  track: string;
  start: number;
  stop: number;
  distance: number;
}

/** A take of a library. */
export interface TakeRow {
  name: string;
  seconds: number;
  tracks: string[];
  tags: string[];
}

/** Takes of a library. */
export interface Takes {
  kind: "takes";
  id: number;
  found: number;
  all: number;
  rows: TakeRow[];
  tags: [string, number][];
}

/** A moving thumbnail. */
export interface ThumbnailRow {
  take: string;
  frames: number;
  bones: number;
  seconds: number;
  widths: number[];
  sides: number[];
}

/** The header of a blob of thumbnails. */
export interface ThumbnailsHeader {
  kind: "thumbnails";
  id: number;
  rows: ThumbnailRow[];
}

/** A figure about what was made, as a person reads it: ``"path error"``, ``"3.2 cm"``. */
export interface Figure {
  name: string;
  value: string;
  title?: string;
}

/** A lane of the timeline: spans, or the values of a signal at even times. */
export interface Lane {
  name: string;
  role: string;
  spans?: Span[];
  values?: number[];
  unit?: string;
}

/** The header of a blob whose payload is the GLB of what was made. */
export interface MadeHeader {
  kind: "made";
  section: "duet" | "keys" | "sensors" | "walk";
  key: string;
  seconds: number;
  fps: number;
  floor?: number;
  characters?: string[];
  pieces?: PieceRow[];
  lanes?: Lane[];
  figures?: Figure[];
  warnings?: string[];
  path?: [number, number, number][];
  clock?: [number, number][];
  costs?: number[];
  chosen?: number;
}

/** A piece of the motion shown; see `kinetograph.Piece`. */
export interface PieceRow {
  take: string;
  track: string;
  start: number;
  stop: number;
  source_start: number;
  source_stop: number;
  cost: number;
  seam: number;
  mirrored?: boolean;
  layer?: string;
}

/** A span of a lane of the timeline. */
export interface Span {
  start: number;
  stop: number;
  label?: string;
  title?: string;
}

/** Calibrate the sensors of the section's layout, and save the layout as a file of the project. */
export interface Calibrate {
  kind: "calibrate";
  source: string;
  still?: [number, number] | null;
  ready?: number;
  standing?: number;
  moving?: number;
  layout?: string;
}

/** Sensors that were calibrated. */
export interface Calibrated {
  kind: "calibrated";
  layout: string;
  rows: CalibratedRow[];
  files: string[];
}

/** How a sensor was calibrated. */
export interface CalibratedRow {
  sensor: string;
  verdict: string;
  before?: number;
  residual?: number;
  like?: number;
  other?: string;
  apart?: number;
  rotated?: number;
}

/** Where a calibration is: what the wearer does now, and the seconds that are left of it. */
export interface CalibrationStep {
  kind: "calibration_step";
  step: "moving" | "ready" | "solving" | "still";
  left: number;
  total: number;
}

/** Call sensors by other names from now on, while listening. */
export interface CallSensors {
  kind: "call_sensors";
  names: Record<string, string>;
}

/** Who is heard, once a second, and the layout's sensors. */
export interface Heard {
  kind: "heard";
  rows: HeardRow[];
  sensors: string[];
}

/** What is heard of a sensor: rows a second, the share that was lost, rows that came late, and its latest force. */
export interface HeardRow {
  sensor: string;
  rate: number;
  lost: string;
  late: number;
  force: number;
  known: boolean;
}

/** The header of a blob whose payload is a value for every joint at even times, as float32. */
export interface JointsHeader {
  kind: "joints";
  id: number;
  fps: number;
  joints: string[];
  frames: number;
}

/** Ask for the uncertainty of every joint of what was sensed last; answered by a blob with a `JointsHeader`. */
export interface JointUncertainty {
  kind: "joint_uncertainty";
  id: number;
}

/** Sense live: what the section's source sends drives a body. */
export interface Listen {
  kind: "listen";
}

/** What ran live has come to its end, after so many frames. */
export interface LiveEnded {
  kind: "live_ended";
  section: "duet" | "keys" | "sensors" | "walk";
  frames: number;
}

/** The link that a phone has to open, and its QR code. */
export interface PhoneLink {
  kind: "phone_link";
  link: string;
  code?: string[];
}

/** How fast are the library's people? Answered by `Pace`; its model is fitted by then. */
export interface AskPace {
  kind: "ask_pace";
  id: number;
}

/** Why is the piece at a time of the walk there, and what else could be? Answered by `Why`. */
export interface AskWhy {
  kind: "ask_why";
  id: number;
  time: number;
}

/** The walk as a clip under rules besides its own: those of a candidate. */
export interface CandidateClip {
  kind: "candidate_clip";
  id: number;
  rules: RuleRow[];
}

/** A piece that could be at a time of the walk, and what the best walk with it costs. */
export interface CandidateRow {
  take: string;
  mirrored: boolean;
  source_start: number;
  source_stop: number;
  start: number;
  stop: number;
  cost: number;
  interpretation: number;
  continuity: number;
  reuse: number;
  more: number;
  rules: RuleRow[];
}

/** What could be at a time of the walk; the first is what is there. */
export interface Candidates {
  kind: "candidates";
  id: number;
  time: number;
  rows: CandidateRow[];
}

/** What could take the place of the piece at a time of the walk? Answered by `Candidates`. */
export interface NextBest {
  kind: "next_best";
  id: number;
  time: number;
  count?: number;
}

/** How fast the library's people walk, metres per second. */
export interface Pace {
  kind: "pace";
  id: number;
  slowest: number;
  fastest: number;
  usual: [number, number, number];
  stands: boolean;
  takes: TakePace[];
}

/** The recording behind the piece at a time of the walk, placed where the piece is, as a clip. */
export interface PieceSource {
  kind: "piece_source";
  id: number;
  time: number;
}

/** A take of the library as a clip, at its own pace, from where the path begins. */
export interface PlayTake {
  kind: "play_take";
  id: number;
  take: string;
}

/** A take of a library: how long it is, and its mean speed over the ground, metres per second. */
export interface TakePace {
  name: string;
  seconds: number;
  speed: number;
}

/** Points that were drawn since the last: seconds, and metres x and z. */
export interface WalkDrawn {
  kind: "walk_drawn";
  points: [number, number, number][];
}

/** A person begins to draw: a body is to follow. */
export interface WalkLive {
  kind: "walk_live";
}

/** Why a piece is there: those with the least margins, and what would have to go for another to be there. */
export interface Why {
  kind: "why";
  id: number;
  time: number;
  rows: WhyRow[];
  without: WithoutRow[];
  span?: [number, number] | null;
  played?: PieceRow[];
  layers?: string[];
}

/** A piece that could be at a time of the walk, with what the best walk with it is charged for. */
export interface WhyRow {
  take: string;
  mirrored: boolean;
  chosen: boolean;
  source_start: number;
  source_stop: number;
  start: number;
  stop: number;
  margin: number;
  terms: Record<string, number>;
  without: string[];
}

/** What would be at a time of the walk without a constraint or a cost, and how much less the walk would cost. */
export interface WithoutRow {
  constraint: string;
  take: string;
  mirrored: boolean;
  source_start: number;
  source_stop: number;
  saved: number;
}

export type AnyMessage =
  | Cancel
  | Edit
  | Failed
  | Kept
  | Nothing
  | Redo
  | Said
  | Solve
  | State
  | StopRun
  | Undo
  | Welcome
  | Working
  | AskHands
  | AskLeader
  | AskLeaders
  | Hands
  | LeaderFacts
  | LeaderTakes
  | Rehearse
  | Rehearsed
  | ShowLeader
  | Transcribe
  | Transcribed
  | Alternative
  | EndPlaces
  | KeyEnds
  | KeyPose
  | KeysMet
  | KeyTrouble
  | Met
  | Trouble
  | Alike
  | AskAlike
  | AskClip
  | AskTakes
  | AskThumbnails
  | Export
  | Exported
  | Takes
  | Calibrate
  | Calibrated
  | CalibrationStep
  | CallSensors
  | Heard
  | JointUncertainty
  | Listen
  | LiveEnded
  | PhoneLink
  | AskPace
  | AskWhy
  | CandidateClip
  | Candidates
  | NextBest
  | Pace
  | PieceSource
  | PlayTake
  | WalkDrawn
  | WalkLive
  | Why;
