// The head of a binary message (docs/api.md), and the codec of an H.264 or H.265 stream. Pure.

export const H264 = 1;
export const JPEG = 2;
export const H265 = 3;
const HEAD_BYTES = 32;

/** @param {ArrayBuffer} message */
export function readVideoMessage(message) {
  const head = new DataView(message);
  if (message.byteLength < HEAD_BYTES || head.getUint8(0) !== 1) return null;
  const flags = head.getUint8(2);
  return {
    kind: head.getUint8(1),
    key: (flags & 1) !== 0,
    shown: (flags & 2) !== 0,
    quarters: head.getUint8(3),
    epoch: head.getUint32(4, true),
    captured: Number(head.getBigUint64(8, true)),
    index: Number(head.getBigUint64(16, true)),
    video: head.getUint8(28) === 2 ? "second" : "first",
    payload: new Uint8Array(message, HEAD_BYTES),
  };
}

/** The codec's name from the first sequence parameter set of an access unit; null without one. */
export function codecOf(kind, unit) {
  for (let at = 0; at + 4 < unit.length; at++) {
    if (unit[at] !== 0 || unit[at + 1] !== 0 || unit[at + 2] !== 1) continue;
    const nal = unit.subarray(at + 3, at + 3 + MAX_SPS_HEAD);
    if (kind === H264 && (nal[0] & 0x1f) === 7) return h264Name(nal);
    if (kind === H265 && ((nal[0] >> 1) & 0x3f) === 33) return h265Name(nal);
  }
  return null;
}

/** Bytes of a sequence parameter set up to the level, with emulation prevention bytes. */
const MAX_SPS_HEAD = 24;

/** RFC 6381, 3.3. */
function h264Name(sps) {
  const hex = (byte) => byte.toString(16).padStart(2, "0");
  return sps.length < 4 ? null : `avc1.${hex(sps[1])}${hex(sps[2])}${hex(sps[3])}`;
}

/** ISO/IEC 14496-15, E.3: profile, compatible profiles (bits reversed), tier and level, constraints. */
function h265Name(sps) {
  const bytes = [...sps].filter((byte, at) => byte !== 3 || sps[at - 1] !== 0 || sps[at - 2] !== 0);
  if (bytes.length < 15) return null;
  // Behind two bytes of header and one of layers.
  const [profile, ...rest] = bytes.slice(3, 15);
  const compatible = rest.slice(0, 4).reduce((bits, byte) => bits * 256 + byte, 0);
  const reversed = parseInt(compatible.toString(2).padStart(32, "0").split("").reverse().join(""), 2);
  const constraints = rest.slice(4, 10).map((byte) => byte.toString(16));
  while (constraints.at(-1) === "0") constraints.pop();
  const space = ["", "A", "B", "C"][profile >> 6];
  const tier = profile & 0x20 ? "H" : "L";
  const head = `hev1.${space}${profile & 0x1f}.${reversed.toString(16)}.${tier}${rest[10]}`;
  return [head, ...constraints].join(".").toUpperCase().replace("HEV1", "hev1");
}
