//! Every error of the file, with its whole message.

use vibro_machine::file::parse;

/// A valid machine; each case changes one place of it.
pub const SOUND: &str = r#"name = "Sound"
gravity = "9.81 m/s2"
[body.box]
mass = "12 kg"
[body.block]
mass = "350 g"
gravity = -1.0
start = { s = "2 mm", v = 0.0 }
[body.wheel]
inertia = "0.02 kg m2"
[body.drum]
inertia = 1
[body.belt]
motion = { rate = "0.5 m/s" }
[spring.mount]
between = ["ground", "box"]
stiffness = "48 kN/m"
damping = "60 N s/m"
preload = 0.0
[stop.upper]
between = ["box", "block"]
gap = "5 mm"
restitution = 0.7
[stop.buffer]
between = ["block", "box"]
gap = "4 mm"
stiffness = "2 MN/m"
damping = "150 N s/m"
law = "no-pull"
[friction.guide]
between = ["belt", "block"]
force = "0.4 N"
static = "0.5 N"
[load.shaker]
on = "box"
harmonics = [{ amplitude = "150 N", frequency = "10 Hz", phase = 0.0 }]
steps = [[0.4, 20.0], [0.9, -20.0]]
table = "record.csv"
[spring.mesh]
arms = { wheel = "50 mm", box = 1.0 }
stiffness = "200 MN/m"
[link.gear]
arms = { wheel = 1.0, drum = -3.0 }
"#;

/// Text to replace, its replacement, and the message. Line numbers refer to the changed text.
#[rustfmt::skip]
const CASES: &[(&str, &str, &str)] = &[
    // Unknown names.
    ("gap = \"5 mm\"", "gpa = \"5 mm\"", "m.toml:22: stop.upper.gpa = \"5 mm\": no such key; did you mean `gap`?"),
    ("[spring.mount]", "[sprign.mount]", "m.toml:15: sprign: no such kind of section; did you mean `spring`?"),
    // A refused name of a body has no follow-on messages.
    ("[body.belt]", "[boddy.belt]", "m.toml:13: boddy: no such kind of section; did you mean `body`?"),
    ("[body.belt]", "[body.2belt]", "m.toml:13: body.2belt: expected a name of letters (A-Z, a-z), digits and _, beginning with a letter, at most 100 characters long"),
    ("damping = \"60 N s/m\"", "colour = \"red\"", "m.toml:18: spring.mount.colour = \"red\": no such key; expected one of between, arms, stiffness, damping, preload, points, quadratic, cubic, quartic, quintic, coefficient, exponent, force, offset, free_length, slip, series_damping, slider"),
    ("between = [\"ground\", \"box\"]", "between = [\"ground\", \"boks\"]", "m.toml:16: spring.mount.between[1] = \"boks\": no body has this name; did you mean `box`?"),
    ("between = [\"ground\", \"box\"]", "between = [\"grond\", \"box\"]", "m.toml:16: spring.mount.between[0] = \"grond\": no body has this name; did you mean `ground`?"),
    ("on = \"box\"", "on = \"ground\"", "m.toml:35: load.shaker.on = \"ground\": the ground does not move; expected one of box, block, wheel, drum, belt"),
    ("on = \"box\"", "on = \"bx\"", "m.toml:35: load.shaker.on = \"bx\": no body has this name; did you mean `box`?"),
    ("arms = { wheel = \"50 mm\", box = 1.0 }", "arms = { whel = \"50 mm\", box = 1.0 }", "m.toml:40: spring.mesh.arms.whel = \"50 mm\": no body has this name; did you mean `wheel`?"),
    ("start = { s = \"2 mm\", v = 0.0 }", "start = { x = \"2 mm\", v = 0.0 }", "m.toml:8: body.block.start.x = \"2 mm\": no such key; expected one of s, v"),
    ("phase = 0.0 }]", "fase = 0.0 }]", "m.toml:36: load.shaker.harmonics[0].fase = 0.0: no such key; did you mean `phase`?"),
    ("law = \"no-pull\"", "law = \"nopull\"", "m.toml:29: stop.buffer.law = \"nopull\": expected \"no-pull\", \"elastogap\", \"pull\" or \"undamped-rebound\""),
    ("motion = { rate = \"0.5 m/s\" }", "motion = { ratee = \"0.5 m/s\" }", "m.toml:14: body.belt.motion.ratee = \"0.5 m/s\": no such key; did you mean `rate`?\nm.toml:14: body.belt.motion: requires one or more of constant, amplitude with frequency, harmonics, sweep, steps, table, input, offset, rate, acceleration"),
    // Bodies.
    ("mass = \"12 kg\"", "gravity = 1.0", "m.toml:3: body.box: requires `mass` for a body that translates, `inertia` for a body that rotates, or `motion` for a prescribed motion"),
    ("mass = \"12 kg\"", "mass = \"12 kg\"\ninertia = \"1 kg m2\"", "m.toml:3: body.box: `mass` and `inertia` cannot be combined: use `mass` for a body that translates, `inertia` for a body that rotates, or `motion` for a prescribed motion"),
    ("mass = \"12 kg\"", "mass = \"12 kg\"\nmotion = \"2 mm\"", "m.toml:3: body.box: `mass` and `motion` cannot be combined: use `mass` for a body that translates, `inertia` for a body that rotates, or `motion` for a prescribed motion"),
    ("mass = \"12 kg\"", "mass = 0", "m.toml:4: body.box.mass = 0: must be greater than 0"),
    ("mass = \"12 kg\"", "mass = \"-3 g\"", "m.toml:4: body.box.mass = \"-3 g\": must be greater than 0"),
    ("mass = \"12 kg\"", "mass = \"12 m\"", "m.toml:4: body.box.mass = \"12 m\": cannot be in `m`; expected one of kg, g, mg, t, lb"),
    ("mass = \"12 kg\"", "mass = nan", "m.toml:4: body.box.mass = nan: must be a finite number"),
    ("mass = \"12 kg\"", "mass = \"inf\"", "m.toml:4: body.box.mass = \"inf\": must be a finite number"),
    ("mass = \"12 kg\"", "mass = 1e999", "m.toml:4: body.box.mass = 1e999: must be a finite number"),
    ("mass = \"12 kg\"", "mass = true", "m.toml:4: body.box.mass = true: expected a number > 0 in kg, or with a unit: kg, g, mg, t, lb"),
    ("mass = \"12 kg\"", "mass = [1.0]", "m.toml:4: body.box.mass = [1.0]: expected a number > 0 in kg, or with a unit: kg, g, mg, t, lb"),
    ("mass = \"12 kg\"", "mass = \"twelve\"", "m.toml:4: body.box.mass = \"twelve\": expected a number > 0 in kg, or with a unit: kg, g, mg, t, lb"),
    ("inertia = \"0.02 kg m2\"", "inertia = \"20 g\"", "m.toml:10: body.wheel.inertia = \"20 g\": cannot be in `g`; expected one of kg.m2, kg.cm2, kg.mm2, g.m2, g.cm2, g.mm2, t.m2, kgm2"),
    ("inertia = \"0.02 kg m2\"", "inertia = \"0.02 kg m2\"\ngravity = 1.0", "m.toml:11: body.wheel.gravity = 1.0: requires `mass`: gravity exerts no torque on a body with `inertia`"),
    ("motion = { rate = \"0.5 m/s\" }", "motion = { rate = \"0.5 m/s\" }\nmass = \"1 kg\"", "m.toml:13: body.belt: `mass` and `motion` cannot be combined: use `mass` for a body that translates, `inertia` for a body that rotates, or `motion` for a prescribed motion"),
    ("motion = { rate = \"0.5 m/s\" }", "motion = { rate = \"0.5 m/s\" }\nstart = { s = 1.0 }", "m.toml:15: body.belt.start: cannot be combined with `motion`, which determines the body's motion"),
    ("motion = { rate = \"0.5 m/s\" }", "motion = {}", "m.toml:14: body.belt.motion: requires one or more of constant, amplitude with frequency, harmonics, sweep, steps, table, input, offset, rate, acceleration"),
    ("motion = { rate = \"0.5 m/s\" }", "motion = { rate = \"0.5 m/s\", amplitude = \"1 rad\", frequency = 1.0 }", "m.toml:14: body.belt.motion.amplitude = \"1 rad\": cannot be in `rad`; expected one of m, cm, mm, um, in"),
    ("motion = { rate = \"0.5 m/s\" }", "motion = { constant = 1.0, offset = 1.0 }", "m.toml:14: body.belt.motion.offset = 1.0: cannot be combined with `constant`, which means the same: use one of them"),
    ("motion = { rate = \"0.5 m/s\" }", "motion = { rate = \"0.5 m/s\" }\ndimension = \"radial\"", "m.toml:15: body.belt.dimension = \"radial\": expected \"translation\" or \"rotation\""),
    ("gravity = -1.0", "gravity = -1.5", "m.toml:7: body.block.gravity = -1.5: expected a number from -1 to 1: the cosine of the angle between s and gravity, such as -1 if s points upwards; the acceleration is `gravity` at the top of the file"),
    ("gravity = \"9.81 m/s2\"", "gravity = \"9.81 m/s\"", "m.toml:2: gravity = \"9.81 m/s\": cannot be in `m/s`; expected one of m/s2, mm/s2, cm/s2, g"),
    ("gravity = \"9.81 m/s2\"", "gravity = -9.81", "m.toml:2: gravity = -9.81: must not be negative: it is the size of the acceleration; `gravity` of each body, from -1 to 1, gives its direction"),
    ("gravity = \"9.81 m/s2\"", "", "m.toml:7: body.block.gravity = -1.0: requires `gravity` at the top level of the file, such as `gravity = \"9.81 m/s2\"`"),
    ("[body.belt]", "[body.ground]\nmass = 1.0\n[body.belt]", "m.toml:13: body.ground: `ground` is the fixed frame; use another name"),
    ("[body.belt]", "[body.\"two words\"]\nmass = 1.0\n[body.belt]", "m.toml:13: body.two words: expected a name of letters (A-Z, a-z), digits and _, beginning with a letter, at most 100 characters long"),
    ("[body.belt]", "[body.idle]\nmass = 1.0\n[body.belt]", "m.toml:13: body.idle: nothing acts on this body; connect an element to it"),
    ("[body.belt]", "[body.box]\nmass = 1.0\n[body.belt]", "m.toml:13: body.box: is given twice; keep one of them"),
    ("[body.belt]", "[body]\nlone = 3\n[body.belt]", "m.toml:14: body.lone = 3: expected tables with names, such as [body.NAME]"),
    // Names.
    ("name = \"Sound\"", "name = \"\"", "m.toml:1: name = \"\": expected a name of letters (A-Z, a-z), digits and _, beginning with a letter, at most 100 characters long"),
    ("name = \"Sound\"", "name = \"two words\"", "m.toml:1: name = \"two words\": expected a name of letters (A-Z, a-z), digits and _, beginning with a letter, at most 100 characters long"),
    ("name = \"Sound\"", "name = 3", "m.toml:1: name = 3: expected a name, such as \"Damper\""),
    ("name = \"Sound\"", "", "m.toml:1: name: missing; expected a name, such as \"Damper\""),
    ("[spring.mesh]", "[spring.upper]", "m.toml:20: stop.upper: another element has this name: spring.upper"),
    ("[spring.mesh]", "[spring.mount]", "m.toml:39: spring.mount: is given twice; keep one of them"),
    ("[stop.buffer]", "[stop.1st]", "m.toml:24: stop.1st: expected a name of letters (A-Z, a-z), digits and _, beginning with a letter, at most 100 characters long"),
    ("[stop.buffer]", "[stop.\"bu.ffer\"]", "m.toml:24: stop.bu.ffer: expected a name of letters (A-Z, a-z), digits and _, beginning with a letter, at most 100 characters long"),
    // Ends and arms.
    ("between = [\"ground\", \"box\"]", "between = [\"box\"]", "m.toml:16: spring.mount.between = [\"box\"]: expected two names, such as [\"ground\", \"box\"]"),
    ("between = [\"ground\", \"box\"]", "between = \"box\"", "m.toml:16: spring.mount.between = \"box\": expected two names, such as [\"ground\", \"box\"]"),
    ("between = [\"ground\", \"box\"]", "between = [\"box\", \"box\"]", "m.toml:16: spring.mount.between = [\"box\", \"box\"]: both ends are the same; expected two bodies, or ground and a body"),
    ("between = [\"ground\", \"box\"]", "between = [\"ground\", \"ground\"]", "m.toml:16: spring.mount.between = [\"ground\", \"ground\"]: both ends are the same; expected two bodies, or ground and a body"),
    ("between = [\"ground\", \"box\"]", "between = [\"wheel\", \"box\"]", "m.toml:16: spring.mount.between = [\"wheel\", \"box\"]: cannot connect a translating and a rotating body directly; use `arms` with a lever such as \"50 mm\""),
    ("between = [\"ground\", \"box\"]", "between = [\"ground\", 3]", "m.toml:16: spring.mount.between[1] = 3: expected \"ground\" or the name of a body"),
    ("between = [\"ground\", \"box\"]", "", "m.toml:15: spring.mount: requires `between = [A, B]` or `arms = { A = 1.0, B = -1.0 }`"),
    ("between = [\"ground\", \"box\"]", "between = [\"ground\", \"box\"]\narms = { box = 1.0 }", "m.toml:17: spring.mount.arms: cannot be combined with `between`: use `between` for two ends, or `arms` for bodies with lever arms"),
    ("arms = { wheel = \"50 mm\", box = 1.0 }", "arms = { wheel = 0.05, box = 1.0 }", "m.toml:40: spring.mesh.arms.box = 1.0: its term is a length, but the term of `wheel` is an angle; all terms must be lengths, or all angles: use an arm in m for a rotating body in a translating element, in 1/m for a translating body in a rotating element, and without a unit otherwise"),
    ("arms = { wheel = \"50 mm\", box = 1.0 }", "arms = { wheel = \"50 N\", box = 1.0 }", "m.toml:40: spring.mesh.arms.wheel = \"50 N\": expected a number other than 0, without a unit, or in m, cm, mm, um or in for an element whose e is a length"),
    ("arms = { wheel = \"50 mm\", box = 1.0 }", "arms = { wheel = \"0 mm\", box = 1.0 }", "m.toml:40: spring.mesh.arms.wheel = \"0 mm\": must not be 0"),
    ("arms = { wheel = \"50 mm\", box = 1.0 }", "arms = {}", "m.toml:40: spring.mesh.arms: names no body; expected one or more bodies"),
    ("arms = { wheel = \"50 mm\", box = 1.0 }", "arms = [\"wheel\", \"box\"]", "m.toml:40: spring.mesh.arms = [\"wheel\", \"box\"]: expected a table of bodies and arms, such as { wheel = 1.0, drum = -3.0 }"),
    // Springs and stops.
    ("stiffness = \"48 kN/m\"", "stiffness = \"-48 kN/m\"", "m.toml:17: spring.mount.stiffness = \"-48 kN/m\": must not be negative: a negative stiffness requires a curve, such as `cubic`, a `force` or `points`"),
    ("stiffness = \"48 kN/m\"", "stiffness = \"48 kN m/rad\"", "m.toml:17: spring.mount.stiffness = \"48 kN m/rad\": cannot be in `kN m/rad`; expected one of N/m, N/mm, kN/m, kN/mm, MN/m, N/cm, N/um, GN/m, lbf/in"),
    ("stiffness = \"48 kN/m\"", "", "m.toml:15: spring.mount.stiffness: missing; expected a number >= 0 in N/m, or with a unit: N/m, N/mm, kN/m, kN/mm, MN/m, N/cm, N/um, GN/m, lbf/in; `points` or a curve, such as `cubic`, may replace it"),
    ("stiffness = \"48 kN/m\"\ndamping = \"60 N s/m\"\npreload = 0.0", "stiffness = 1.0\noffset = 1.0\nfree_length = 2.0\ncoefficient = 3.0\nexponent = 2\nslider = 0.1", "m.toml:20: spring.mount.coefficient = 3.0: cannot be combined with `offset`: use two springs in parallel\nm.toml:21: spring.mount.exponent = 2: cannot be combined with `offset`: use two springs in parallel\nm.toml:22: spring.mount.slider = 0.1: cannot be combined with `offset`: use two springs in parallel"),
    ("[spring.mount]\nbetween = [\"ground\", \"box\"]\nstiffness = \"48 kN/m\"\ndamping = \"60 N s/m\"\npreload = 0.0", "[damper.mount]\nbetween = [\"ground\", \"box\"]", "m.toml:15: damper.mount.damping: missing; expected a number > 0 in N.s/m, or with a unit: N.s/m, kN.s/m, N.s/mm, kg/s, N/(m/s), Ns/m, kNs/m, Ns/mm; a curve, such as `quadratic` or `cubic`, or `force` may replace it"),
    ("preload = 0.0", "force = \"= e * (e < 0)\"", "m.toml:19: spring.mount.force = \"= e * (e < 0)\": comparisons are not supported at `< 0)`: a formula has no corners: points, stops and friction have them"),
    ("damping = \"60 N s/m\"", "damping = -1", "m.toml:18: spring.mount.damping = -1: must not be negative"),
    ("preload = 0.0", "preload = \"1 m\"", "m.toml:19: spring.mount.preload = \"1 m\": cannot be in `m`; expected one of N, mN, kN, MN, lbf"),
    ("gap = \"5 mm\"", "gap = \"5 mN\"", "m.toml:22: stop.upper.gap = \"5 mN\": cannot be in `mN`; expected one of m, cm, mm, um, in"),
    ("gap = \"5 mm\"", "", "m.toml:20: stop.upper.gap: missing; expected a number in m, or with a unit: m, cm, mm, um, in"),
    ("gap = \"5 mm\"", "gap = \"-3 mm\"", "m.toml:22: stop.upper.gap = \"-3 mm\": e = 0.002 m at the start is beyond the gap; a rigid stop requires e <= gap: increase the gap, or change the start"),
    ("restitution = 0.7", "restitution = -0.1", "m.toml:23: stop.upper.restitution = -0.1: expected a number from 0 to 1"),
    ("restitution = 0.7", "restitution = 1.01", "m.toml:23: stop.upper.restitution = 1.01: expected a number from 0 to 1"),
    ("restitution = 0.7", "restitution = 0.7\nstiffness = \"1 N/m\"", "m.toml:24: stop.upper.stiffness = \"1 N/m\": cannot be combined with `restitution`: use `restitution` for a rigid stop, or `stiffness` for a compliant one"),
    ("restitution = 0.7", "restitution = 0.7\nlaw = \"no-pull\"", "m.toml:24: stop.upper.law = \"no-pull\": cannot be combined with `restitution`: use `restitution` for a rigid stop, or `stiffness` for a compliant one"),
    ("restitution = 0.7", "", "m.toml:20: stop.upper: requires `restitution` (rigid stop) or `stiffness` (compliant stop)"),
    ("restitution = 0.7", "damping = 3.0", "m.toml:20: stop.upper: requires `restitution` (rigid stop) or `stiffness` (compliant stop)"),
    ("damping = \"150 N s/m\"", "damping = \"-150 N s/m\"", "m.toml:28: stop.buffer.damping = \"-150 N s/m\": must not be negative"),
    ("stiffness = \"2 MN/m\"", "stiffness = \"-2 MN/m\"", "m.toml:27: stop.buffer.stiffness = \"-2 MN/m\": must not be negative"),
    // Friction.
    ("force = \"0.4 N\"", "force = \"-0.4 N\"", "m.toml:32: friction.guide.force = \"-0.4 N\": must not be negative"),
    ("force = \"0.4 N\"", "force = { constant = \"-0.4 N\" }", "m.toml:32: friction.guide.force = -0.4: must not be negative"),
    ("force = \"0.4 N\"", "", "m.toml:30: friction.guide.force: missing; expected a number >= 0 in N, or with a unit: N, mN, kN, MN, lbf, or a signal"),
    ("static = \"0.5 N\"", "stribeck = \"0.1 m/s\"", "m.toml:33: friction.guide.stribeck = \"0.1 m/s\": requires `static`: the level falls from `static` to `force` as the speed grows"),
    ("static = \"0.5 N\"", "static = 0.5\nstribeck = 0.1\nstribeck_exponent = 3", "m.toml:35: friction.guide.stribeck_exponent = 3: expected the number 1 or 2"),
    ("static = \"0.5 N\"", "stribeck_exponent = 1", "m.toml:33: friction.guide.stribeck_exponent = 1: requires `stribeck`, the speed at which the level falls from `static` to `force`"),
    ("static = \"0.5 N\"", "viscous = \"-1 N s/m\"", "m.toml:33: friction.guide.viscous = \"-1 N s/m\": must not be negative"),
    ("force = \"0.4 N\"\nstatic = \"0.5 N\"", "follows = \"buffer\"\ncoefficient = 0.3\nviscous = 1.0\nstribeck = 0.1", "m.toml:34: friction.guide.viscous = 1.0: cannot be combined with `follows`: use a damper between the same ends\nm.toml:35: friction.guide.stribeck = 0.1: cannot be combined with `follows`: use `force` and `static`"),
    ("force = \"0.4 N\"", "force = \"0.6 N\"", "m.toml:33: friction.guide.static = \"0.5 N\": must be at least 0.6 N, the sliding friction friction.guide.force"),
    ("static = \"0.5 N\"", "static = \"0.5 m\"", "m.toml:33: friction.guide.static = \"0.5 m\": cannot be in `m`; expected one of N, mN, kN, MN, lbf"),
    ("static = \"0.5 N\"", "static = []", "m.toml:33: friction.guide.static = []: expected a number >= 0 in N, or with a unit: N, mN, kN, MN, lbf, or a signal such as { amplitude = 1.0, frequency = \"10 Hz\" }"),
    // Signals.
    ("on = \"box\"", "on = \"belt\"", "m.toml:35: load.shaker.on = \"belt\": the motion of this body is prescribed; expected a body with mass or inertia"),
    ("on = \"box\"", "", "m.toml:34: load.shaker.on: missing; expected the name of a body"),
    ("on = \"box\"", "on = [\"box\"]", "m.toml:35: load.shaker.on = [\"box\"]: expected the name of a body"),
    ("frequency = \"10 Hz\"", "frequency = 0", "m.toml:36: load.shaker.harmonics[0].frequency = 0: must be greater than 0"),
    ("frequency = \"10 Hz\"", "frequency = \"-10 Hz\"", "m.toml:36: load.shaker.harmonics[0].frequency = \"-10 Hz\": must be greater than 0"),
    ("frequency = \"10 Hz\"", "frequency = \"10 s\"", "m.toml:36: load.shaker.harmonics[0].frequency = \"10 s\": cannot be in `s`; expected one of Hz, mHz, kHz, MHz, rpm, 1/min, rad/s"),
    ("amplitude = \"150 N\", ", "", "m.toml:36: load.shaker.harmonics[0].amplitude: missing; expected a number in N, or with a unit: N, mN, kN, MN, lbf"),
    ("phase = 0.0 }]", "phase = 0.0, 3 = 4 }]", "m.toml:36: load.shaker.harmonics[0].3 = 4: no such key; expected one of amplitude, frequency, phase"),
    ("harmonics = [{ amplitude = \"150 N\", frequency = \"10 Hz\", phase = 0.0 }]", "harmonics = 3", "m.toml:36: load.shaker.harmonics = 3: expected a list such as [{ amplitude = 1.0, frequency = \"10 Hz\", phase = 0.0 }]"),
    ("harmonics = [{ amplitude = \"150 N\", frequency = \"10 Hz\", phase = 0.0 }]", "harmonics = [3]", "m.toml:36: load.shaker.harmonics[0] = 3: expected a list such as [{ amplitude = 1.0, frequency = \"10 Hz\", phase = 0.0 }]"),
    ("harmonics = [{ amplitude = \"150 N\", frequency = \"10 Hz\", phase = 0.0 }]", "amplitude = 3.0", "m.toml:34: load.shaker.frequency: missing; expected a number > 0 in Hz, or with a unit: Hz, mHz, kHz, MHz, rpm, 1/min, rad/s"),
    ("table = \"record.csv\"", "table = \"record.csv\"\namplitude = 3.0", "m.toml:39: load.shaker.amplitude = 3.0: cannot be combined with `harmonics`: use `amplitude`, `frequency` and `phase` for one harmonic, or `harmonics` for a list of them"),
    ("steps = [[0.4, 20.0], [0.9, -20.0]]", "steps = [[0.9, 20.0], [\"400 ms\", -20.0]]", "m.toml:37: load.shaker.steps[1].time = \"400 ms\": must be after 0.9 s, the time of the previous step"),
    ("steps = [[0.4, 20.0], [0.9, -20.0]]", "steps = [[0.4, 20.0], [0.9]]", "m.toml:37: load.shaker.steps[1] = [0.9]: expected a list of [time, height], such as [[0.4, 20.0]]"),
    ("steps = [[0.4, 20.0], [0.9, -20.0]]", "steps = [[\"0.4 m\", \"20 N\"]]", "m.toml:37: load.shaker.steps[0,0] = \"0.4 m\": cannot be in `m`; expected one of s, ms, us, min, h"),
    ("steps = [[0.4, 20.0], [0.9, -20.0]]", "steps = 0.4", "m.toml:37: load.shaker.steps = 0.4: expected a list of [time, height], such as [[0.4, 20.0]]"),
    ("table = \"record.csv\"", "table = \"recrd.csv\"", "m.toml:38: load.shaker.table = \"recrd.csv\": cannot be read: there is no such file"),
    ("table = \"record.csv\"", "table = \"..\u{2f}record.csv\"", "m.toml:38: load.shaker.table = \"..\u{2f}record.csv\": expected a path below the file's folder, with / between its parts, such as \"data/record.csv\""),
    ("table = \"record.csv\"", "table = \"/etc/record.csv\"", "m.toml:38: load.shaker.table = \"/etc/record.csv\": expected a path below the file's folder, with / between its parts, such as \"data/record.csv\""),
    ("table = \"record.csv\"", "table = \"C:\\\\record.csv\"", "m.toml:38: load.shaker.table = \"C:\\\\record.csv\": expected a path below the file's folder, with / between its parts, such as \"data/record.csv\""),
    ("table = \"record.csv\"", "table = \"falling.csv\"", "m.toml:38: load.shaker.table = \"falling.csv\": line 3: `0.5,1` has a time that is not after the previous one; expected increasing times"),
    ("table = \"record.csv\"", "table = \"short.csv\"", "m.toml:38: load.shaker.table = \"short.csv\": has 1 row with numbers; a record requires at least 2, each with a time and a value"),
    ("table = \"record.csv\"", "table = \"words.csv\"", "m.toml:38: load.shaker.table = \"words.csv\": line 5: `1;2` is separated by a semicolon; expected 2 cells separated by commas, and numbers with a decimal point, as in the first line"),
    ("table = \"record.csv\"", "table = \"nan.csv\"", "m.toml:38: load.shaker.table = \"nan.csv\": line 2: `NaN` is not a number; expected a number such as 0.5"),
    ("table = \"record.csv\"", "table = [[0, 1], [0, 2]]", "m.toml:38: load.shaker.table[1] = [0, 2]: must be after 0.0 s, the time of the previous row"),
    ("table = \"record.csv\"", "table = [[0, 1]]", "m.toml:38: load.shaker.table: has 1 row with numbers; a record requires at least 2, each with a time and a value"),
    ("table = \"record.csv\"", "table = 3", "m.toml:38: load.shaker.table = 3: expected a file such as \"record.csv\", or a list of [time, value]"),
    ("table = \"record.csv\"", "table = \"record.csv\"\ninterpolation = \"spline\"", "m.toml:39: load.shaker.interpolation = \"spline\": expected \"straight\", \"cubic\" or \"hold\""),
    ("table = \"record.csv\"", "interpolation = \"cubic\"", "m.toml:38: load.shaker.interpolation = \"cubic\": requires `table`, the record to interpolate"),
    ("table = \"record.csv\"", "input = \"yes\"", "m.toml:38: load.shaker.input = \"yes\": expected true or false, without quotation marks"),
    // Links and starts.
    ("arms = { wheel = 1.0, drum = -3.0 }", "arms = { belt = 1.0 }", "m.toml:11: body.drum: nothing acts on this body; connect an element to it\nm.toml:42: link.gear: connects only bodies with prescribed motion; requires a body with mass or inertia"),
    ("arms = { wheel = 1.0, drum = -3.0 }", "arms = { wheel = 1.0, drum = -3.0 }\n[link.again]\narms = { wheel = 2.0, drum = -6.0 }", "m.toml:44: link.again: the links before it already determine its e; remove this link, which is redundant or contradicts them"),
    ("arms = { wheel = 1.0, drum = -3.0 }", "arms = { wheel = 1.0, drum = -3.0 }\n[link.other]\narms = { wheel = 1.0, drum = -2.0 }\n[link.third]\nbetween = [\"wheel\", \"drum\"]", "m.toml:46: link.third: the links before it already determine its e; remove this link, which is redundant or contradicts them"),
    ("inertia = 1", "inertia = 1\nstart = { s = 0.3 }", "m.toml:43: link.gear: the starts of its bodies give e = -0.8999999999999999 rad; a link requires e = 0: change the start of one of them"),
    ("inertia = 1", "inertia = 1\nstart = { v = 0.3 }", "m.toml:43: link.gear: the starts of its bodies give e' = -0.8999999999999999 rad/s; a link requires e' = 0: change the start of one of them"),
    ("start = { s = \"2 mm\", v = 0.0 }", "start = { s = \"6 mm\", v = 0.0 }", "m.toml:22: stop.upper.gap = \"5 mm\": e = 0.006 m at the start is beyond the gap; a rigid stop requires e <= gap: increase the gap, or change the start"),
    ("start = { s = \"2 mm\", v = 0.0 }", "start = \"rest\"", "m.toml:8: body.block.start = \"rest\": expected a table such as { s = 0.0, v = 0.0 }"),
    ("gravity = \"9.81 m/s2\"", "gravity = \"9.81 m/s2\"\nstart = \"rest\"", "m.toml:9: body.block.start.s = \"2 mm\": cannot be combined with `start = \"rest\"`, the start of the machine: remove one of them"),
    ("gravity = \"9.81 m/s2\"", "gravity = \"9.81 m/s2\"\nstart = \"now\"", "m.toml:3: start = \"now\": expected \"rest\"; give any other start in the table of each body"),
    // Invalid TOML.
    ("name = \"Sound\"", "name = Sound", "m.toml:1: name = Sound: must be in quotation marks: \"Sound\""),
    ("mass = \"12 kg\"", "mass = 12 kg # net", "m.toml:4: body.box.mass = 12 kg: must be in quotation marks: \"12 kg\""),
    ("mass = \"12 kg\"", "mass = 12 // net", "m.toml:4: body.box.mass = 12 // net: a comment begins with `#`: 12 # net"),
    ("mass = \"12 kg\"", "mass = 12; gravity = 1", "m.toml:4: body.box.mass: unexpected `;`: write each key on its own line"),
    ("mass = \"12 kg\"", "mass kg = 12", "m.toml:4: `mass kg`: a key has no spaces; a unit stands in the value, such as mass = \"3 kg\""),
    ("[stop.upper]", "[[stop.upper]]", "m.toml:20: stop.upper = [[stop.upper]]: expected a heading in single brackets, such as [stop.NAME]"),
    ("mass = \"12 kg\"", "mass = twelve", "m.toml:4: body.box.mass = twelve: must be in quotation marks: \"twelve\""),
    ("mass = \"12 kg\"", "mass = 3.", "m.toml:4: body.box.mass = 3.: a digit is missing after the decimal point; write 3.0"),
    ("mass = \"12 kg\"", "mass = net/2", "m.toml:4: body.box.mass = net/2: write an expression in quotation marks, beginning with `=`: \"= net/2\""),
    ("mass = \"12 kg\"", "mass = “12 kg”", "m.toml:4: body.box.mass = “12 kg”: use straight quotation marks: \"12 kg\""),
    ("mass = \"12 kg\"", "mass = \"12,5 kg\"", "m.toml:4: body.box.mass = \"12,5 kg\": write a decimal point: \"12.5 kg\""),
    ("[stop.upper]", "[stop.]", "m.toml:20: `[stop.]`: a name is missing after `stop.`; write a heading such as [stop.NAME]"),
    ("[stop.upper]", "[stop.upper]]", "m.toml:20: one `]` too many in `[stop.upper]]`; write [stop.upper]"),
    ("[stop.upper]", "stop.upper", "m.toml:20: `stop.upper`: expected a heading in brackets, [stop.upper], or `=` and a value"),
    ("[stop.upper]", "[stop.upper # wall", "m.toml:20: stop.upper: missing closing bracket `]`"),
    ("between = [\"ground\", \"box\"]", "between = (\"ground\", \"box\")", "m.toml:16: spring.mount.between: write a list in square brackets: [\"ground\", \"box\"]"),
    ("mass = \"12 kg\"", "mass = = 3 * m", "m.toml:4: body.box.mass = = 3 * m: must be in quotation marks: \"= 3 * m\""),
    ("between = [\"ground\", \"box\"]", "between = [ground, \"box\"]", "m.toml:16: spring.mount.between = ground: must be in quotation marks: \"ground\""),
    ("mass = \"12 kg\"", "mass = \"12 kg", "m.toml:4: body.box.mass: missing quotation mark `\"`"),
    ("mass = \"12 kg\"", "mass = 12 kg\"", "m.toml:4: body.box.mass: missing quotation mark `\"`"),
    ("between = [\"ground\", \"box\"]", "between = [\"ground, \"box\"]", "m.toml:16: spring.mount.between: missing quotation mark `\"`"),
    ("[stop.upper]", "[stop.upper", "m.toml:20: stop.upper: missing closing bracket `]`"),
    ("[stop.upper]", "[stop upper]", "m.toml:20: stop upper: expected a heading such as [body.NAME]"),
    ("[stop.upper]", "stop.upper]", "m.toml:20: missing opening bracket `[` in `stop.upper]`"),
    ("between = [\"ground\", \"box\"]", "between = [\"ground\", \"box\"", "m.toml:16: spring.mount.between: missing closing bracket `]`"),
    ("between = [\"ground\", \"box\"]", "between = [\"ground\", \"box\",", "m.toml:16: spring.mount.between: missing closing bracket `]`"),
    ("between = [\"ground\", \"box\"]", "between = \"ground\", \"box\"]", "m.toml:16: spring.mount.between: missing opening bracket `[` in `between = \"ground\", \"box\"]`"),
    ("between = [\"ground\", \"box\"]", "between = [\"ground\" \"box\"]", "m.toml:16: spring.mount.between: missing comma between two items"),
    ("arms = { wheel = \"50 mm\", box = 1.0 }", "arms = { wheel = \"50 mm\", box = 1.0", "m.toml:40: spring.mesh.arms: missing closing bracket `}`"),
    ("arms = { wheel = 1.0, drum = -3.0 }", "arms = { wheel = 1.0, drum = -3.0", "m.toml:43: link.gear.arms: missing closing bracket `}`"),
    ("frequency = \"10 Hz\", phase = 0.0 }]", "frequency = \"10 Hz\", phase = 0.0 ]", "m.toml:36: load.shaker.harmonics: missing closing bracket `}`"),
    ("frequency = \"10 Hz\"", "\n frequency = 10 Hz", "m.toml:37: load.shaker.harmonics = 10 Hz: must be in quotation marks: \"10 Hz\""),
    ("mass = \"12 kg\"", "mass \"12 kg\"", "m.toml:4: body.box: missing `=` after `mass`"),
    ("mass = \"12 kg\"", "mass: \"12 kg\"", "m.toml:4: body.box: missing `=` after `mass`"),
    ("phase = 0.0 }]", "phase 0.0 }]", "m.toml:36: load.shaker.harmonics: missing `=` after `phase`"),
    ("restitution = 0.7", "restitution =", "m.toml:23: stop.upper.restitution: missing value after `=`"),
    ("restitution = 0.7", "= 0.7", "m.toml:23: stop.upper: missing key before `=`"),
    ("restitution = 0.7", "restitution = .7", "m.toml:23: stop.upper.restitution = .7: expected a number, such as 12, 0.5 or 1e-3"),
    ("restitution = 0.7", "restitution = 0,7", "m.toml:23: stop.upper.restitution = 0,7: write a decimal point: 0.7"),
    ("restitution = 0.7", "restitution = 0.7\nrestitution = 0.8", "m.toml:24: stop.upper.restitution: is given twice; keep one of them"),
    ("phase = 0.0 }]", "phase = 0.0, phase = 1.0 }]", "m.toml:36: load.shaker.harmonics: `phase` is given twice; keep one of them"),
];

pub fn records(path: &str) -> std::io::Result<String> {
    match path {
        "record.csv" => Ok("time,value\n0,0\n1,2.5\n".into()),
        "falling.csv" => Ok("0,1\n1,1\n0.5,1\n".into()),
        "short.csv" => Ok("time,value\n0,1\n".into()),
        "words.csv" => Ok("# a record\n\ntime,value\n0,1\n1;2\n".into()),
        "nan.csv" => Ok("0,1\n1,NaN\n".into()),
        _ => Err(std::io::Error::other("there is no such file")),
    }
}

fn said(text: &str) -> String {
    match parse(text, "m.toml", &records) {
        Ok(_) => "accepted".into(),
        Err(refusal) => refusal.to_string(),
    }
}

#[test]
fn golden_message_of_every_refusal() {
    assert_eq!(said(SOUND), "accepted");
    let mut wrong = Vec::new();
    for (from, to, message) in CASES {
        assert_eq!(SOUND.matches(from).count(), 1, "{from}");
        let found = said(&SOUND.replace(from, to));
        if found != *message {
            wrong.push(format!("{from} -> {to}\n  said: {found:?}\n  not:  {message:?}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn records_that_are_no_regular_files_are_refused_at_once() {
    let folder = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join("records");
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(folder.join("folder")).unwrap();
    let mut names = vec!["folder"];
    // No process ever writes to the pipe.
    if std::process::Command::new("mkfifo").arg(folder.join("pipe")).status().is_ok_and(|s| s.success()) {
        names.push("pipe");
    }
    for name in names {
        let machine = folder.join("m.toml");
        let text = "name = \"M\"\n[body.b]\nmass = 1.0\n[load.l]\non = \"b\"\ntable = \"NAME\"\n"
            .replace("NAME", name);
        std::fs::write(&machine, text).unwrap();
        let refused = vibro_machine::file::read(&machine).unwrap_err().to_string();
        let said = format!(
            "m.toml:6: load.l.table = \"{name}\": cannot be read: it is a folder, pipe or device; expected a regular file"
        );
        assert!(refused.ends_with(&said), "{refused}");
    }
}
