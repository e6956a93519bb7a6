"""A serial-device server (RFC 2217) whose line can be spoiled on purpose: errors, breaks, CTS, hang-ups."""
import socket
import threading

IAC, SB, SE, WILL, DO = 255, 250, 240, 251, 253
COM_PORT = 44
OVERRUN, PARITY, FRAMING, BREAK = 2, 4, 8, 16
CTS, DSR = 16, 32


class DeviceServer:
    """What the other side writes is in `read`; `say`, `line_error` and `signals` go to it."""

    def __init__(self):
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.address = f"rfc2217://127.0.0.1:{self.listener.getsockname()[1]}"
        self.read = bytearray()
        self.settings = {}
        self.connections = 0
        self.peer = None
        self.ended = False
        self.thread = threading.Thread(target=self.run, daemon=True)
        self.thread.start()

    def say(self, data):
        self.peer.sendall(data.replace(b"\xff", b"\xff\xff"))

    def option(self, code, *values):
        body = bytes(values).replace(b"\xff", b"\xff\xff")
        self.peer.sendall(bytes([IAC, SB, COM_PORT, code]) + body + bytes([IAC, SE]))

    def line_error(self, which):
        self.option(106, which)

    def signals(self, which):
        self.option(107, which)

    def hang_up(self):
        if self.peer:
            self.peer.shutdown(socket.SHUT_RDWR)

    def run(self):
        while not self.ended:
            try:
                peer, _ = self.listener.accept()
            except OSError:
                return
            self.peer = peer
            self.read.clear()
            self.connections += 1
            try:
                self.serve(peer)
            except OSError:
                pass
            self.peer = None
            peer.close()

    def serve(self, peer):
        state, verb, sub = "data", 0, bytearray()
        peer.sendall(bytes([IAC, DO, COM_PORT]))
        while True:
            piece = peer.recv(4096)
            if not piece:
                return
            for byte in piece:
                if state == "data":
                    if byte == IAC:
                        state = "iac"
                    else:
                        self.read.append(byte)
                elif state == "iac":
                    state = "data"
                    if byte == IAC:
                        self.read.append(byte)
                    elif byte == SB:
                        state, sub = "sub", bytearray()
                    elif byte >= WILL:
                        state, verb = "verb", byte
                elif state == "verb":
                    state = "data"
                elif state == "sub":
                    if byte == IAC:
                        state = "sub_iac"
                    else:
                        sub.append(byte)
                elif state == "sub_iac":
                    state = "data" if byte == SE else "sub"
                    if byte == SE:
                        self.take(sub)
                    else:
                        sub.append(byte)

    def take(self, sub):
        if len(sub) < 3 or sub[0] != COM_PORT:
            return
        code, values = sub[1], bytes(sub[2:])
        self.settings.setdefault(code, []).append(values)
        if code <= 5:
            self.option(code + 100, *values)
        if code == 4:
            self.signals(CTS | DSR)

    def close(self):
        self.ended = True
        self.hang_up()
        self.listener.close()
        self.thread.join(5)
