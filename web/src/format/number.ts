// Numbers as the controllers show them: fixed digits, a true minus sign, nothing invented for what is not known.

export const unknownText = "—";

export function fixed(value: number | null | undefined, digits: number): string {
  if (value === null || value === undefined || !Number.isFinite(value)) return unknownText;
  const text = Math.abs(value).toFixed(digits);
  // -0.0004 is shown as 0.000, without a sign that would look like a position.
  return value < 0 && Number(text) !== 0 ? `−${text}` : text;
}

export const position = (value: number | null | undefined) => fixed(value, 3);
export const whole = (value: number | null | undefined) => fixed(value, 0);

export function percent(part: number | null | undefined, digits = 0): string {
  if (part === null || part === undefined || !Number.isFinite(part) || part < 0) return unknownText;
  // 99.97 % is not 100 %: the last block has not been reached.
  const capped = part < 1 ? Math.min(part * 100, 100 - 10 ** -digits) : 100;
  return `${capped.toFixed(digits)} %`;
}

export function bytes(count: number | null | undefined): string {
  if (count === null || count === undefined) return unknownText;
  if (count < 1024) return `${count} B`;
  const units = ["KB", "MB", "GB"] as const;
  let value = count / 1024;
  let unit = 0;
  while (value >= 1024 && unit < units.length - 1) {
    value /= 1024;
    unit += 1;
  }
  return `${value.toFixed(value < 10 ? 2 : value < 100 ? 1 : 0)} ${units[unit]}`;
}

export const grouped = (value: number) => value.toLocaleString("en-US").replaceAll(",", " ");
