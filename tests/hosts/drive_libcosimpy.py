"""Runs the FMU in libcosim: drive_libcosimpy.py FMU STEP STEPS OUTPUT [NAME=VALUE ...]; writes a CSV of the variables in
the environment's NAMES."""

import os
import sys

from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave

NAMES = tuple(os.environ["NAMES"].split(","))

fmu, step, steps, output, *starts = sys.argv[1:]
log_output_level(CosimLogLevel.WARNING)
execution = CosimExecution.from_step_size(round(float(step) * 1e9))  # libcosim counts in nanoseconds
slave = execution.add_local_slave(CosimLocalSlave(fmu_path=fmu, instance_name="box"))
references = {v.name if isinstance(v.name, str) else v.name.decode(): v.reference
              for v in execution.slave_variables(slave)}
for start in starts:
    name, value = start.split("=")
    assert execution.real_initial_value(slave, references[name], float(value)), start
observer = CosimObserver.create_last_value()
assert execution.add_observer(observer)
with open(output, "w") as file:
    print("time", *NAMES, sep=",", file=file)
    for _ in range(int(steps)):
        assert execution.step(), "libcosim could not step"
        values = observer.last_real_values(slave, [references[name] for name in NAMES])
        print(execution.status().current_time / 1e9, *values, sep=",", file=file)
