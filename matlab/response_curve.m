% The response curve of a plate on wires below a rail, with its unstable part, in twenty lines.
addpath(fileparts(mfilename('fullpath')));
machine = [tempname(), '.toml'];
vibro.new('duffing_stop', machine);
found = vibro.response(machine, 'vary', 'load.coil.frequency=25Hz:60Hz', 'of', 'plate.s');
curve = found.response;
frequency = curve.('load.coil.frequency');
stable = strcmp(curve.('stability'), 'stable');
hold on
for branch = unique(curve.('branch')).'
  here = curve.('branch') == branch;
  height = 1e3 * curve.('maximum.plate.s');
  plot(frequency(here & stable), height(here & stable), 'b.');
  plot(frequency(here & ~stable), height(here & ~stable), 'r.');
end
points = found.special_points;
text(points.('value'), repmat(0.1, numel(points.('value')), 1), points.('label'));
xlabel('frequency of the coil (Hz)');
ylabel('largest displacement of the plate (mm)');
delete(machine);
