// A headless Chromium with software GL on a page of web/dist. CHROMIUM names the program, PLAYWRIGHT the folder that
// playwright-core is installed in (web/test.sh sets both).
import { createRequire } from "node:module";
import { join, resolve } from "node:path";
import { fileURLToPath } from "node:url";
import { serve } from "./serve.mjs";

const FLAGS = [
    "--headless=new", "--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
    "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync",
];

// Software GL on a busy machine draws a frame in seconds.
export const PATIENCE = 240_000;

export const dist = fileURLToPath(new URL("dist", import.meta.url));

/** A server of web/dist and a browser; `open` opens a page on it. */
export async function browse() {
    const require = createRequire(join(resolve(process.env.PLAYWRIGHT), "package.json"));
    const { chromium } = require("playwright-core");
    const server = await serve(dist);
    const browser = await chromium.launch({ executablePath: process.env.CHROMIUM, args: FLAGS });
    const address = `http://127.0.0.1:${server.address().port}/`;

    /** A page with a query, and what its console and its requests complain about. */
    async function open(query = "", { viewport = { width: 640, height: 360 }, prepare } = {}) {
        const context = await browser.newContext({ viewport, hasTouch: true });
        context.setDefaultTimeout(PATIENCE);
        const page = await context.newPage();
        const complaints = [];
        page.on("console", (line) => line.type() === "error" && complaints.push(line.text()));
        page.on("pageerror", (error) => complaints.push(String(error)));
        page.on("crash", () => complaints.push("the page crashed"));
        page.on("response", (answer) => answer.status() >= 400 && complaints.push(`${answer.status()} ${answer.url()}`));
        if (prepare) await page.addInitScript(prepare);
        await page.goto(address + query);
        return { page, complaints };
    }
    async function close() {
        await browser.close();
        server.close();
    }
    return { open, close };
}

/** What the demo tells the page, see src/app/web.rs. */
export const told = (page) => page.evaluate(() => window.athlete);
