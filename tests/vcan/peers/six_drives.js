// Six CiA 402 drives that are not ours: npm's canopen speaks CANopen (SDO, NMT, PDO, SYNC, heartbeat), its dictionary is
// read from our EDS; only the power state machine and a motor that lags stand here. No PDO is mapped but by SDO.
//   node six_drives.js PACKAGES EDS INTERFACE
// Prints a line of JSON for each change of state and, at SIGTERM, one with each drive's mapping, states and positions.
//
// Of the peer (canopen 6.2.1): it reads SYNC's counter from byte 1, tells of an RPDO only when a value changed, lets an
// RPDO act at once instead of on the next SYNC, and knows no $NODEID.
'use strict';
const path = require('path');
const [packages, edsFile, interfaceName] = process.argv.slice(2);
const load = (name) => require(path.join(path.resolve(packages), 'node_modules', name));
const { Device, Eds } = load('canopen');
const can = load('socketcan');

const kLagShare = 0.3;        // of the way to the target that the motor goes in one SYNC
const kHeartbeatMs = 100;
const kStates = { disabled: 0x0240, ready: 0x0221, switchedOn: 0x0233, enabled: 0x1237, quickStop: 0x0217 };

// The edges of the CiA 402 table that a controlword can take without a fault.
function nextState(state, word) {
  if ((word & 0x02) === 0) return 'disabled';
  if ((word & 0x04) === 0) return state === 'enabled' || state === 'quickStop' ? 'quickStop' : 'disabled';
  if ((word & 0x07) === 0x06) return state === 'quickStop' ? state : 'ready';
  if ((word & 0x0F) === 0x07) return state === 'disabled' || state === 'quickStop' ? state : 'switchedOn';
  if (state === 'disabled') return state;
  return state === 'ready' ? 'switchedOn' : 'enabled';
}

class Drive {
  constructor(channel, id) {
    this.id = id;
    this.state = 'disabled';
    this.states = ['disabled'];
    this.eds = Eds.fromFile(edsFile);
    this.resolveNodeId();
    this.eds.addSdoServerParameter(0, 0x580 + id, 0x600 + id);
    this.device = new Device({ id, eds: this.eds });
    this.device.on('message', (m) => channel.send({ id: m.id, ext: false, rtr: false, data: m.data }));
    this.lowest = this.highest = this.position = this.start = 100 * id;
    this.set(0x6064, this.position);
    this.set(0x6041, kStates.disabled);
    this.set(0x1017, kHeartbeatMs);
    this.eds.getEntry(0x6060).on('update', (mode) => this.set(0x6061, mode.value));
    this.device.start();
    channel.addListener('onMessage', (m) => this.receive(m));
  }

  set(index, value) { this.eds.getEntry(index).value = value; }
  get(index) { return this.eds.getEntry(index).value; }

  // Our EDS counts identifiers from the node's number, as the standard has it.
  resolveNodeId() {
    for (const [index, base] of [[0x1400, 0x80000200], [0x1800, 0x80000180]])
      this.eds.getSubEntry(index, 1).value = base + this.id;
    this.eds.getSubEntry(0x1018, 4).value = this.id;
    for (const index of [0x1600, 0x1A00]) this.eds.getEntry(index)[0].value = 0;  // the reader counts sub-indexes instead
  }

  receive(message) {
    this.device.receive(message);
    if (message.id === 0x200 + this.id) this.obey();
    if (message.id === 0x080) this.move();
  }

  obey() {
    const state = nextState(this.state, this.get(0x6040));
    if (state === this.state) return;
    this.state = state;
    this.states.push(state);
    this.set(0x6041, kStates[state]);
    console.log(JSON.stringify({ node: this.id, state, position: this.position }));
  }

  move() {
    if (this.state !== 'enabled') return;
    this.position = Math.round(this.position + kLagShare * (this.get(0x607A) - this.position));
    this.lowest = Math.min(this.lowest, this.position);
    this.highest = Math.max(this.highest, this.position);
    this.set(0x6064, this.position);
  }

  mapping(index) {
    const entry = this.eds.getEntry(index);
    const mapped = [];
    for (let i = 1; i <= entry[0].value; ++i) mapped.push(entry[i].value.toString(16));
    return mapped;
  }

  summary() {
    const { id, states, start, position, lowest, highest } = this;
    return { node: id, states, start, position, lowest, highest, target: this.get(0x607A), mode: this.get(0x6061),
             rpdo: this.mapping(0x1600), tpdo: this.mapping(0x1A00) };
  }
}

const channel = can.createRawChannel(interfaceName);
const drives = [1, 2, 3, 4, 5, 6].map((id) => new Drive(channel, id));
channel.start();

// Interpreted code is slow until it has run: reads of our own, over the bus, until all drives answer at once.
const kWarmReads = 40;
let asked = 0;
const tester = can.createRawChannel(interfaceName);
const ask = () => tester.send({ id: 0x601 + (asked++ % 6), ext: false, rtr: false, data: Buffer.from([0x40, 0, 0x10, 0, 0, 0, 0, 0]) });
tester.addListener('onMessage', (m) => {
  if ((m.id & 0x780) !== 0x580 || asked > kWarmReads) return;
  if (asked < kWarmReads) return ask();
  ++asked;
  tester.stop();
  console.log('six_drives: ready');
});
tester.start();
ask();
process.on('SIGTERM', () => {
  console.log(JSON.stringify({ drives: drives.map((d) => d.summary()) }));
  process.exit(0);
});
