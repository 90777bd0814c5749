#!/usr/bin/env python3
"""Times `athlete bench` and MuJoCo on the same scenes, turn and turn about, and prints the ratios of the minima.

    cargo build --release --no-default-features --features cli
    python3 benches/mujoco/compare.py --athlete target/release/athlete

MuJoCo's fastest setting is searched once for every scene (bench.py says how); then both engines run in turn, so that a
machine that slows down slows down both. A ratio is MuJoCo's time over ours per character: larger is better for us.
The column `to Newton` is the ratio to MuJoCo's fastest Newton setting: the other solvers stop early at a rougher answer.
"""

import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).parent
# Least ratios aimed at, by what the scene is, for one f64 character and for 8 lanes of f32.
TARGETS = {"skater_stand": (8, 45), "foot_stand": (6, 30), "cold": (10, 60), "air": (5, None)}


def target(scene, lanes):
    key = next((k for k in ("cold", "air") if scene.endswith("_" + k)), scene)
    single, eight = TARGETS.get(key, (None, None))
    lanes = str(lanes).lower().replace(" ", "")
    if lanes == "8xf32":
        return eight
    if lanes in ("1", "f64", "1xf64", "f64x1"):
        return single
    return None


def run(command):
    done = subprocess.run([str(c) for c in command], stdout=subprocess.PIPE, text=True, check=False)
    if done.returncode != 0:
        raise SystemExit(f"failed ({done.returncode}): {' '.join(str(c) for c in command)}")
    return done.stdout


def ours(args):
    command = [args.athlete, "bench", "--json"] + [part for scene in args.scene for part in ("--scene", scene)]
    report = json.loads(run(command + (["--quick"] if args.quick else [])))
    return report.get("build", {}), report["rows"]


def theirs(xml, scene, found=None, blocks=12, extra=()):
    command = [sys.executable, HERE / "bench.py", xml, "--scene", scene, "--blocks", blocks, *extra]
    if found:
        settings = dict.fromkeys([found["setting"]] + ([found["newton"]["setting"]] if "newton" in found else []))
        command += [part for setting in settings for part in ("--setting", setting)]
        command += [] if found["lean"] is None else [f"--lean={found['lean']}"]
    return json.loads(run(command).splitlines()[-1])


def characters(scenes, args):
    """The exported file of every scene that can be given to MuJoCo: the scene's own contact points and friction."""
    given = dict(pair.split("=", 1) for pair in args.xml)
    files = {}
    for scene in scenes:
        file = pathlib.Path(args.work) / f"{scene}.xml"
        if scene not in given:
            command = [str(args.athlete), "export-mjcf", "--character", scene, str(file)]
            if subprocess.run(command, stdout=subprocess.DEVNULL, check=False).returncode != 0 or not file.exists():
                print(f"{scene}: cannot be exported, left out", file=sys.stderr)
                continue
        files[scene] = given.get(scene, str(file))
    return files


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--athlete", type=pathlib.Path, default=pathlib.Path("target/release/athlete"))
    parser.add_argument("--xml", action="append", default=[], metavar="SCENE=FILE", help="instead of exporting it")
    parser.add_argument("--scene", action="append", default=[], help="only scenes whose names hold this")
    parser.add_argument("--rounds", type=int, default=4)
    parser.add_argument("--quick", action="store_true", help="few repetitions here, few settings there")
    parser.add_argument("--json", action="store_true", help="print the rows instead of a table")
    parser.add_argument("--bench-option", action="append", default=[], help="passed on to bench.py, such as --quick")
    args = parser.parse_args()
    if args.quick:
        args.bench_option.append("--quick")
    with tempfile.TemporaryDirectory() as work:
        args.work = work
        report(args)


def report(args):
    build, rows = ours(args)
    wanted = lambda scene: not args.scene or any(part in scene for part in args.scene)
    files = characters(sorted({r["scene"] for r in rows if wanted(r["scene"])}), args)

    # The search, once; then turn and turn about, keeping the least of each.
    mujoco = {scene: theirs(file, scene, extra=args.bench_option) for scene, file in files.items()}
    best = {(r["scene"], str(r["lanes"])): dict(r) for r in rows if r["scene"] in files}
    for _ in range(args.rounds):
        for scene, file in files.items():
            again = theirs(file, scene, mujoco[scene], extra=args.bench_option)
            least = min(mujoco[scene], again, key=lambda r: r["us_min"])
            newtons = [r["newton"] for r in (mujoco[scene], again) if "newton" in r]
            mujoco[scene] = {**least, "newton": min(newtons, key=lambda r: r["us_min"])} if newtons else least
        for row in ours(args)[1]:
            key = (row["scene"], str(row["lanes"]))
            if key in best and row["us_min"] < best[key]["us_min"]:
                best[key] = dict(row)

    table = []
    for (scene, lanes), row in best.items():
        ratio = mujoco[scene]["us_min"] / row["us_min"]
        aim = target(scene, lanes)
        newton = mujoco[scene].get("newton")
        to_newton = round(newton["us_min"] / row["us_min"], 2) if newton else None
        entry = {"mujoco": mujoco[scene], "ratio": round(ratio, 2), "ratio_newton": to_newton, "target": aim}
        table.append({**row, **entry})
    if args.json:
        print(json.dumps({"build": build, "rows": table}))
        return
    print("build:", ", ".join(f"{k} {v}" for k, v in build.items()))
    print(f"| {'scene':<18} | {'lanes':<8} | points | us | MuJoCo us (points) | ratio | target | to Newton | MuJoCo setting |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    for r in table:
        m = r["mujoco"]
        aim = "" if r["target"] is None else f"{r['target']}{'' if r['ratio'] >= r['target'] else ' (missed)'}"
        print(
            f"| {r['scene']:<18} | {r['lanes']!s:<8} | {r.get('points', '')} of {r.get('solver_points', '')} | {r['us_min']:.3f} "
            f"| {m['us_min']:.2f} ({m['points']}) | {r['ratio']:.1f} | {aim} "
            f"| {'' if r['ratio_newton'] is None else r['ratio_newton']} | {m['setting']} |"
        )


if __name__ == "__main__":
    main()
