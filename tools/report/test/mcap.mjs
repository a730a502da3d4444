// Reads an MCAP file by the library of its makers: node mcap.mjs FILE. Prints topic, schema and count of messages, one line each;
// ends non-zero where the library refuses a record or a message is no JSON of its schema's properties.
import { readFileSync } from "node:fs";
import { McapStreamReader } from "@mcap/core";

const reader = new McapStreamReader();
reader.append(readFileSync(process.argv[2]));
const schemas = new Map();
const channels = new Map();
let failures = 0;
for (let record = reader.nextRecord(); record; record = reader.nextRecord()) {
  if (record.type === "Schema") schemas.set(record.id, { name: record.name, json: JSON.parse(new TextDecoder().decode(record.data)) });
  if (record.type === "Channel") channels.set(record.id, { topic: record.topic, schema: schemas.get(record.schemaId), count: 0 });
  if (record.type !== "Message") continue;
  const channel = channels.get(record.channelId);
  channel.count++;
  const message = JSON.parse(new TextDecoder().decode(record.data));
  for (const name of Object.keys(message)) if (!(name in channel.schema.json.properties)) failures++;
}
for (const { topic, schema, count } of channels.values()) console.log(`${topic} ${schema.name} ${count}`);
if (!reader.done()) failures++;
process.exit(failures ? 1 : 0);
