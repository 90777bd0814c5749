// How many skaters does one thread of the browser hold? node web/crowd.mjs [SKATERS]; web/test.sh --crowd runs it.
// Opens the demo with that many skaters, each with its policy at its character's rate, and prints for windows of half a
// simulated second: skaters in real time (skaters * simulated time / wall time of the ticks, drawing not counted).
import { browse, told } from "./browser.mjs";

const WINDOWS = 11;
const skaters = Number(process.argv[2] ?? 100);
const { open, close } = await browse();
const { page, complaints } = await open(`?low&crowd=${skaters}`, { viewport: { width: 160, height: 90 } });
const until = (condition, argument) => page.waitForFunction(condition, argument, { timeout: 600_000, polling: 100 });
await until((n) => window.athlete?.bodies >= n, skaters);

const held = [];
let before = await told(page);
while (held.length < WINDOWS) {
    await until((s) => window.athlete.simulated >= s, before.simulated + 0.5);
    const now = await told(page);
    held.push((now.bodies * (now.simulated - before.simulated)) / (now.spent - before.spent));
    before = now;
}
// The first window has the skaters' first steps in it, when the browser still compiles.
held.shift();
held.sort((a, b) => a - b);
const memory = (await page.evaluate(() => window.athleteMemory())) / 1e6;
console.log(`skaters ${skaters}: in real time on one thread, median ${held[held.length >> 1].toFixed(0)}, best ${held.at(-1).toFixed(0)}`);
console.log(`memory of the program ${memory.toFixed(0)} MB`);
for (const complaint of complaints) console.error(complaint);
await close();
process.exitCode = complaints.length ? 1 : 0;
