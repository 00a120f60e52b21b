// Reads sessions as Foxglove does: the MCAP reader, then protobufjs on the embedded descriptors.
// Messages of Foxglove's own names are compared with the definitions that Foxglove publishes.
import { open } from "node:fs/promises";
import { createRequire } from "node:module";

const require = createRequire(import.meta.url);
const { McapIndexedReader } = require("@mcap/core");
const { FileHandleReadable } = require("@mcap/nodejs");
const { foxgloveMessageSchemas } = require("@foxglove/schemas/internal");
const { FileDescriptorSet } = require("protobufjs/ext/descriptor");
const protobuf = require("protobufjs");

const published = new Map(Object.values(foxgloveMessageSchemas).map((it) => [it.name, it]));

function compare(type) {
  const theirs = published.get(type.name);
  if (theirs == undefined) throw new Error(`Foxglove publishes no ${type.name}`);
  const names = (fields) => fields.map((it) => it.name).sort().join(" ");
  const [ours, wanted] = [names(type.fieldsArray), names(theirs.fields)];
  if (ours !== wanted) throw new Error(`${type.name}: ${ours}; Foxglove has ${wanted}`);
  for (const field of theirs.fields) {
    const { id, repeated } = type.fields[field.name];
    if (field.protobufFieldNumber != undefined && field.protobufFieldNumber !== id) {
      throw new Error(`${type.name}.${field.name} has number ${id}`);
    }
    if (repeated !== (field.array != undefined)) throw new Error(`${type.name}.${field.name}: array`);
    const inner = field.type.type === "nested" && field.type.schema;
    if (inner && inner.protoEquivalent == undefined) compare(type.fields[field.name].resolve().resolvedType);
  }
}

for (const path of process.argv.slice(2)) {
  const file = await open(path);
  const readable = new FileHandleReadable(file);
  const reader = await McapIndexedReader.Initialize({ readable });
  const channels = new Map();
  for (const [id, { topic, messageEncoding, schemaId }] of reader.channelsById) {
    if (messageEncoding !== "protobuf") continue;
    const schema = reader.schemasById.get(schemaId);
    const root = protobuf.Root.fromDescriptor(FileDescriptorSet.decode(schema.data));
    const type = root.resolveAll().lookupType(schema.name);
    if (schema.name.startsWith("foxglove.")) compare(type);
    channels.set(id, { topic, type, count: 0 });
  }
  for await (const message of reader.readMessages()) {
    const channel = channels.get(message.channelId);
    if (channel == undefined) continue;
    const decoded = channel.type.decode(message.data);
    const wrong = channel.type.verify(decoded);
    if (wrong != undefined) throw new Error(`${channel.topic}: ${wrong}`);
    channel.count += 1;
  }
  for (const { topic, type, count } of channels.values()) {
    console.log(`${topic} ${type.fullName} ${count}`);
  }
  await file.close();
}
