import { memo } from "react";
import { tokens } from "./tokens";

/// Control characters are made visible: a NUL in a program is a finding, not a blank.
const visible = (text: string) => text.replace(/[\u0000-\u0008\u000b-\u001f]/g, (c) => String.fromCharCode(0x2400 + c.charCodeAt(0)));

export const Code = memo(function Code({ text }: { text: string }) {
  return <>{tokens(text).map((token, i) => <span key={i} className={`tk-${token.kind}`}>{visible(token.text)}</span>)}</>;
});
