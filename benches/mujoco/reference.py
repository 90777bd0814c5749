#!/usr/bin/env python3
"""Writes the numbers that the dynamics are checked against: tests/data/mujoco_<character>.json.

    athlete export-mjcf --character skater skater.xml
    python3 benches/mujoco/reference.py skater.xml foot_human.xml runner.xml

Each file holds random states of one character and what MuJoCo computes for them without contact: products of the mass
matrix with random vectors (every state, another vector each), the whole mass matrix (the first states), bias forces with
gravity, and accelerations under random generalised forces. The same seed gives the same states.
"""

import argparse
import json
import math
import pathlib

import mujoco
import numpy as np

CONVENTIONS = {
    "units": "SI, radians; gravity 0 -9.81 0",
    "order": "links depth-first as in 'bodies'; joints in the same order",
    "qpos": "free: position (world), quaternion; ball: quaternion; hinge: angle. Quaternions are w x y z, child to parent",
    "qvel": "free: linear velocity of the body's origin (world axes), angular velocity (body axes); ball: angular "
    "velocity of the child against its parent (child axes); hinge: rate. tau, bias, qacc and M are in the same coordinates",
    "qacc": "time derivative of qvel under M qacc + bias = tau",
    "bias": "Coriolis, centrifugal and gravity forces",
    "Mx": "mass matrix times x",
    "mass_matrix": "upper triangle, row by row, of the first states",
    "com": "centre of mass, world axes",
}


def load(path):
    """The model with nothing but the body: no contact, no passive forces, no visual geoms."""
    model = mujoco.MjModel.from_xml_path(str(path))
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)
    assert not model.dof_damping.any() and not model.dof_armature.any() and not model.jnt_stiffness.any()
    return model


def random_quaternion(rng):
    q = rng.normal(size=4)
    q /= np.linalg.norm(q)
    return q if q[0] >= 0 else -q


def short(values, digits):
    """Rounded to so many decimals: exact once read back, and short in the file."""
    return np.array([float(f"{v:.{digits}f}") for v in values])


def random_state(model, rng):
    qpos = np.zeros(model.nq)
    for joint in range(model.njnt):
        at = model.jnt_qposadr[joint]
        kind = model.jnt_type[joint]
        if kind == mujoco.mjtJoint.mjJNT_FREE:
            qpos[at : at + 3] = short(rng.uniform(-2, 2, 3), 4)
            qpos[at + 3 : at + 7] = random_quaternion(rng)
        elif kind == mujoco.mjtJoint.mjJNT_BALL:
            qpos[at : at + 4] = random_quaternion(rng)
        else:
            qpos[at] = short(rng.uniform(-math.pi, math.pi, 1), 4)[0]
    return qpos, short(rng.normal(scale=3.0, size=model.nv), 4), short(rng.normal(scale=60.0, size=model.nv), 3)


def record(model, data, rng, whole):
    qpos, qvel, tau = random_state(model, rng)
    x = short(rng.normal(size=model.nv), 3)
    data.qpos[:], data.qvel[:], data.qfrc_applied[:] = qpos, qvel, tau
    mujoco.mj_forward(model, data)
    product = np.zeros(model.nv)
    mujoco.mj_mulM(model, data, product, x)
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, full)
    # What is written has to hold together before anything is compared with it.
    residual = np.abs(full @ data.qacc + data.qfrc_bias - tau).max() / max(1.0, np.abs(data.qfrc_bias).max())
    assert residual < 1e-9, residual
    assert np.abs(full @ x - product).max() < 1e-9 * np.abs(product).max()
    assert np.array_equal(qpos, data.qpos)
    state = {
        "qpos": qpos.tolist(),
        "qvel": qvel.tolist(),
        "tau": tau.tolist(),
        "x": x.tolist(),
        "Mx": product.tolist(),
        "bias": data.qfrc_bias.tolist(),
        "qacc": data.qacc.tolist(),
        "com": data.subtree_com[1].tolist(),
    }
    if whole:
        state["mass_matrix"] = full[np.triu_indices(model.nv)].tolist()
    return state


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("xml", nargs="+", type=pathlib.Path, help="exported characters")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("tests/data"))
    parser.add_argument("--states", type=int, default=100)
    parser.add_argument("--whole", type=int, default=5, help="states with the whole mass matrix")
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()

    args.out.mkdir(parents=True, exist_ok=True)
    for path in args.xml:
        model = load(path)
        data = mujoco.MjData(model)
        rng = np.random.default_rng(args.seed)
        name = model.names[: model.names.index(b"\0")].decode()
        head = {
            "format": "athlete-mujoco-reference-1",
            "character": name,
            "mujoco": mujoco.mj_versionString(),
            "seed": args.seed,
            "conventions": CONVENTIONS,
            "bodies": [model.body(i).name for i in range(1, model.nbody)],
            "nq": model.nq,
            "nv": model.nv,
            "mass": float(model.body_mass.sum()),
        }
        # One state a line keeps the file readable and its changes small.
        lines = [json.dumps(record(model, data, rng, i < args.whole), separators=(",", ":")) for i in range(args.states)]
        text = json.dumps(head, indent=1)[:-2] + ',\n "states": [\n' + ",\n".join(lines) + "\n]}\n"
        json.loads(text)
        file = args.out / f"mujoco_{name}.json"
        file.write_text(text)
        print(f"{file}: {args.states} states, {model.nv} degrees of freedom, {len(text) / 1e6:.2f} MB")


if __name__ == "__main__":
    main()
