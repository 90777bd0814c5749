#!/usr/bin/env python3
"""Times MuJoCo on an exported character and prints one JSON line a scene.

    athlete export-mjcf --character skater skater.xml
    python3 benches/mujoco/bench.py skater.xml --scene skater_stand

Scenes, by the end of their name:

  ..._stand       on its feet, trunk and arms swaying by 0.15 rad at 1 Hz, servos on
  ..._stand_cold  the same, and every 20 steps a small random perturbation of all joints
  ..._air         no contact: mj_forward in random poses, servos on
  ..._air_step    no contact: mj_step in flight, servos on, swaying

Without --setting it tries solvers, iteration limits, friction cones, dense and sparse algebra, integrators and two ways of
writing the servos, drops those that sink in, lose contact points or stray from what the most accurate setting does, and
reports the fastest. All features that the scene does not use are switched off, the visual geoms are dropped, and steps
are taken inside C, 20 to a call.
"""

import argparse
import dataclasses
import itertools
import json
import math
import pathlib
import re
import statistics
import sys
import time

import mujoco
import numpy as np

CHUNK = 20  # steps between two changes of the target (and perturbations)
SWAY = 0.15  # rad
SWAY_RATE = 1.0  # Hz
COLD_ANGLE = 0.001  # rad, standard deviation of the perturbation of a joint (the root is left alone)
COLD_SPEED = 0.02  # rad/s, the same of its speed
SINK = 0.005  # m of penetration that a setting may show
DRIFT = 0.01  # m that the root may end away from where the reference setting takes it
TILT = 0.03  # rad, the same of its rotation
ANKLE = 0.2  # m, height that ankles are below and knees above
POINTS = 0.9  # least share of the reference's touching points


@dataclasses.dataclass(frozen=True)
class Setting:
    """One way of running MuJoCo."""

    solver: str = "newton"
    iterations: int = 100
    cone: str = "pyramidal"
    jacobian: str = "dense"
    integrator: str = "euler"
    servo: str = "spring"
    island: str = "noisland"

    def __str__(self):
        return "/".join(str(v) for v in dataclasses.astuple(self))

    @staticmethod
    def parse(text):
        parts = text.split("/")
        return Setting(parts[0], int(parts[1]), *parts[2:])


def turn(axis, angle):
    """A rotation about the x, y or z axis as a quaternion."""
    quaternion = [math.cos(angle / 2), 0.0, 0.0, 0.0]
    quaternion[1 + axis] = math.sin(angle / 2)
    return quaternion


def servo_xml(model):
    """Position servos as actuators: three a ball joint, about the axes of the child."""
    kp, kd = model.numeric("athlete_kp").data, model.numeric("athlete_kd").data
    rows = []
    for joint in range(model.njnt):
        if model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_FREE:
            continue
        link = model.jnt_bodyid[joint] - 1
        ball = model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_BALL
        name = model.joint(joint).name.replace("&", "&amp;").replace("<", "&lt;").replace('"', "&quot;")
        for gear in ("1 0 0", "0 1 0", "0 0 1") if ball else ("1 0 0",):
            rows.append(f'<position joint="{name}" gear="{gear}" kp="{kp[link]}" kv="{kd[link]}"/>')
    return "<actuator>" + "".join(rows) + "</actuator>"


class Scene:
    """A character in one scene under one setting."""

    def __init__(self, text, scene, setting, args, lean=None):
        self.args, self.setting, self.lean = args, setting, lean
        self.cold, self.air, self.flight = (scene.endswith(end) for end in ("_cold", "_air", "_air_step"))
        text = text.replace("<compiler ", '<compiler discardvisual="true" ', 1)
        plain = mujoco.MjModel.from_xml_string(text)
        if setting.servo == "actuator":
            text = text.replace("</mujoco>", servo_xml(plain) + "</mujoco>")
        self.model = mujoco.MjModel.from_xml_string(text)
        self.configure()
        self.data = mujoco.MjData(self.model)
        self.rng = np.random.default_rng(1)
        self.sway, self.ankles = self.swaying_joints(), self.ankle_joints()
        self.rest = self.model.qpos0.copy()
        self.deepest, self.end, self.points = 0.0, None, 0.0
        if self.air:
            self.empty = self.empty_call()
        else:
            self.settle()

    def configure(self):
        m, s = self.model, self.setting
        m.opt.solver = getattr(mujoco.mjtSolver, "mjSOL_" + s.solver.upper())
        m.opt.cone = getattr(mujoco.mjtCone, "mjCONE_" + s.cone.upper())
        m.opt.jacobian = getattr(mujoco.mjtJacobian, "mjJAC_" + s.jacobian.upper())
        m.opt.integrator = getattr(mujoco.mjtIntegrator, "mjINT_" + s.integrator.upper())
        m.opt.iterations = s.iterations
        if s.iterations < 100:
            m.opt.tolerance = 1e-6
            m.opt.ls_iterations = 10
        off = ["EQUALITY", "FRICTIONLOSS", "LIMIT", "CLAMPCTRL", "SENSOR", "MIDPHASE", "AUTORESET"]
        off += ["ISLAND"] if s.island == "noisland" else []
        off += ["CONSTRAINT"] if self.air or self.flight else []
        off += ["ACTUATION"] if s.servo == "spring" else []
        for name in off:
            m.opt.disableflags |= int(getattr(mujoco.mjtDisableBit, "mjDSBL_" + name))
        if s.servo == "spring":
            kp, kd = m.numeric("athlete_kp").data, m.numeric("athlete_kd").data
            for joint in range(m.njnt):
                if m.jnt_type[joint] != mujoco.mjtJoint.mjJNT_FREE:
                    link, at = m.jnt_bodyid[joint] - 1, m.jnt_dofadr[joint]
                    m.jnt_stiffness[joint] = kp[link]
                    m.dof_damping[at : at + (3 if m.jnt_type[joint] == mujoco.mjtJoint.mjJNT_BALL else 1)] = kd[link]

    def swaying_joints(self):
        """Ball joints that sway and the axis (x: trunk, forwards; z: arms, sideways)."""
        found = []
        for pattern, axis, limit in ((self.args.trunk, 0, 1), (self.args.arms, 2, 2)):
            names = [
                j
                for j in range(self.model.njnt)
                if re.search(pattern, self.model.joint(j).name, re.IGNORECASE)
                and self.model.jnt_type[j] == mujoco.mjtJoint.mjJNT_BALL
            ]
            found += [(j, axis) for j in names[:limit]]
        return found

    def ankle_joints(self):
        """The ball joints between shin and foot: below `ANKLE` at rest, their parents above it."""
        m = self.model
        mujoco.mj_forward(m, self.data)
        height = self.data.xanchor[:, 1]
        ball = [j for j in range(m.njnt) if m.jnt_type[j] == mujoco.mjtJoint.mjJNT_BALL]
        above = lambda j: self.data.xpos[m.body_parentid[m.jnt_bodyid[j]], 1] > ANKLE
        return [j for j in ball if height[j] < ANKLE and above(j)]

    def aim(self, joint, axis, angle):
        """Sets the target of a joint: a rotation about one axis."""
        if self.setting.servo == "spring":
            at = self.model.jnt_qposadr[joint]
            self.model.qpos_spring[at : at + 4] = turn(axis, angle)
        else:
            self.data.ctrl[self.first_actuator(joint) + axis] = angle

    def target(self, t):
        for joint in self.ankles:
            self.aim(joint, 0, self.lean or 0.0)
        for joint, axis in self.sway:
            self.aim(joint, axis, SWAY * math.sin(2 * math.pi * SWAY_RATE * t))

    def first_actuator(self, joint):
        return int(np.nonzero(self.model.actuator_trnid[:, 0] == joint)[0][0])

    def perturb(self):
        push = self.rng.normal(scale=COLD_ANGLE, size=self.model.nv)
        push[:6] = 0.0
        mujoco.mj_integratePos(self.model, self.data.qpos, push, 1.0)
        self.data.qvel[6:] += self.rng.normal(scale=COLD_SPEED, size=self.model.nv - 6)

    def settle(self):
        """The posture that blocks start from: in flight the zero pose, else leaning from the ankles so that the weight is over the middle of the feet."""
        if self.flight:
            self.lean = 0.0
            self.target(0.0)
            self.settled = (self.rest.copy(), np.zeros(self.model.nv), np.zeros(self.model.nv))
            return
        if self.lean is None:
            self.lean = 0.0
            for _ in range(8):
                self.stand(1.0)
                touching = self.data.contact.pos[:, 2]
                if len(touching) == 0:
                    break
                com = self.data.subtree_com[1]
                self.lean += 0.4 * (com[2] - (touching.min() + touching.max()) / 2) / com[1]
        self.stand(0.5)
        self.settled = (self.data.qpos.copy(), self.data.qvel.copy(), self.data.qacc_warmstart.copy())

    def stand(self, seconds):
        """Puts the character on its feet, leaning as one piece, and lets it come to rest."""
        m, d = self.model, self.data
        mujoco.mj_resetData(m, d)
        d.qpos[:] = self.rest
        for joint in self.ankles:
            at = m.jnt_qposadr[joint]
            d.qpos[at : at + 4] = turn(0, self.lean)
        mujoco.mj_forward(m, d)
        if self.ankles:
            # Turned about the ankles, so that the feet lie flat.
            pivot = d.xanchor[self.ankles].mean(axis=0)
            sin, cos = math.sin(-self.lean), math.cos(-self.lean)
            y, z = d.qpos[1] - pivot[1], d.qpos[2] - pivot[2]
            d.qpos[1:3] = pivot[1] + y * cos - z * sin, pivot[2] + y * sin + z * cos
            d.qpos[3:7] = turn(0, -self.lean)
        # Just below the floor: every point that can touch does so from the first step.
        d.qpos[1] -= 2e-4
        self.target(0.0)
        mujoco.mj_step(m, d, int(seconds / m.opt.timestep))

    def block(self, steps):
        """Microseconds a step in every chunk of so many steps from the settled posture, and the mean number of touching
        points."""
        return self.forward_block(steps) if self.air else self.step_block(steps)

    def step_block(self, steps):
        m, d = self.model, self.data
        d.qpos[:], d.qvel[:], d.qacc_warmstart[:] = self.settled
        # The same perturbations in every block, so that blocks and settings can be compared.
        self.rng = np.random.default_rng(1)
        spent, points = [], []
        chunks = max(1, steps // CHUNK)
        for chunk in range(chunks):
            self.target(chunk * CHUNK * m.opt.timestep)
            if self.cold:
                self.perturb()
            start = time.perf_counter_ns()
            mujoco.mj_step(m, d, CHUNK)
            spent.append((time.perf_counter_ns() - start) / 1e3 / CHUNK)
            points.append(d.ncon)
            if d.ncon:
                self.deepest = max(self.deepest, -d.contact.dist.min())
        self.end, self.points = d.qpos[:7].copy(), statistics.fmean(points)
        return spent, self.points

    def forward_block(self, steps):
        m, d = self.model, self.data
        push = self.rng.normal(scale=0.5, size=m.nv)
        d.qpos[:] = self.rest
        mujoco.mj_integratePos(m, d.qpos, push, 1.0)
        d.qvel[:] = self.rng.normal(scale=1.0, size=m.nv)
        forward = mujoco.mj_forward
        spent = []
        for _ in range(max(1, steps // CHUNK)):
            start = time.perf_counter_ns()
            for _ in range(CHUNK):
                forward(m, d)
            # The way into C and back is not MuJoCo's fault: an empty call's time is taken off.
            spent.append((time.perf_counter_ns() - start) / 1e3 / CHUNK - self.empty)
        return spent, 0.0

    def empty_call(self, calls=2000):
        """Microseconds of a call that does nothing, the least of many: a difference of two noisy figures would have a
        minimum of its own."""
        m, nothing, least = self.model, mujoco.mj_isDual, math.inf
        for _ in range(20):
            start = time.perf_counter_ns()
            for _ in range(calls):
                nothing(m)
            least = min(least, (time.perf_counter_ns() - start) / 1e3 / calls)
        return least

    def fault(self, reference):
        """What is wrong with the last block, judged by that of the reference setting; `None` if nothing."""
        if self.air or self.flight:
            return None
        tilt = 2 * math.acos(min(1.0, abs(float(self.end[3:] @ reference.end[3:]))))
        if self.deepest > max(SINK, 1.5 * reference.deepest):
            return "sinks in"
        if not (np.linalg.norm(self.end[:3] - reference.end[:3]) < DRIFT and tilt < TILT):
            return "strays"
        if self.points < POINTS * reference.points:
            return "loses contact points"
        return None


def least(blocks):
    """Microseconds a step, the least time of every chunk over the blocks: a block repeats the same work, and other
    programs on the machine seldom disturb the same chunk of it every time."""
    return statistics.fmean(map(min, zip(*blocks)))


def reference_run(text, scene, steps, args):
    """What the character does under the most accurate setting."""
    run = Scene(text, scene, Setting(iterations=100, cone="elliptic", servo="spring"), args)
    run.block(steps)
    if not (run.air or run.flight):
        w, x, y, z = run.end[3:]
        lean = math.acos(max(-1.0, min(1.0, 1 - 2 * (x * x + z * z))))
        print(
            f"{scene}: {run.points:.1f} points touch at up to {run.deepest * 1e3:.1f} mm, "
            f"the root ends leaning by {lean:.3f} rad",
            file=sys.stderr,
        )
        if lean > 0.5:
            raise SystemExit(f"{scene}: the character falls; look at --trunk, --arms and the gains in the file")
    return run


def candidates(scene, full, solvers):
    """Settings worth trying."""
    if scene.endswith("_air"):
        return [Setting(jacobian=j, servo=s) for j in ("dense", "sparse") for s in ("spring", "actuator")]
    if scene.endswith("_air_step"):
        servos = [("euler", "spring"), ("implicitfast", "spring"), ("implicitfast", "actuator")]
        return [Setting(jacobian=j, integrator=i, servo=s) for j in ("dense", "sparse") for i, s in servos]
    if not full:
        return [Setting(iterations=i, jacobian=j) for i in (100, 4) for j in ("dense", "sparse")]
    servos = [("euler", "spring"), ("implicitfast", "spring"), ("implicitfast", "actuator")]
    grid = itertools.product(
        ("newton", "cg", "pgs"), (100, 8, 4, 2), ("pyramidal", "elliptic"), ("dense", "sparse"), servos
    )
    # The projected Gauss-Seidel solver needs the dual, which MuJoCo sets up for either algebra.
    return [Setting(s, i, c, j, integrator, servo) for s, i, c, j, (integrator, servo) in grid if s in solvers]


def search(text, scene, args):
    """The fastest settings that do what the reference does, best first."""
    reference = reference_run(text, scene, args.steps, args)
    tried = []
    for setting in candidates(scene, not args.quick, args.solvers.split(",")):
        run = Scene(text, scene, setting, args, reference.lean)
        figures = [run.block(args.steps)[0] for _ in range(2)]
        tried.append((least(figures), setting, run.fault(reference)))
    good = sorted((t for t in tried if t[2] is None), key=lambda t: t[0])
    print(f"{scene}: {len(good)} of {len(tried)} settings agree with the reference", file=sys.stderr)
    if not good:
        raise SystemExit(f"{scene}: no setting agrees with the reference")
    ranked = [setting for _, setting, _ in good]
    best = ranked[: args.finalists]
    best += [s for s in ranked[args.finalists :] if s.solver == "newton"][:2]
    if "_air" not in scene:
        best += [dataclasses.replace(setting, island="island") for setting in best[:2]]
    return best, reference.lean


def measure(text, scene, settings, lean, args):
    """Blocks of the settings in turn; the row of the one with the least minimum, and beside it the fastest Newton solver
    (the only one here that converges within its iterations)."""
    runs = [Scene(text, scene, setting, args, lean) for setting in settings]
    figures = [[] for _ in runs]
    points = [[] for _ in runs]
    for _ in range(args.blocks):
        for i, run in enumerate(runs):
            spent, touching = run.block(args.steps)
            figures[i].append(spent)
            points[i].append(touching)
    def figure(among):
        i = min(among, key=lambda i: least(figures[i]))
        return {
            "setting": str(settings[i]),
            "points": round(statistics.fmean(points[i]), 1),
            "us_min": round(least(figures[i]), 3),
            "us_median": round(statistics.median(map(statistics.fmean, figures[i])), 3),
        }

    row = {"scene": scene, "engine": "mujoco", **figure(range(len(runs))), "lean": runs[0].lean}
    newton = [i for i, setting in enumerate(settings) if setting.solver == "newton"]
    return {**row, "newton": figure(newton)} if newton else row


def parser():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("xml", type=pathlib.Path, help="exported character")
    p.add_argument("--scene", action="append", required=True, help="name of a scene; may be repeated")
    p.add_argument("--setting", action="append", help="run this setting (as printed) instead of searching; may be repeated")
    p.add_argument("--lean", type=float, help="lean from the ankles with --setting, rad, instead of finding it")
    p.add_argument("--solref", default="0.005 1", help="stiffness of the contacts (time constant in s, damping ratio)")
    p.add_argument("--quick", action="store_true", help="search only a few settings")
    p.add_argument("--solvers", default="newton,cg,pgs", help="solvers to try")
    p.add_argument("--steps", type=int, help="steps of a block (default: those of a second)")
    p.add_argument("--blocks", type=int, default=10, help="blocks of every finalist")
    p.add_argument("--finalists", type=int, default=5)
    p.add_argument("--friction", type=float, help="friction coefficient of all points, instead of the file's")
    p.add_argument("--trunk", default="abdomen|lower_?back|spine|torso|trunk|chest", help="links that may sway: the first")
    p.add_argument("--arms", default="bicep|upper_?arm|humerus|shoulder", help="links that may sway: the first two")
    return p


def main():
    args = parser().parse_args()
    text = args.xml.read_text()
    if args.friction is not None:
        text = re.sub(r'friction="[^"]*"(?= group="3")', f'friction="{args.friction} 0 0"', text)
    text = text.replace('condim="3"', f'condim="3" solref="{args.solref}"')
    args.steps = args.steps or round(1 / float(re.search(r'timestep="([^"]*)"', text)[1]))
    for scene in args.scene:
        if args.setting:
            settings, lean = [Setting.parse(setting) for setting in args.setting], args.lean
        else:
            settings, lean = search(text, scene, args)
        print(json.dumps(measure(text, scene, settings, lean, args)), flush=True)


if __name__ == "__main__":
    main()
