// Numbers and texts as the page writes them: node numbers.mjs. Prints a line per failure, ends non-zero if there is one.
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { build } from "esbuild";

const source = join(dirname(fileURLToPath(import.meta.url)), "..", "src");
const bundle = async (entry) => {
  const { outputFiles } = await build({ entryPoints: [join(source, entry)], bundle: true, write: false, format: "esm" });
  return import(`data:text/javascript;base64,${Buffer.from(outputFiles[0].text).toString("base64")}`);
};
const { decimalsFor, fixed, percent, plain, short, trueMinus, unitText } = await bundle("dom.ts");

let failures = 0;
function same(found, wanted, of) {
  if (found === wanted) return;
  failures++;
  console.log(`FAIL ${of}: ${JSON.stringify(found)}, expected ${JSON.stringify(wanted)}`);
}

// What is nearly a tenth has as many digits as a tenth.
same(short(0.1), "0.100", "short");
same(short(0.0999999), "0.100", "short below a power of ten");
same(short(999.9999), "1000", "short of nearly a thousand");
same(short(-1.91e-6), "−1.91 × 10⁻⁶", "short of a tiny number");
same(short(1e308), "1.00 × 10³⁰⁸", "short of a huge number");
same(short(Infinity), "–", "short of no number");
same(plain(0.25), "0.25", "plain");
same(plain(1500), "1500", "plain keeps zeros before the point");
same(plain(2e9), "2 × 10⁹", "plain of a large number");
same(fixed(-0.0001, 3), "0.000", "fixed: zero has no sign");
same(fixed(-1.5, 1), "−1.5", "fixed");
same(fixed(1e308, 2), "1.00 × 10³⁰⁸", "fixed of a huge number");
same(decimalsFor(3.2), 2, "decimals of metres per second");
same(decimalsFor(0.45), 3, "decimals of friction");
same(decimalsFor(40), 1, "decimals of degrees");
same(decimalsFor(0), 3, "decimals of nothing");
same(percent(1), "100 %", "percent");
same(percent(0.99995), "> 99.9 %", "percent of nearly all");
same(percent(0.12), "12 %", "percent of some");
same(percent(undefined), "–", "percent of nothing");
same(unitText("m/s2"), "m/s²", "unit");
same(unitText("N"), "N", "unit without a power");
same(trueMinus("d0 = -0.03 rad, -.5 and -1"), "d0 = −0.03 rad, −.5 and −1", "minus");
same(trueMinus("steer-lag 2-3 seed-1 --only"), "steer-lag 2-3 seed-1 --only", "hyphens stay");

console.log(failures ? `${failures} checks failed` : "all checks passed");
process.exit(failures ? 1 : 0);
