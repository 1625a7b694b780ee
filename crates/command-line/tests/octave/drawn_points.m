function drawn_points(path)
% Writes the points of all lines of the present axes: bits of x, bits of y.
  file = fopen(path, 'w');
  closer = onCleanup(@() fclose(file));
  drawn = findobj(gca(), 'type', 'line');
  for k = 1:numel(drawn)
    x = get(drawn(k), 'xdata');
    y = get(drawn(k), 'ydata');
    for i = 1:numel(x)
      fprintf(file, '%s %s\n', num2hex(x(i)), num2hex(y(i)));
    end
  end
end
