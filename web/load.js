// Loads the demo: says what the browser lacks, shows how much has arrived, starts, and says why when it stops.
import init from "./demo.js";

// Bytes of demo_bg.wasm as written by web/build.sh: what a server says of a compressed answer is another number.
const WASM_BYTES = 0;

const curtain = document.getElementById("curtain");
const bar = document.getElementById("bar");
const message = document.getElementById("message");
const canvas = document.getElementById("demo");

function say(text) {
    curtain.hidden = false;
    bar.hidden = true;
    message.textContent = text;
}

/** What the demo needs and this browser lacks, or null. */
function missing() {
    // (func (result v128) i32.const 0 i8x16.splat i8x16.popcnt)
    const simd = [0, 97, 115, 109, 1, 0, 0, 0, 1, 5, 1, 96, 0, 1, 123, 3, 2, 1, 0, 10, 10, 1, 8, 0, 65, 0, 253, 15, 253, 98, 11];
    if (typeof WebAssembly !== "object" || !WebAssembly.validate(new Uint8Array(simd))) {
        return "This browser has no WebAssembly with SIMD.\nChrome or Edge 91, Firefox 89, Safari 16.4 or anything later has.";
    }
    if (!document.createElement("canvas").getContext("webgl2")) {
        return "This browser shows no WebGL2.\nIt may be switched off, or the graphics driver may be blocked: see the browser's page on graphics (chrome://gpu, about:support).";
    }
    return null;
}

/** The answer of the server, its bytes counted as they pass. */
async function fetchCounted(url, total) {
    const answer = await fetch(url);
    if (!answer.ok) throw new Error(`${url}: ${answer.status} ${answer.statusText}`);
    let bytes = 0;
    const counter = new TransformStream({
        transform(chunk, out) {
            bytes += chunk.length;
            bar.value = Math.min(bytes / total, 1);
            message.textContent = `Loading: ${(bytes / 1e6).toFixed(1)} of ${(total / 1e6).toFixed(1)} MB`;
            out.enqueue(chunk);
        },
    });
    const headers = { "content-type": "application/wasm" };
    return new Response(answer.body.pipeThrough(counter), { headers });
}

/** Lifts the curtain when the second frame is there: the first has compiled the shaders. */
function showWhenDrawn() {
    if ((window.athlete?.frame ?? 0) >= 2) curtain.hidden = true;
    else requestAnimationFrame(showWhenDrawn);
}

async function start() {
    const lack = missing();
    if (lack) return say(lack);
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("webglcontextlost", () => say("The graphics driver took the picture away. Load the page again."));
    window.addEventListener("error", (event) => say(`The demo stopped: ${event.message}\nThe browser's console says more.`));
    requestAnimationFrame(showWhenDrawn);
    const program = await init({ module_or_path: await fetchCounted("demo_bg.wasm", WASM_BYTES) });
    window.athleteMemory = () => program.memory.buffer.byteLength;
    canvas.focus();
}

start().catch((error) => {
    console.error(error);
    say(`The demo did not start.\n${error?.message ?? error}`);
});
