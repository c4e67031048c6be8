// The head of a binary message (docs/api.md), and the codec of an H.264 stream. Pure.

export const H264 = 1;
export const JPEG = 2;
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
    payload: new Uint8Array(message, HEAD_BYTES),
  };
}

/** The codec's name (RFC 6381) from the first sequence parameter set of an access unit; null without one. */
export function codecOf(unit) {
  for (let at = 0; at + 7 < unit.length; at++) {
    if (unit[at] === 0 && unit[at + 1] === 0 && unit[at + 2] === 1 && (unit[at + 3] & 0x1f) === 7) {
      const hex = (byte) => byte.toString(16).padStart(2, "0");
      return `avc1.${hex(unit[at + 4])}${hex(unit[at + 5])}${hex(unit[at + 6])}`;
    }
  }
  return null;
}
