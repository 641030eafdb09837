// check_eds.js PACKAGES EDS WIRE: npm canopen's reader finds in the EDS what the drive answers (WIRE, of dump_wire), no
// more and no less: objects, sizes, access, defaults where the EDS gives one.
'use strict';
const assert = require('assert');
const fs = require('fs');
const path = require('path');
const [packages, edsFile, wireFile] = process.argv.slice(2);
const { Eds } = require(path.join(path.resolve(packages), 'node_modules', 'canopen'));
const kNode = 3;
const kSizes = { 2: 1, 3: 2, 4: 4, 5: 1, 6: 2, 7: 4 };  // CiA 306 data types

const eds = Eds.fromFile(edsFile);
const text = fs.readFileSync(edsFile, 'utf8');
const found = new Map();
const note = (entry, index, sub) => found.set(`${index.toString(16).toUpperCase().padStart(4, '0')} ${sub}`, entry);
for (const [key, entry] of eds.entries()) {
  const index = parseInt(key, 16);
  if (!entry.subNumber) note(entry, index, 0);
  for (let sub = 0; entry.subNumber && sub <= 16; ++sub) if (entry.at(sub)) note(entry.at(sub), index, sub);
}

// npm's reader knows no $NODEID, and counts sub-indexes into sub-index 0: the default as the file has it.
function defaultOf(address) {
  const [index, sub] = address.split(' ');
  const section = text.split(`[${index}sub${Number(sub).toString(16).toUpperCase()}]\n`)[1] || text.split(`[${index}]\n`)[1];
  const value = /^DefaultValue=(.*)$/m.exec(section.split('\n\n')[0]);
  if (!value) return null;
  return value[1].split('+').reduce((sum, part) => sum + (part === '$NODEID' ? kNode : Number(part)), 0);
}

const objects = fs.readFileSync(wireFile, 'utf8').split('\n').filter((l) => l.startsWith('object ')).map((l) => l.split(' ').slice(1));
for (const [index, sub, size, access, value] of objects) {
  const address = `${index} ${sub}`;
  const entry = found.get(address);
  assert(entry, `the drive has ${address}, the EDS has not`);
  found.delete(address);
  assert.strictEqual(kSizes[entry.dataType], Number(size), `bytes of ${address}`);
  assert.strictEqual(entry.accessType, access, `access of ${address}`);
  const modulus = 2 ** (8 * Number(size));
  const wanted = defaultOf(address);
  if (wanted !== null) assert.strictEqual(((wanted % modulus) + modulus) % modulus, Number(value), `default of ${address}`);
}
assert.deepStrictEqual([...found.keys()], [], 'the EDS has objects that the drive has not');
console.log(`check_eds: ${objects.length} objects as the drive answers them`);
