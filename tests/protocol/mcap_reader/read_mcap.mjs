// node read_mcap.mjs FILE.mcap: prints {topics, first and last /tick, every /link} as JSON, decoded with the schemas that
// the file carries; every checksum is validated. Exit code 1 and the reason if the file is refused.
import { readFileSync } from "node:fs";
import { McapIndexedReader, McapStreamReader } from "@mcap/core";
import protobuf from "protobufjs";
import descriptor from "protobufjs/ext/descriptor/index.js";

function readable(bytes) {
  return {
    size: async () => BigInt(bytes.length),
    read: async (offset, size) => {
      if (offset + size > BigInt(bytes.length)) throw new Error("read beyond the end of the file");
      return new Uint8Array(bytes.buffer, bytes.byteOffset + Number(offset), Number(size));
    },
  };
}

function decoderOf(schema) {
  const set = descriptor.FileDescriptorSet.decode(schema.data);
  const type = protobuf.Root.fromDescriptor(set).lookupType(schema.name);
  return (data) => type.toObject(type.decode(data), { longs: String, enums: String, defaults: true });
}

/// The whole file record by record, also checksums that the index does not lead to.
function streamedMessages(bytes) {
  const reader = new McapStreamReader({ validateCrcs: true });
  reader.append(bytes);
  let messages = 0;
  for (let record; (record = reader.nextRecord()) != undefined; ) if (record.type === "Message") ++messages;
  if (!reader.done()) throw new Error("the file was cut");
  return messages;
}

async function main(path) {
  const bytes = readFileSync(path);
  const streamed = streamedMessages(bytes);
  const reader = await McapIndexedReader.Initialize({ readable: readable(bytes) });
  const decoders = new Map();
  for (const [id, schema] of reader.schemasById) decoders.set(id, decoderOf(schema));
  const ticks = [], links = [], topics = {};
  for await (const message of reader.readMessages({ validateCrcs: true })) {
    const channel = reader.channelsById.get(message.channelId);
    topics[channel.topic] = (topics[channel.topic] ?? 0) + 1;
    const value = decoders.get(channel.schemaId)(message.data);
    const entry = { log_time: message.logTime.toString(), sequence: message.sequence, value };
    if (channel.topic === "/tick") ticks.push(entry);
    if (channel.topic === "/link") links.push(entry);
  }
  const count = Number(reader.statistics.messageCount);
  if (count !== streamed) throw new Error(`statistics count ${count} messages, the file has ${streamed}`);
  console.log(JSON.stringify({ topics, chunks: reader.chunkIndexes.length, ticks, links }));
}

main(process.argv[2]).catch((error) => {
  console.error(`read_mcap: ${process.argv[2]}: ${error.message}`);
  process.exit(1);
});
