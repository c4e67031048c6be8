// The expert's figures, as names and values. No document.

import { fixed, words } from "./words.js";

/** A simulated world below this share of real time is named as slow. */
const SLOW = 0.9;

/** A rate with its sign and its direction: pan is positive to the right, tilt upwards, zoom to a closer view. */
function rateText({ pan, tilt, zoom }) {
  const turn = (axis, rate, plus, minus) => {
    const value = fixed(Math.abs(rate), 2);
    return Number(value) === 0 ? [] : [`${axis} ${rate > 0 ? "+" : "\u2212"}${value} rad/s (${rate > 0 ? plus : minus})`];
  };
  const { left, right, up, down, rest, pan: panWord, tilt: tiltWord, zoom: zoomWord, closer, wider } = words.turns;
  const zooms = zoom === 0 ? [] : [`${zoomWord} ${zoom > 0 ? closer : wider}`];
  return [...turn(panWord, pan, right, left), ...turn(tiltWord, tilt, up, down), ...zooms].join(", ") || rest;
}

/** Names and values of all figures of a snapshot. @returns {string[][]} */
export function factsOf(snapshot) {
  const { track, percept, video, link, recording, work, drive } = snapshot;
  const number = (value, digits = 2) => (value === null || value === undefined ? "–" : fixed(value, digits));
  const lost = track.lost_s !== null ? ` ${words.ago(fixed(track.lost_s, 0))}` : "";
  const distance = snapshot.boat ? `, ${words.distanceText(snapshot.boat)}` : "";
  const facts = [
    [words.facts.track, words.tracks[track.confirming ? "confirming" : track.doubted ? "doubted" : track.state] + lost + distance],
    [words.facts.p, `${number(percept?.p)}${work.schema_p === null ? "" : `  (${words.facts.schemaP}: ${number(work.schema_p)})`}`],
    [words.facts.confidence, number(track.confidence)],
    [words.facts.camera, rateText(snapshot.command) + (snapshot.zoom ? `, ${fixed(snapshot.zoom.ratio, 1)}\u00d7` : "")],
    [words.facts.video, words.videoText(words.videos[video.state], video.fps, video.dropped) + (video.reason ? `: ${video.reason}` : "")],
    [words.facts.link, words.links[link.state] + (link.battery_v === null ? "" : `, ${fixed(link.battery_v, 1)} V`)],
    [words.facts.recording, words.recordings[recording.state] + (recording.path ? `: ${recording.path.split("/").at(-1)}` : "")],
    [words.facts.work, words.workText(work.camera)],
    [words.facts.netYaw, words.netYawText(Math.round(snapshot.net_yaw_deg))],
  ];
  if (link.gimbal || link.camera || link.stream) facts.push([words.facts.equipment, words.equipmentText(link)]);
  if (link.position) facts.push([words.facts.position, words.positionText(link.position, link.altitude_m)]);
  facts.push(...placesOf(snapshot));
  if (work.schema) facts.push([words.facts.schema, words.workText(work.schema)]);
  if (snapshot.vessel) facts.push([words.facts.boat, words.vesselText(snapshot.vessel, drive)]);
  else if (drive) facts.push([words.facts.boat, words.boatText(drive)]);
  if (drive && !drive.paused && drive.pace < SLOW) facts.push([words.facts.world, words.slowText(drive.pace, video.size)]);
  return facts;
}

/** Latitude and longitude of the boat and of the target; of a kite with a position alone, why they are not known. */
function placesOf({ boat, vessel, earth }) {
  if (earth === "no-heading") return [[words.facts.boatPlace, words.noHeading]];
  const boatPlace = vessel?.progress?.on_earth ?? boat?.on_earth;
  const target = vessel?.marks.find(({ destination }) => destination)?.on_earth;
  return [[words.facts.boatPlace, boatPlace], [words.facts.targetPlace, target]]
    .filter(([, place]) => place).map(([name, place]) => [name, words.placeText(place)]);
}
