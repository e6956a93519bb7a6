// The server's side of a WebSocket, as little as the mock needs: text frames out, text and close frames in (RFC 6455).
import { createHash } from "node:crypto";

export function accept(request, socket) {
  const key = createHash("sha1").update(request.headers["sec-websocket-key"] + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11").digest("base64");
  socket.write(`HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Accept: ${key}\r\n\r\n`);
  const link = { onmessage: () => {}, onclose: () => {}, send, close: () => socket.destroy() };
  let held = Buffer.alloc(0);
  function send(text) {
    const body = Buffer.from(text);
    const head = body.length < 126 ? Buffer.from([0x81, body.length])
      : body.length < 65536 ? Buffer.from([0x81, 126, body.length >> 8, body.length & 255])
      : Buffer.concat([Buffer.from([0x81, 127, 0, 0, 0, 0]), uint32(body.length)]);
    if (!socket.destroyed) socket.write(Buffer.concat([head, body]));
  }
  socket.on("data", (data) => {
    held = Buffer.concat([held, data]);
    for (;;) {
      if (held.length < 2) return;
      const short = held[1] & 127;
      const at = short === 126 ? 4 : short === 127 ? 10 : 2;
      if (held.length < at + 4) return;
      const length = short === 126 ? held.readUInt16BE(2) : short === 127 ? Number(held.readBigUInt64BE(2)) : short;
      if (held.length < at + 4 + length) return;
      const mask = held.subarray(at, at + 4);
      const body = Buffer.from(held.subarray(at + 4, at + 4 + length)).map((byte, i) => byte ^ mask[i & 3]);
      const kind = held[0] & 15;
      held = held.subarray(at + 4 + length);
      if (kind === 8) return socket.end();
      if (kind === 1) link.onmessage(body.toString());
    }
  });
  socket.on("close", () => link.onclose());
  socket.on("error", () => {});
  return link;
}

function uint32(n) {
  const bytes = Buffer.alloc(4);
  bytes.writeUInt32BE(n);
  return bytes;
}
