#!/usr/bin/env python3
"""What a server costs: N simulated agents, each a real TLS link with 5 live updates a second, for some seconds.

    tests/bench/fleet.py [--agents 200] [--seconds 30] [--bin build/release/bin]

Prints one JSON line: CPU of one core in percent, memory, updates received a second, and as the reference in the same
run the CPU of an idle server.
"""
import argparse
import json
import os
import subprocess
import sys
import time

HERE = os.path.dirname(os.path.abspath(__file__))


def cpu_seconds(pid):
    with open(f"/proc/{pid}/stat", encoding="ascii") as file:
        fields = file.read().rsplit(")", 1)[1].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def measure(pid, seconds):
    """CPU in percent of one core over the time given."""
    began, cpu = time.monotonic(), cpu_seconds(pid)
    time.sleep(seconds)
    return 100 * (cpu_seconds(pid) - cpu) / (time.monotonic() - began)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--agents", type=int, default=200)
    parser.add_argument("--seconds", type=float, default=30)
    parser.add_argument("--bin", default=os.path.join(HERE, "../../build/release/bin"))
    options = parser.parse_args()
    os.environ["HEADSTOCK_BIN"] = os.path.abspath(options.bin)
    sys.path.insert(0, os.path.join(HERE, "../integration"))
    from shop import Shop, eventually

    shop = Shop()
    fleet = None
    try:
        shop.start_server()
        idle = measure(shop.server.child.pid, 5)
        tokens = os.path.join(shop.folder, "tokens")
        with open(tokens, "w", encoding="ascii") as file:
            for number in range(options.agents):
                made = shop.admin.post("/machines", {"name": f"Machine {number + 1:03d}", "profile": "fanuc-0i-t"})
                file.write(made["enrolment_token"] + "\n")
        fleet = subprocess.Popen([os.path.join(options.bin, "fleet_simulator"), "--server", f"127.0.0.1:{shop.agent_port}",
                                  "--tokens", tokens, "--updates-per-second", "5"], stdout=subprocess.DEVNULL)
        eventually(lambda: sum(m["live"]["connected"] for m in shop.admin.get("/machines", limit=1000)["items"])
                   == options.agents, "every agent connected", 300)
        busy = measure(shop.server.child.pid, options.seconds)
        print(json.dumps({"agents": options.agents, "updates_per_s": options.agents * 5,
                          "server_cpu_percent_of_one_core": round(busy, 1), "idle_cpu_percent": round(idle, 2),
                          "server_peak_memory_mib": round(shop.server.peak_memory_mib(), 1)}))
    finally:
        if fleet:
            fleet.kill()
            fleet.wait()
        shop.close()


if __name__ == "__main__":
    main()
