function show(found)
% VIBRO.SHOW  Draw a result into the present axes
%
%   vibro.show(vibro.run('damper.toml', 'until', '2s'))
%
%   A run is drawn as the coordinates of its bodies over time; a response or branches of orbits over
%   the parameter, stable orbits solid and others dashed, with the labels of the special points; a
%   bifurcation diagram and a sweep over the parameter; a section in the plane of its first body; a
%   fit as record and motion over time. For other results `vibro` draws pictures itself: give 'out'.
  drawers = struct('run', @of_run, 'response', @(f) of_branches(f, f.response), ...
                   'orbits', @(f) of_branches(f, f.branches), 'bifurcation', @of_diagram, ...
                   'sweep', @of_sweep, 'section', @of_section, 'fit', @of_fit);
  if ~isstruct(found) || ~isfield(found, 'command')
    error('vibro:refused', 'expected a result of this package, such as of vibro.run');
  elseif ~isfield(drawers, found.command)
    error('vibro:refused', ['a result of vibro.%s is not drawn here; expected one of %s. ', ...
          'With the option ''out'' the folder has the picture of the program'], ...
          found.command, strjoin(fieldnames(drawers).', ', '));
  end
  draw = drawers.(found.command);
  draw(found);
end

function of_run(found)
  lines_over(found.states, 'time', '\.s$', '-');
  xlabel('time (s)');
end

function of_fit(found)
  lines_over(found.residuals, 'time', '^(?!time$)(?!.*\.residual$)', '-');
  xlabel('time (s)');
end

% Draws every column whose name matches over one column.
function lines_over(columns, base, pattern, style)
  names = vibro.inner.names(columns);
  names = names(~cellfun('isempty', regexp(names, pattern, 'once')));
  values = cellfun(@(name) columns.(name), names, 'UniformOutput', false);
  pairs = [repmat({columns.(base)}, 1, numel(values)); values; repmat({style}, 1, numel(values))];
  plot(pairs{:});
  legend(names, 'Interpreter', 'none');
end

% Draws branches of orbits: each piece of one stability as a line that reaches the next piece.
function of_branches(found, curve)
  names = vibro.inner.names(curve);
  parameter = names{find(strcmp(names, 'label'), 1) + 1};
  measure = names{find(strcmp(names, 'stability'), 1) + 1};
  x = curve.(parameter);
  y = curve.(measure);
  stable = strcmp(curve.('stability'), 'stable');
  firsts = [1; find(diff(curve.('branch')) ~= 0 | diff(stable) ~= 0) + 1];
  lasts = [firsts(2:end) - 1; numel(x)];
  styles = {'b--', 'b-'};
  held = ishold();
  for k = 1:numel(firsts)
    last = lasts(k);
    if last < numel(x) && curve.('branch')(last + 1) == curve.('branch')(last)
      last = last + 1;
    end
    plot(x(firsts(k):last), y(firsts(k):last), styles{1 + stable(firsts(k))});
    hold('on');
  end
  labels = curve.('label');
  if iscell(labels)  % without any label the column is NaN
    marked = find(~cellfun('isempty', labels) & ~strcmp(labels, 'EP'));
    text(x(marked), y(marked), labels(marked));
  end
  if ~held
    hold('off');
  end
  xlabel(parameter, 'Interpreter', 'none');
  ylabel(measure, 'Interpreter', 'none');
end

function of_diagram(found)
  points_of(found.bifurcation, 1, 3);
end

% Draws the first output of a sweep, whose spread is the first column of spreads.
function of_sweep(found)
  names = vibro.inner.names(found.sweep);
  spreads = regexp(names, '^(.*)\.spread$', 'tokens', 'once');
  spread = find(~cellfun('isempty', spreads), 1);
  points_of(found.sweep, 1, find(strcmp(names, spreads{spread}{1}), 1));
end

function of_section(found)
  names = vibro.inner.names(found.section);
  place = find(~cellfun('isempty', regexp(names, '\.s$', 'once')), 1);
  points_of(found.section, place, place + 1);
end

% Draws one column over another as points, by their places in the table.
function points_of(columns, over, of)
  names = vibro.inner.names(columns);
  plot(columns.(names{over}), columns.(names{of}), 'k.');
  xlabel(names{over}, 'Interpreter', 'none');
  ylabel(names{of}, 'Interpreter', 'none');
end
