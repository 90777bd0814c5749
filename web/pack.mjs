// Compresses the files of a folder and prints what a visitor fetches: node web/pack.mjs FOLDER
// Beside each file goes a .br and a .gz copy where that is smaller.
import { readdirSync, readFileSync, writeFileSync } from "node:fs";
import { join, relative } from "node:path";
import { brotliCompressSync, constants, gzipSync } from "node:zlib";

const folder = process.argv[2];
const files = readdirSync(folder, { recursive: true, withFileTypes: true })
    .filter((entry) => entry.isFile() && !/\.(br|gz)$/.test(entry.name))
    .map((entry) => join(entry.parentPath ?? entry.path, entry.name))
    .sort();

const total = [0, 0, 0];
const row = (name, sizes) => console.log([...sizes.map((n) => String(n).padStart(10)), ` ${name}`].join(""));
row("file", ["raw", "gzip", "brotli"]);
for (const file of files) {
    const raw = readFileSync(file);
    const gzip = gzipSync(raw, { level: 9 });
    // The largest window that browsers read, 16 MiB.
    const params = { [constants.BROTLI_PARAM_LGWIN]: 24, [constants.BROTLI_PARAM_SIZE_HINT]: raw.length };
    const brotli = brotliCompressSync(raw, { params });
    const sizes = [raw.length];
    for (const [copy, ending] of [[gzip, ".gz"], [brotli, ".br"]]) {
        const smaller = copy.length < raw.length;
        if (smaller) writeFileSync(file + ending, copy);
        sizes.push(smaller ? copy.length : raw.length);
    }
    sizes.forEach((bytes, k) => (total[k] += bytes));
    row(relative(folder, file), sizes);
}
row("total", total);
