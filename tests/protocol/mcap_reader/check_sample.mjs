// node check_sample.mjs OUTPUT.json: the numbers of tests/protocol/sample_recording.hpp, as read_mcap.mjs found them.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";

const found = JSON.parse(readFileSync(process.argv[2], "utf8"));
assert.deepEqual(found.topics, { "/tick": 500, "/link": 5 });
assert.ok(found.chunks > 5, "the sample has several chunks");
found.ticks.forEach((tick, i) => {
  const time = String(1000000000 + 4000000 * i);
  assert.equal(tick.log_time, time);
  assert.equal(tick.sequence, i);
  assert.equal(tick.value.arm_time_ns, time);
  assert.equal(tick.value.cycle, String(i));
  assert.equal(tick.value.mode, "MODE_HOLD");
  assert.deepEqual(tick.value.q_reading_rad, [0.001 * i, -0.5]);
});
found.links.forEach((link, i) => {
  assert.equal(link.value.to_controller, true);
  assert.equal(link.value.peer, "127.0.0.1:40312");
  assert.equal(link.value.envelope.sequence, String(100 * i));
  assert.equal(link.value.envelope.stop.reason, "operator");
});
console.log(`read_mcap: ${found.ticks.length} ticks and ${found.links.length} link messages as written`);
