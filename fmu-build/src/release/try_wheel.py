"""Imports the installed package and prints what the release command compares: its version, the sums of the archives inside, the bits
of the default motion from rest at every half second."""

import hashlib
import struct

import vibro_impact as vi

print(vi.__version__)
for version in (2, 3):
    print(hashlib.sha256(vi.fmu_path(version).read_bytes()).hexdigest())
run = vi.PaperMachine().simulate(start=[0.0] * 6, times=[0.5 * i for i in range(601)])
for s, v in zip(run.s, run.v):
    print(struct.pack(">6d", *s, *v).hex())
