// Bundles src/ into dist/report.js and dist/report.css. `node build.mjs --to DIR` writes elsewhere (tests compare bytes).
import { createHash } from "node:crypto";
import { mkdirSync, readdirSync, readFileSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const here = dirname(fileURLToPath(import.meta.url));
const to = process.argv[2] === "--to" ? process.argv[3] : join(here, "dist");

/** SHA-256 over what the bundle is made of: names and contents, in the order of their names. */
function sourceHash() {
  const hash = createHash("sha256");
  const sources = readdirSync(join(here, "src"), { recursive: true }).filter((name) => /\.(ts|css)$/.test(name));
  const files = [...sources.map((name) => `src/${name}`), "build.mjs", "package-lock.json"].sort();
  for (const name of files) {
    const text = readFileSync(join(here, name), "utf8");
    hash.update(`${name}\n${Buffer.byteLength(text)}\n${text}`);
  }
  return hash.digest("hex");
}

const stamp = `source ${sourceHash()}`;
const licence = readFileSync(join(here, "node_modules/uplot/LICENSE"), "utf8").trim();
const shared = { bundle: true, minify: true, legalComments: "none", write: false, logLevel: "warning" };
const script = await build({
  ...shared,
  entryPoints: [join(here, "src/main.ts")],
  format: "iife",
  target: "es2020",
  charset: "ascii",
  banner: { js: `/* gripline report, ${stamp}\n\nIt holds uPlot 1.6.32:\n\n${licence}\n*/` },
});
const style = await build({
  ...shared,
  entryPoints: [join(here, "src/style.css")],
  charset: "ascii",
  banner: { css: `/* gripline report, ${stamp} */` },
});
mkdirSync(to, { recursive: true });
const text = script.outputFiles[0].text;
if (/<\/script|<!--/i.test(text)) throw new Error("the bundle would end the script element it is put into");
writeFileSync(join(to, "report.js"), text);
writeFileSync(join(to, "report.css"), style.outputFiles[0].text);
