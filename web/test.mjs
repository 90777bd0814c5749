// The page in a browser: it draws, time passes, the pause button stops it by mouse and by finger, the space bar too, nothing
// complains, and what goes wrong is said. web/test.sh runs it.
import assert from "node:assert/strict";
import { writeFile } from "node:fs/promises";
import { test } from "node:test";
import { PATIENCE, browse, told } from "./browser.mjs";

const { open, close } = await browse();
test.after(close);

const until = (page, condition, argument) => page.waitForFunction(condition, argument, { polling: 50 });

/** Waits for so many more frames: the program sees presses once per frame, and software GL draws one in seconds. */
async function frames(page, count) {
    const { frame } = await told(page);
    await until(page, (n) => window.athlete.frame >= n, frame + count);
}

/**
 * Presses until time stands still or goes on. A press that begins in one frame and ends in the next is too long for a click
 * where a frame takes a second, so it is tried again.
 */
async function press(page, act, paused) {
    for (let tries = 0; tries < 6; tries++) {
        await act();
        await frames(page, 3);
        if ((await told(page)).paused === paused) return;
    }
    assert.fail(`no press made paused ${paused}`);
}

/** Waits until the skater is there and drawn. */
const drawn = (page) => until(page, () => window.athlete?.bodies >= 1 && document.getElementById("curtain").hidden);

/** Simulated time stands still over three frames. */
async function stands(page) {
    // A tick may be due in the frame after the button.
    await frames(page, 2);
    const before = await told(page);
    await frames(page, 3);
    assert.equal((await told(page)).simulated, before.simulated);
}

/** Simulated time goes on by half a second. */
async function passes(page) {
    const { simulated } = await told(page);
    await until(page, (s) => window.athlete.simulated > s + 0.5, simulated);
}

test("the demo runs", { timeout: 4 * PATIENCE }, async (t) => {
    const begun = Date.now();
    const viewport = { width: 800, height: 480 };
    const { page, complaints } = await open("?low", { viewport });
    t.after(() => page.context().close());
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
    const button = { x: 14 + 32, y: viewport.height - 14 - 16 };
    await page.mouse.move(button.x, button.y);
    await frames(page, 2);
    await press(page, () => page.mouse.click(button.x, button.y), true);
    await stands(page);

    await press(page, () => page.keyboard.press("Space"), false);
    await passes(page);

    await press(page, () => page.touchscreen.tap(button.x, button.y), true);
    await stands(page);

    const memory = await page.evaluate(() => window.athleteMemory());
    console.log(`memory of the program: ${(memory / 1e6).toFixed(0)} MB`);
    assert.deepEqual(complaints, []);
});

/** A finger that comes down, moves and is lifted; `act` runs while it is down. */
async function finger(page, from, to, act) {
    const session = await page.context().newCDPSession(page);
    const send = (type, ...touchPoints) => session.send("Input.dispatchTouchEvent", { type, touchPoints });
    await send("touchStart", from);
    await frames(page, 3);
    await send("touchMove", to);
    await act();
    await send("touchEnd");
    await frames(page, 3);
}

test("a finger pulls at the skater, another steers her", { timeout: 2 * PATIENCE }, async (t) => {
    const viewport = { width: 800, height: 480 };
    const { page, complaints } = await open("?low", { viewport });
    t.after(() => page.context().close());
    await drawn(page);
    assert.equal((await told(page)).steered, false);
    // The camera keeps the skater a little beside the middle: some column of her is hit.
    for (let tries = 0; tries < 12; tries++) {
        const x = viewport.width / 2 + 8 * (tries % 2 ? -tries : tries);
        let pulls = false;
        await finger(page, { x, y: viewport.height / 2 }, { x: x + 90, y: viewport.height / 2 - 40 }, async () => {
            await frames(page, 3);
            pulls = (await told(page)).pull > 50;
        });
        if (pulls) break;
        assert.ok(tries < 11, "no finger took hold of the skater");
    }
    assert.equal((await told(page)).pull, 0, "let go");
    // The stick lies in the lower right corner since the first touch, see src/app/stick.rs.
    const middle = { x: viewport.width - 22 - 74, y: viewport.height - 22 - 74 };
    await finger(page, middle, { x: middle.x, y: middle.y - 40 }, () => until(page, () => window.athlete.steered));
    await passes(page);
    assert.deepEqual(complaints, []);
});

test("skills and policies come as files", { timeout: PATIENCE }, async (t) => {
    const { page, complaints } = await open("?low&crowd=2");
    t.after(() => page.context().close());
    await until(page, () => window.athlete?.bodies >= 2);
    await passes(page);
    assert.deepEqual(complaints, []);
});

test("a browser without WebGL2 is told so", { timeout: PATIENCE }, async (t) => {
    const { page } = await open("", {
        prepare: () => {
            const real = HTMLCanvasElement.prototype.getContext;
            HTMLCanvasElement.prototype.getContext = function (kind, ...rest) {
                return kind === "webgl2" ? null : real.call(this, kind, ...rest);
            };
        },
    });
    t.after(() => page.context().close());
    await until(page, () => document.getElementById("message").textContent.includes("WebGL2"));
});

test("an option that does not exist is named", { timeout: PATIENCE }, async (t) => {
    const { page } = await open("?lwo");
    t.after(() => page.context().close());
    await until(page, () => document.getElementById("message").textContent.includes("--lwo"));
});
