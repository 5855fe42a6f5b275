// SPDX-License-Identifier: Apache-2.0
// daemon.mjs: a simulated box in real time, that can be killed and started again.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { mkdirSync, openSync, readFileSync, writeFileSync } from "node:fs";
import { createServer } from "node:net";
import { until } from "./browser.mjs";

export function free_port() {
  return new Promise((resolve) => {
    const server = createServer().listen(0, "127.0.0.1", () => {
      const { port } = server.address();
      server.close(() => resolve(port));
    });
  });
}

export class Daemon {
  static async make(program) {
    const self = new Daemon();
    self.program = program;
    self.port = await free_port();
    self.url = `http://127.0.0.1:${self.port}`;
    self.token = "a-token-for-tests-0123456789abcdef";
    mkdirSync("data", { recursive: true });
    writeFileSync("token", `${self.token}\n`, { mode: 0o600 });
    self.configure("sim.ambient: 10");
    await self.start();
    return self;
  }

  /* From the next start on; `what`: of the simulated box, in place of what the board says. */
  configure(what, [width, height] = [192, 128]) {
    writeFileSync("box.yaml", [
      `board: ${process.env.SOURCE}/boards/sim-small/board.yaml`, "data: data", "token_file: token", `listen: ["127.0.0.1:${this.port}"]`, "retry: 1s",
      `set: {sim.clock: real, ${what}, lamps.left.warm_up: 500ms, lamps.right.warm_up: 500ms, sim.sensor.width: ${width}px, sim.sensor.height: ${height}px}`, ""].join("\n"));
  }

  async start() {
    const log = openSync("daemon.log", "a");
    this.child = spawn(this.program, ["--config", "box.yaml"], { stdio: ["ignore", log, log] });
    this.ended = new Promise((resolve) => this.child.once("exit", (code, signal) => resolve(code ?? signal)));
    await until("the daemon answers", async () => {
      assert.equal(this.child.exitCode, null, `the daemon ended: ${readFileSync("daemon.log", "utf8").slice(-2000)}`);
      return (await fetch(`${this.url}/api/v1/health`)).ok;
    }, 60000);
  }

  async kill(signal) {
    this.child.kill(signal);
    return this.ended;
  }

  async ask(path) {
    const answer = await fetch(`${this.url}/api/v1/${path}`, { headers: { Authorization: `Bearer ${this.token}` } });
    assert.ok(answer.ok, `${path}: ${answer.status}`);
    return answer.json();
  }
}
