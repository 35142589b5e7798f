// read_recovered.mjs FILE...: for each file the number of messages and the sum of their checksums, as @mcap/core reads
// them by indexes and as a stream. Run in a folder that has node_modules.
import fs from "node:fs";
import { createRequire } from "node:module";
import zlib from "node:zlib";

const require = createRequire(`${process.cwd()}/`);
const { McapIndexedReader, McapStreamReader } = require("@mcap/core");
const { FileHandleReadable } = require("@mcap/nodejs");
const { loadDecompressHandlers } = require("@mcap/support");
const decompressHandlers = await loadDecompressHandlers();

const sumOf = (topic, message) => {
  const start = Buffer.alloc(12);
  start.writeUInt32LE(message.sequence, 0);
  start.writeBigUInt64LE(message.logTime, 4);
  return zlib.crc32(Buffer.concat([Buffer.from(`${topic}\0`), start, message.data]));
};

const indexed = async (file) => {
  const handle = await fs.promises.open(file);
  try {
    const readable = new FileHandleReadable(handle);
    const reader = await McapIndexedReader.Initialize({ readable, decompressHandlers });
    let [count, sum] = [0, 0];
    for await (const message of reader.readMessages({ validateCrcs: true })) {
      count += 1;
      sum = (sum + sumOf(reader.channelsById.get(message.channelId).topic, message)) >>> 0;
    }
    return `${count} ${sum}`;
  } finally {
    await handle.close();
  }
};

const streamed = (file) => {
  const reader = new McapStreamReader({ decompressHandlers, validateCrcs: true });
  reader.append(fs.readFileSync(file));
  const topics = new Map();
  let [count, sum] = [0, 0];
  for (let record; (record = reader.nextRecord()); ) {
    if (record.type === "Channel") topics.set(record.id, record.topic);
    if (record.type !== "Message") continue;
    count += 1;
    sum = (sum + sumOf(topics.get(record.channelId), record)) >>> 0;
  }
  return reader.done() ? `${count} ${sum}` : "the end is missing";
};

for (const file of process.argv.slice(2)) {
  try {
    const [a, b] = [await indexed(file), streamed(file)];
    console.log(a === b ? a : `by indexes ${a}, as a stream ${b}`);
  } catch (error) {
    console.log(error.message.replaceAll("\n", " "));
  }
}
