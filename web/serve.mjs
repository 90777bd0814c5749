// Serves web/dist on this machine: node web/serve.mjs [PORT] [FOLDER]. Any static server does as well; this one sends the
// compressed copies, as a server for the public should.
import { createReadStream } from "node:fs";
import { stat } from "node:fs/promises";
import { createServer } from "node:http";
import { extname, join, normalize } from "node:path";
import { fileURLToPath } from "node:url";

const TYPES = { ".html": "text/html; charset=utf-8", ".js": "text/javascript; charset=utf-8", ".wasm": "application/wasm" };
const COPIES = { br: ".br", gzip: ".gz" };

async function size(file) {
    const found = await stat(file).catch(() => null);
    return found?.isFile() ? found.size : null;
}

/** A server of the files of a folder; port 0 takes a free one. Only this machine reaches it. */
export async function serve(folder, port = 0) {
    const server = createServer(async (request, answer) => {
        const path = decodeURIComponent(new URL(request.url, "http://localhost").pathname);
        const file = join(folder, normalize(path.endsWith("/") ? `${path}index.html` : path));
        const accepted = (request.headers["accept-encoding"] ?? "").split(/[ ,]+/);
        const headers = { "content-type": TYPES[extname(file)] ?? "application/octet-stream", "cache-control": "no-cache" };
        const copies = Object.keys(COPIES).filter((encoding) => accepted.includes(encoding));
        for (const encoding of [...copies, null]) {
            const copy = encoding ? file + COPIES[encoding] : file;
            const length = await size(copy);
            if (length === null) continue;
            if (encoding) headers["content-encoding"] = encoding;
            answer.writeHead(200, { ...headers, "content-length": length });
            createReadStream(copy).pipe(answer);
            return;
        }
        answer.writeHead(404).end();
    });
    await new Promise((ready) => server.listen(port, "127.0.0.1", ready));
    return server;
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
    const folder = process.argv[3] ?? fileURLToPath(new URL("dist", import.meta.url));
    const server = await serve(folder, Number(process.argv[2] ?? 8080));
    console.log(`http://127.0.0.1:${server.address().port}/`);
}
