"""A control at the far end of a serial line: a pseudo-terminal, a small buffer, DC1 and DC3."""
import os
import random
import select
import threading
import tty


def even(byte):
    """ISO: bit 8 makes the number of ones even."""
    return byte | 0x80 if bin(byte & 0x7F).count("1") % 2 else byte & 0x7F


def iso(text):
    return bytes(even(ord(c)) for c in text)


class Control:
    def __init__(self, seed=1):
        self.master, slave = os.openpty()
        tty.setraw(slave)
        self.device = os.ttyname(slave)
        # Kept open: a pseudo-terminal whose other end nobody holds answers with errors.
        self.slave = slave
        self.read = bytearray()
        self.random = random.Random(seed)
        self.stops = 0
        self.most_after_stop = 0
        self.reading = False
        self.ended = False
        self.thread = threading.Thread(target=self.run, daemon=True)
        self.thread.start()

    def say(self, data):
        os.write(self.master, data)

    def start(self):
        """The operator presses READ: DC1."""
        self.read.clear()
        self.reading = True
        self.say(b"\x11")

    def run(self):
        stopped, after, buffered = False, 0, 0
        while not self.ended:
            ready, _, _ = select.select([self.master], [], [], 0.002)
            if ready and self.reading:
                try:
                    piece = os.read(self.master, self.random.randint(1, 16))
                except OSError:
                    return
                self.read += piece
                buffered += len(piece)
                if stopped:
                    after += len(piece)
                    self.most_after_stop = max(self.most_after_stop, after)
                elif buffered > 96 or self.random.random() < 0.02:
                    stopped, after = True, 0
                    self.stops += 1
                    self.say(b"\x93")
            buffered = max(0, buffered - self.random.randint(0, 24))
            if stopped and buffered < 32:
                stopped = False
                self.say(b"\x11")

    def close(self):
        self.ended = True
        self.thread.join()
        os.close(self.master)
        os.close(self.slave)
