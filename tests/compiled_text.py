"""Compile one plan in this process and print how often its code calls sine and cosine."""

import json
import re
import sys

from walkergen.scene import Scene
from walkergen.simulation import record
from walkergen.simulation.plan import prepare
from walkergen.walker import solids
from walkergen.walker.design import Design

design = Design()
scene = Scene.model_validate(json.loads(sys.argv[1]))
plan = prepare(scene, design, solids.mass_of(design))
state = plan.start(0.05, 0.0, 0.0)
plan.advance(state, 1e-5, record.new(len(state)))
kernel = plan.model.advance
text = kernel.outer.inspect_llvm(kernel.outer.signatures[0])  # type: ignore[attr-defined]
print(len(re.findall(r"call double @(?:llvm\.)?(?:sin|cos)", text)), text.count("\n"))
