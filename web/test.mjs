// The page in a browser: it draws, time passes, the pause button stops it by mouse and by finger, the space bar too, nothing
// complains, and what goes wrong is said. web/test.sh runs it.
import assert from "node:assert/strict";
import { writeFile } from "node:fs/promises";
import { test } from "node:test";
import { browse, told } from "./browser.mjs";

const SLOW = 240_000; // software GL on a busy machine
const HOLD = 500; // a press has to last over a frame
const { open, close } = await browse();
test.after(close);

const until = (page, condition, argument) => page.waitForFunction(condition, argument, { timeout: SLOW, polling: 50 });
const pass = (ms) => new Promise((done) => setTimeout(done, ms));

/** Waits until the skater is there and drawn. */
const drawn = (page) => until(page, () => window.athlete?.bodies >= 1 && document.getElementById("curtain").hidden);

/** Simulated time stands still over three frames. */
async function stands(page) {
    // A tick may be due in the frame after the button.
    const { frame } = await told(page);
    await until(page, (n) => window.athlete.frame >= n, frame + 2);
    const before = await told(page);
    await until(page, (n) => window.athlete.frame >= n, before.frame + 3);
    assert.equal((await told(page)).simulated, before.simulated);
}

/** Simulated time goes on by half a second. */
async function passes(page) {
    const { simulated } = await told(page);
    await until(page, (s) => window.athlete.simulated > s + 0.5, simulated);
}

test("the demo runs", { timeout: 3 * SLOW }, async () => {
    const begun = Date.now();
    const { page, complaints } = await open("?low");
    await drawn(page);
    console.log(`drawn after ${((Date.now() - begun) / 1000).toFixed(1)} s`);
    const first = await told(page);
    await passes(page);
    assert.notEqual((await told(page)).time, first.time, "the skater's own clock");

    const picture = await page.screenshot();
    await writeFile(process.env.PICTURE ?? "target/web.png", picture);
    const colors = await page.evaluate(async (png) => {
        const bitmap = await createImageBitmap(await (await fetch(`data:image/png;base64,${png}`)).blob());
        const canvas = new OffscreenCanvas(bitmap.width, bitmap.height);
        const context = canvas.getContext("2d");
        context.drawImage(bitmap, 0, 0);
        return new Set(new Uint32Array(context.getImageData(0, 0, bitmap.width, bitmap.height).data.buffer)).size;
    }, picture.toString("base64"));
    assert.ok(colors > 500, `a lit scene has many colours, the picture has ${colors}`);

    // The first of the buttons in the lower left corner, see src/app/buttons.rs.
    const button = { x: 14 + 32, y: 360 - 14 - 16 };
    await page.mouse.move(button.x, button.y);
    await pass(HOLD);
    await page.mouse.down();
    await pass(HOLD);
    await page.mouse.up();
    await until(page, () => window.athlete.paused);
    await stands(page);

    await page.keyboard.down("Space");
    await pass(HOLD);
    await page.keyboard.up("Space");
    await until(page, () => !window.athlete.paused);
    await passes(page);

    const finger = await page.context().newCDPSession(page);
    await finger.send("Input.dispatchTouchEvent", { type: "touchStart", touchPoints: [button] });
    await pass(HOLD);
    await finger.send("Input.dispatchTouchEvent", { type: "touchEnd", touchPoints: [] });
    await until(page, () => window.athlete.paused);
    await stands(page);

    const memory = await page.evaluate(() => window.athleteMemory());
    console.log(`memory of the program: ${(memory / 1e6).toFixed(0)} MB`);
    assert.deepEqual(complaints, []);
    await page.context().close();
});

test("skills and policies come as files", { timeout: SLOW }, async () => {
    const { page, complaints } = await open("?low&crowd=2");
    await until(page, () => window.athlete?.bodies >= 2);
    await passes(page);
    assert.deepEqual(complaints, []);
    await page.context().close();
});

test("a browser without WebGL2 is told so", { timeout: SLOW }, async () => {
    const { page } = await open("", {
        prepare: () => {
            const real = HTMLCanvasElement.prototype.getContext;
            HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
                return kind === "webgl2" ? null : real.call(this, kind, ...rest);
            };
        },
    });
    await until(page, () => document.getElementById("message").textContent.includes("WebGL2"));
    await page.context().close();
});

test("an option that does not exist is named", { timeout: SLOW }, async () => {
    const { page } = await open("?lwo");
    await until(page, () => document.getElementById("message").textContent.includes("--lwo"));
    await page.context().close();
});
