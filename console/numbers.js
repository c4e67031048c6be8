// Numbers as text. Pure.

/** A number with so many decimal places; what rounds to zero has no sign. */
export function fixed(value, digits) {
  const text = value.toFixed(digits);
  return Number(text) === 0 ? text.replace("-", "") : text;
}
