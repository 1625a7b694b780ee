// A ball between two stops of a table that shakes it: 30,000 events in 45 s.
export const RATTLE = {
  until: "45",
  events: 29_000,
  text: `name = "Rattle"

[body.table]
motion = { amplitude = "1 mm", frequency = "200 Hz" }

[body.ball]
mass = "20 g"
start = { v = "1 m/s" }

[stop.floor]
between = ["ball", "table"]
gap = "0.5 mm"
restitution = 0.9

[stop.ceiling]
between = ["table", "ball"]
gap = "0.5 mm"
restitution = 0.9
`,
};
