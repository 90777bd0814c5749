#!/usr/bin/env python3
"""Checks policy files with the tools of the ONNX project.

    pip install onnx onnxruntime numpy
    cargo test --release --no-default-features --features cli --test core policy::write_samples -- --ignored
    python3 scripts/check_onnx.py target/policy_samples/*.onnx

For each file: onnx.checker accepts it, with shapes inferred; it has a contract; onnxruntime gives the contract's golden
action; onnxruntime and the ONNX reference evaluator agree on random observations, one at a time and in a batch; and
where a .json of the same name lies beside it (observations, and the actions that this crate computed), onnxruntime
agrees with those too. Ends with code 1 where something differs by more than allowed, relative where numbers are beyond
1.
"""

import json
import pathlib
import sys

import numpy as np
import onnx
import onnxruntime
from onnx.reference import ReferenceEvaluator

KEY = "bevy_athlete"
# Largest difference between two runtimes; from the trainer's golden pair; and from the reference evaluator, which adds the terms of a
# product in another order (in f32 that alone is worth 1e-6).
RUNTIMES, GOLDEN, REFERENCE = 1e-6, 1e-5, 1e-5


def difference(a, b):
    a, b = np.asarray(a, np.float64), np.asarray(b, np.float64)
    return float(np.max(np.abs(a - b) / np.maximum(np.abs(b), 1.0)))


def check(path):
    model = onnx.load(path)
    onnx.checker.check_model(model, full_check=True)
    contract = json.loads({entry.key: entry.value for entry in model.metadata_props}[KEY])
    session = onnxruntime.InferenceSession(str(path), providers=["CPUExecutionProvider"])
    reference = ReferenceEvaluator(model)

    def run(rows):
        rows = np.asarray(rows, np.float32)
        return session.run(["action"], {"observation": rows})[0]

    size = sum(block["size"] for block in contract["observation"])
    found = {}
    golden = contract["golden"]
    found["golden pair"] = (difference(run([golden["observation"]])[0], golden["action"]), GOLDEN)

    random = np.random.default_rng(1)
    mean, scale = np.array(contract["normaliser"]["mean"]), np.array(contract["normaliser"]["scale"])
    raw = (mean + random.normal(size=(64, size)) * 3 / scale).astype(np.float32)
    together = run(raw)
    assert together.shape == (64, 3 * len(contract["action"]["links"])), together.shape
    found["reference evaluator"] = (difference(together, reference.run(None, {"observation": raw})[0]), REFERENCE)
    found["one by one"] = (difference(together, np.concatenate([run(row[None]) for row in raw])), RUNTIMES)

    beside = path.with_suffix(".json")
    if beside.exists():
        sample = json.loads(beside.read_text())
        rows = sample["rows"]
        actions = run(np.reshape(sample["observations"], (rows, size)))
        found["this crate"] = (difference(actions, np.reshape(sample["actions"], (rows, -1))), RUNTIMES)

    words = ", ".join(f"{what} {value:.1e}" for what, (value, _) in found.items())
    print(f"{path.name}: {contract['character']}, {contract['skill']}, {size} -> {together.shape[1]}; {words}")
    return all(value <= allowed for value, allowed in found.values())


def main():
    paths = [pathlib.Path(argument) for argument in sys.argv[1:]]
    if not paths:
        sys.exit(__doc__)
    print(f"onnx {onnx.__version__}, onnxruntime {onnxruntime.__version__}, numpy {np.__version__}")
    good = [check(path) for path in paths]
    sys.exit(0 if all(good) else 1)


if __name__ == "__main__":
    main()
