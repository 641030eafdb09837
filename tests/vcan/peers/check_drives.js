// check_drives.js LOG q1 q2 q3 q4 q5: did the drives of six_drives.js see what CiA 402 wants, and arrive?
'use strict';
const assert = require('assert');
const fs = require('fs');
const [log, ...joints] = process.argv.slice(2);
const lines = fs.readFileSync(log, 'utf8').trim().split('\n');
const { drives } = JSON.parse(lines[lines.length - 1]);
const kCountsPerTurn = 32768;
const kToleranceCounts = 0.004 * kCountsPerTurn / (2 * Math.PI);  // goal_tolerance_rad

assert.strictEqual(drives.length, 6);
for (const drive of drives) {
  assert.deepStrictEqual(drive.states, ['disabled', 'ready', 'switchedOn', 'enabled', 'quickStop'], `states of node ${drive.node}`);
  assert.deepStrictEqual(drive.rpdo, ['60400010', '607a0020', '60b20010'], `RPDO1 of node ${drive.node}`);
  assert.deepStrictEqual(drive.tpdo, ['60410010', '60640020', '60770010'], `TPDO1 of node ${drive.node}`);
  assert.strictEqual(drive.mode, 8, `mode of node ${drive.node}`);
  const goal = drive.node <= 5 ? Number(joints[drive.node - 1]) * kCountsPerTurn / (2 * Math.PI) : drive.start;
  assert(Math.abs(drive.position - goal) <= kToleranceCounts, `node ${drive.node} stands at ${drive.position}, goal ${goal}`);
  assert(drive.lowest >= Math.min(drive.start, goal) - 1 && drive.highest <= Math.max(drive.start, goal) + 1,
         `node ${drive.node} left the way between start and goal: ${drive.lowest} to ${drive.highest}`);
}
console.log(`check_drives: six drives enabled, moved to ${drives.map((d) => d.position).join(', ')} counts, stopped`);
