// All words of the page, in English. Another language is another file of the same keys (words.xx.js, chosen
// by ?lang=xx).
import { fixed } from "./numbers.js";
import states from "./states.en.js";

const placeText = ({ latitude_deg, longitude_deg }) =>
  `${fixed(Math.abs(latitude_deg), 5)}° ${latitude_deg < 0 ? "S" : "N"}, ${fixed(Math.abs(longitude_deg), 5)}° ${longitude_deg < 0 ? "W" : "E"}`;

const capital = (text) => text.charAt(0).toUpperCase() + text.slice(1);

export default {
  // Laws, causes and alarms: the program's own words
  ...states,
  // Buttons and labels
  expert: "Expert", operate: "Operate", fullScreen: "Full screen", fullScreenEnd: "Window",
  manual: "Open the manual", keys: "Help ?", theme: "Night", themeDay: "Day", sound: "Sound off", soundOn: "Sound on",
  stage: "Picture", picture: "Picture of the camera. Drag a box around the boat. Enter starts a box by keyboard.",
  videosGroup: "The two videos", trackVideo: "Follow in this video",
  videoShown: (number, isTracked) => `Video ${number}: ${isTracked ? "the boat is followed here" : "watched only"}`,
  frozen: "Frozen: draw the box ", freeze: "Freeze", unfreeze: "Go on", reject: "Not that one", candidates: "Objects", deselect: "Forget", proposed: "proposed", tapToMark: "? tap to mark",
  mark: "Mark", marking: "Tap the point", markKind: "What is marked", unmark: "Remove", unmarkAll: "Clear", note: "Mark moment", noted: "The moment is marked in the recording.",
  stillThere: "The person is still there: the place is renewed.",
  markKinds: { person: "Person", place: "Place", "way-point": "Way-point", forbidden: "Keep out", home: "Home" },
  guide: "Go", guideInPicture: "Go in the picture", stopBoat: "Stop boat", nextMark: "Next", goHome: "Home",
  search: "Search", netYawZero: "Untwisted",
  tools: "Selection and zoom", zoomIn: "Zoom in", zoomOut: "Zoom out", zoomReset: "Fit", overlays: "Show",
  command: "Command", byHand: "By hand, boat, control", stop: "STOP", stopping: "STOPPING", stopKey: "Space", engage: "Engage", disengage: "Disengage",
  nudge: "Turn camera", nudgeUp: "Tilt the camera up", nudgeDown: "Tilt the camera down",
  nudgeLeft: "Pan the camera left", nudgeRight: "Pan the camera right",
  wide: "Wide", near: "Near", lensWider: "Zoom the camera out", lensCloser: "Zoom the camera in", keepSize: "Keep size",
  drive: "Drive boat", helmAhead: "Boat ahead", helmAstern: "Boat astern", helmLeft: "Boat left", helmRight: "Boat right",
  pause: "Pause", resume: "Resume", helmsman: "Helmsman", law: "Camera law",
  takeControl: "Take control", askControl: "Ask for control", askedControl: "Asked: waiting", giveControl: (who) => `Give control to ${who}`,
  newDrive: "New drive", beginDrive: "Begin", scenario: "Scenario", seed: "Seed",
  newDriveText: "Another world takes the place of this one. The camera stops, and the marks go.",
  worldText: (command, { scenario, seed }) => `${command}  sim:${scenario}, seed ${seed}`,
  drillsTitle: "Drills", drillsText: "Short tasks in another world, each with a result. The camera stops, and the marks go.",
  drillText: (title, s) => `Drill: ${title}. ${s} s left`, drillPassed: "passed", drillFailed: "not passed",
  drillBy: { person: "You", schema: "The paper's schema", default: "The default law" },
  drillInPicture: "In the picture", drillInEllipse: "In the ellipse", drillMoves: "Movements", drillTravel: "Camera's way",
  drillFigures: ({ in_picture: picture, in_ellipse: ellipse, moves, travel_rad: travel }) =>
    [`${Math.round(100 * picture)} %`, `${Math.round(100 * ellipse)} %`, String(moves), `${fixed(travel, 2)} rad`],
  drillNote: "The laws had the same boat on the same way, with perfect sight, and were engaged from the start.",
  drillNext: "Next drill", drillAgain: "Again", drillAll: "All drills",
  thisIsTheBoat: "This is the boat: tap it, or drag a box around it.",
  hintClose: "Got it", hintsAgain: "Show the hints again",
  devices: "Other devices", devicesHere: "This console is for this computer alone. For other devices, start the program with --listen 0.0.0.0:8480.",
  linkControl: "To control", linkWatch: "To watch", otherPages: "Open pages", noPages: "No other page is open.", signOut: "Sign out",
  newLinksText: "Who has a link can open it again after signing out. New links end the old ones, and sign all other pages out.",
  newLinks: "New links", linksRenewed: "New links: all other pages are signed out.",
  hints: {
    select: "Tap the boat, and tap it again to follow it; or drag a box around it.",
    drive: "The arrow keys drive the boat; so do the buttons under Drive boat.",
    rescue: "Mark a person: press Mark, tap the person, then press Go. The boat goes there.",
  },
  figures: "Figures", strips: "The last two minutes: P, camera commands, confidence, delay", events: "Events",
  alarmList: "Alarms", keysTitle: "Keys", close: "Close", cancel: "Cancel",
  takeTitle: "Take the control from the other page?",
  entry: "Access", entryPage: "Barrelman: access", entryTitle: "A token is needed", token: "Token or link", open: "Open",
  entryText: "Open the link that the program printed at its start, or paste the link or its token here.",
  linkWrong: "The token of the link that was opened is not known. The program makes new tokens at each start: open the link that it printed last.",
  entryStopped: "Stopped.", entryNotStopped: "The stop was not confirmed: press again, or stop at the ground station.",
  entryWrong: "This token is not known. The program makes new tokens at each start.",
  // The page on which a box is drawn in one picture
  pickHint: "Drag a box around the whole boat. The wheel zooms.", pickTake: "Track this",
  pickBox: (box) => `Box ${box.join(",")}`, pickDone: "The program goes on with this box. This page can be closed.", pickDoneConsole: "The run begins with this box. The console opens here.",
  // State
  connecting: "CONNECTING", ended: "ENDED", lastKnown: (s) => `last known, ${s} s ago`,
  losses: {
    lost: "CONNECTION LOST - retrying. The camera can be stopped at the ground station.",
    hangs: "THE PROGRAM HANGS - what stands here is old. The link rests the camera; look at the ground station.",
    behind: "THIS PAGE IS LATE - the network or this device is too slow. What stands here is old. Stop works.",
    dismissed: "TOO MANY PAGES ARE OPEN - this one was disconnected. Close others, then reload.",
  },
  endedText: ({ camera, boat }) => {
    const left = [camera && "The camera may be turning: look at the ground station.", boat && "The boat may be under way: stop it with its remote control."].filter(Boolean);
    return left.length ? `The program has ended. ${left.join(" ")}` : "The program has ended; the camera rests.";
  },
  // Across the picture
  notices: {
    connecting: "Connecting to the program", waiting: "Waiting for the first picture", old: "The last picture", ended: "The video has ended",
    videoConnecting: "Connecting to the video", lost: (reason) => `No picture: the video is lost${reason ? `: ${reason}` : ""}`, none: (s) => `No video for ${s} s`,
    behind: (s) => `The picture is ${s} s late`,
  },
  youControl: "You control", client: (id, isProgram) => (isProgram ? "a program" : `page ${id}`), youWatch: (who) => `${capital(who)} controls; you watch`, nobodyControls: "Nobody controls",
  mayWatch: "You watch (watch link)", holderLost: (who) => `${capital(who)} controls, but is not connected`,
  took: (who) => `${capital(who)} took the control.`, gotControl: "You have the control.",
  asks: (who) => `${capital(who)} asks for the control.`,
  modes: { idle: "DISENGAGED", servoing: "FOLLOWING", holding: "HOLDING", nudging: "TURNED BY HAND", searching: "SEARCHING",
    calibrating: "CALIBRATING", stopped: "STOPPED" },
  tracks: { unseeded: "nothing selected", tracking: "tracking", coasting: "coasting", lost: "lost", confirming: "confirming", doubted: "doubted by the detector" },
  next: {
    connecting: "Wait: the page connects to the program.",
    connect: "Wait for the connection, or stop at the ground station.",
    hangs: "The program hangs: stop the camera at the ground station.",
    behind: "This page is late: improve its network, or close other programs.",
    ended: "Start the program again to go on: the page connects by itself.",
    stopUnacknowledged: "Stop was not acknowledged: use the ground station's own stop.",
    watch: "You watch. Only Stop works here. Take the control to do more.",
    watchLink: "You watch with the watch link. Only Stop works here.",
    asked: "You asked for the control: wait until it is given, or press Take control.",
    video: "Wait for video: check the camera and the network.",
    late: "The video is late: the camera rests. Check the network, or restart the camera's stream.",
    link: "The link is down: check the cable or the ground station.",
    boatLink: "The link to the boat is down: check its radio. Stop does not reach the boat.",
    dryRun: "Dry run: the camera is not moved. Start with --link to move it.",
    emergency: "The vehicle has an emergency or lands: the camera rests.",
    vehicle: "Another client has the control. Press Engage to take it back.",
    select: "Tap the boat, press its number, or draw a box around it.",
    proposed: "Is that the boat? Tap it again, or engage.",
    reselect: "The boat is lost: draw a new box around it, or wait.",
    search: "The boat is lost: draw a new box around it, or press Search.",
    searching: "The camera searches for the boat. Stop or Disengage ends the search.",
    opposed: "The camera turned the wrong way: check the sign in the configuration, then start again.",
    unwind: "The tether is wound up: disengage, and turn the camera back by hand.",
    confirm: "Wait: the selection is being confirmed.",
    endStop: "The camera is near its end stop: move the kite.",
    person: "Drag the mark onto the person, or tap the mark: still there.",
    doubted: "The detector sees no boat there. Is it the boat? Press Engage. Otherwise press Not that one.",
    engage: "Check the box, then press Engage.",
    stopped: "Stopped. Engage to follow again, or Disengage.",
    stoppedByVehicle: "The vehicle ended the following. Check the vehicle, then Engage again, or Disengage.",
    follow: "The camera follows the boat.",
    hidden: "The boat is hidden: wait, or stop.",
    nudge: "Turning the camera by hand.",
    paused: "Paused. Press Resume.",
  },
  reasons: {
    tap: "Drag a box around the boat, from corner to corner.", small: "The box is too small: zoom in, and draw again.",
    old: "The picture moves again: finish the box on the moving boat.", noPicture: "There is no picture yet.", watchedOnly: "The boat is followed in the other video: press \u201cFollow in this video\u201d first.", isTracked: "The boat is followed in this video.", videoAtRest: "Disengage first: the video is changed at rest.",
    notConnected: "Not connected.", noAnswer: "No answer: look whether it was done.", watcher: "You watch: take the control first.", watchLink: "You watch with the watch link.", controls: "You control.",
    law: "Disengage before changing the law.", nudge: "Disengage before turning the camera by hand.", zoomMode: "Disengage before zooming by hand.",
    nudgeDryRun: "A dry run does not move the camera.", nudgeLink: "The link is not up.",
    nudgeControl: "The vehicle does not accept commands.", nudgeFlight: "The vehicle has an emergency or lands.",
    nudgeVideo: "There is no video.",
    noBoat: "No boat is connected.", nothingMarked: "Mark a place or a person first.", noHome: "Mark home first.",
    engaged: "The camera is engaged.", disengaged: "The camera is disengaged.", boatStopped: "The boat is stopped.",
    guided: "The boat goes already.", notLost: "The boat is not lost.", notRecorded: "Nothing is recorded.", notTwisted: "The tether is not twisted by half a turn.",
    screenMayGoDark: (isEncrypted) => `The screen may go dark: ${isEncrypted ? "the browser does not keep it awake. Set" : "this page is not encrypted. Use https, or set"} the device to stay awake.`,
    nothingFollowed: "Nothing is followed.", unacknowledged: "STOP NOT ACKNOWLEDGED: use the ground station's own stop.",
  },
  layers: {
    region: "Region and sectors", box: "Box and axis", heading: "Heading", trail: "Trail", p: "P",
    command: "Camera command", advice: "Advice", marks: "Marks and circles", map: "Map",
  },
  paths: { h264: "H.264 (WebCodecs)", h265: "H.265 (WebCodecs)", jpeg: "JPEG", none: "no video" },
  picturePath: (path, median, p95) => `${path}, ${median === null ? "delay not known" : `${median} ms (95 %: ${p95} ms)`}`,
  facts: {
    track: "Track", p: "P", confidence: "Confidence", video: "Video", link: "Link", camera: "Camera command", recording: "Recording",
    work: "Camera's work", schema: "Schema's work", boat: "Boat", world: "Slow world", schemaP: "P with the schema", netYaw: "Net yaw", equipment: "In use", position: "Kite", boatPlace: "Boat at", targetPlace: "Target at",
  },
  links: {
    "dry-run": "dry run: nothing is sent", simulated: "simulated camera", opening: "opening", starting: "starting", up: "up",
    closing: "closing", closed: "closed", silent: "silent",
  },
  videos: { connecting: "connecting", up: "up", lost: "lost, reconnecting", ended: "ended" },
  recordings: { off: "off", recording: "on", failed: "FAILED" },
  seconds: (s) => `${s} s`, ago: (s) => `for ${s} s`,
  workText: (work) => `${work.moves} ${work.moves === 1 ? "move" : "moves"}, ${fixed(work.travel_rad, 2)} rad, ${Math.round(100 * work.rest_share)} % at rest`,
  equipmentText: ({ gimbal, camera, stream }) => [gimbal && `gimbal ${gimbal}`, camera && `camera ${camera}`, stream && `stream ${stream}`].filter(Boolean).join(", "),
  boatText: (drive) => `${fixed(drive.speed_m_per_s, 1)} m/s, ${drive.helm === "page" ? "you steer" : drive.helm}`,
  boatMode: (vessel) => {
    const doing = { "getting-way": "getting under way", avoiding: "going around a circle", blocked: "no way past the circles", holding: "at the mark", "standing-off": "waiting before the person", "no-fix": "boat near the horizon" }[vessel.guidance];
    const how = vessel.mode === "guided" ? `${doing ? `: ${doing}` : ""}${vessel.basis === "picture" ? " (by the picture: no distances)" : ""}` : "";
    return vessel.text.charAt(0).toUpperCase() + vessel.text.slice(1) + how + (vessel.says ? `. It says: ${vessel.says}` : "");
  },
  vesselText: ({ progress, throttle, rudder, marks }, drive) => {
    const speed = progress ?? drive;
    const people = marks.filter(({ kind }) => kind === "person");
    const held = people.filter((mark) => mark.held?.state === "tracking").length;
    const seen = people.length ? `, ${held} of ${people.length} ${people.length === 1 ? "person" : "people"} seen` : "";
    const goal = progress && marks.some(({ destination }) => destination) ? `, ${fixed(progress.distance_m, 1)} m to go` : "";
    const side = Math.round(100 * Math.abs(rudder)) ? ` ${rudder < 0 ? "\u2190" : "\u2192"} ${Math.round(100 * Math.abs(rudder))}` : "";
    const helm = throttle || rudder ? `, ${throttle < 0 ? "\u2193" : "\u2191"} ${Math.round(100 * Math.abs(throttle))}${side} %` : "";
    return `${speed ? `${fixed(speed.speed_m_per_s, 1)} m/s` : "speed not known"}${goal}${helm}${seen}`;
  },
  netYawText: (degrees) => (degrees === 0 ? "0°" : `${Math.abs(degrees)}° to the ${degrees > 0 ? "right" : "left"}`),
  distanceText: ({ distance_m, std_dev_m, direction_deg }) => {
    const side = Math.round(direction_deg) === 0 ? "ahead" : `${fixed(Math.abs(direction_deg), 0)}° ${direction_deg > 0 ? "right" : "left"}`;
    return `${fixed(distance_m, 0)} m ± ${fixed(Math.max(1, 2 * std_dev_m), 0)} m, ${side}`;
  },
  placeText,
  noHeading: "latitude and longitude not known: the kite does not report where north is for the camera",
  positionText: (position, height) => placeText(position)
    + (height === null ? "" : `, ${fixed(height, 0)} m up`) + (position.heading_deg === null ? "" : `, heading ${fixed(position.heading_deg, 0)}°`),
  slowText: (pace, size) => `${Math.round(100 * pace)} % of real time${size && size[0] > 640 ? "; try --size 640x360" : ""}`,
  turns: { pan: "pan", tilt: "tilt", left: "left", right: "right", up: "up", down: "down", rest: "at rest", zoom: "zoom", closer: "closer", wider: "wider" },
  videoText: (state, fps, dropped) => `${state}, ${fixed(fps, 0)} frames/s, ${dropped} dropped`,
  strip: { p: "P", command: "pan (+ right), tilt (+ up), rad/s", confidence: "confidence", delay: "delay, ms" },
  answers: { superseded: "Replaced by a later request", refused: "Refused" },
  keyList: [
    ["Space", "Stop the camera and the boat"], ["e", "Engage"], ["r", "Disengage: the camera rests"],
    ["w a s d", "Turn the camera by hand, while disengaged: tilt up, pan left, tilt down, pan right"], ["Arrows", "Drive the boat by hand; a gamepad's left stick does, too"],
    ["PageUp PageDown, or Shift and the wheel", "Zoom the camera in and out, where it can; a gamepad's right stick does, too"], ["j", "Keep the boat's size by the zoom while engaged"],
    ["t", "Mark a point: then tap it, or Enter, arrows, Enter on the picture"], ["g", "The boat goes to the mark"], ["b", "Stop the boat alone"], ["c", "The next mark"], ["y", "The boat goes home"],
    ["u, on a mark that was tapped", "Remove the mark"], ["z", "Freeze the picture"], ["f", "Full screen"], ["v", "The other video, where there are two"], ["i", "Operate or Expert"], ["Enter, on a switch of the overlay", "Switch it"], ["x", "Not that one"], ["o", "Show what stands out from the water"], ["1 to 8", "Follow the object of this number"], ["l", "Search for a boat that is lost"], ["Enter, on the picture", "Draw a box by keyboard: arrows move, Shift+arrows resize, Enter selects, Escape cancels"],
    ["+ - 0", "Zoom in, out, whole picture"], ["p", "Pause or resume the simulated world"], ["h", "Give the helm back"], ["k", "A new drive in a simulated world"],
    ["m", "Mark this moment in the recording"], ["n", "Night or day"], ["q", "Sound"], ["?", "These keys"],
  ],
  libraryTitle: "Recordings", toLibrary: "Library", toConsole: "To the console", libraryList: "Recordings, the newest first", libraryDetail: "The chosen recording",
  libraryNone: "There is no recording yet: `barrelman run` makes one of each sortie.", libraryLost: "The program does not answer.",
  makeFilm: "Make the film", momentsTitle: "Moments", speed: "Speed", stepBack: "One picture back", stepOn: "One picture on",
  newName: "Name", rename: "Rename", deleteRecording: "Delete", deleteTitle: "Delete this recording and its film for good?",
  summaryComputed: "The recording was cut off: the figures are computed from what is there.", summaryOfCut: "The recording was cut off: the figures are of what is there.",
  summaryToCome: "The summary comes with the end of the recording.", noSummary: (why) => `There are no figures: ${why}`,
  recordingStates: { "being-recorded": "being recorded", complete: "complete", "cut-off": "cut off" },
  watched: "The picture of the recording", watchedBeside: "The picture of the recording beside it", position: "Time in the recording", playFilm: "Play", pauseFilm: "Pause", beside: "Beside it", besideNone: "nothing",
  notWatchable: { "being-recorded": "It is being recorded.", "cut-off": "The recording was cut off and has no index: make its film to watch it." },
  filmStates: { none: "with box, mode and time of day, for a player of videos", "being-made": "The film is being made.", ready: "", failed: "The film could not be made: the recording may hold no video." },
  files: { "recording.mcap": "Recording (MCAP)", "sortie.json": "Summary (JSON)", "annotated.mp4": "Film (MP4)", "report.html": "Report (HTML)", "video.mp4": "Video without drawings (MP4)", "trial.csv": "Table (CSV)" },
  moment: ({ what, cause, text }) => (what === "stopped" ? `stopped: ${states.causes[cause] ?? cause}` : what === "noted" ? `moment marked${text ? `: ${text}` : ""}` : { selected: "selected", engaged: "engaged", disengaged: "disengaged", lost: "boat lost", found: "boat found", marked: "marked", guided: "boat sent to a mark" }[what] ?? what),
  sortie: (sortie, length) => [
    ["Length", length(sortie.length_s)],
    ["Engaged", sortie.engaged_s > 0 ? `${length(sortie.engaged_s)}, the boat known for ${((100 * sortie.followed_s) / sortie.engaged_s).toFixed(1)} %` : "never"],
    ["Boat lost", sortie.losses.count > 0 ? `${sortie.losses.count} times, ${length(sortie.losses.total_s)} in all, ${length(sortie.losses.longest_s)} the longest` : "never"],
    ["Camera", `${sortie.camera.moves} movements, ${sortie.camera.travel_rad.toFixed(2)} rad (the motor schema: about ${sortie.schema.moves}, ${sortie.schema.travel_rad.toFixed(2)} rad)`],
    ["Video", sortie.video],
    ["Link", sortie.link || "dry run"],
  ],
};
